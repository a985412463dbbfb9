//! Calls of functions in printed code: of the standard library for a single state, of the runtime's
//! functions without branches in loops over lanes.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::expressions::constant;
use super::ident;
use crate::algebra::{Binary, Function};

/// A call for a single state.
pub(super) fn call(function: Function, x: &TokenStream) -> TokenStream {
    if let Function::Powf(exponent) = function {
        let exponent = constant(exponent.get());
        return quote!(f64::powf(#x, #exponent));
    }
    let method = ident(function.name());
    quote!(f64::#method(#x))
}

/// A call within a loop over lanes: of a function without branches.
pub(super) fn call_in_lane(
    function: Function,
    x: &TokenStream,
    private: &TokenStream,
) -> TokenStream {
    match function {
        _ if function.entry().is_instruction => call(function, x),
        Function::Powf(exponent) => {
            let exponent = constant(exponent.get());
            quote!(#private::lane::powf(#x, #exponent))
        }
        _ => {
            let name = ident(function.name());
            quote!(#private::lane::#name(#x))
        }
    }
}

/// A call with two arguments within a loop over lanes.
pub(super) fn call2_in_lane(
    function: Binary,
    x: &TokenStream,
    y: &TokenStream,
    private: &TokenStream,
) -> TokenStream {
    let (name, last) = (ident(function.name()), last_argument(function));
    quote!(#private::lane::#name(#x, #y #last))
}

/// A call with two arguments.
pub(super) fn call2(
    function: Binary,
    x: &TokenStream,
    y: &TokenStream,
    private: &TokenStream,
) -> TokenStream {
    let (name, last) = (ident(function.name()), last_argument(function));
    if function.entry().is_method {
        quote!(f64::#name(#x, #y #last))
    } else {
        quote!(#private::#name(#x, #y #last))
    }
}

/// The number of logarithms as the last argument of a call.
fn last_argument(function: Binary) -> Option<TokenStream> {
    function.logarithms().map(|n| {
        let n = Literal::i32_suffixed(n);
        quote!(, #n)
    })
}

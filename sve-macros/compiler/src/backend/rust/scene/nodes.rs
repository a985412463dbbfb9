//! The impulses of nodes that read consecutive sites: the bodies of loops without branches, which
//! are in the runtime.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::super::function::Formulas;
use super::super::ident;
use crate::algebra::Expr;
use crate::program::symbol_name;
use crate::scene::{Derived, Gather, Read};

/// `node`: the sum at a node to which each common pair contributes once.
pub(super) fn node(derived: &Derived, formulas: Formulas<'_>) -> TokenStream {
    let private = formulas.private;
    let body = impulse(&derived.node, formulas);
    quote! {
        #[inline(always)]
        fn node(
            &self,
            h: f64,
            time: f64,
            dw: &[f64],
            reads: &impl #private::scene::Reads<Self::Numbers>,
        ) -> Self::Numbers {
            #body
        }
    }
}

/// `contribution`: the impulses of one pair.
pub(super) fn contribution(derived: &Derived, formulas: Formulas<'_>) -> TokenStream {
    let private = formulas.private;
    let pairs = derived.pairs.iter().enumerate().map(|(at, (_, gather))| {
        let (at, body) = (Literal::usize_unsuffixed(at), impulse(gather, formulas));
        let counts = gather.counts.map(Literal::usize_unsuffixed);
        // a closure that is not part of the loop would not be compiled for the vectors of the
        // machine
        let body = quote!(#[inline(always)] |reads| { #body });
        quote!(#at => #private::scene::add::<_, #(#counts),*>(streams, to, #body),)
    });
    quote! {
        #[inline(always)]
        fn contribution(
            &self,
            pair: usize,
            h: f64,
            time: f64,
            dw: &[f64],
            streams: &#private::scene::Streams<'_, Self::Numbers>,
            to: &mut [Self::Numbers],
        ) {
            match pair {
                #(#pairs)*
                _ => {}
            }
        }
    }
}

/// Statements and values, which are NaN where a condition is not positive.
pub(super) fn where_defined(
    values: &[Expr],
    conditions: &[Expr],
    formulas: Formulas<'_>,
) -> (TokenStream, Vec<TokenStream>) {
    let (mut statements, mut all) = formulas.within_loop(&[values, conditions].concat());
    let conditions = all.split_off(values.len());
    if !conditions.is_empty() {
        statements.extend(quote!(let is_defined = #((#conditions > 0.0))&*;));
        for value in &mut all {
            *value = quote!(if is_defined { #value } else { f64::NAN });
        }
    }
    (statements, all)
}

/// The impulse, as an expression of `reads`.
fn impulse(gather: &Gather, formulas: Formulas<'_>) -> TokenStream {
    let private = formulas.private;
    let inputs = gather.reads.iter().map(|(symbol, read)| {
        let name = ident(&symbol_name(formulas.symbols, *symbol));
        let (what, number, component) = match *read {
            Read::Own(component) => ("own", None, Some(component)),
            Read::Row(number, component) => ("row", Some(number), Some(component)),
            Read::Column(number) => ("column", Some(number), None),
            Read::Increment(number) => ("increment", Some(number), None),
        };
        let (what, number) = (ident(what), number.map(Literal::usize_unsuffixed));
        let component = component.map(Literal::usize_unsuffixed);
        let component = component.map(|component| quote!([#component]));
        let number = number.map(|number| quote!(, #number));
        quote!(let #name: f64 = #private::scene::Reads::#what(reads #number) #component;)
    });
    let (statements, values) = where_defined(&gather.impulse, &gather.conditions, formulas);
    quote! {
        #(#inputs)*
        #statements
        [#(#values),*]
    }
}

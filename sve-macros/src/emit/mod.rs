//! Plans and instructions → tokens. Infallible, and the only place that knows it prints Rust.

mod code;
mod linearise;
mod mend;
mod momenta;
mod plan;
mod rounding;
mod rule;
mod step;
mod straight;
mod stub;
mod system;

pub(crate) use momenta::momenta;
pub(crate) use rule::rule;
pub(crate) use stub::stub;
pub(crate) use system::system;

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use crate::parse::Annotated;

/// Path of what generated code calls in the runtime.
fn private(block: &Annotated) -> TokenStream {
    let runtime = &block.arguments.runtime;
    quote!(#runtime::__private)
}

/// The function that a symmetry gives.
pub(crate) fn momentum_name(symmetry: &Ident) -> Ident {
    format_ident!("{symmetry}_momentum", span = symmetry.span())
}

/// Attributes of every generated implementation. Generated arithmetic is not written to please a reader's linter.
fn attributes() -> TokenStream {
    quote! {
        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)]
    }
}

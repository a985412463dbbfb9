//! Plans and instructions → tokens. Infallible, and the only place that knows it prints Rust.

mod code;
mod lanes;
mod linearise;
mod mend;
mod momenta;
mod names;
mod plan;
mod rounding;
mod rule;
mod solve;
mod step;
mod straight;
mod stub;
mod system;

pub(crate) use momenta::momenta;
pub(crate) use rule::rule;
pub(crate) use stub::stub;
pub(crate) use system::system;

use proc_macro2::{Ident, Literal, TokenStream};
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

/// Doc comments, a line each: headings with formulas below. As text blocks these are neither markdown nor tests.
fn documented(parts: &[(&str, &str)]) -> TokenStream {
    let mut tokens = TokenStream::new();
    let mut line = |text: &str| {
        let text = verbatim(&format!(" {text}"));
        tokens.extend(quote!(#[doc = #text]));
    };
    for (at, (heading, text)) in parts.iter().enumerate() {
        if at > 0 {
            line("");
        }
        line(heading);
        if !text.is_empty() {
            line("");
            line("```text");
            text.lines().for_each(&mut line);
            line("```");
        }
    }
    tokens
}

/// A string literal that is read as it is, also in the expansion: letters with bars stay letters.
fn verbatim(text: &str) -> Literal {
    let raw = format!("r\"{text}\"");
    raw.parse().unwrap_or_else(|_| Literal::string(text))
}

/// Attributes of every generated implementation. Generated arithmetic is not written to please a reader's linter.
fn attributes() -> TokenStream {
    quote! {
        #[automatically_derived]
        #[allow(unused_variables, clippy::all, clippy::pedantic, clippy::nursery)]
    }
}

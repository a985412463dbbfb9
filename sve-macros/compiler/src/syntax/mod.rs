//! Tokens → annotated block: nesting, the attribute, the items with their roles and signatures;
//! errors of shape.

pub(crate) mod arguments;
pub(crate) mod inputs;
pub(crate) mod nalgebra;
pub(crate) mod nesting;
pub(crate) mod parse;
pub(crate) mod recovery;
mod reduced;
pub(crate) mod roles;
mod rule_arguments;
pub(crate) mod signature;

use quote::ToTokens;
use syn::Type;

/// Returns a type without its parentheses and without the invisible groups of a macro.
pub(crate) fn bare(ty: &Type) -> &Type {
    match ty {
        Type::Paren(inner) => bare(&inner.elem),
        Type::Group(inner) => bare(&inner.elem),
        other => other,
    }
}

/// Returns the source text of a type, for messages.
pub(crate) fn readable(ty: &impl ToTokens) -> String {
    ty.to_token_stream()
        .to_string()
        .replace(" ;", ";")
        .replace(" [", "[")
        .replace("& ", "&")
        .replace(" < ", "<")
        .replace(" >", ">")
        .replace(" ::", "::")
        .replace(":: ", "::")
        .replace(" . ", ".")
}

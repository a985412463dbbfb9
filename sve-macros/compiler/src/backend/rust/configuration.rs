//! The type of configurations, as the user wrote it.
//!
//! A number and a row of numbers are `[f64; N]`, which the runtime takes where nothing is said.

use proc_macro2::TokenStream;
use quote::quote;
use syn::Type;

use crate::syntax::nalgebra::Written;
use crate::syntax::parse::{Annotated, is_f64};

/// The type of `q` in the Lagrangian, unless it is `f64` or a row `[f64; N]`.
pub(super) fn written(block: &Annotated) -> Option<&Type> {
    let lagrangian = &block.lagrangian;
    let (_, ty) = lagrangian.arguments.get(usize::from(lagrangian.is_timed))?;
    (!is_row(ty)).then_some(ty)
}

/// The type of configurations with `n` coordinates.
pub(super) fn configuration(block: &Annotated, n: &impl quote::ToTokens) -> TokenStream {
    match written(block) {
        Some(ty) => quote!(#ty),
        None => quote!([f64; #n]),
    }
}

/// Whether a type is `f64` or a row of such numbers.
fn is_row(ty: &Type) -> bool {
    let entry = match bare(ty) {
        Type::Array(array) => bare(&array.elem),
        other => other,
    };
    is_f64(entry)
}

/// Whether a type is a vector of nalgebra, or an array of vectors or of arrays of `f64`, as deep as may be.
pub(super) fn is_vector_or_nested(ty: &Type) -> bool {
    fn consists_of_numbers(ty: &Type) -> bool {
        match bare(ty) {
            Type::Array(array) => consists_of_numbers(&array.elem),
            other => is_f64(other) || is_vector_of_numbers(other),
        }
    }
    !is_row(ty) && consists_of_numbers(ty)
}

fn is_vector_of_numbers(ty: &Type) -> bool {
    Written::of_type(ty)
        .is_some_and(|written| written.is_vector() && written.has_floats == Some(true))
}

/// A type without parentheses around it.
fn bare(ty: &Type) -> &Type {
    match ty {
        Type::Paren(inner) => bare(&inner.elem),
        Type::Group(inner) => bare(&inner.elem),
        other => other,
    }
}

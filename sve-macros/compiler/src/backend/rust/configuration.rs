//! The type of configurations, as the user wrote it.
//!
//! A number and a row of numbers are `[f64; N]`, which the runtime takes where nothing is said.

use proc_macro2::{Literal, TokenStream};
use quote::quote;
use syn::Type;

use crate::model::Model;
use crate::syntax::nalgebra::Written;
use crate::syntax::parse::{Annotated, is_f64};
use crate::syntax::signature::is_rotation;

/// The type of the configuration, unless it is `f64` or a row `[f64; N]`: the type of `q` in the
/// Lagrangian, with a quaternion in place of each rotation, and a tuple where a rotation stands
/// beside a vector.
pub(super) fn written(block: &Annotated, private: &TokenStream) -> Option<TokenStream> {
    let types: Vec<&Type> = block.configuration().collect();
    if block.arguments.is_reduced {
        let attitude = attitude(block, private);
        return Some(quote!(#private::Reduced<#attitude>));
    }
    match types.as_slice() {
        [ty] if is_row(ty) => None,
        [ty] => Some(stored(ty, private)),
        types => {
            let types = types.iter().map(|ty| stored(ty, private));
            Some(quote!((#(#types),*)))
        }
    }
}

/// The type of the attitude that a reduced system leaves out of its states.
fn attitude(block: &Annotated, private: &TokenStream) -> TokenStream {
    stored(block.coordinates(), private)
}

/// The type in the state for a type in a signature: a quaternion for a rotation.
pub(super) fn stored(ty: &Type, private: &TokenStream) -> TokenStream {
    match bare(ty) {
        ty if !is_rotation(ty) => quote!(#ty),
        Type::Array(array) => {
            let (entry, length) = (stored(&array.elem, private), &array.len);
            quote!([#entry; #length])
        }
        _ => quote!(#private::UnitQuaternion<f64>),
    }
}

/// The type of configurations with `n` degrees of freedom.
pub(super) fn configuration(
    block: &Annotated,
    n: &impl quote::ToTokens,
    private: &TokenStream,
) -> TokenStream {
    written(block, private).unwrap_or_else(|| quote!([f64; #n]))
}

/// How generated functions receive a configuration.
pub(super) struct Received {
    /// The type in which steps compute with a configuration.
    pub(super) flat: TokenStream,
    /// Reads the entries of `q` before its first use.
    pub(super) open: TokenStream,
    /// Reads the entries of the configuration of `state` before its first use.
    pub(super) open_state: TokenStream,
    /// The state itself, after [`open_state`](Self::open_state).
    pub(super) start: TokenStream,
}

/// How generated functions receive a configuration: a row in a vector space, otherwise a value from
/// which the entries are read.
pub(super) fn received(block: &Annotated, model: &Model, private: &TokenStream) -> Received {
    let n = Literal::usize_unsuffixed(model.dof());
    if !model.configuration().has_rotations() {
        return Received {
            flat: quote!([f64; #n]),
            open: TokenStream::new(),
            open_state: TokenStream::new(),
            start: quote!(state),
        };
    }
    let whole = if block.arguments.is_reduced {
        attitude(block, private)
    } else {
        configuration(block, &n, private)
    };
    let entries = Literal::usize_unsuffixed(model.configuration().entries());
    Received {
        flat: quote!(#private::WithRotations<#whole, #n>),
        open: quote!(let q = &q.entries::<#entries>();),
        open_state: quote! {
            let start = state;
            let state = &#private::with_entries::<_, #entries, #n>(start);
        },
        start: quote!(start),
    }
}

/// Returns whether a type is `f64` or a row of such numbers.
fn is_row(ty: &Type) -> bool {
    let entry = match bare(ty) {
        Type::Array(array) => bare(&array.elem),
        other => other,
    };
    is_f64(entry)
}

/// Returns whether a type is a vector of nalgebra, or an array of vectors or of arrays of `f64` of
/// any depth.
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

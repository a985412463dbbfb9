//! Mass matrices that depend on the position, at each stage: their inverses, and the velocities of
//! momenta.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::{Axis, Writer};
use crate::model::Meaning;

impl Writer<'_> {
    /// The inverse of the mass matrix at a stage; of a diagonal one the diagonal.
    pub(super) fn inverse(&self, matrix: &[TokenStream], is_diagonal: bool) -> TokenStream {
        let n = self.model.dof();
        if is_diagonal {
            let diagonal = (0..n).map(|i| &matrix[i * n + i]);
            return quote!(let inverse = [#(1f64 / #diagonal),*];);
        }
        let rows = matrix.chunks(n).map(|row| quote!([#(#row),*]));
        let private = self.private;
        quote!(let inverse = #private::lane::inverse(&[#(#rows),*]);)
    }

    /// Writes the inverse to `masses`, and reads it from there.
    pub(super) fn kept_inverse(&self, is_diagonal: bool) -> [TokenStream; 2] {
        let n = self.model.dof();
        let places = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let entry = |i: usize, j: usize| {
            let i = Literal::usize_unsuffixed(i);
            Axis::Stages.entry(&quote!(masses.inverse[#i]), j)
        };
        let keep = places
            .filter(|(i, j)| !is_diagonal || i == j)
            .map(|(i, j)| {
                let (kept, entry) = (entry(i, j), inverse_entry(is_diagonal, i, j));
                quote!(#kept = #entry;)
            });
        let rows = (0..n).map(|i| {
            if is_diagonal {
                return entry(i, i);
            }
            let row = (0..n).map(|j| entry(i, j));
            quote!([#(#row),*])
        });
        [quote!(#(#keep)*), quote!(let inverse = [#(#rows),*];)]
    }

    /// The velocity at a stage.
    pub(super) fn velocity(&self, is_diagonal: bool) -> TokenStream {
        let n = self.model.dof();
        let components = (0..n).map(|i| {
            let terms = (0..n).filter(|&j| !is_diagonal || i == j).map(|j| {
                let entry = inverse_entry(is_diagonal, i, j);
                let momentum = Axis::Stages.input(&Meaning::Momentum(j));
                let j = Literal::usize_unsuffixed(j);
                quote!(#entry * (#momentum - offset[#j]))
            });
            let mut sum = TokenStream::new();
            for (at, term) in terms.enumerate() {
                let plus = (at > 0).then(|| quote!(+));
                sum.extend(quote!(#plus #term));
            }
            sum
        });
        quote!([#(#components),*])
    }
}

/// An entry of the inverse of the mass matrix; of a diagonal one the diagonal alone is stored.
fn inverse_entry(is_diagonal: bool, row: usize, column: usize) -> TokenStream {
    let [row, column] = [row, column].map(Literal::usize_unsuffixed);
    if is_diagonal {
        quote!(inverse[#row])
    } else {
        quote!(inverse[#row][#column])
    }
}

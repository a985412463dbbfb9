//! The factors of matrices that depend on parameters and step size alone: computed in `prepare`,
//! beside its numbers.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use crate::program::{Factored, Step, Value};
use crate::structure::Matrix;

/// The matrices whose factors a step uses more than once.
pub(super) struct Factors<'a> {
    /// Of each block, where its matrix is factored.
    blocks: Vec<Factored>,
    /// The matrices that are factored in `prepare`.
    matrices: Vec<&'a Matrix<Value>>,
}

impl<'a> Factors<'a> {
    pub(super) fn new(step: &'a Step) -> Self {
        let all = &step.scheme.blocks;
        let blocks: Vec<Factored> = all.iter().map(|b| b.factored(&step.program)).collect();
        let early = all.iter().zip(&blocks);
        let early = early.filter(|(_, factored)| **factored == Factored::InPrepare);
        Self {
            matrices: early
                .filter_map(|(b, _)| b.solution.first_matrix())
                .collect(),
            blocks,
        }
    }

    /// An expression of the factors of a block's matrix, `Some` if it is regular. Nothing if it is
    /// not factored apart from the solve.
    pub(super) fn of(
        &self,
        block: usize,
        matrix: &TokenStream,
        private: &TokenStream,
    ) -> Option<TokenStream> {
        match self.blocks[block] {
            Factored::Nowhere => None,
            Factored::InStep => Some(quote!(#private::factored(&#matrix))),
            Factored::InPrepare => {
                let earlier = self.blocks[..block].iter();
                let place = earlier.filter(|b| **b == Factored::InPrepare).count();
                let place = Literal::usize_unsuffixed(place);
                Some(quote!(factors.#place))
            }
        }
    }

    /// The type of what `prepare` returns, its value, and the statement with which a step takes it
    /// apart; `array` has the numbers.
    pub(super) fn beside(
        &self,
        numbers: &[Value],
        array: &TokenStream,
        printer: &Printer<'_>,
        private: &TokenStream,
    ) -> (TokenStream, TokenStream, TokenStream) {
        let count = Literal::usize_unsuffixed(numbers.len());
        let of_numbers = quote!([f64; #count]);
        if self.matrices.is_empty() {
            return (of_numbers, array.clone(), TokenStream::new());
        }
        let types = self.matrices.iter().map(|matrix| {
            let size = Literal::usize_unsuffixed(matrix.size());
            quote!(::core::option::Option<#private::Factors<#size>>,)
        });
        let values = self.matrices.iter().map(|matrix| {
            let matrix = printer.matrix(&matrix.rows);
            quote!(#private::factored(&#matrix),)
        });
        let open = if numbers.is_empty() {
            quote!(let (_, factors) = prepared;)
        } else {
            quote!(let (prepared, factors) = prepared;)
        };
        (
            quote!((#of_numbers, (#(#types)*))),
            quote!((#array, (#(#values)*))),
            open,
        )
    }
}

//! `fn linearise`: the entries of the linearised step.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::configuration::Received;
use super::solve::names as pattern;
use super::straight::Straight;
use crate::algebra::{Arena, Expr};
use crate::linearise::{Entry, Linearisation};
use crate::model::{Model, Symbols};

pub(super) fn linearise(
    private: &TokenStream,
    model: &Model,
    received: &Received,
    linearisation: &Linearisation,
    symbols: &Symbols,
    arena: &Arena,
) -> TokenStream {
    let Linearisation {
        unknowns,
        outputs,
        inputs,
        matrices,
        through,
    } = linearisation;
    let m = Literal::usize_unsuffixed(model.noises.len());
    let size = Literal::usize_unsuffixed(unknowns.len());
    let matrices: Vec<&Vec<Entry>> = matrices.iter().chain(through.iter().flatten()).collect();
    let roots: Vec<Expr> = matrices
        .iter()
        .flat_map(|matrix| matrix.iter().map(|entry| entry.value))
        .collect();
    let rows: Vec<Vec<Expr>> = matrices
        .iter()
        .map(|matrix| matrix.iter().map(|entry| entry.value).collect())
        .collect();
    let rows: Vec<[Vec<Expr>; 1]> = rows.into_iter().map(|row| [row]).collect();
    let names = [
        "residual_by_x",
        "residual_by_z",
        "output_by_x",
        "output_by_z",
        "intermediate_by_z",
        "output_by_intermediate",
    ];
    let views: Vec<(&[Vec<Expr>], Vec<String>)> = rows
        .iter()
        .zip(names)
        .map(|(row, name)| (row.as_slice(), vec![name.to_owned()]))
        .collect();
    let (statements, values) = Straight::new(arena, symbols, &roots).finish(private, &views);
    let matrices = matrices.into_iter().zip(values).map(|(entries, values)| {
        let places = entries.iter().map(|&Entry { row, column, .. }| {
            let [row, column] = [row, column].map(Literal::usize_unsuffixed);
            quote!((#row, #column))
        });
        quote!(#private::Entries { places: &[#(#places),*], values: &#values[0] })
    });
    let matrices: Vec<TokenStream> = matrices.collect();
    let (matrices, through) = matrices.split_at(4);
    let through = (!through.is_empty()).then(|| quote!(.through([#(#through),*])));
    let unknowns = pattern(unknowns, symbols);
    let Received {
        flat,
        open: _,
        open_state,
        reopen_state: _,
    } = received;
    quote! {
        type Unknowns = [f64; #size];
        #[inline]
        fn linearise<__T>(
            &self,
            state: &#private::State<#flat>,
            h: f64,
            dw: &[f64; #m],
            unknowns: &[f64; #size],
            then: impl ::core::ops::FnOnce(#private::Linearisation<'_>) -> __T,
        ) -> __T {
            #open_state
            let time = state.t;
            let #unknowns = *unknowns;
            #statements
            then(#private::Linearisation::new([#size, #outputs, #inputs], [#(#matrices),*])#through)
        }
    }
}

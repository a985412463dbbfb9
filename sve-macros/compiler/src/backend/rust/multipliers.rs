//! `fn multipliers`: the impulses of constraints after a step is solved.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::solve::names as pattern;
use super::straight::Straight;
use crate::algebra::{Arena, Expr};
use crate::linearise::Linearisation;
use crate::model::{Model, Symbols};

/// The function that tells what a step can report beside its result; nothing where there is nothing.
pub(super) fn multipliers(
    private: &TokenStream,
    model: &Model,
    reported: &[Expr],
    linearisation: &Linearisation,
    symbols: &Symbols,
    arena: &Arena,
) -> Option<TokenStream> {
    if reported.is_empty() {
        return None;
    }
    let rows = [reported.to_vec()];
    let parts: [(&[Vec<Expr>], Vec<String>); 1] = [(&rows, vec!["multiplier".to_owned()])];
    let (statements, arrays) = Straight::new(arena, symbols, reported).finish(private, &parts);
    let values = arrays.first()?;
    let [n, m, size] = [
        model.dof(),
        model.noises.len(),
        linearisation.unknowns.len(),
    ]
    .map(Literal::usize_unsuffixed);
    let unknowns = pattern(&linearisation.unknowns, symbols);
    Some(quote! {
        fn multipliers(
            &self,
            state: &#private::State<[f64; #n]>,
            h: f64,
            dw: &[f64; #m],
            unknowns: &[f64; #size],
            visit: &mut dyn ::core::ops::FnMut(f64),
        ) {
            let time = state.t;
            let #unknowns = *unknowns;
            #statements
            let [multipliers] = #values;
            for multiplier in multipliers {
                visit(multiplier);
            }
        }
    })
}

//! The body of `linearise`, and `fn multipliers`: the entries of the linearised step, and the
//! impulses of constraints after a step is solved.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::Context;
use super::function::{Formulas, Printed};
use super::solve::names as pattern;
use crate::algebra::Expr;
use crate::derivation::Derived;
use crate::linearise::{Entry, Linearisation};
use crate::program::Array;

pub(super) fn linearise(
    context: &Context<'_>,
    derived: &Derived,
    open_state: &TokenStream,
) -> TokenStream {
    let derivatives = context.settings.derivatives;
    if !derivatives.include(derived.is_unstructured) {
        return quote!(::core::panic!(
            "the derivatives of this step are not derived"
        ));
    }
    let Linearisation {
        unknowns,
        outputs,
        inputs,
        matrices,
        through,
    } = &derived.linearisation;
    let private = context.private;
    let size = Literal::usize_unsuffixed(unknowns.len());
    let matrices: Vec<&Vec<Entry>> = matrices.iter().chain(through.iter().flatten()).collect();
    let names = [
        "residual_by_x",
        "residual_by_z",
        "output_by_x",
        "output_by_z",
        "intermediate_by_z",
        "output_by_intermediate",
    ];
    let arrays = matrices.iter().zip(names).map(|(matrix, name)| {
        let values: Vec<Expr> = matrix.iter().map(|entry| entry.value).collect();
        Array::vector(name, &values)
    });
    let formulas = context.formulas_of(derived);
    let Printed {
        statements, arrays, ..
    } = formulas.list(&arrays.collect::<Vec<_>>());
    let matrices = matrices.into_iter().zip(arrays).map(|(entries, values)| {
        let places = entries.iter().map(|&Entry { row, column, .. }| {
            let [row, column] = [row, column].map(Literal::usize_unsuffixed);
            quote!((#row, #column))
        });
        quote!(#private::Entries::Listed { places: &[#(#places),*], values: &#values })
    });
    let matrices: Vec<TokenStream> = matrices.collect();
    let (matrices, through) = matrices.split_at(4);
    let through = (!through.is_empty()).then(|| quote!(.through([#(#through),*])));
    let unknowns = pattern(unknowns, formulas.symbols);
    quote! {
        #open_state
        let time = state.t;
        let #unknowns = *unknowns;
        #statements
        then(#private::Linearisation::new([#size, #outputs, #inputs], [#(#matrices),*])#through)
    }
}

/// The function that tells what a step can report beside its result; nothing where there is
/// nothing.
pub(super) fn multipliers(context: &Context<'_>, derived: &Derived) -> Option<TokenStream> {
    let reported = &derived.scheme.reported;
    if reported.is_empty() {
        return None;
    }
    let (private, [n, m]) = (context.private, context.sizes());
    let formulas: Formulas<'_> = context.formulas_of(derived);
    let (statements, [values]) = formulas.arrays(&[Array::vector("multiplier", reported)]);
    let unknowns = &derived.linearisation.unknowns;
    let size = Literal::usize_unsuffixed(unknowns.len());
    let unknowns = pattern(unknowns, formulas.symbols);
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
            for multiplier in #values {
                visit(multiplier);
            }
        }
    })
}

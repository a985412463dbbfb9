//! The constants of `impl Scene`: the outermost loops, their terms, and the pairs of streams.

use proc_macro2::TokenStream;
use quote::quote;

use super::super::function::Formulas;
use super::super::verbatim;
use crate::model::scene::Head;
use crate::scene::{Derived, Pair, Root};

/// Prints the constants.
pub(super) fn tables(derived: &Derived, formulas: Formulas<'_>) -> TokenStream {
    let private = formulas.private;
    let roots = derived.roots.iter().enumerate().map(|(number, root)| {
        let (text, is_stream) = (verbatim(&text(root, derived)), root.is_stream);
        let mut of_root = derived.terms.iter().filter(|term| term.root == number);
        let has_noise = of_root.any(|term| term.is_noise);
        quote! {
            #private::scene::Loop { text: #text, is_stream: #is_stream, has_noise: #has_noise }
        }
    });
    let terms = derived.terms.iter().map(|term| {
        let (in_loop, columns) = (term.root, term.columns.len());
        let function = &derived.roots[term.root].function;
        let sites = term.sites.iter().map(|&site| {
            let index = derived.scene.integers.text(site);
            verbatim(&format!("`q[{index}]` in `{function}`"))
        });
        let has_increment = term.increment.is_some();
        quote! {
            #private::scene::Term {
                in_loop: #in_loop,
                slots: &[#(#sites),*],
                columns: #columns,
                has_increment: #has_increment,
            }
        }
    });
    let pairs = derived.pairs.iter().map(|(pair, _)| {
        let Pair {
            term,
            site,
            rows,
            columns,
            reads_increment,
            ..
        } = pair;
        quote! {
            #private::scene::Pair {
                term: #term,
                slot: #site,
                rows: &[#(#rows),*],
                columns: &[#(#columns),*],
                reads_increment: #reads_increment,
            }
        }
    });
    let impulses = derived
        .terms
        .iter()
        .flat_map(|term| term.impulses.iter().flatten().copied());
    let totals = derived.totals.iter().flat_map(|total| &total.summands);
    let totals = totals.map(|summand| summand.value);
    let mut numbers = impulses.chain(totals).chain(derived.scene.side_numbers());
    let reads_time = numbers.any(|e| formulas.arena.contains(e, derived.scene.time));
    let common = derived.common;
    let is_symmetric = (!derived.is_symmetric()).then(|| {
        quote!(
            const IS_SYMMETRIC: bool = false;
        )
    });
    quote! {
        #is_symmetric
        const LOOPS: &'static [#private::scene::Loop] = &[#(#roots),*];
        const TERMS: &'static [#private::scene::Term] = &[#(#terms),*];
        const PAIRS: &'static [#private::scene::Pair] = &[#(#pairs),*];
        const NODE_PAIRS: usize = #common;
        const READS_TIME: bool = #reads_time;
    }
}

/// The place of a root, for messages.
fn text(root: &Root, derived: &Derived) -> String {
    let (function, integers) = (&root.function, &derived.scene.integers);
    let head = root.sum.map(|sum| &derived.scene.sums[sum.0].head);
    match head {
        Some(&Head::For { counter, from, to }) => {
            let (counter, from, to) = (
                integers.name(counter),
                integers.text(from),
                integers.text(to),
            );
            format!("the loop `for {counter} in {from}..{to}` in `{function}`")
        }
        _ => format!("`{function}`"),
    }
}

//! The body of a step: the program of its tiers with the solves between them.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Printer;
use super::count::Work;
use super::names::input_name;
use super::solve::Solver;
use super::values::Step;
use crate::model::{Meaning, Symbols};
use crate::schedule::{Operation, Program, Tier};
use crate::structure::Scheme;
use crate::symbolic::{Arena, Symbol};

/// The code of a step.
pub(super) struct Code {
    /// Numbers that `prepare` returns.
    pub(super) prepared: usize,
    /// The body of `prepare`.
    pub(super) prepare: TokenStream,
    /// The body of `increment`.
    pub(super) body: TokenStream,
    pub(super) work: Work,
}

/// The code of a scheme, in tiers.
pub(super) fn code(
    scheme: &Scheme,
    unknowns: &[Symbol],
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> Code {
    let step = Step::new(scheme, |iteration| &iteration.guess, symbols, arena);
    let results = step.results();
    let mut printer = Printer::new(&step.program, symbols, &step.labels, private);
    let kept = printer.split_prepared(&results);
    let (prepare, array) = (printer.prepare(), printer.array(&kept));
    let solver = Solver {
        private,
        printer: &printer,
        symbols,
        arena,
    };
    let load = printer.load(&results);
    let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
    let blocks = step.solves.iter().zip(&scheme.blocks).enumerate();
    let blocks = blocks.map(|(at, (solve, block))| {
        let solve = solver.tokens(at, solve, block, scheme.dq.len());
        let after = printer.statements(Tier::Solved(at));
        quote!(#solve #after)
    });
    let (dq, dp) = (printer.array(&step.dq), printer.array(&step.dp));
    let unknowns = unknowns.iter().map(|&s| input_name(symbols, s));
    let time = uses_time(&step.program, symbols).then(|| quote!(let time = state.t;));
    Code {
        prepared: kept.len(),
        prepare: quote!(#prepare #array),
        body: quote! {
            #time
            #load
            #(#start)*
            #(#blocks)*
            ::core::result::Result::Ok((#dq, #dp, [#(#unknowns),*]))
        },
        work: Work::of(&step.program).with_solves(scheme),
    }
}

fn uses_time(program: &Program, symbols: &Symbols) -> bool {
    let is_time = |s: Symbol| matches!(symbols.meaning(s), Meaning::Time);
    program
        .all()
        .any(|(_, i)| matches!(i.operation, Operation::Input(s) if is_time(s)))
}

//! The body of a step: the program of its tiers with the solves between them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::count::Work;
use super::names::input_name;
use super::solve::Solver;
use super::values::{Chosen, Step};
use crate::algebra::{Arena, Symbol};
use crate::program::{Operation, Program, Tier};
use crate::structure::{Block, Scheme, Solution};
use crate::system::model::{Meaning, Symbols};

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
    let chosen = Chosen {
        start: |iteration| &iteration.guess,
        bounds: |judge| &judge.quick,
    };
    let step = Step::new(scheme, chosen, symbols, arena);
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
    let mut first = 0;
    let blocks = blocks.map(|(at, (solve, block))| {
        let tokens = solver.tokens((at, first), solve, block, scheme.dq.len());
        first += solved(block);
        let after = printer.statements(Tier::Solved(at));
        let judge = solver.judge(solve, block);
        quote!(#tokens #after #judge)
    });
    let blocks: Vec<TokenStream> = blocks.collect();
    let domain = step.domain.iter().enumerate().map(|(at, &(value, is_closed))| {
        let (value, at) = (printer.operand(value), Literal::usize_unsuffixed(at));
        let holds = inside(&value, is_closed);
        quote! {
            if !(#holds) {
                return ::core::result::Result::Err(#private::SolveError::OutsideDomain { condition: #at });
            }
        }
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
            #(#domain)*
            ::core::result::Result::Ok((#dq, #dp, [#(#unknowns),*]))
        },
        work: Work::of(&step.program).with_solves(scheme),
    }
}

/// Whether a value is within its domain.
pub(super) fn inside(value: &TokenStream, is_closed: bool) -> TokenStream {
    if is_closed {
        quote!(#value >= 0f64)
    } else {
        quote!(#value > 0f64)
    }
}

/// How many unknowns of a block are solved for, those of formulas aside.
fn solved(block: &Block) -> usize {
    match &block.solution {
        Solution::Formula(_) => 0,
        Solution::System { solved, .. } => solved.len(),
        Solution::Iteration(iteration) => iteration.solved.len(),
    }
}

fn uses_time(program: &Program, symbols: &Symbols) -> bool {
    let is_time = |s: Symbol| matches!(symbols.meaning(s), Meaning::Time);
    program
        .all()
        .any(|(_, i)| matches!(i.operation, Operation::Input(s) if is_time(s)))
}

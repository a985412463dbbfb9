//! The body of a step: the program of its tiers with the solves between them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::factors::Factors;
use super::ident;
use super::solve::Solver;
use crate::algebra::{Arena, Expr, Symbol};
use crate::program::{Operation, Program, Step, Tier, Work, symbol_name};
use crate::structure::Scheme;
use crate::system::model::{Meaning, Symbols};

/// The code of a step.
pub(super) struct Code {
    /// The type that `prepare` returns.
    pub(super) prepared: TokenStream,
    /// The body of `prepare`.
    pub(super) prepare: TokenStream,
    /// The body of `increment`.
    pub(super) body: TokenStream,
    pub(super) work: Work,
}

/// The code of a scheme, in tiers.
pub(super) fn code(
    scheme: &Scheme<Expr>,
    unknowns: &[Symbol],
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> Code {
    let step = Step::new(scheme, symbols, arena);
    let scheme = &step.scheme;
    let results = step.results();
    let mut printer = Printer::new(&step.program, symbols, &step.labels, private);
    let kept = printer.split_prepared(&results);
    let (prepare, array) = (printer.prepare(), printer.array(&kept));
    let factors = Factors::new(&step);
    let solver = Solver {
        private,
        printer: &printer,
        symbols,
        arena,
        factors: &factors,
    };
    let (kept, array, open) = factors.beside(&kept, &array, &printer, private);
    let load = printer.load(&results);
    let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
    let mut first = 0;
    let blocks = scheme.blocks.iter().enumerate().map(|(at, block)| {
        let tokens = solver.tokens((at, first), &block.solution, scheme.dq.len());
        first += block.solution.solved().len();
        let after = printer.statements(Tier::Solved(at));
        let judge = solver.judge(&block.solution);
        quote!(#tokens #after #judge)
    });
    let blocks: Vec<TokenStream> = blocks.collect();
    let domain = scheme.domain.iter().enumerate().map(|(at, condition)| {
        let (value, at) = (printer.operand(condition.value), Literal::usize_unsuffixed(at));
        let holds = inside(&value, condition.is_closed);
        quote! {
            if !(#holds) {
                return ::core::result::Result::Err(#private::SolveError::OutsideDomain { condition: #at });
            }
        }
    });
    let (dq, dp) = (printer.array(&scheme.dq), printer.array(&scheme.dp));
    let unknowns = unknowns.iter().map(|&s| ident(&symbol_name(symbols, s)));
    let time = uses_time(&step.program, symbols).then(|| quote!(let time = state.t;));
    Code {
        prepared: kept,
        prepare: quote!(#prepare #array),
        body: quote! {
            #time
            #open
            #load
            #(#start)*
            #(#blocks)*
            #(#domain)*
            ::core::result::Result::Ok((#dq, #dp, [#(#unknowns),*]))
        },
        work: Work::of(&step),
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

fn uses_time(program: &Program, symbols: &Symbols) -> bool {
    let is_time = |s: Symbol| matches!(symbols.meaning(s), Meaning::Time);
    program
        .all()
        .any(|(_, i)| matches!(i.operation, Operation::Input(s) if is_time(s)))
}

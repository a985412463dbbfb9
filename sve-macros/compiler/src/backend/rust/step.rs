//! The body of a step: the program of its tiers with the solves between them.

use std::collections::HashSet;

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::{Place, Printer};
use super::cold::Cold;
use super::factors::Factors;
use super::function::Formulas;
use super::ident;
use super::solve::Solver;
use crate::algebra::{Expr, Symbol};
use crate::model::{Meaning, Symbols};
use crate::program::{
    Carried, Operation, Program, Residual, Step, Tier, Value, Work, operands, symbol_name,
};
use crate::structure::Scheme;

/// The code of a step.
pub(super) struct Code {
    /// The type that `prepare` returns.
    pub(super) prepared: TokenStream,
    /// The numbers that a trajectory carries from step to step.
    pub(super) carried: usize,
    /// The body of `prepare`.
    pub(super) prepare: TokenStream,
    /// The body of `increment`.
    pub(super) body: TokenStream,
    pub(super) work: Work,
}

/// The code of a scheme, in tiers.
pub(super) fn code(
    scheme: &Scheme<Expr>,
    finds_singular_masses: bool,
    unknowns: &[Symbol],
    cold: &Cold<'_>,
) -> Code {
    let formulas = cold.formulas;
    let Formulas {
        arena,
        symbols,
        private,
    } = formulas;
    let step = Step::new(scheme, symbols, arena);
    let scheme = &step.scheme;
    let results = step.results();
    let carried = Carried::of(&step, symbols);
    let pairs = carried.iter().flat_map(|carried| &carried.pairs);
    let mut printer = Printer::new(Place::Single, &step.program, &step.labels, formulas)
        .keeping(pairs.flat_map(|(here, there)| [here, there]));
    let kept = printer.split_prepared(&results);
    let (prepare, array) = (printer.prepare(), printer.array(&kept));
    let factors = Factors::new(&step);
    let solver = Solver {
        formulas,
        printer: &printer,
        factors: &factors,
        finds_singular_masses,
        cold,
    };
    let (kept, array, open) = factors.beside(&kept, &array, &printer, private);
    let load = printer.load(&results);
    let noise = printer.statements(Tier::Noise);
    let (state, remember) = match &carried {
        Some(carried) => with_carried(carried, &step.program, &printer),
        None => (printer.statements(Tier::State), TokenStream::new()),
    };
    let mut first = 0;
    let blocks = scheme.blocks.iter().enumerate().map(|(at, block)| {
        let tokens = solver.tokens((at, first), &block.solution, scheme.dq.len());
        first += block.solution.solved().len();
        let after = printer.statements(Tier::Solved(at));
        let judge = solver.judge(at, &block.solution);
        quote!(#tokens #after #judge)
    });
    let blocks: Vec<TokenStream> = blocks.collect();
    let checks = checks(scheme, &printer, private);
    let (dq, dp) = (printer.array(&scheme.dq), printer.array(&scheme.dp));
    let unknowns = unknowns.iter().map(|&s| ident(&symbol_name(symbols, s)));
    let time = uses_time(&step.program, symbols).then(|| quote!(let time = state.t;));
    Code {
        prepared: kept,
        carried: carried.as_ref().map_or(0, |carried| carried.pairs.len()),
        prepare: quote!(#prepare #array),
        body: quote! {
            #time
            #open
            #load
            #noise
            #state
            #(#blocks)*
            #checks
            #remember
            ::core::result::Result::Ok((#dq, #dp, [#(#unknowns),*]))
        },
        work: Work::of(&step, carried.as_ref()),
    }
}

/// The tests that L is defined at the solution, and that the contraction of an iteration is enough
/// to accept it.
fn checks(
    scheme: &Scheme<Value, Residual>,
    printer: &Printer<'_>,
    private: &TokenStream,
) -> TokenStream {
    let domain = scheme.domain.iter().enumerate().map(|(at, condition)| {
        let (value, at) = (printer.operand(condition.value), Literal::usize_unsuffixed(at));
        let holds = inside(&value, condition.is_closed);
        quote! {
            if !(#holds) {
                return ::core::result::Result::Err(#private::SolveError::OutsideDomain { condition: #at });
            }
        }
    });
    let guards = scheme.guards.iter().map(|&guard| {
        let guard = printer.operand(guard);
        quote! {
            if newton.is_fast_path() && !(#guard >= 0f64) {
                return ::core::result::Result::Err(#private::SolveError::OtherBranch);
            }
        }
    });
    quote!(#(#domain)* #(#guards)*)
}

/// The statements of the state's tier, and the statement that carries values to the next step.
/// Statements that only yield carried values run if nothing was carried.
fn with_carried(
    carried: &Carried,
    program: &Program,
    printer: &Printer<'_>,
) -> (TokenStream, TokenStream) {
    let statements = |wanted: &dyn Fn(Value, Operation) -> bool| -> TokenStream {
        program
            .of_tier(Tier::State)
            .filter(|&(value, operation)| wanted(value, operation))
            .map(|(value, operation)| printer.statement(value, operation))
            .collect()
    };
    let read: HashSet<Value> = carried
        .sources
        .iter()
        .flat_map(|&value| operands(program.get(value).operation))
        .collect();
    let is_source = |value, operation| {
        let is_input = matches!(operation, Operation::Input(_));
        carried.sources.contains(&value) || is_input && read.contains(&value)
    };
    let sources = statements(&is_source);
    let others = statements(&|value, _| !carried.sources.contains(&value));
    let (here, there): (Vec<Value>, Vec<Value>) = carried.pairs.iter().copied().unzip();
    let (here, there) = (printer.array(&here), printer.array(&there));
    let take = quote! {
        let #here = *memory.get_or_insert_with(|| {
            #sources
            #here
        });
        #others
    };
    (
        take,
        quote!(*memory = ::core::option::Option::Some(#there);),
    )
}

/// The test that a value is within its domain.
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

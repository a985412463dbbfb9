//! The body of a step: the program of its tiers with the solves between them.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Printer;
use super::count::Work;
use super::names::{Labels, input_name};
use super::solve::Solve;
use crate::model::{Meaning, Symbols};
use crate::schedule::{Operation, Program, Scheduler, Tier, Tiers, Value};
use crate::structure::{Block, Form, Iteration, Refinement, Scheme, Solution};
use crate::symbolic::{Arena, Expr, Symbol};

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
    let step = schedule(scheme, unknowns, symbols, private, arena);
    let mut printer = Printer::new(&step.program, symbols, &step.labels, private);
    let kept = printer.split_prepared(&step.results);
    let (prepare, array) = (printer.prepare(), printer.array(&kept));
    Code {
        prepared: kept.len(),
        prepare: quote!(#prepare #array),
        body: step.body(private, &printer, symbols),
        work: Work::of(&step.program).with_solves(scheme),
    }
}

/// A step with values for expressions.
struct Step {
    solves: Vec<Solve>,
    dq: Vec<Value>,
    dp: Vec<Value>,
    /// What the solves determine.
    unknowns: Vec<Symbol>,
    /// Every value that is used other than by an instruction.
    results: Vec<Value>,
    program: Program,
    /// What the values are.
    labels: Labels,
}

/// Turns all expressions of a scheme into one program.
fn schedule(
    scheme: &Scheme,
    unknowns: &[Symbol],
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> Step {
    let Scheme {
        blocks,
        dq,
        dp,
        form,
        increments: _,
    } = scheme;
    let mut tiers = Tiers::new();
    let mut all: Vec<Expr> = [dq.as_slice(), dp].concat();
    for (at, block) in blocks.iter().enumerate() {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(linear.matrix.iter().flatten().chain(&linear.rhs));
            }
            Solution::Iteration(iteration) => {
                let Iteration {
                    guess,
                    refinement,
                    fallback: _,
                    singular_at_rest: _,
                    residual,
                    jacobian,
                    curvature,
                    iterates,
                    solved,
                } = &**iteration;
                if let Some(Refinement { first, rhs }) = refinement {
                    tiers.extend(first.iter().map(|&s| (s, Tier::Guess(at))));
                    all.extend(rhs);
                }
                tiers.extend(iterates.iter().map(|&s| (s, Tier::Iterate(at))));
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                let matrices = guess.matrix.iter().chain(jacobian).flatten();
                all.extend(matrices.chain(&guess.rhs).chain(residual).chain(curvature));
            }
        }
    }
    let mut scheduler = Scheduler::new(arena, symbols, tiers, &all);
    let solves: Vec<Solve> = blocks
        .iter()
        .map(|block| Solve::new(block, dq.len(), &mut scheduler, symbols, private, arena))
        .collect();
    let rows = [dq.as_slice(), dp].concat();
    let (dq, dp) = (scheduler.values(dq), scheduler.values(dp));
    let mut results = [dq.as_slice(), &dp].concat();
    for solve in &solves {
        results.extend(solve.results());
    }
    let mut labels = Labels::default();
    if scheme.is_matrix() {
        labels.map(&scheduler, arena, symbols, &rows);
    }
    let formulas = formulas(blocks, symbols);
    labels.expressions(&scheduler, arena, symbols, &formulas, &all);
    let mut first = 0;
    for (solve, block) in solves.iter().zip(blocks) {
        solve.label(first, &mut labels);
        first += block.unknowns.len();
    }
    let [q, p] = match form {
        Form::Increment => ["dq", "dp"],
        Form::State => ["q1", "p1"],
    };
    labels.vector(q, 0, &dq);
    labels.vector(p, 0, &dp);
    Step {
        program: scheduler.finish(&results),
        labels,
        solves,
        dq,
        dp,
        unknowns: unknowns.to_vec(),
        results,
    }
}

/// The unknowns that have formulas, which bear their names.
pub(super) fn formulas(blocks: &[Block], symbols: &Symbols) -> Vec<(Expr, String)> {
    let formula = |block: &Block| match block.solution {
        Solution::Formula(formula) => Some((formula, symbols.name(block.unknowns[0]))),
        _ => None,
    };
    blocks.iter().filter_map(formula).collect()
}

impl Step {
    /// The body of `increment`.
    fn body(&self, private: &TokenStream, printer: &Printer<'_>, symbols: &Symbols) -> TokenStream {
        let load = printer.load(&self.results);
        let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
        let blocks = self.solves.iter().enumerate().map(|(at, solve)| {
            let solve = solve.tokens(private, printer, at, symbols);
            let after = printer.statements(Tier::Solved(at));
            quote!(#solve #after)
        });
        let (dq, dp) = (printer.array(&self.dq), printer.array(&self.dp));
        let unknowns = self.unknowns.iter().map(|&s| input_name(symbols, s));
        let time = self.uses_time(symbols).then(|| quote!(let time = state.t;));
        quote! {
            #time
            #load
            #(#start)*
            #(#blocks)*
            ::core::result::Result::Ok((#dq, #dp, [#(#unknowns),*]))
        }
    }

    fn uses_time(&self, symbols: &Symbols) -> bool {
        let is_time = |s: Symbol| matches!(symbols.meaning(s), Meaning::Time);
        self.program
            .all()
            .any(|(_, i)| matches!(i.operation, Operation::Input(s) if is_time(s)))
    }
}

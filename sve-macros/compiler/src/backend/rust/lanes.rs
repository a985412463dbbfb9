//! The step of many states at once, a lane each: loops over the lanes that the compiler turns into
//! vector instructions.
//!
//! Input: a scheme. Output: `increment_lanes`, or nothing for a system that is too large for it.
//! Invariant: no branches within a loop; what leaves the fast path is marked, and stepped by
//! `increment`. A value that a later loop needs is stored in a row of `kept`.

mod advance;
mod single;

pub(super) use advance::stores;

use std::collections::BTreeMap;

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use super::axis::Axis;
use super::code::{Place, Printer};
use super::function::Formulas;
use super::judge::accepted;
use super::pivots::{self, Sparse};
use super::solve::{Again, Policy, evaluation, names};
use super::tangents::bound;
use crate::algebra::Expr;
use crate::model::{Meaning, Symbols};
use crate::program::limits::in_lanes::BY_FORMULA;
use crate::program::{
    Factored, Loops, Operation, Residual, Step, Tier, Value, in_lanes, is_single,
};
use crate::structure::{Iteration, Linear, Matrix, Scheme, Solution, Storage};

/// `increment_lanes` of a scheme with so many degrees of freedom and noises.
pub(super) fn lanes(
    scheme: &Scheme<Expr>,
    [n, m]: [Literal; 2],
    formulas: Formulas<'_>,
) -> Option<TokenStream> {
    let Formulas {
        arena,
        symbols,
        private,
    } = formulas;
    let (step, loops) = in_lanes(scheme, symbols, arena)?;
    let printer = Printer::new(
        Place::Over(Axis::Lanes),
        &step.program,
        &step.labels,
        formulas,
    );
    let printer = printer
        .without(&loops.omitted)
        .keeping(loops.rows.keys().chain(loops.moved.values()));
    let writer = Writer {
        step: &step,
        loops: &loops,
        printer: &printer,
        symbols,
        private,
    };
    let body = writer.body();
    Some(quote! {
        #[inline(always)]
        fn increment_lanes(
            &self,
            _: &Self::Prepared,
            states: &#private::lane::StateLanes<#n>,
            next: &mut #private::lane::StateLanes<#n>,
            h: f64,
            dw: &[#private::lane::Lane; #m],
            newton: &#private::Newton,
            unknowns: &mut impl #private::lane::KeepUnknowns,
        ) -> #private::lane::Mask {
            #body
        }
    })
}

/// Writes the loops.
struct Writer<'a> {
    step: &'a Step,
    loops: &'a Loops,
    printer: &'a Printer<'a>,
    symbols: &'a Symbols,
    private: &'a TokenStream,
}

impl Writer<'_> {
    fn body(&self) -> TokenStream {
        let (private, printer) = (self.private, self.printer);
        let rows = Literal::usize_unsuffixed(self.loops.rows.len());
        let prepare = printer.statements(Tier::Prepare);
        let inputs = Axis::inputs(self.symbols, private);
        let early = (0..self.step.scheme.blocks.len())
            .filter(|&at| self.is_factored(at))
            .map(|at| self.factors(at));
        let mut tokens = quote! {
            #prepare
            #inputs
            #(#early)*
            let mut kept = #private::lane::rows::<#rows>();
        };
        let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
        let mut section = quote!(#(#start)*);
        for (at, block) in self.step.scheme.blocks.iter().enumerate() {
            let after = printer.statements(Tier::Solved(at));
            match &block.solution {
                Solution::Formula(_) => section.extend(after),
                Solution::System { linear, .. } => {
                    let solution = if self.step.scheme.is_constrained() {
                        let solution = self.solved_by_pivots(at, &linear.matrix, &linear.rhs, true);
                        quote!(#solution.by)
                    } else {
                        self.solution(at, &linear.matrix, &self.printer.array(&linear.rhs))
                    };
                    let solved = bound(&self.step.scheme, at, &solution, self.symbols);
                    section.extend(quote!(#solved #after));
                }
                Solution::Iteration(iteration) => {
                    let course = course(at);
                    section.extend(self.start(at, iteration));
                    let one = self.one(self.loops.of_block[at], &section);
                    let declared = self.declared(at, iteration);
                    let iterate = self.iterate(at, iteration);
                    tokens.extend(quote! {
                        #declared
                        #one
                        #iterate
                    });
                    let solution = quote!(#course.point(lane));
                    let solved = bound(&self.step.scheme, at, &solution, self.symbols);
                    section = match self.judge(&course, iteration) {
                        Some([limits, judge]) => quote!(#solved #limits #after #judge),
                        None => quote!(#solved #after),
                    };
                }
            }
        }
        section.extend(self.advance());
        let last = self.one(self.loops.uses.len() - 1, &section);
        let (solved, _) = self.solved();
        quote! {
            #tokens
            let mut any = 0u64;
            #last
            next.restore_unsolved(states, any, |lane| #solved)
        }
    }

    /// Prints a loop over the lanes: loads values that earlier loops kept, computes, keeps values
    /// for later loops.
    fn one(&self, number: usize, statements: &TokenStream) -> TokenStream {
        let take = self.loops.uses[number].iter().map(|&value| {
            let instruction = self.step.program.get(value);
            if self.is_read_again(value) {
                return self.printer.statement(value, instruction.operation);
            }
            let (name, kept) = (self.printer.operand(value), self.kept(value));
            quote!(let #name = #kept;)
        });
        let keep = self.loops.rows.keys().filter_map(|&value| {
            let tier = self.step.program.get(value).tier;
            let computed = self.loops.of_tier(tier, self.step) == Some(number);
            let (name, kept) = (self.printer.operand(value), self.kept(value));
            (computed && !self.is_read_again(value)).then(|| quote!(#kept = #name;))
        });
        let body = quote!(#(#take)* #statements #(#keep)*);
        Axis::Lanes.sweep(&body, self.private)
    }

    fn kept(&self, value: Value) -> TokenStream {
        Axis::Lanes.kept(self.loops.rows.get(&value).copied().unwrap_or_default())
    }

    /// Returns whether a value is an input that each loop can read. The last loop alone changes
    /// states.
    fn is_read_again(&self, value: Value) -> bool {
        match self.step.program.get(value).operation {
            Operation::Input(symbol) => !matches!(
                self.symbols.meaning(symbol),
                Meaning::Unknown(_) | Meaning::Limit(_) | Meaning::End(_)
            ),
            _ => false,
        }
    }

    /// Returns whether the matrix of the first solves of a block is factored before the loops. In a
    /// loop, the compiler finds that several solves without branches share an elimination.
    fn is_factored(&self, at: usize) -> bool {
        let scheme = &self.step.scheme;
        !scheme.is_constrained()
            && scheme.blocks[at].factored(&self.step.program) == Factored::InPrepare
    }

    /// The statement that factors the matrix of the first solves of a block.
    fn factors(&self, at: usize) -> Option<TokenStream> {
        let matrix = self.step.scheme.blocks[at].solution.first_matrix()?;
        let (private, name) = (self.private, factors(at));
        let matrix = self.printer.matrix(&matrix.rows);
        Some(quote!(let #name = #private::lane::factored(&#matrix);))
    }

    /// A solve of a step with constraints, with the sign of the determinant. If `tests_pivots` is
    /// set, the solution is NaN where the scalar step finds dependent constraints.
    fn solved_by_pivots(
        &self,
        at: usize,
        matrix: &Matrix<Value>,
        rhs: &[Value],
        tests_pivots: bool,
    ) -> TokenStream {
        let (private, printer) = (self.private, self.printer);
        let size = matrix.size();
        let pivots = self.step.scheme.blocks[at].pivots.as_ref();
        if let Some(pivots) = pivots.filter(|_| size > BY_FORMULA) {
            let mut entries = BTreeMap::new();
            for row in 0..size {
                let stored = matrix.row(row).filter(|x| !printer.is_zero(x.1));
                entries.extend(stored.map(|(column, e)| ((row, column), printer.operand(e))));
            }
            let rhs = rhs.iter().map(|&b| printer.operand(b)).collect();
            let system = Sparse { entries, rhs };
            return pivots::solved(&system, &pivots.0, tests_pivots, private);
        }
        let (matrix, rhs) = (printer.matrix(&matrix.rows), printer.array(rhs));
        quote!(#private::lane::solved(&#matrix, &#rhs))
    }

    /// A first solve of a block with its matrix. A block without constraints has no banded matrix.
    fn solution(&self, at: usize, matrix: &Matrix<Value>, rhs: &TokenStream) -> TokenStream {
        let private = self.private;
        if self.is_factored(at) {
            let factors = factors(at);
            return quote!(#factors.solve(&#rhs));
        }
        match matrix.storage {
            Storage::Diagonal => {
                let diagonal: Vec<Value> = matrix.stored().collect();
                let diagonal = self.printer.array(&diagonal);
                quote!(#private::lane::solve_diagonal(&#diagonal, &#rhs))
            }
            Storage::Dense | Storage::Cofactors | Storage::Banded(_) => {
                let matrix = self.printer.matrix(&matrix.rows);
                quote!(#private::lane::solve(&#matrix, &#rhs))
            }
        }
    }

    /// The start of an iteration: its guess, and what its root is accepted by.
    fn start(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let course = course(at);
        if self.is_single(at) {
            return self.start_single(at, iteration);
        }
        if !iteration.needs_guess {
            let (guess, limit) = (self.guess(at, iteration), self.limit(at, iteration));
            return quote!(#course.start(lane, #guess, #limit););
        }
        let Linear { matrix, rhs } = &iteration.guess;
        let guess = self.solved_by_pivots(at, matrix, rhs, true);
        let sign = match iteration.limit {
            Some(_) => quote!(guess.determinant),
            None => quote!(f64::NAN),
        };
        quote! {
            let guess = #guess;
            #course.start(lane, guess.by, #sign);
        }
    }

    fn guess(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let Linear { matrix, rhs } = &iteration.guess;
        let first = self.solution(at, matrix, &self.printer.array(rhs));
        if iteration.refinements.is_empty() {
            return first;
        }
        let again = Again {
            solve: &|rhs| self.solution(at, matrix, rhs),
            policy: Policy::Mask,
        };
        let refined = again.refined(at, iteration, self.printer);
        quote!({ let guess = #first; #refined })
    }

    /// The limit of no noise and h → 0, where it is asked for.
    fn limit(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        match &iteration.judge {
            None => quote!([f64::NAN; #size]),
            Some(judge) => {
                let matrix = iteration.limit.as_ref().unwrap_or(&iteration.guess.matrix);
                self.solution(at, matrix, &self.printer.array(&judge.limit_rhs))
            }
        }
    }

    /// Names of the limit, and the test of a solution.
    fn judge(
        &self,
        course: &Ident,
        iteration: &Iteration<Value, Residual>,
    ) -> Option<[TokenStream; 2]> {
        let judge = iteration.judge.as_ref()?;
        let limit = names(&judge.limit, self.symbols);
        let accepted = accepted(&judge.bounds, self.printer, self.private);
        Some([
            quote!(let #limit = #course.limit(lane);),
            quote!(#course.accept(lane, #accepted);),
        ])
    }

    /// The variables that an iteration needs in all its loops.
    fn declared(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let (private, course) = (self.private, course(at));
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let kind = if self.is_single(at) {
            quote!(SingleLanes)
        } else if iteration.needs_guess {
            quote!(ContractingLanes::<#size>)
        } else {
            quote!(NewtonLanes::<#size>)
        };
        let angles = self.angles_at_guess(at);
        quote! {
            let mut #course = #private::lane::#kind::new(newton);
            #angles
        }
    }

    fn iterate(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let course = course(at);
        let iterates = names(&iteration.iterates, self.symbols);
        let statements = self.statements_from_guess(at);
        let evaluation = self.evaluation(at, iteration);
        let body = quote! {
            let #iterates = #course.point(lane);
            #statements
            #course.update(lane, &#evaluation);
        };
        let body = self.one(self.loops.of_block[at] + 1, &body);
        quote!(while #course.next_iteration() { #body })
    }

    /// The evaluation at a point, from the statements of the iteration.
    fn evaluation(&self, at: usize, iteration: &Iteration<Value, Residual>) -> TokenStream {
        let jacobian = if iteration.needs_guess {
            let residuals: Vec<Value> = iteration.residual.iter().map(|r| r.value).collect();
            self.solved_by_pivots(at, &iteration.jacobian, &residuals, false)
        } else {
            self.printer.matrix(&iteration.jacobian.rows)
        };
        evaluation(iteration, &jacobian, self.printer)
    }
}

/// The iteration of a block.
fn course(at: usize) -> Ident {
    format_ident!("course_{at}")
}

/// The factors of the matrix of a block's first solves.
fn factors(at: usize) -> Ident {
    format_ident!("factors_{at}")
}

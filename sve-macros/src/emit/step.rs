//! The body of a step: the program of its tiers with the solves between them.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::names::{Labels, input_name};
use super::rounding::rounding;
use super::straight::{Straight, rows};
use crate::model::{Meaning, Symbols};
use crate::schedule::{Operation, Program, Scheduler, Tier, Tiers, Value};
use crate::structure::{Band, Block, Form, Iteration, Linear, Refinement, Scheme, Solution};
use crate::symbolic::{Arena, Expr, Symbol};

/// A step with values for expressions.
pub(super) struct Step {
    solves: Vec<Solve>,
    dq: Vec<Value>,
    dp: Vec<Value>,
    /// What the solves determine.
    unknowns: Vec<Symbol>,
    /// Every value that is used other than by an instruction.
    pub(super) results: Vec<Value>,
    pub(super) program: Program,
    /// What the values are.
    pub(super) labels: Labels,
}

/// A block with values for expressions.
enum Solve {
    Formula,
    System(System, Vec<Symbol>),
    Iteration(Box<Newton>),
}

/// A linear system.
struct System {
    matrix: Matrix,
    rhs: Vec<Value>,
}

/// The entries of a matrix, of its band where it has one.
struct Matrix {
    rows: Vec<Vec<Value>>,
    band: Option<Band>,
}

/// An iteration.
struct Newton {
    guess: System,
    refinement: Option<(Vec<Symbol>, Vec<Value>)>,
    /// Code of the guess where no linear system gives one.
    rest: TokenStream,
    /// Code that computes another guess where it stands.
    fallback: TokenStream,
    /// Code of the rounding errors of the residual.
    rounding: TokenStream,
    residual: Vec<Value>,
    magnitude: Vec<Value>,
    jacobian: Matrix,
    curvature: Option<Value>,
    iterates: Vec<Symbol>,
    solved: Vec<Symbol>,
}

/// Code of an iteration that runs where the usual course does not arrive.
struct Aside {
    rest: TokenStream,
    fallback: TokenStream,
    rounding: TokenStream,
}

/// Turns all expressions of a scheme into one program.
pub(super) fn schedule(
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
        .map(|block| match &block.solution {
            Solution::Formula(_) => Solve::Formula,
            Solution::System { linear, solved } => {
                Solve::System(system(&mut scheduler, linear), solved.clone())
            }
            Solution::Iteration(iteration) => {
                let rest = rest(iteration, dq.len());
                let aside = Aside {
                    fallback: fallback(&iteration.fallback, &rest, symbols, private, arena),
                    rounding: rounding(&iteration.residual, symbols, private, arena),
                    rest,
                };
                Solve::Iteration(Box::new(newton(&mut scheduler, iteration, aside)))
            }
        })
        .collect();
    let rows = [dq.as_slice(), dp].concat();
    let (dq, dp) = (scheduler.values(dq), scheduler.values(dp));
    let results = results(&solves, &dq, &dp);
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
fn formulas(blocks: &[Block], symbols: &Symbols) -> Vec<(Expr, String)> {
    let formula = |block: &Block| match block.solution {
        Solution::Formula(formula) => Some((formula, symbols.name(block.unknowns[0]))),
        _ => None,
    };
    blocks.iter().filter_map(formula).collect()
}

impl Solve {
    /// Says what the values of a block are, its equations counted from `first`.
    fn label(&self, first: usize, labels: &mut Labels) {
        match self {
            Self::Formula => {}
            Self::System(System { matrix, rhs }, _) => {
                matrix.label("matrix", first, labels);
                labels.vector("rhs", first, rhs);
            }
            Self::Iteration(newton) => {
                let Newton {
                    guess,
                    refinement,
                    rest: _,
                    fallback: _,
                    rounding: _,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                    iterates: _,
                    solved: _,
                } = &**newton;
                guess.matrix.label("mass", first, labels);
                labels.vector("residual", first, residual);
                jacobian.label("jacobian", first, labels);
                if let Some(curvature) = curvature {
                    labels.call(*curvature, format!("curvature_{first}"));
                }
                labels.vector("guess_rhs", first, &guess.rhs);
                if let Some((_, rhs)) = refinement {
                    labels.vector("refinement_rhs", first, rhs);
                }
                labels.vector("magnitude", first, magnitude);
            }
        }
    }
}

impl Matrix {
    /// Says what the entries are, their rows and columns counted from `first`.
    fn label(&self, name: &str, first: usize, labels: &mut Labels) {
        let Some(band) = self.band else {
            labels.matrix(name, first, &self.rows);
            return;
        };
        for (i, row) in self.rows.iter().enumerate() {
            for (k, &value) in row.iter().enumerate() {
                if let Some(j) = (i + k).checked_sub(band.lower) {
                    labels.call(value, format!("{name}_{}_{}", first + i, first + j));
                }
            }
        }
    }
}

fn system(scheduler: &mut Scheduler<'_>, linear: &Linear) -> System {
    System {
        matrix: matrix(scheduler, &linear.matrix),
        rhs: scheduler.values(&linear.rhs),
    }
}

fn matrix(scheduler: &mut Scheduler<'_>, entries: &[Vec<Expr>]) -> Matrix {
    let (band, entries) = banded(entries, scheduler.arena());
    Matrix {
        rows: entries.iter().map(|row| scheduler.values(row)).collect(),
        band,
    }
}

/// A matrix as its band, if it has one, else as it is.
fn banded<'a>(
    matrix: &'a [Vec<Expr>],
    arena: &Arena,
) -> (Option<Band>, std::borrow::Cow<'a, [Vec<Expr>]>) {
    let is_zero = |e: &&Expr| arena.constant_value(**e) == Some(0.0);
    match (
        Band::of(matrix, arena),
        matrix.iter().flatten().find(is_zero),
    ) {
        (Some(band), Some(&zero)) => (Some(band), band.rows(matrix, zero).into()),
        _ => (None, matrix.into()),
    }
}

/// Rows of entries as a matrix of the runtime.
fn typed(
    private: &TokenStream,
    band: Option<Band>,
    size: usize,
    rows: &TokenStream,
) -> TokenStream {
    let Some(band) = band else {
        return rows.clone();
    };
    let [size, lower, width] = [size, band.lower, band.width()].map(Literal::usize_unsuffixed);
    quote!(#private::Banded::<#size, #lower, #width>(#rows))
}

fn newton(scheduler: &mut Scheduler<'_>, iteration: &Iteration, aside: Aside) -> Newton {
    let Aside {
        rest,
        fallback,
        rounding,
    } = aside;
    let guess = system(scheduler, &iteration.guess);
    let refinement = iteration.refinement.as_ref();
    let refinement = refinement.map(|r| (r.first.clone(), scheduler.values(&r.rhs)));
    let jacobian = matrix(scheduler, &iteration.jacobian);
    let (residual, magnitude) = iteration
        .residual
        .iter()
        .map(|&r| scheduler.residual(r))
        .unzip();
    Newton {
        guess,
        refinement,
        rest,
        fallback,
        rounding,
        residual,
        magnitude,
        jacobian,
        curvature: iteration.curvature.map(|c| scheduler.value(c)),
        iterates: iteration.iterates.clone(),
        solved: iteration.solved.clone(),
    }
}

/// Code of a guess that is computed only after a failure, all of it where it stands.
fn fallback(
    linear: &Linear,
    rest: &TokenStream,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> TokenStream {
    let rhs = [linear.rhs.clone()];
    let (band, matrix) = banded(&linear.matrix, arena);
    let roots: Vec<Expr> = matrix.iter().flatten().chain(&rhs[0]).copied().collect();
    let matrices: [(&[Vec<Expr>], Vec<String>); 2] = [
        (&matrix, rows("matrix", matrix.len())),
        (&rhs, vec!["rhs".to_owned()]),
    ];
    let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &matrices);
    let [matrix, rhs] = arrays.as_slice() else {
        return TokenStream::new();
    };
    let matrix = typed(private, band, linear.rhs.len(), matrix);
    quote! {
        #statements
        let [rhs] = #rhs;
        match #private::solve(&#matrix, &rhs) {
            ::core::option::Option::Some(guess) => guess,
            ::core::option::Option::None => #rest,
        }
    }
}

/// The guess where no linear system gives one: rest; but where the mass vanishes at rest, a velocity of the momentum's sign.
fn rest(iteration: &Iteration, degrees_of_freedom: usize) -> TokenStream {
    let size = iteration.iterates.len();
    if iteration.singular_at_rest && size == degrees_of_freedom {
        return quote!(state.p);
    }
    let size = Literal::usize_unsuffixed(size);
    quote!([0.0; #size])
}

/// Every value that is used other than by an instruction.
fn results(solves: &[Solve], dq: &[Value], dp: &[Value]) -> Vec<Value> {
    let mut results = [dq, dp].concat();
    for solve in solves {
        match solve {
            Solve::Formula => {}
            Solve::System(System { matrix, rhs }, _) => {
                results.extend(matrix.rows.iter().flatten().chain(rhs));
            }
            Solve::Iteration(newton) => {
                let Newton {
                    guess,
                    refinement,
                    rest: _,
                    fallback: _,
                    rounding: _,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                    iterates: _,
                    solved: _,
                } = &**newton;
                results.extend(refinement.iter().flat_map(|r| &r.1));
                let matrices = guess.matrix.rows.iter().chain(&jacobian.rows).flatten();
                results.extend(
                    matrices
                        .chain(&guess.rhs)
                        .chain(residual)
                        .chain(magnitude)
                        .chain(curvature),
                );
            }
        }
    }
    results
}

impl Step {
    /// The body of `increment`.
    pub(super) fn body(
        &self,
        private: &TokenStream,
        printer: &Printer<'_>,
        symbols: &Symbols,
    ) -> TokenStream {
        let load = printer.load(&self.results);
        let start = [Tier::Noise, Tier::State].map(|tier| printer.statements(tier));
        let blocks = self.solves.iter().enumerate().map(|(at, solve)| {
            let solve = match solve {
                Solve::Formula => TokenStream::new(),
                Solve::System(system, solved) => {
                    system.tokens(private, printer, &names(solved, symbols))
                }
                Solve::Iteration(newton) => newton.tokens(private, printer, at, symbols),
            };
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

/// A pattern of names.
pub(super) fn names(list: &[Symbol], symbols: &Symbols) -> TokenStream {
    let names = list.iter().map(|&s| input_name(symbols, s));
    quote!([#(#names),*])
}

impl Matrix {
    fn tokens(&self, private: &TokenStream, printer: &Printer<'_>) -> TokenStream {
        typed(
            private,
            self.band,
            self.rows.len(),
            &printer.matrix(&self.rows),
        )
    }
}

impl System {
    fn tokens(
        &self,
        private: &TokenStream,
        printer: &Printer<'_>,
        solved: &TokenStream,
    ) -> TokenStream {
        let matrix = self.matrix.tokens(private, printer);
        let rhs = printer.array(&self.rhs);
        quote! {
            let #solved = match #private::solve(&#matrix, &#rhs) {
                ::core::option::Option::Some(solution) => solution,
                ::core::option::Option::None => {
                    return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 });
                }
            };
        }
    }
}

impl Newton {
    fn tokens(
        &self,
        private: &TokenStream,
        printer: &Printer<'_>,
        at: usize,
        symbols: &Symbols,
    ) -> TokenStream {
        let Self {
            guess,
            refinement,
            rest,
            fallback,
            rounding,
            residual,
            magnitude,
            jacobian,
            curvature,
            iterates,
            solved,
        } = self;
        let size = Literal::usize_unsuffixed(iterates.len());
        let guess_matrix = guess.matrix.tokens(private, printer);
        let guess_rhs = printer.array(&guess.rhs);
        let refine = refinement.as_ref().map(|(first, rhs)| {
            let (names, rhs) = (names(first, symbols), printer.array(rhs));
            let statements = printer.statements(Tier::Guess(at));
            let entries = (0..first.len()).map(|i| {
                let i = Literal::usize_unsuffixed(i);
                quote!(guess[#i] + refinement[#i])
            });
            // within the arm of the first solve, so that its division is done once
            quote! {
                let #names = guess;
                #statements
                match #private::solve(&#guess_matrix, &#rhs) {
                    ::core::option::Option::Some(refinement) => [#(#entries),*],
                    ::core::option::Option::None => guess,
                }
            }
        });
        let guessed = refine.unwrap_or_else(|| quote!(guess));
        let (residual, magnitude, jacobian) = (
            printer.array(residual),
            printer.array(magnitude),
            jacobian.tokens(private, printer),
        );
        let curvature = curvature.map_or_else(|| quote!(f64::NAN), |c| printer.operand(c));
        let (iterates, solved) = (names(iterates, symbols), names(solved, symbols));
        let statements = printer.statements(Tier::Iterate(at));
        quote! {
            let guess = match #private::solve(&#guess_matrix, &#guess_rhs) {
                ::core::option::Option::Some(guess) => { #guessed }
                ::core::option::Option::None => #rest,
            };
            let fallback = || { #fallback };
            let rounding = |&#iterates: &[f64; #size]| { #rounding };
            let #solved = newton.solve_or(guess, fallback, rounding, |&#iterates: &[f64; #size]| {
                #statements
                #private::Evaluation {
                    residual: #residual,
                    magnitude: #magnitude,
                    jacobian: #jacobian,
                    curvature: #curvature,
                }
            })?;
        }
    }
}

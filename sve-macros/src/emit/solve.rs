//! The solve of a block: its values, and the code that calls the runtime with them.
//!
//! Input: a block of the scheme, and the scheduler that computes its expressions. Output: values, names of values, tokens.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::count::Operations;
use super::names::{Labels, input_name};
use super::rounding::rounding;
use super::straight::{Printed, Straight, rows};
use crate::model::Symbols;
use crate::schedule::{Scheduler, Tier, Value};
use crate::structure::{Band, Block, Iteration, Linear, Solution};
use crate::symbolic::{Arena, Expr, Symbol};

/// A block with values for expressions.
pub(super) enum Solve {
    Formula,
    System(System, Vec<Symbol>),
    Iteration(Box<Newton>),
}

/// A linear system.
pub(super) struct System {
    matrix: Matrix,
    rhs: Vec<Value>,
}

/// The entries of a matrix, of its band where it has one.
struct Matrix {
    rows: Vec<Vec<Value>>,
    band: Option<Band>,
}

/// An iteration.
pub(super) struct Newton {
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

impl Solve {
    /// The values of a block in a step of so many degrees of freedom.
    pub(super) fn new(
        block: &Block,
        degrees_of_freedom: usize,
        scheduler: &mut Scheduler<'_>,
        symbols: &Symbols,
        private: &TokenStream,
        arena: &Arena,
    ) -> Self {
        match &block.solution {
            Solution::Formula(_) => Self::Formula,
            Solution::System { linear, solved } => {
                Self::System(system(scheduler, linear), solved.clone())
            }
            Solution::Iteration(iteration) => {
                let rest = rest(iteration, degrees_of_freedom);
                let aside = Aside {
                    fallback: start(&iteration.fallback, &rest, symbols, private, arena).0,
                    rounding: rounding(&iteration.residual, symbols, private, arena),
                    rest,
                };
                Self::Iteration(Box::new(newton(scheduler, iteration, aside)))
            }
        }
    }

    /// Every value that is used other than by an instruction.
    pub(super) fn results(&self) -> Vec<Value> {
        match self {
            Self::Formula => Vec::new(),
            Self::System(System { matrix, rhs }, _) => {
                matrix.rows.iter().flatten().chain(rhs).copied().collect()
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
                let matrices = guess.matrix.rows.iter().chain(&jacobian.rows).flatten();
                let refined = refinement.iter().flat_map(|r| &r.1);
                let vectors = guess.rhs.iter().chain(residual).chain(magnitude);
                let all = refined.chain(matrices).chain(vectors).chain(curvature);
                all.copied().collect()
            }
        }
    }

    pub(super) fn tokens(
        &self,
        private: &TokenStream,
        printer: &Printer<'_>,
        at: usize,
        symbols: &Symbols,
    ) -> TokenStream {
        match self {
            Self::Formula => TokenStream::new(),
            Self::System(system, solved) => {
                system.tokens(private, printer, &names(solved, symbols))
            }
            Self::Iteration(newton) => newton.tokens(private, printer, at, symbols),
        }
    }

    /// Says what the values of a block are, its equations counted from `first`.
    pub(super) fn label(&self, first: usize, labels: &mut Labels) {
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
            let begin = band.begin(i);
            for (k, &value) in row.iter().enumerate() {
                labels.call(value, format!("{name}_{}_{}", first + i, first + begin + k));
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

/// Code of a guess that is computed where it stands, all of it: the solution of a linear system, or else rest. With its
/// operations, the solve not counted.
pub(super) fn start(
    linear: &Linear,
    rest: &TokenStream,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> (TokenStream, Operations) {
    let rhs = [linear.rhs.clone()];
    let (band, matrix) = banded(&linear.matrix, arena);
    let roots: Vec<Expr> = matrix.iter().flatten().chain(&rhs[0]).copied().collect();
    let mut straight = Straight::new(arena, symbols, &roots);
    let values = [
        (straight.values(&matrix), rows("matrix", matrix.len())),
        (straight.values(&rhs), vec!["rhs".to_owned()]),
    ];
    let Printed {
        statements,
        arrays,
        operations,
    } = straight.print(private, &values);
    let [matrix, rhs] = arrays.as_slice() else {
        return (TokenStream::new(), operations);
    };
    let matrix = typed(private, band, linear.rhs.len(), matrix);
    let tokens = quote! {
        #statements
        let [rhs] = #rhs;
        match #private::solve(&#matrix, &rhs) {
            ::core::option::Option::Some(guess) => guess,
            ::core::option::Option::None => #rest,
        }
    };
    (tokens, operations)
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

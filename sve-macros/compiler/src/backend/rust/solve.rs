//! The solve of a block of single states: code that calls the runtime with the block's values.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::count::Operations;
use super::names::input_name;
use super::rounding::rounding;
use super::straight::{Printed, Straight, rows};
use super::values::{Matrix, Newton, Solve, System, Verdict, banded};
use crate::algebra::{Arena, Expr, Symbol};
use crate::program::Tier;
use crate::structure::{Band, Block, Enclosure, Iteration, Linear, Refinement, Solution};
use crate::system::model::Symbols;

/// Writes solves.
pub(super) struct Solver<'a> {
    pub(super) private: &'a TokenStream,
    pub(super) printer: &'a Printer<'a>,
    pub(super) symbols: &'a Symbols,
    pub(super) arena: &'a Arena,
}

impl Solver<'_> {
    /// The solve of the block number `at`, whose unknowns are those from number `first` on of what the step solves for, in a
    /// step of so many degrees of freedom.
    pub(super) fn tokens(
        &self,
        (at, first): (usize, usize),
        solve: &Solve,
        block: &Block,
        degrees_of_freedom: usize,
    ) -> TokenStream {
        match (solve, &block.solution) {
            (Solve::System(system), Solution::System { solved, .. }) => {
                self.system(system, &names(solved, self.symbols))
            }
            (Solve::Iteration(newton), Solution::Iteration(iteration)) => {
                self.newton((at, first), newton, iteration, degrees_of_freedom)
            }
            _ => TokenStream::new(),
        }
    }

    fn system(&self, system: &System, solved: &TokenStream) -> TokenStream {
        let private = self.private;
        let matrix = self.matrix(&system.matrix);
        let rhs = self.printer.array(&system.rhs);
        quote! {
            let #solved = match #private::solve(&#matrix, &#rhs) {
                ::core::option::Option::Some(solution) => solution,
                ::core::option::Option::None => {
                    return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 });
                }
            };
        }
    }

    fn matrix(&self, matrix: &Matrix) -> TokenStream {
        let rows = self.printer.matrix(&matrix.rows);
        typed(self.private, matrix.band, matrix.rows.len(), &rows)
    }

    fn newton(
        &self,
        (at, first): (usize, usize),
        newton: &Newton,
        iteration: &Iteration,
        degrees_of_freedom: usize,
    ) -> TokenStream {
        let Self {
            private,
            printer,
            symbols,
            arena,
        } = self;
        let Newton {
            guess,
            origin,
            refinement: _,
            residual,
            magnitude,
            jacobian,
            curvature,
            judge,
        } = newton;
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let rest = rest(iteration, degrees_of_freedom);
        let (fallback, _) = start(&iteration.fallback, &rest, symbols, private, arena);
        let rounding = rounding(&iteration.residual, symbols, private, arena);
        let (matrix, rhs) = (self.matrix(&guess.matrix), printer.array(&guess.rhs));
        let guessed = self.refined(at, newton, iteration, &matrix);
        let (residual, magnitude) = (printer.array(residual), printer.array(magnitude));
        let jacobian = self.matrix(jacobian);
        let curvature = curvature.map_or_else(|| quote!(f64::NAN), |c| printer.operand(c));
        let iterates = names(&iteration.iterates, symbols);
        let solved = names(&iteration.solved, symbols);
        let statements = printer.statements(Tier::Iterate(at));
        // the matrix of the guess is the one of the limit
        let (oriented, origin) = match origin {
            Some(_) => (quote!(origin), quote!(origin)),
            None => (quote!(_), quote!(#private::DeterminantSign::UNKNOWN)),
        };
        let limit = judge.as_ref().map(|verdict| match &verdict.limit_rhs {
            None => quote!(guess),
            Some(rhs) => {
                let rhs = printer.array(rhs);
                quote!(match #private::solve(&#matrix, &#rhs) {
                    ::core::option::Option::Some(limit) => limit,
                    ::core::option::Option::None => [f64::NAN; #size],
                })
            }
        });
        let limit = limit.unwrap_or_else(|| quote!([f64::NAN; #size]));
        let (first, judged) = (Literal::usize_unsuffixed(first), judge.is_some());
        let limits = iteration.judge.as_ref().map(|j| {
            let names = names(&j.limit, symbols);
            quote!(let #names = limit;)
        });
        quote! {
            let (guess, origin, limit) = match #private::solve_with_sign(&#matrix, &#rhs) {
                ::core::option::Option::Some((guess, #oriented)) => ({ #guessed }, #origin, #limit),
                ::core::option::Option::None => (#rest, #private::DeterminantSign::UNKNOWN, [f64::NAN; #size]),
            };
            let fallback = || { #fallback };
            let rounding = |&#iterates: &[f64; #size]| { #rounding };
            let block = #private::BlockProperties { first: #first, has_bounds: #judged, limit_sign: origin };
            #limits
            let #solved = newton.solve_block(block, guess, fallback, rounding, |&#iterates: &[f64; #size]| {
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

    /// The test of the solution of a block, after the values that it needs.
    pub(super) fn judge(&self, solve: &Solve, block: &Block) -> TokenStream {
        let (Solve::Iteration(newton), Solution::Iteration(iteration)) = (solve, &block.solution)
        else {
            return TokenStream::new();
        };
        let (Some(verdict), Some(judge)) = (&newton.judge, &iteration.judge) else {
            return TokenStream::new();
        };
        let private = self.private;
        let accepted = accepted(verdict, self.printer, private);
        let (full, or_full) = match &judge.full {
            None => (None, None),
            Some(bounds) => {
                let full = self.full(bounds);
                let full = quote!(let full = || { #full };);
                (Some(full), Some(quote!(&& !#private::cold(full))))
            }
        };
        quote! {
            #full
            if newton.tests_bounds() && !(#accepted) #or_full {
                return ::core::result::Result::Err(#private::SolveError::OtherBranch);
            }
        }
    }

    /// Statements and the value of the test by the full bounds, computed where they stand.
    fn full(&self, bounds: &Enclosure) -> TokenStream {
        let Self {
            private,
            printer: _,
            symbols,
            arena,
        } = self;
        let Enclosure {
            middle,
            radii,
            conditions,
        } = bounds;
        let roots: Vec<Expr> = bounds.exprs().copied().collect();
        let conditions = [conditions.clone()];
        let parts: [(&[Vec<Expr>], Vec<String>); 3] = [
            (middle, rows("middle", middle.len())),
            (radii, rows("radius", radii.len())),
            (&conditions, vec!["distance".to_owned()]),
        ];
        let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &parts);
        let [middle, radii, distances] = arrays.as_slice() else {
            return quote!(false);
        };
        quote! {
            #statements
            let [distances] = #distances;
            #private::is_regular_within(&#middle, &#radii) && #private::all_positive(&distances)
        }
    }

    /// A guess after its second stage, if there is one.
    fn refined(
        &self,
        at: usize,
        newton: &Newton,
        iteration: &Iteration,
        matrix: &TokenStream,
    ) -> TokenStream {
        let (Some(rhs), Some(Refinement { first, .. })) =
            (&newton.refinement, &iteration.refinement)
        else {
            return quote!(guess);
        };
        let private = self.private;
        let (names, rhs) = (names(first, self.symbols), self.printer.array(rhs));
        let statements = self.printer.statements(Tier::Guess(at));
        let sum = sum_of_stages(first.len());
        // within the arm of the first solve, so that its division is done once
        quote! {
            let #names = guess;
            #statements
            match #private::solve(&#matrix, &#rhs) {
                ::core::option::Option::Some(refinement) => #sum,
                ::core::option::Option::None => guess,
            }
        }
    }
}

/// Whether a solution is accepted: the conditions hold and every matrix within the radii is regular.
pub(super) fn accepted(
    verdict: &Verdict,
    printer: &Printer<'_>,
    private: &TokenStream,
) -> TokenStream {
    let Verdict {
        limit_rhs: _,
        middle,
        radii,
        conditions,
    } = verdict;
    let (middle, radii) = (printer.matrix(middle), printer.matrix(radii));
    let conditions = conditions.iter().map(|&c| printer.operand(c));
    quote!(#private::is_regular_within(&#middle, &#radii) #(& (#conditions > 0f64))*)
}

/// The sum of the two stages of a guess.
pub(super) fn sum_of_stages(size: usize) -> TokenStream {
    let entries = (0..size).map(|i| {
        let i = Literal::usize_unsuffixed(i);
        quote!(guess[#i] + refinement[#i])
    });
    quote!([#(#entries),*])
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

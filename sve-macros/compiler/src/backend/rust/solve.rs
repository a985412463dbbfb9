//! The solve of a block of single states: code that calls the runtime with the block's values.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::factors::Factors;
use super::ident;
use super::rounding::rounding;
use super::straight::{Printed, Straight, rows};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Symbols;
use crate::program::{Operations, Residual, Tier, Value, symbol_name};
use crate::structure::{
    Enclosure, Iteration, Linear, Matrix, PathJudge, Refinement, Solution, Storage,
};

/// Writes solves.
pub(super) struct Solver<'a> {
    pub(super) private: &'a TokenStream,
    pub(super) printer: &'a Printer<'a>,
    pub(super) symbols: &'a Symbols,
    pub(super) arena: &'a Arena,
    pub(super) factors: &'a Factors<'a>,
    /// Whether the step fails where the matrix of a limit, which has the determinant of the mass matrix, is singular.
    pub(super) finds_singular_masses: bool,
    /// What reads the entries of the state in closures of the rarely taken paths.
    pub(super) reopen: &'a TokenStream,
}

impl Solver<'_> {
    /// The solve of the block number `at`, whose unknowns are those from number `first` on of what the step solves for, in a
    /// step of so many degrees of freedom.
    pub(super) fn tokens(
        &self,
        (at, first): (usize, usize),
        solution: &Solution<Value, Residual>,
        degrees_of_freedom: usize,
    ) -> TokenStream {
        match solution {
            Solution::Formula(_) => TokenStream::new(),
            Solution::System { linear, solved } => {
                self.system(at, linear, &names(solved, self.symbols))
            }
            Solution::Iteration(iteration) => {
                self.newton((at, first), iteration, degrees_of_freedom)
            }
        }
    }

    fn system(&self, at: usize, system: &Linear<Value>, solved: &TokenStream) -> TokenStream {
        let private = self.private;
        let matrix = self.matrix(&system.matrix);
        let rhs = self.printer.array(&system.rhs);
        let solution = match self.factors.of(at, &matrix, private) {
            Some(factors) => quote!(#factors.as_ref().map(|factors| factors.solve(&#rhs))),
            None => quote!(#private::solve(&#matrix, &#rhs)),
        };
        quote! {
            let #solved = match #solution {
                ::core::option::Option::Some(solution) => solution,
                ::core::option::Option::None => {
                    return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 });
                }
            };
        }
    }

    fn matrix(&self, matrix: &Matrix<Value>) -> TokenStream {
        let rows = self.printer.matrix(&matrix.rows);
        typed(self.private, matrix, &rows)
    }

    fn newton(
        &self,
        (at, first): (usize, usize),
        iteration: &Iteration<Value, Residual>,
        degrees_of_freedom: usize,
    ) -> TokenStream {
        let Self {
            private,
            printer,
            symbols,
            arena,
            factors,
            finds_singular_masses,
            reopen,
        } = self;
        let Iteration {
            guess,
            limit,
            residual,
            jacobian,
            curvature,
            judge,
            ..
        } = iteration;
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let rest = rest(iteration, degrees_of_freedom);
        let (fallback, _) = start(&iteration.fallback, &rest, symbols, private, arena);
        let equations: Vec<Expr> = residual.iter().map(|r| r.expr).collect();
        let rounding = rounding(&equations, symbols, private, arena);
        let (matrix, rhs) = (self.matrix(&guess.matrix), printer.array(&guess.rhs));
        let factors = factors.of(at, &matrix, private);
        let again = Again {
            matrix: &matrix,
            is_factored: factors.is_some(),
            private,
        };
        let guessed = self.refined(at, iteration, &again);
        let [residual, magnitude] = residuals(residual, printer);
        let jacobian = self.matrix(jacobian);
        let curvature = curvature.map_or_else(|| quote!(f64::NAN), |c| printer.operand(c));
        let iterates = names(&iteration.iterates, symbols);
        let solved = names(&iteration.solved, symbols);
        let statements = printer.statements(Tier::Iterate(at));
        // the matrix of the guess is the one of the limit
        let (oriented, origin) = match (limit, &factors) {
            (Some(_), None) => (quote!(origin), quote!(origin)),
            (Some(_), Some(_)) => (quote!(factors), quote!(factors.sign())),
            (None, _) => (quote!(_), quote!(#private::DeterminantSign::UNKNOWN)),
        };
        let limit = judge.as_ref().map(|judge| {
            if iteration.limit_is_guess(judge) {
                return quote!(guess);
            }
            let rhs = printer.array(&judge.limit_rhs);
            let none = quote!([f64::NAN; #size]);
            again.solve(&rhs, &quote!(limit), &quote!(limit), &none)
        });
        let limit = limit.unwrap_or_else(|| quote!([f64::NAN; #size]));
        let first = Literal::usize_unsuffixed(first);
        let judged = judge.is_some() || iteration.path.is_some();
        let constrained = iteration.needs_guess;
        let limits = judge.as_ref().map(|j| {
            let names = names(&j.limit, symbols);
            quote!(let #names = limit;)
        });
        let attempt = match factors {
            Some(factors) => {
                quote!(#factors.as_ref().map(|factors| (factors.solve(&#rhs), factors)))
            }
            None => quote!(#private::solve_with_sign(&#matrix, &#rhs)),
        };
        let without_guess = if iteration.needs_guess || *finds_singular_masses {
            quote!(return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 }))
        } else {
            quote!((#rest, #private::DeterminantSign::UNKNOWN, [f64::NAN; #size]))
        };
        quote! {
            let (guess, origin, limit) = match #attempt {
                ::core::option::Option::Some((guess, #oriented)) => ({ #guessed }, #origin, #limit),
                ::core::option::Option::None => #without_guess,
            };
            let fallback = || { #reopen #fallback };
            let rounding = |&#iterates: &[f64; #size]| { #reopen #rounding };
            let block = #private::BlockProperties { first: #first, has_bounds: #judged, needs_strong_contraction: #constrained, limit_sign: origin };
            #limits
            let #solved = newton.solve_block(block, &guess, fallback, rounding, |&#iterates: &[f64; #size]| {
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
    pub(super) fn judge(&self, solution: &Solution<Value, Residual>) -> TokenStream {
        let Solution::Iteration(iteration) = solution else {
            return TokenStream::new();
        };
        if let Some(path) = &iteration.path {
            return self.path(path);
        }
        let Some(judge) = &iteration.judge else {
            return TokenStream::new();
        };
        let private = self.private;
        let accepted = accepted(&judge.bounds, self.printer, private);
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
    fn full(&self, bounds: &Enclosure<Expr>) -> TokenStream {
        let Self {
            private,
            printer: _,
            symbols,
            arena,
            factors: _,
            finds_singular_masses: _,
            reopen,
        } = self;
        let Enclosure {
            middle,
            radii,
            conditions,
        } = bounds;
        let roots: Vec<Expr> = bounds.entries().copied().collect();
        let conditions = [conditions.clone()];
        let parts: [(&[Vec<Expr>], Vec<String>); 3] = [
            (&middle.rows, rows("middle", middle.rows.len())),
            (radii, rows("radius", radii.len())),
            (&conditions, vec!["distance".to_owned()]),
        ];
        let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &parts);
        let [middle_rows, radii, distances] = arrays.as_slice() else {
            return quote!(false);
        };
        let middle = typed(private, middle, middle_rows);
        quote! {
            #reopen
            #statements
            let [distances] = #distances;
            #private::is_regular_within(&#middle, &#radii) && #private::all_positive(&distances)
        }
    }

    /// The test of the solution of a block with multipliers of constraints, computed where it stands.
    fn path(&self, judge: &PathJudge) -> TokenStream {
        let Self {
            private,
            printer: _,
            symbols,
            arena,
            factors: _,
            reopen,
            finds_singular_masses: _,
        } = self;
        let PathJudge {
            limit,
            of_limit,
            bounds,
            reach,
            defects,
        } = judge;
        let size = Literal::usize_unsuffixed(limit.len());
        let none = quote!([f64::NAN; #size]);
        let (of_limit, _) = start(of_limit, &none, symbols, private, arena);
        let names = names(limit, symbols);
        let roots: Vec<Expr> = bounds
            .entries()
            .chain(reach)
            .chain(defects)
            .copied()
            .collect();
        let lists = [defects, reach, &bounds.conditions].map(|list| [list.clone()]);
        let parts: [(&[Vec<Expr>], Vec<String>); 5] = [
            (
                &bounds.middle.rows,
                rows("middle", bounds.middle.rows.len()),
            ),
            (&bounds.radii, rows("radius", bounds.radii.len())),
            (&lists[0], vec!["defect".to_owned()]),
            (&lists[1], vec!["reach".to_owned()]),
            (&lists[2], vec!["distance".to_owned()]),
        ];
        let (statements, arrays) = Straight::new(arena, symbols, &roots).finish(private, &parts);
        let [middle, radii, defects, reach, distances] = arrays.as_slice() else {
            return TokenStream::new();
        };
        let middle = typed(private, &bounds.middle, middle);
        quote! {
            let full = || {
                let #names = { #reopen #of_limit };
                #reopen
                #statements
                let ([defects], [reach], [distances]) = (#defects, #reach, #distances);
                #private::contains_path(&#middle, &#radii, &defects, &reach) && #private::all_positive(&distances)
            };
            if newton.tests_paths() && !#private::cold(full) {
                return ::core::result::Result::Err(#private::SolveError::OtherBranch);
            }
        }
    }

    /// A guess after its later stages.
    fn refined(
        &self,
        at: usize,
        iteration: &Iteration<Value, Residual>,
        again: &Again<'_>,
    ) -> TokenStream {
        // each stage within the arm of the solve before, so that a division of theirs is done once
        let stages = iteration.refinements.iter().enumerate().rev();
        let guess = quote!(guess);
        let refined = stages.fold(None, |later, (stage, Refinement { first, rhs })| {
            let names = names(first, self.symbols);
            let statements = self.printer.statements(Tier::Guess(at, stage));
            let sum = sum_of_stages(first.len());
            let rhs = self.printer.array(rhs);
            let sum = match later {
                Some(later) => quote!({ let guess = #sum; #later }),
                None => sum,
            };
            let refined = again.solve(&rhs, &quote!(refinement), &sum, &guess);
            Some(quote! {
                let #names = guess;
                #statements
                #refined
            })
        });
        refined.unwrap_or(guess)
    }
}

/// A further solve with the matrix of a block's first solve, beside that one.
struct Again<'a> {
    matrix: &'a TokenStream,
    /// Whether `factors` are those of the matrix.
    is_factored: bool,
    private: &'a TokenStream,
}

impl Again<'_> {
    /// The value of `with`, in which the solution is `name`; or `without` if the matrix is singular.
    fn solve(
        &self,
        rhs: &TokenStream,
        name: &TokenStream,
        with: &TokenStream,
        without: &TokenStream,
    ) -> TokenStream {
        let Self {
            matrix, private, ..
        } = self;
        if self.is_factored {
            return quote!({
                let #name = factors.solve(&#rhs);
                #with
            });
        }
        quote!(match #private::solve(&#matrix, &#rhs) {
            ::core::option::Option::Some(#name) => #with,
            ::core::option::Option::None => #without,
        })
    }
}

/// Whether a solution is accepted: the conditions hold and every matrix within the radii is regular.
pub(super) fn accepted(
    bounds: &Enclosure<Value>,
    printer: &Printer<'_>,
    private: &TokenStream,
) -> TokenStream {
    let Enclosure {
        middle,
        radii,
        conditions,
    } = bounds;
    let middle = typed(private, middle, &printer.matrix(&middle.rows));
    let radii = printer.matrix(radii);
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

/// Residuals, and their magnitudes.
pub(super) fn residuals(residuals: &[Residual], printer: &Printer<'_>) -> [TokenStream; 2] {
    let array = |of: fn(&Residual) -> Value| {
        let values: Vec<Value> = residuals.iter().map(of).collect();
        printer.array(&values)
    };
    [array(|r| r.value), array(|r| r.magnitude)]
}

/// Printed rows of stored entries as a matrix of the runtime.
pub(super) fn typed<T: Copy>(
    private: &TokenStream,
    matrix: &Matrix<T>,
    rows: &TokenStream,
) -> TokenStream {
    match matrix.storage {
        Storage::Dense => rows.clone(),
        Storage::Cofactors => quote!(#private::Cofactors(#rows)),
        Storage::Diagonal => quote!(#private::Diagonal(#rows)),
        Storage::Banded(band) => {
            let numbers = [matrix.size(), band.lower, band.width()];
            let [size, lower, width] = numbers.map(Literal::usize_unsuffixed);
            quote!(#private::Banded::<#size, #lower, #width>(#rows))
        }
    }
}

/// Code of a guess that is computed where it stands, all of it: the solution of a linear system, or else rest. With its
/// operations, the solve not counted.
pub(super) fn start(
    linear: &Linear<Expr>,
    rest: &TokenStream,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> (TokenStream, Operations) {
    let (stored, rhs) = (&linear.matrix.rows, [linear.rhs.clone()]);
    let roots: Vec<Expr> = stored.iter().flatten().chain(&rhs[0]).copied().collect();
    let mut straight = Straight::new(arena, symbols, &roots);
    let values = [
        (straight.values(stored), rows("matrix", stored.len())),
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
    let matrix = typed(private, &linear.matrix, matrix);
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
fn rest(iteration: &Iteration<Value, Residual>, degrees_of_freedom: usize) -> TokenStream {
    let size = iteration.iterates.len();
    if iteration.limit.is_none() && size == degrees_of_freedom {
        return quote!(state.p);
    }
    let size = Literal::usize_unsuffixed(size);
    quote!([0.0; #size])
}

/// A pattern of names.
pub(super) fn names(list: &[Symbol], symbols: &Symbols) -> TokenStream {
    let names = list.iter().map(|&s| ident(&symbol_name(symbols, s)));
    quote!([#(#names),*])
}

//! The solve of a block of single states: code that calls the runtime with the block's values.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::cold::Cold;
use super::factors::Factors;
use super::function::{Formulas, Printed};
use super::ident;
use super::rounding::rounding;
use crate::algebra::{Expr, Symbol};
use crate::model::Symbols;
use crate::program::{Array, Operations, Residual, Tier, Value, entries, symbol_name};
use crate::structure::{Enclosure, Iteration, Linear, Matrix, PathJudge, Refinement, Solution};

/// Writes solves.
pub(super) struct Solver<'a> {
    pub(super) formulas: Formulas<'a>,
    pub(super) printer: &'a Printer<'a>,
    pub(super) factors: &'a Factors<'a>,
    /// Whether the step fails where the matrix of a limit, which has the determinant of the mass matrix, is singular.
    pub(super) finds_singular_masses: bool,
    pub(super) cold: &'a Cold<'a>,
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
                self.system(at, linear, &names(solved, self.formulas.symbols))
            }
            Solution::Iteration(iteration) => {
                self.newton((at, first), iteration, degrees_of_freedom)
            }
        }
    }

    fn system(&self, at: usize, system: &Linear<Value>, solved: &TokenStream) -> TokenStream {
        let private = self.formulas.private;
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
        self.printer.stored(matrix.storage, &matrix.rows)
    }

    fn newton(
        &self,
        (at, first): (usize, usize),
        iteration: &Iteration<Value, Residual>,
        degrees_of_freedom: usize,
    ) -> TokenStream {
        let Self {
            formulas,
            printer,
            factors,
            finds_singular_masses,
            cold,
        } = self;
        let Formulas {
            symbols, private, ..
        } = *formulas;
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
        let vector = quote!([f64; #size]);
        let (fallback, _) = start(&iteration.fallback, &rest, *formulas);
        let entries = iteration.fallback.entries();
        let fallback = cold.function(("fallback", at), (&entries, &[]), (&vector, &fallback));
        let equations: Vec<Expr> = residual.iter().map(|r| r.expr).collect();
        let rounding = rounding(&equations, *formulas);
        let rounding = cold.function(("rounding", at), (&equations, &[]), (&vector, &rounding));
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
            let fallback = || #fallback;
            let rounding = |&#iterates: &[f64; #size]| #rounding;
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
    pub(super) fn judge(&self, at: usize, solution: &Solution<Value, Residual>) -> TokenStream {
        let Solution::Iteration(iteration) = solution else {
            return TokenStream::new();
        };
        if let Some(path) = &iteration.path {
            return self.path(at, path);
        }
        let Some(judge) = &iteration.judge else {
            return TokenStream::new();
        };
        let private = self.formulas.private;
        let accepted = accepted(&judge.bounds, self.printer, private);
        let or_full = judge.full.as_ref().map(|bounds| {
            let full = self.full(at, bounds);
            quote!(&& !#full)
        });
        quote! {
            if newton.tests_bounds() && !(#accepted) #or_full {
                return ::core::result::Result::Err(#private::SolveError::OtherBranch);
            }
        }
    }

    /// The test by the full bounds.
    fn full(&self, at: usize, bounds: &Enclosure<Expr>) -> TokenStream {
        let (statements, [middle, radii, distances]) = self.formulas.arrays(&[
            Array::matrix("middle", &bounds.middle),
            Array::rows("radius", &bounds.radii),
            Array::vector("distance", &bounds.conditions),
        ]);
        let private = self.formulas.private;
        let body = quote! {
            #statements
            #private::is_regular_within(&#middle, &#radii) && #private::all_positive(&#distances)
        };
        let entries: Vec<Expr> = bounds.entries().copied().collect();
        let function = ("is_accepted", at);
        (self.cold).function(function, (&entries, &[]), (&quote!(bool), &body))
    }

    /// The test of the solution of a block with multipliers of constraints.
    fn path(&self, at: usize, judge: &PathJudge) -> TokenStream {
        let formulas = self.formulas;
        let PathJudge {
            limit,
            of_limit,
            bounds,
            reach,
            defects,
        } = judge;
        let size = Literal::usize_unsuffixed(limit.len());
        let none = quote!([f64::NAN; #size]);
        let (limits, _) = start(of_limit, &none, formulas);
        let names = names(limit, formulas.symbols);
        let arrays = [
            Array::matrix("middle", &bounds.middle),
            Array::rows("radius", &bounds.radii),
            Array::vector("defect", defects),
            Array::vector("reach", reach),
            Array::vector("distance", &bounds.conditions),
        ];
        let (statements, [middle, radii, defects, reach, distances]) = formulas.arrays(&arrays);
        let private = formulas.private;
        let body = quote! {
            let #names = { #limits };
            #statements
            #private::contains_path(&#middle, &#radii, &#defects, &#reach) && #private::all_positive(&#distances)
        };
        let entries = [of_limit.entries(), entries(&arrays)].concat();
        let function = ("contains_path", at);
        let full = (self.cold).function(function, (&entries, limit), (&quote!(bool), &body));
        quote! {
            if newton.tests_paths() && !#full {
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
            let names = names(first, self.formulas.symbols);
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
    let middle = printer.stored(middle.storage, &middle.rows);
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

/// Code of a guess that is computed where it stands, all of it: the solution of a linear system, or else rest. With its
/// operations, the solve not counted.
pub(super) fn start(
    linear: &Linear<Expr>,
    rest: &TokenStream,
    formulas: Formulas<'_>,
) -> (TokenStream, Operations) {
    let printed = formulas.list(&[
        Array::matrix("matrix", &linear.matrix),
        Array::vector("rhs", &linear.rhs),
    ]);
    let Printed {
        statements, arrays, ..
    } = printed;
    let private = formulas.private;
    let tokens = quote! {
        #statements
        match #private::solve(#(&#arrays),*) {
            ::core::option::Option::Some(guess) => guess,
            ::core::option::Option::None => #rest,
        }
    };
    (tokens, printed.operations)
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

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
use crate::program::{Array, Operations, Residual, Tier, Value, symbol_name};
use crate::structure::{Iteration, Linear, Matrix, Refinement, Solution};

/// Writes solves.
pub(super) struct Solver<'a> {
    pub(super) formulas: Formulas<'a>,
    pub(super) printer: &'a Printer<'a>,
    pub(super) factors: &'a Factors<'a>,
    /// True if the step fails where the matrix of a limit is singular; this matrix has the
    /// determinant of the mass matrix.
    pub(super) finds_singular_masses: bool,
    pub(super) cold: &'a Cold<'a>,
}

impl Solver<'_> {
    /// The solve of the block number `at`, whose unknowns are those from number `first` on of what
    /// the step solves for, in a step of so many degrees of freedom.
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
        let (printer, private) = (self.printer, self.formulas.private);
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let rest = rest(iteration, degrees_of_freedom);
        let first_guess = self.first_guess(at, iteration, &rest);
        let [fallback, rounding] = self.cold_paths(at, iteration, &rest);
        let [iterates, solved] =
            [&iteration.iterates, &iteration.solved].map(|list| names(list, self.formulas.symbols));
        let statements = printer.statements(Tier::Iterate(at));
        let evaluation = evaluation(iteration, &self.matrix(&iteration.jacobian), printer);
        let first = Literal::usize_unsuffixed(first);
        let judged = iteration.judge.is_some() || iteration.path.is_some();
        let constrained = iteration.needs_guess;
        let limits = iteration.judge.as_ref().map(|j| {
            let names = names(&j.limit, self.formulas.symbols);
            quote!(let #names = limit;)
        });
        quote! {
            #first_guess
            let fallback = || #fallback;
            let rounding = |&#iterates: &[f64; #size]| #rounding;
            let block = #private::BlockProperties { first: #first, has_bounds: #judged, needs_strong_contraction: #constrained, limit_sign: origin };
            #limits
            let #solved = newton.solve_block(block, &guess, fallback, rounding, |&#iterates: &[f64; #size]| {
                #statements
                #evaluation
            })?;
        }
    }

    /// Calls of the functions for the second guess, and for the rounding errors of the residual.
    fn cold_paths(
        &self,
        at: usize,
        iteration: &Iteration<Value, Residual>,
        rest: &TokenStream,
    ) -> [TokenStream; 2] {
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let vector = quote!([f64; #size]);
        let entries = iteration.fallback.entries();
        let (fallback, _) = start(&iteration.fallback, rest, self.formulas);
        let equations: Vec<Expr> = iteration.residual.iter().map(|r| r.expr).collect();
        let rounding = rounding(&equations, self.formulas);
        let paths = [
            ("fallback", entries, fallback),
            ("rounding", equations, rounding),
        ];
        paths.map(|(name, formulas, body)| {
            (self.cold).function((name, at), (&formulas, &[]), (&vector, &body))
        })
    }

    /// The statement that finds the first guess, the sign of the determinant in the limit, and the
    /// limit. The matrix of the guess is the one of the limit.
    fn first_guess(
        &self,
        at: usize,
        iteration: &Iteration<Value, Residual>,
        rest: &TokenStream,
    ) -> TokenStream {
        let (printer, private) = (self.printer, self.formulas.private);
        let Iteration {
            guess,
            limit,
            judge,
            ..
        } = iteration;
        let size = Literal::usize_unsuffixed(iteration.iterates.len());
        let (matrix, rhs) = (self.matrix(&guess.matrix), printer.array(&guess.rhs));
        let factors = self.factors.of(at, &matrix, private);
        let again = Again {
            solve: &|rhs| match &factors {
                Some(_) => quote!(factors.solve(&#rhs)),
                None => quote!(#private::solve(&#matrix, &#rhs)),
            },
            policy: match &factors {
                Some(_) => Policy::Mask,
                None => Policy::Branch,
            },
        };
        let guessed = again.refined(at, iteration, printer);
        let (oriented, origin) = match (limit, &factors) {
            (Some(_), None) => (quote!(origin), quote!(origin)),
            (Some(_), Some(_)) => (quote!(factors), quote!(factors.sign())),
            (None, _) => (quote!(_), quote!(#private::DeterminantSign::UNKNOWN)),
        };
        let none = quote!([f64::NAN; #size]);
        let limit = match judge {
            None => none.clone(),
            Some(judge) if iteration.limit_is_guess(judge) => quote!(guess),
            Some(judge) => {
                let (rhs, limit) = (printer.array(&judge.limit_rhs), quote!(limit));
                again.solve(&rhs, &limit, &limit, &none)
            }
        };
        let attempt = match &factors {
            Some(factors) => {
                quote!(#factors.as_ref().map(|factors| (factors.solve(&#rhs), factors)))
            }
            None => quote!(#private::solve_with_sign(&#matrix, &#rhs)),
        };
        let without_guess = if iteration.needs_guess || self.finds_singular_masses {
            quote!(return ::core::result::Result::Err(#private::SolveError::Singular { iteration: 0 }))
        } else {
            quote!((#rest, #private::DeterminantSign::UNKNOWN, #none))
        };
        quote! {
            let (guess, origin, limit) = match #attempt {
                ::core::option::Option::Some((guess, #oriented)) => ({ #guessed }, #origin, #limit),
                ::core::option::Option::None => #without_guess,
            };
        }
    }
}

/// The result of a solve whose matrix is singular.
pub(super) enum Policy {
    /// Its value is `None`.
    Branch,
    /// Its value is not finite, or the matrix is known to be regular.
    Mask,
}

/// Further solves with the matrix of a block's first solve, beside that one.
pub(super) struct Again<'a> {
    /// The solve for a right-hand side.
    pub(super) solve: &'a dyn Fn(&TokenStream) -> TokenStream,
    pub(super) policy: Policy,
}

impl Again<'_> {
    /// The value of `with`, in which the solution is `name`; or `without` if the matrix is
    /// singular.
    fn solve(
        &self,
        rhs: &TokenStream,
        name: &TokenStream,
        with: &TokenStream,
        without: &TokenStream,
    ) -> TokenStream {
        let solution = (self.solve)(rhs);
        match self.policy {
            Policy::Mask => quote!({ let #name = #solution; #with }),
            Policy::Branch => quote!(match #solution {
                ::core::option::Option::Some(#name) => #with,
                ::core::option::Option::None => #without,
            }),
        }
    }

    /// The guess after its later stages. Each stage stands within the arm of the solve before, so
    /// that a division of these solves is done once.
    pub(super) fn refined(
        &self,
        at: usize,
        iteration: &Iteration<Value, Residual>,
        printer: &Printer<'_>,
    ) -> TokenStream {
        let stages = iteration.refinements.iter().enumerate().rev();
        let guess = quote!(guess);
        let refined = stages.fold(None, |later, (stage, Refinement { first, rhs })| {
            let names = names(first, printer.formulas.symbols);
            let statements = printer.statements(Tier::Guess(at, stage));
            let (sum, rhs) = (sum_of_stages(first.len()), printer.array(rhs));
            let sum = match later {
                Some(later) => quote!({ let guess = #sum; #later }),
                None => sum,
            };
            let refined = self.solve(&rhs, &quote!(refinement), &sum, &guess);
            Some(quote! {
                let #names = guess;
                #statements
                #refined
            })
        });
        refined.unwrap_or(guess)
    }
}

/// The sum of the two stages of a guess.
fn sum_of_stages(size: usize) -> TokenStream {
    let entries = (0..size).map(|i| {
        let i = Literal::usize_unsuffixed(i);
        quote!(guess[#i] + refinement[#i])
    });
    quote!([#(#entries),*])
}

/// The evaluation at a point, after the statements of the iteration.
pub(super) fn evaluation(
    iteration: &Iteration<Value, Residual>,
    jacobian: &TokenStream,
    printer: &Printer<'_>,
) -> TokenStream {
    let array = |of: fn(&Residual) -> Value| {
        let values: Vec<Value> = iteration.residual.iter().map(of).collect();
        printer.array(&values)
    };
    let (residual, magnitude) = (array(|r| r.value), array(|r| r.magnitude));
    let curvature = iteration.curvature;
    let curvature = curvature.map_or_else(|| quote!(f64::NAN), |c| printer.operand(c));
    let private = printer.formulas.private;
    quote! {
        #private::Evaluation {
            residual: #residual,
            magnitude: #magnitude,
            jacobian: #jacobian,
            curvature: #curvature,
        }
    }
}

/// Code of a guess that is computed where it stands, all of it: the solution of a linear system, or
/// else rest. With its operations, the solve not counted.
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

/// The guess where no linear system gives one: rest; but where the mass vanishes at rest, a
/// velocity of the momentum's sign.
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

//! The test that the solution of a block is the one that is connected with no noise and h → 0.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::code::Printer;
use super::solve::{Solver, names, start};
use crate::algebra::Expr;
use crate::program::{Array, Residual, Value, entries};
use crate::structure::{Enclosure, PathJudge, Solution};

impl Solver<'_> {
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
}

/// The test of a solution: the conditions hold and every matrix within the radii is regular.
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

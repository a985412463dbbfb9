//! The step without structure: what generic code would do, which has the equations and their
//! Jacobian and knows nothing else. Tests compare the other steps with it, see
//! `Settings::unstructured`.
//!
//! Input: an iteration in all unknowns, and the results. Output: the body of `increment`. All that
//! is needed is computed where it is needed, functions of angles too; nothing is prepared.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::function::{Formulas, Printed};
use super::ident;
use super::rounding::rounding;
use super::solve::{names, start};
use super::step::Code;
use crate::algebra::Expr;
use crate::program::{Array, Factored, Kernel, Operations, Value, Work, entries};
use crate::structure::{Iteration, Scheme};

/// The code of a scheme whose only block is this iteration.
pub(super) fn code(
    scheme: &Scheme<Expr>,
    iteration: &Iteration<Expr>,
    formulas: Formulas<'_>,
) -> Code {
    let private = formulas.private;
    let size = Literal::usize_unsuffixed(iteration.iterates.len());
    let rest = quote!([0.0; #size]);
    let (guess, of_guess) = start(&iteration.fallback, &rest, formulas);
    let rounding = rounding(&iteration.residual, formulas);
    let (evaluation, of_evaluation) = evaluation(iteration, formulas);
    let iterates = names(&iteration.iterates, formulas.symbols);
    let solved = names(&iteration.solved, formulas.symbols);
    let (results, of_results) = results(scheme, &solved, formulas);
    let work = Work {
        prepare: Operations::default(),
        step: of_guess + of_results,
        carried: Operations::default(),
        iteration: of_evaluation,
    };
    Code {
        prepared: quote!([f64; 0]),
        carried: 0,
        prepare: quote!([]),
        body: quote! {
            let time = state.t;
            let guess = { #guess };
            let rounding = |&#iterates: &[f64; #size]| { #rounding };
            let block = #private::BlockProperties { first: 0, has_bounds: false, needs_strong_contraction: false, limit_sign: #private::DeterminantSign::UNKNOWN };
            let #solved = newton.solve_block(block, &guess, || #rest, rounding, |&#iterates: &[f64; #size]| {
                #evaluation
            })?;
            #results
        },
        work: work.with_solves(scheme, |_| Factored::Nowhere),
    }
}

/// Statements and the value of an evaluation, with its operations.
fn evaluation(iteration: &Iteration<Expr>, formulas: Formulas<'_>) -> (TokenStream, Operations) {
    let Iteration {
        residual, jacobian, ..
    } = iteration;
    let roots: Vec<Expr> = residual.iter().copied().chain(jacobian.stored()).collect();
    let mut scheduler = formulas.scheduler(&roots);
    scheduler.disable_angle_addition();
    let residuals = residual.iter().map(|&e| scheduler.residual(e));
    let (residual, magnitude): (Vec<Value>, Vec<Value>) = residuals.unzip();
    let arrays = vec![
        Array::vector("residual", &residual),
        Array::vector("magnitude", &magnitude),
        scheduler.array(&Array::matrix("jacobian", jacobian)),
    ];
    let Printed {
        statements,
        arrays,
        operations,
    } = formulas.print(&Kernel::of_values(scheduler, arrays));
    let private = formulas.private;
    let fields = ["residual", "magnitude", "jacobian"].map(ident);
    let tokens = quote! {
        #statements
        #private::Evaluation { #(#fields: #arrays,)* curvature: f64::NAN }
    };
    (tokens, operations)
}

/// The result of `increment` once the unknowns are known, with its operations.
fn results(
    scheme: &Scheme<Expr>,
    solved: &TokenStream,
    formulas: Formulas<'_>,
) -> (TokenStream, Operations) {
    let arrays = [
        Array::vector("dq", &scheme.dq),
        Array::vector("dp", &scheme.dp),
    ];
    let mut scheduler = formulas.scheduler(&entries(&arrays));
    scheduler.disable_angle_addition();
    let Printed {
        statements,
        arrays,
        operations,
    } = formulas.print(&Kernel::new(scheduler, &arrays));
    let tokens = quote!(#statements ::core::result::Result::Ok((#(#arrays,)* #solved)));
    (tokens, operations)
}

//! The step without structure: what generic code would do, which has the equations and their Jacobian and knows nothing else. The
//! other steps are compared with it, see `structure = both` in `parse`.
//!
//! Input: an iteration in all unknowns, and the results. Output: the body of `increment`. All that is needed is computed where
//! it is needed, functions of angles too; nothing is prepared.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::rounding::rounding;
use super::solve::{names, start};
use super::step::Code;
use super::straight::{Printed, Straight, rows};
use crate::algebra::{Arena, Expr};
use crate::model::Symbols;
use crate::program::{Factored, Operations, Work};
use crate::structure::{Iteration, Scheme};

/// The code of a scheme whose only block is this iteration.
pub(super) fn code(
    scheme: &Scheme<Expr>,
    iteration: &Iteration<Expr>,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> Code {
    let size = Literal::usize_unsuffixed(iteration.iterates.len());
    let rest = quote!([0.0; #size]);
    let (guess, of_guess) = start(&iteration.fallback, &rest, symbols, private, arena);
    let rounding = rounding(&iteration.residual, symbols, private, arena);
    let (evaluation, of_evaluation) = evaluation(iteration, symbols, private, arena);
    let iterates = names(&iteration.iterates, symbols);
    let solved = names(&iteration.solved, symbols);
    let (results, of_results) = results(scheme, &solved, symbols, private, arena);
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
fn evaluation(
    iteration: &Iteration<Expr>,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> (TokenStream, Operations) {
    let Iteration {
        residual, jacobian, ..
    } = iteration;
    let roots: Vec<Expr> = residual.iter().copied().chain(jacobian.stored()).collect();
    let mut straight = Straight::new(arena, symbols, &roots).without_angle_addition();
    let (residual, magnitude) = straight.residuals(residual);
    let values = [
        (vec![residual], vec!["residual".to_owned()]),
        (vec![magnitude], vec!["magnitude".to_owned()]),
        (
            straight.values(&jacobian.rows),
            rows("jacobian", jacobian.size()),
        ),
    ];
    let Printed {
        statements,
        arrays,
        operations,
    } = straight.print(private, &values);
    let [residual, magnitude, jacobian] = arrays.as_slice() else {
        return (TokenStream::new(), operations);
    };
    let tokens = quote! {
        #statements
        let [residual] = #residual;
        let [magnitude] = #magnitude;
        #private::Evaluation { residual, magnitude, jacobian: #jacobian, curvature: f64::NAN }
    };
    (tokens, operations)
}

/// What `increment` returns once the unknowns are known, with its operations.
fn results(
    scheme: &Scheme<Expr>,
    solved: &TokenStream,
    symbols: &Symbols,
    private: &TokenStream,
    arena: &Arena,
) -> (TokenStream, Operations) {
    let rows = [scheme.dq.clone(), scheme.dp.clone()];
    let roots = rows.concat();
    let mut straight = Straight::new(arena, symbols, &roots).without_angle_addition();
    let values = (
        straight.values(&rows),
        ["dq", "dp"].map(ToOwned::to_owned).to_vec(),
    );
    let Printed {
        statements,
        arrays,
        operations,
    } = straight.print(private, &[values]);
    let tokens = quote! {
        #statements
        let [dq, dp] = #(#arrays)*;
        ::core::result::Result::Ok((dq, dp, #solved))
    };
    (tokens, operations)
}

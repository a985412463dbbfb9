//! Blocks of a step: line search, sign of the determinant, warm starts.

use super::super::{BlockProperties, BlockSolver, Evaluation, Newton};
use super::{counted, scalar, square_root};
use crate::solve::SolveError;
use crate::solve::dense::DeterminantSign;

/// Solves a block with a known sign of the determinant and a second guess that leads to no root.
fn solve_with_limit_sign(
    guess: f64,
    limit_sign: DeterminantSign,
    evaluate: impl Fn(&[f64; 1]) -> Evaluation<1>,
) -> Result<[f64; 1], SolveError> {
    let newton = Newton::default();
    let solver = BlockSolver::new(&newton);
    solver.solve_block(
        block(limit_sign),
        &[guess],
        || [-guess],
        |_| [0.0],
        evaluate,
    )
}

const POSITIVE: DeterminantSign = DeterminantSign::of(1.0);
const NEGATIVE: DeterminantSign = DeterminantSign::of(-1.0);

/// Returns a block without bounds: its root is accepted by the path of its iteration.
fn block(limit_sign: DeterminantSign) -> BlockProperties {
    BlockProperties {
        first: 0,
        has_bounds: false,
        needs_strong_contraction: false,
        limit_sign,
    }
}

#[test]
fn updates_are_damped_where_full_ones_diverge() {
    let arctangent = |x: &[f64; 1]| Evaluation {
        residual: [x[0].atan()],
        magnitude: [2.0],
        jacobian: [[1.0 / (1.0 + x[0] * x[0])]],
        curvature: -2.0 * x[0] / (1.0 + x[0] * x[0]).powi(2),
    };
    let (alone, _) = counted(&Newton::default(), [3.0], arctangent);
    assert!(alone.is_err(), "{alone:?}");
    for guess in [1.5, 3.0, 30.0] {
        let [x] = solve_with_limit_sign(guess, POSITIVE, arctangent).unwrap();
        assert!(x.abs() < 1e-14, "{x:e}");
    }
    // Without a root, the line search ends.
    let none = |x: &[f64; 1]| Evaluation {
        curvature: 2.0,
        ..scalar(&[x[0] * x[0], 1.0], 2.0 * x[0])
    };
    assert!(solve_with_limit_sign(0.7, DeterminantSign::UNKNOWN, none).is_err());
}

#[test]
fn a_root_with_the_other_sign_of_the_determinant_is_rejected() {
    // x³ − 4x² + 2.5x = 0.45 has one real root, near 3.2. Without the first two terms the root is
    // 0.18.
    let third = |x: &[f64; 1]| Evaluation {
        curvature: 6.0 * x[0] - 8.0,
        ..scalar(
            &[x[0].powi(3), -4.0 * x[0] * x[0], 2.5 * x[0], -0.45],
            3.0 * x[0] * x[0] - 8.0 * x[0] + 2.5,
        )
    };
    let [near] = solve_with_limit_sign(3.4, POSITIVE, third).unwrap();
    assert!((third(&[near]).residual[0]).abs() < 1e-14);
    // From the other side of the local extrema, the segment to the root contains points with the
    // other sign.
    assert!(solve_with_limit_sign(0.6, POSITIVE, third).is_err());
    // The sign at the root differs from the sign in the limit.
    assert_eq!(
        solve_with_limit_sign(3.4, NEGATIVE, third),
        Err(SolveError::OtherBranch)
    );
    assert!(solve_with_limit_sign(3.4, DeterminantSign::UNKNOWN, third).is_ok());
}

#[test]
fn a_warm_start_has_to_contract() {
    let newton = Newton::default();
    let evaluate = |x: &[f64; 1]| Evaluation {
        curvature: 2.0,
        ..square_root(x)
    };
    let follow = |guesses: Vec<f64>| {
        let solver = BlockSolver::warm_started(&newton, &guesses);
        solver.solve_block(block(POSITIVE), &[2.0], || [8.0], |_| [0.0], evaluate)
    };
    let x = follow(vec![1.5]).unwrap();
    assert!((x[0] - 2.0_f64.sqrt()).abs() < 1e-15);
    // A guess too far away, and a guess where the slope is negative, are rejected.
    assert!(follow(vec![0.3]).is_err());
    assert!(follow(vec![-1.5]).is_err());
    // Without a given guess the block's own is used, from which the iteration contracts.
    assert!(follow(Vec::new()).is_ok());
}

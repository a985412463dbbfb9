//! The places of the unknowns of a step of a Gauss rule, and the derivatives of its residuals.

use super::stages::product;
use super::step::{Response, Stage};
use super::tableau::Tableau;

/// Place of a component of the velocity of stage `i` among the unknowns. The velocities of all
/// stages stand together, as in the lanes of the fixed-point iteration.
#[inline(always)]
pub(super) const fn velocity<const S: usize>(i: usize, component: usize) -> usize {
    component * S + i
}

/// Place of a component of the displacement of stage `i` among the unknowns.
#[inline(always)]
pub(super) const fn displacement<const S: usize, const N: usize>(
    i: usize,
    component: usize,
) -> usize {
    (N + component) * S + i
}

/// Returns whether a noise moves positions. If so, the displacements are unknowns beside the
/// velocities.
pub(super) const fn moves_position<const S: usize, const N: usize, const K: usize>() -> bool {
    assert!(
        K == S * N || K == 2 * S * N,
        "one or two unknowns a stage and coordinate"
    );
    K == 2 * S * N
}

/// Computes the derivatives of the residuals by the unknowns.
pub(super) fn jacobian<const S: usize, const N: usize, const K: usize>(
    weights: &[f64; S],
    stages: &[Stage<N>; S],
    jacobian: &mut [[f64; K]; K],
) {
    let moves_position = moves_position::<S, N, K>();
    let ratio_of = const { &Tableau::<S>::VALUES.ratio_of };
    for m in 0..N {
        for n in 0..N {
            let by_positions = row(stages, |stage| stage.impulse.by_position[m][n]);
            for i in 0..S {
                let (stage, ratios) = (&stages[i], &ratio_of[i]);
                // The effects of the stages k on stage i through all stages j.
                let mut parts = by_positions;
                for j in 0..S {
                    parts[j] *= ratios[j];
                }
                let through = product(ratio_of, &parts);
                let row = &mut jacobian[velocity::<S>(i, m)];
                for k in 0..S {
                    let by_position = ratios[k] * stage.lagrangian.dqv[n][m] - through[k];
                    let by_velocity = -ratios[k] * stages[k].impulse.by_velocity[m][n];
                    if moves_position {
                        row[velocity::<S>(k, n)] = by_velocity;
                        row[displacement::<S, N>(k, n)] = by_position;
                    } else {
                        row[velocity::<S>(k, n)] = by_velocity + weights[k] * by_position;
                    }
                }
                row[velocity::<S>(i, n)] += stage.lagrangian.dvv[m][n];
            }
        }
    }
    if moves_position {
        for i in 0..S {
            displacements(i, weights, &stages[i].shift, jacobian);
        }
    }
}

/// Returns a number of each stage.
#[inline(always)]
pub(super) fn row<const S: usize, const N: usize>(
    stages: &[Stage<N>; S],
    number: impl Fn(&Stage<N>) -> f64,
) -> [f64; S] {
    let mut row = [0.0; S];
    for i in 0..S {
        row[i] = number(&stages[i]);
    }
    row
}

/// Computes the derivatives of the equations for the displacements of stage `i`.
fn displacements<const S: usize, const N: usize, const K: usize>(
    i: usize,
    weights: &[f64; S],
    shift: &Response<N>,
    jacobian: &mut [[f64; K]; K],
) {
    let ratios = const { &Tableau::<S>::VALUES.ratio_of }[i];
    for m in 0..N {
        let row = &mut jacobian[displacement::<S, N>(i, m)];
        for n in 0..N {
            for k in 0..S {
                let same = f64::from(u8::from(i == k && m == n));
                let by_velocity = if i == k { shift.by_velocity[m][n] } else { 0.0 };
                row[velocity::<S>(k, n)] = -same * weights[k] - by_velocity;
                row[displacement::<S, N>(k, n)] = same - ratios[k] * shift.by_position[m][n];
            }
        }
    }
}

//! The places of the unknowns of a step of a Gauss rule, and the derivatives of its residuals.

use super::step::Stage;
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
    let ratio = const { &Tableau::<S>::VALUES.ratio };
    for i in 0..S {
        for k in 0..S {
            // The effect of stage k on stage i through all stages j.
            let mut through = [[0.0; N]; N];
            for j in 0..S {
                let factor = ratio[j][i] * ratio[k][j];
                for m in 0..N {
                    for n in 0..N {
                        through[m][n] += factor * stages[j].impulse.by_position[m][n];
                    }
                }
            }
            let (r, weight) = (ratio[k][i], weights[k]);
            for m in 0..N {
                for n in 0..N {
                    let by_position = r * stages[i].lagrangian.dqv[n][m] - through[m][n];
                    let mut by_velocity = -r * stages[k].impulse.by_velocity[m][n];
                    if i == k {
                        by_velocity += stages[i].lagrangian.dvv[m][n];
                    }
                    let row = velocity::<S>(i, m);
                    if moves_position {
                        jacobian[row][velocity::<S>(k, n)] = by_velocity;
                        jacobian[row][displacement::<S, N>(k, n)] = by_position;
                    } else {
                        jacobian[row][velocity::<S>(k, n)] = by_velocity + weight * by_position;
                    }
                }
            }
            if moves_position {
                let shift = &stages[i].shift;
                for m in 0..N {
                    let row = displacement::<S, N>(i, m);
                    for n in 0..N {
                        let same = f64::from(u8::from(i == k && m == n));
                        let by_velocity = if i == k { shift.by_velocity[m][n] } else { 0.0 };
                        jacobian[row][velocity::<S>(k, n)] = -same * weight - by_velocity;
                        jacobian[row][displacement::<S, N>(k, n)] =
                            same - r * shift.by_position[m][n];
                    }
                }
            }
        }
    }
}

//! One update of Newton's method.
//!
//! Input: residual and Jacobian at a point. Output: the vector to be subtracted from the unknowns,
//! and the sign of the Jacobian's determinant.

use super::Evaluation;
use crate::solve::dense::{DeterminantSign, Matrix};

/// Largest change of Newton's update by the term with the second derivative, relative to the
/// update, at which the term is used.
pub(crate) const LARGEST_CORRECTION: f64 = 0.25;

/// Largest number of unknowns whose matrix may be copied within the loop of the iteration.
const LARGEST_INLINED: usize = 16;

/// Solves a system of many unknowns. Its copy of the matrix leaves the stack before the next
/// evaluation.
#[inline(never)]
fn solve_apart<const K: usize>(
    jacobian: &impl Matrix<K>,
    residual: &[f64; K],
) -> Option<([f64; K], DeterminantSign)> {
    jacobian.solve_with_sign(residual)
}

/// An update of the unknowns.
#[derive(Clone, Copy)]
pub(super) struct Update<const K: usize> {
    /// The vector to be subtracted.
    pub(super) by: [f64; K],
    /// Newton's vector, which is subtracted in the last update.
    pub(super) newton: [f64; K],
    /// True if the update converges with third order.
    pub(super) is_third_order: bool,
    /// The sign of the Jacobian's determinant.
    pub(super) sign: DeterminantSign,
}

impl<const K: usize, J: Matrix<K>> Evaluation<K, J> {
    /// Computes the update; `None` if the Jacobian is singular.
    ///
    /// For a single unknown, Newton's `u = f/f′` becomes Chebyshev's `u + ½ (f″/f′) u²` if the
    /// change is small (Traub, *Iterative Methods for the Solution of Equations*, section 5).
    #[inline(always)]
    pub(super) fn update(&self) -> Option<Update<K>> {
        if K != 1 {
            let (by, sign) = if K > LARGEST_INLINED {
                solve_apart(&self.jacobian, &self.residual)?
            } else {
                self.jacobian.solve_with_sign(&self.residual)?
            };
            return Some(Update {
                by,
                newton: by,
                is_third_order: false,
                sign,
            });
        }
        let slope = self.jacobian.first();
        if slope == 0.0 {
            return None;
        }
        // Two independent divisions run at the same time. One division would delay the second
        // quotient by a multiplication.
        let newton = [self.residual[0] / slope; K];
        let correction = 0.5 * self.curvature / slope * newton[0];
        let is_third_order = correction.abs() <= LARGEST_CORRECTION;
        let by = if is_third_order {
            let mut update = newton;
            update[0] += correction * update[0];
            update
        } else {
            uncorrected(newton)
        };
        Some(Update {
            by,
            newton,
            is_third_order,
            sign: DeterminantSign::of(slope),
        })
    }
}

/// Returns whether a Jacobian with this update is regular with a determinant of the given sign.
#[inline(always)]
pub(super) fn is_regular_with<const K: usize>(
    update: Option<&Update<K>>,
    sign: DeterminantSign,
) -> bool {
    update.is_some_and(|update| !update.sign.is_opposite_to(sign))
}

/// Returns Newton's update. The call keeps the compiler from computing both updates and selecting
/// one: the iteration can continue as soon as one is known.
#[cold]
#[inline(never)]
fn uncorrected<const K: usize>(update: [f64; K]) -> [f64; K] {
    update
}

/// Returns the factor of the last update of an unknown: 1 + 1/32 if the last bit of the unknown is
/// odd, otherwise 1 − 1/32.
///
/// The last update is about half a unit in the last place. Residuals near their root are multiples
/// of a small unit, so an update of exactly half a unit in the last place is not rare. The factor
/// rounds such a tie to the number with an even last bit, as an addition does. Without the factor
/// the rounding errors of the update would decide. They have the sign of the iteration, which is
/// the same step after step.
#[inline(always)]
pub(crate) fn tie_breaking_factor(x: f64) -> f64 {
    if x.to_bits() & 1 == 1 {
        1.0 + 1.0 / 32.0
    } else {
        1.0 - 1.0 / 32.0
    }
}

//! One update of Newton's method, and the tests of an evaluation.
//!
//! Input: residual, its terms' magnitudes and Jacobian at a point. Output: what is to be subtracted from the unknowns, the orientation of
//! the Jacobian, the relative residual.

use super::{BENT, Evaluation};
use crate::linear::Matrix;

/// An update of the unknowns.
pub(super) struct Update<const K: usize> {
    /// What is to be subtracted.
    pub(super) by: [f64; K],
    /// Whether it is of third order.
    pub(super) cubic: bool,
    /// A number of the sign of the determinant of the Jacobian.
    pub(super) orientation: f64,
}

/// The update: of a single unknown, Newton's `u = f/f′` becomes Chebyshev's
/// `u + ½ (f″/f′) u²` where that is a small change (Traub, Iterative Methods for the Solution of Equations, section 5).
#[inline]
pub(super) fn update<const K: usize, J: Matrix<K>>(at: &Evaluation<K, J>) -> Option<Update<K>> {
    if K != 1 {
        let (by, orientation) = at.jacobian.solve_oriented(&at.residual)?;
        return Some(Update {
            by,
            cubic: false,
            orientation,
        });
    }
    let slope = at.jacobian.first();
    if slope == 0.0 {
        return None;
    }
    // two divisions at once: one, of which the other quantity is a multiple, would be followed by the multiplication
    let mut update = [at.residual[0] / slope; K];
    let bend = 0.5 * at.curvature / slope * update[0];
    let cubic = bend.abs() <= BENT;
    let by = if cubic {
        update[0] += bend * update[0];
        update
    } else {
        straight(update)
    };
    Some(Update {
        by,
        cubic,
        orientation: slope,
    })
}

/// What the last update of an unknown is multiplied by: 1 ± 1/32, more where the last bit of the unknown is odd.
///
/// The last update is about half a unit in the last place. Residuals near their root are multiples of a small unit, so an update of
/// exactly half a unit in the last place is not rare. Such a tie goes to the number with an even last bit, as in an addition; decided by the
/// rounding errors of the update, it would go to the side from which the iteration comes, which is the same one step after step.
#[inline(always)]
pub(crate) fn last_factor(x: f64) -> f64 {
    if x.to_bits() & 1 == 1 {
        1.0 + 1.0 / 32.0
    } else {
        1.0 - 1.0 / 32.0
    }
}

/// Whether two determinants are of opposite signs; a NaN has none.
#[inline(always)]
pub(crate) fn is_opposite(a: f64, b: f64) -> bool {
    (a < 0.0 && b > 0.0) || (a > 0.0 && b < 0.0)
}

/// Whether the Jacobian has an inverse, and the orientation of the one where the solution comes from.
#[inline]
pub(super) fn is_regular<const K: usize, J: Matrix<K>>(at: &Evaluation<K, J>, origin: f64) -> bool {
    match update(at) {
        Some(update) => !is_opposite(update.orientation, origin),
        None => false,
    }
}

/// Keeps the compiler from selecting between two updates after both are known, where it can go on with one.
#[cold]
#[inline(never)]
fn straight<const K: usize>(update: [f64; K]) -> [f64; K] {
    update
}

/// Largest residual relative to the terms it is the sum of; NaN where one is not finite.
#[inline]
pub(super) fn relative<const K: usize, J>(at: &Evaluation<K, J>) -> f64 {
    let (mut largest, mut sum) = (0.0, 0.0);
    for i in 0..K {
        let m = at.magnitude[i];
        // 0/0 is 0: an equation whose terms all vanish is satisfied. An infinite m gives NaN: no finite residual is small
        // against infinity.
        let r = at.residual[i].abs() / (m + f64::MIN_POSITIVE) + 0.0 * m;
        if r > largest {
            largest = r;
        }
        sum += r;
    }
    // the comparison drops a NaN, the sum does not
    largest + 0.0 * sum
}

//! The test of convergence by residuals, for single states and for lanes.
//!
//! Input: the relative residuals of two successive iterations. Output: the iteration has converged,
//! contracts, or stalls. Invariant: [`judge`] and [`predicts_negligible`] have no branches, so that
//! a loop over lanes compiles to vector instructions.

#![allow(clippy::needless_bitwise_bool)] // both sides are computed, without a branch

/// Residual and Jacobian at a point. The Jacobian is of any type that implements `Matrix`.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const K: usize, J = [[f64; K]; K]> {
    /// The values that vanish at the root.
    pub residual: [f64; K],
    /// For each equation, the sum of the magnitudes of its terms.
    pub magnitude: [f64; K],
    /// Derivatives, rows by equation.
    pub jacobian: J,
    /// Second derivative of a single equation in a single unknown; NaN if there are more unknowns
    /// or it is not known.
    pub curvature: f64,
}

/// Residual below which an exact Newton step squares the residual to rounding level: the square
/// root of rounding. A residual that does not even halve there is its own rounding error.
pub(crate) const ROOT_OF_ROUNDING: f64 = 1.5e-8;

/// Largest residual at which the constant of convergence is measured.
const ASYMPTOTIC: f64 = 0.1;

/// Fraction of the tolerance below which a predicted residual need not be evaluated: 3·10⁻²⁰ of the
/// terms by default.
///
/// The error that the iteration leaves has the same sign step after step, while the rounding errors
/// of the unknowns, 10⁻¹⁶, form a random walk. Over 10⁷ steps the sum of the iteration errors stays
/// below the random walk.
pub(crate) const NEGLIGIBLE: f64 = 1.0 / 16384.0;

/// Largest ratio of successive residuals at which the iteration does not count as stalled.
pub(crate) const STALL: f64 = 0.5;

/// Largest ratio of successive residuals at which the iteration counts as contracting.
/// Kantorovich's theorem guarantees ¼ for a start inside its ball.
pub(crate) const CONTRACTION: f64 = 0.25;

/// The largest ratio for roots that no bounds judge, on the fast path: stages of many coordinates,
/// and multipliers of constraints. A step whose velocity turns by an angle α has a ratio of about
/// α²/4, so this ratio is a turn of a quarter of a radian: far from a turn at which the path of
/// solutions ends, and from a fold. At a double root, where the gradient of a constraint vanishes
/// with the constraint, the ratio is ¼.
pub(crate) const STRONG_CONTRACTION: f64 = 1.0 / 64.0;

/// Residual after an update that can be rounding error of the update, relative to the terms: the
/// solution of a small linear system loses a few digits.
pub(crate) const ERROR_OF_UPDATE: f64 = 64.0 * f64::EPSILON;

/// The verdict on two successive residuals.
#[derive(Clone, Copy)]
pub(crate) struct Verdict {
    /// The residual is below the tolerance.
    pub(crate) is_converged: bool,
    /// The residual is at most half the one before.
    pub(crate) has_halved: bool,
    /// The residual no longer halves, at a size at which only rounding errors can be the reason.
    pub(crate) is_stalled_by_rounding: bool,
}

/// Judges the relative residual of an iteration by the one before.
#[inline(always)]
pub(crate) fn judge(residual: f64, previous: f64, tolerance: f64) -> Verdict {
    let has_halved = residual <= STALL * previous;
    Verdict {
        is_converged: residual <= tolerance,
        has_halved,
        is_stalled_by_rounding: !has_halved & (residual < ROOT_OF_ROUNDING),
    }
}

/// Largest growth of the terms of an equation at which two relative residuals are comparable. The
/// prediction errs by the square of this growth, and [`NEGLIGIBLE`] leaves room for that error.
const COMPARABLE: f64 = 64.0;

/// Returns whether the relative residuals of two successive points are in the same units: no
/// equation has terms that are much larger at the second point. The relative residual of an
/// equation whose terms all vanish at the root, but for rounding errors, can have any size and then
/// says nothing about the other equations. `before` and `here` are
/// [`Evaluation::contraction_bounds`] at the two points, the residuals times the magnitudes of the
/// terms.
#[inline(always)]
pub(crate) fn are_comparable<const K: usize>(
    [previous, residual]: [f64; 2],
    [before, here]: [&[f64; K]; 2],
) -> bool {
    let largest = COMPARABLE * residual;
    let mut all = true;
    for i in 0..K {
        all &= here[i] * previous <= largest * before[i];
    }
    all
}

/// Returns whether the residual after an update of second or third order is predicted to be
/// negligible beside the tolerance.
///
/// The prediction is `r_{k+1} ≈ (r_k / r_{k−1}²) r_k²`, or with cubes: it takes the constant of
/// convergence from the last update. After a damped update, or before the order is reached, the
/// measured ratio is too large for the test.
#[inline(always)]
pub(crate) fn predicts_negligible(
    residual: f64,
    previous: f64,
    is_third_order: bool,
    tolerance: f64,
) -> bool {
    let (residual_2, previous_2) = (residual * residual, previous * previous);
    let numerator = residual_2 * if is_third_order { residual_2 } else { residual };
    let denominator = previous_2 * if is_third_order { previous } else { 1.0 };
    (numerator <= NEGLIGIBLE * tolerance * denominator) & (previous < ASYMPTOTIC)
}

impl<const K: usize, J> Evaluation<K, J> {
    /// Returns the largest residual relative to the sum of its terms' magnitudes; NaN if one of
    /// them is not finite.
    #[inline]
    pub(crate) fn relative_residual(&self) -> f64 {
        let (mut largest, mut sum) = (0.0, 0.0);
        for i in 0..K {
            let m = self.magnitude[i];
            // 0/0 is 0: an equation whose terms all vanish is satisfied. An infinite m gives NaN:
            // no finite residual is small relative to infinity.
            let r = self.residual[i].abs() / (m + f64::MIN_POSITIVE) + 0.0 * m;
            if r > largest {
                largest = r;
            }
            sum += r;
        }
        // the comparison drops a NaN, the sum does not
        largest + 0.0 * sum
    }

    /// Returns the largest residuals of the next point at which the iteration counts as contracting
    /// by the given ratio; `relative` is the relative residual at this point.
    #[inline(always)]
    pub(crate) fn contraction_bounds(&self, relative: f64, ratio: f64) -> [f64; K] {
        let mut bounds = [0.0; K];
        for i in 0..K {
            bounds[i] = if K == 1 {
                // A single residual needs no division, so its bound is known earlier.
                ratio * self.residual[i].abs()
            } else {
                ratio * relative * self.magnitude[i]
            };
        }
        bounds
    }

    /// Returns whether every residual is within its bound.
    #[inline]
    pub(super) fn is_within(&self, bounds: &[f64; K]) -> bool {
        let mut all = true;
        for i in 0..K {
            all &= self.residual[i].abs() <= bounds[i];
        }
        all
    }
}

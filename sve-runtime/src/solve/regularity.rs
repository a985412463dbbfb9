//! Regularity of an interval matrix: decides whether every matrix within given distances of a
//! midpoint matrix is regular. A step accepts its root by this test.
//!
//! Input: midpoints and radii of the entries. Output: true if all matrices in between have an
//! inverse. Invariant: no branches, so that a loop over lanes compiles to vector instructions, and
//! the answer is the same for a single state and in lanes.
//!
//! Let C be the inverse of the midpoint matrix, R the radii and `E = |C| R`. Then `C A` differs
//! from the identity by at most E in each entry, and A is regular if the spectral radius of E is
//! below 1. This holds if `1 − E` is an M-matrix, whose pivots are positive. The test does not
//! depend on the units of equations and unknowns.
//!
//! A box contains a path of solutions if, for every A in the interval matrix and every residual F
//! at the centre of the box, `|A⁻¹ F|` is within the box. `(1 − E)⁻¹ |C| |F|` bounds it.
//!
//! Sources: Neumaier, *Interval Methods for Systems of Equations* (1990), proposition 4.1.1;
//! Berman, Plemmons, *Nonnegative Matrices in the Mathematical Sciences* (1994), chapter 6, for
//! M-matrices.

// Both sides are computed: a branch would prevent vector instructions.
#![allow(clippy::needless_bitwise_bool)]

use super::banded::Banded;
use super::diagonal::Diagonal;

/// Bound of the spectral radius. The distance from 1 covers the rounding errors of the radii and of
/// a nearly singular inverse.
const BOUND: f64 = 0.95;

/// The midpoints of an interval matrix.
pub trait Midpoints<const K: usize> {
    /// The radii of the stored entries.
    type Radii;
    /// Returns whether every matrix whose entries are within `radius` of the midpoints is regular.
    fn is_regular_within(&self, radius: &Self::Radii) -> bool;
    /// Returns whether every such matrix A is regular with `|A⁻¹ b| ≤ reach` for `|b| ≤ defects`.
    /// See [`contains_path`].
    fn contains_path(&self, radius: &Self::Radii, defects: &[f64; K], reach: &[f64; K]) -> bool;
}

/// Returns whether every matrix whose entries are within `radius` of the entries of `middle` is
/// regular; `false` if an entry is NaN.
#[inline(always)]
pub fn is_regular_within<const K: usize, A: Midpoints<K>>(middle: &A, radius: &A::Radii) -> bool {
    middle.is_regular_within(radius)
}

/// Returns whether a box contains the whole path of solutions from the limit x₀ of no noise and h →
/// 0 to the step, and no other solution; `false` if a number is NaN.
///
/// The box is `|x − x₀| ≤ reach`. For every smaller step, the radii hold within the box and
/// `defects` bound the residuals at x₀. As long as the path is in the box, `x − x₀ = −A⁻¹ F` with a
/// matrix A within the radii and F within the defects. If this vector is within the box for all A
/// and F, the path cannot leave the box.
#[inline(always)]
pub fn contains_path<const K: usize, A: Midpoints<K>>(
    middle: &A,
    radius: &A::Radii,
    defects: &[f64; K],
    reach: &[f64; K],
) -> bool {
    middle.contains_path(radius, defects, reach)
}

impl<const K: usize> Midpoints<K> for [[f64; K]; K] {
    type Radii = Self;

    #[inline(always)]
    fn is_regular_within(&self, radius: &Self) -> bool {
        is_regular_within_dense(self, radius)
    }

    #[inline(always)]
    fn contains_path(&self, radius: &Self, defects: &[f64; K], reach: &[f64; K]) -> bool {
        if K == 1 {
            let size = BOUND * self[0][0].abs() - radius[0][0];
            return (size > 0.0) & (defects[0] <= size * reach[0]);
        }
        let inverse = if K == 2 {
            let [a, b, c, d] = [self[0][0], self[0][1], self[1][0], self[1][1]];
            let scale = 1.0 / (a * d - b * c);
            let mut inverse = *self;
            [inverse[0][0], inverse[0][1]] = [d * scale, -b * scale];
            [inverse[1][0], inverse[1][1]] = [-c * scale, a * scale];
            inverse
        } else {
            inverse(*self)
        };
        let step = deviation(&inverse, &core::array::from_fn(|i| [defects[i]]));
        let matrix = distance_from_one(&deviation(&inverse, radius));
        let solution = solve_by_positive_pivots(matrix, &step.map(|[x]| x));
        is_within(&solution, reach)
    }
}

impl<const K: usize, const LOWER: usize, const WIDTH: usize> Midpoints<K>
    for Banded<K, LOWER, WIDTH>
{
    type Radii = [[f64; WIDTH]; K];

    #[inline(always)]
    fn is_regular_within(&self, radius: &Self::Radii) -> bool {
        self.contains_path(radius, &[0.0; K], &[0.0; K])
    }

    fn contains_path(&self, radius: &Self::Radii, defects: &[f64; K], reach: &[f64; K]) -> bool {
        let (mut middle, mut radii) = ([[0.0; K]; K], [[0.0; K]; K]);
        for i in 0..K {
            let begin = i.saturating_sub(LOWER);
            for j in 0..WIDTH.min(K - begin) {
                middle[i][begin + j] = self.0[i][j];
                radii[i][begin + j] = radius[i][j];
            }
        }
        middle.contains_path(&radii, defects, reach)
    }
}

impl<const K: usize> Midpoints<K> for Diagonal<K> {
    type Radii = [[f64; K]; K];

    /// Tests `1 − E` multiplied by the midpoint. The product is an M-matrix if `1 − E` is one, so
    /// no inverse is needed.
    #[inline(always)]
    fn is_regular_within(&self, radius: &[[f64; K]; K]) -> bool {
        has_positive_pivots(self.less(radius))
    }

    #[inline(always)]
    fn contains_path(&self, radius: &[[f64; K]; K], defects: &[f64; K], reach: &[f64; K]) -> bool {
        is_within(&solve_by_positive_pivots(self.less(radius), defects), reach)
    }
}

impl<const K: usize> Diagonal<K> {
    /// Returns the magnitudes of the midpoints, times [`BOUND`], less the radii.
    #[inline(always)]
    fn less(&self, radius: &[[f64; K]; K]) -> [[f64; K]; K] {
        let mut difference = *radius;
        for i in 0..K {
            for j in 0..K {
                difference[i][j] = -radius[i][j];
            }
            difference[i][i] += BOUND * self.0[i][0].abs();
        }
        difference
    }
}

#[inline(always)]
fn is_regular_within_dense<const K: usize>(middle: &[[f64; K]; K], radius: &[[f64; K]; K]) -> bool {
    match K {
        1 => radius[0][0] < BOUND * middle[0][0].abs(),
        2 => {
            let [a, b, c, d] = [middle[0][0], middle[0][1], middle[1][0], middle[1][1]];
            // The matrix is (1 − E) times the determinant of the midpoint: the adjugate needs no
            // division.
            let size = BOUND * (a * d - b * c).abs();
            let row = |x: f64, y: f64, j: usize| x.abs() * radius[0][j] + y.abs() * radius[1][j];
            let [e00, e01, e10, e11] = [row(d, b, 0), row(d, b, 1), row(c, a, 0), row(c, a, 1)];
            let (x, y) = (size - e00, size - e11);
            (x > 0.0) & (y > 0.0) & (x * y > e01 * e10)
        }
        _ => has_positive_pivots(distance_from_one(&deviation(&inverse(*middle), radius))),
    }
}

/// Returns whether all numbers are positive.
#[inline]
pub fn all_positive(numbers: &[f64]) -> bool {
    numbers.iter().all(|&x| x > 0.0)
}

/// Returns `E = |C| R`.
#[inline(always)]
fn deviation<const K: usize, const C: usize>(
    inverse: &[[f64; K]; K],
    radius: &[[f64; C]; K],
) -> [[f64; C]; K] {
    let mut e = [[0.0; C]; K];
    for i in 0..K {
        for k in 0..K {
            let size = inverse[i][k].abs();
            for j in 0..C {
                e[i][j] += size * radius[k][j];
            }
        }
    }
    e
}

/// Returns `BOUND − E`.
#[inline(always)]
fn distance_from_one<const K: usize>(e: &[[f64; K]; K]) -> [[f64; K]; K] {
    let mut a = *e;
    for i in 0..K {
        for j in 0..K {
            a[i][j] = -e[i][j];
        }
        a[i][i] += BOUND;
    }
    a
}

/// Returns whether all pivots are positive.
#[inline(always)]
fn has_positive_pivots<const K: usize>(mut a: [[f64; K]; K]) -> bool {
    let mut all = true;
    for k in 0..K {
        all &= a[k][k] > 0.0;
        let inverse = 1.0 / a[k][k];
        for i in k + 1..K {
            let factor = a[i][k] * inverse;
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
        }
    }
    all
}

/// Returns the solution of a system by elimination; NaN if a pivot is not positive.
#[inline(always)]
fn solve_by_positive_pivots<const K: usize>(mut a: [[f64; K]; K], b: &[f64; K]) -> [f64; K] {
    let (mut x, mut inverses) = (*b, [0.0; K]);
    for k in 0..K {
        inverses[k] = positive_inverse(a[k][k]);
        for i in k + 1..K {
            let factor = a[i][k] * inverses[k];
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            x[i] -= factor * x[k];
        }
    }
    for k in (0..K).rev() {
        for j in k + 1..K {
            x[k] -= a[k][j] * x[j];
        }
        x[k] *= inverses[k];
    }
    x
}

/// Returns the inverse of a positive number, and NaN for others.
#[inline(always)]
fn positive_inverse(x: f64) -> f64 {
    if x > 0.0 { 1.0 / x } else { f64::NAN }
}

/// Returns whether no number exceeds its bound; `false` if one is NaN.
#[inline(always)]
fn is_within<const K: usize>(x: &[f64; K], bounds: &[f64; K]) -> bool {
    let mut all = true;
    for i in 0..K {
        all &= x[i] <= bounds[i];
    }
    all
}

/// Returns the inverse, by Gauss–Jordan elimination with partial pivoting; NaN or infinite if the
/// matrix is singular.
#[inline(always)]
fn inverse<const K: usize>(mut a: [[f64; K]; K]) -> [[f64; K]; K] {
    let mut b = [[0.0; K]; K];
    for i in 0..K {
        b[i][i] = 1.0;
    }
    for k in 0..K {
        for i in k + 1..K {
            let larger = a[i][k].abs() > a[k][k].abs();
            for j in 0..K {
                let (upper, lower) = (a[k][j], a[i][j]);
                a[k][j] = if larger { lower } else { upper };
                a[i][j] = if larger { upper } else { lower };
                let (upper, lower) = (b[k][j], b[i][j]);
                b[k][j] = if larger { lower } else { upper };
                b[i][j] = if larger { upper } else { lower };
            }
        }
        let pivot = 1.0 / a[k][k];
        for j in 0..K {
            a[k][j] *= pivot;
            b[k][j] *= pivot;
        }
        for i in 0..K {
            let factor = if i == k { 0.0 } else { a[i][k] };
            for j in 0..K {
                a[i][j] -= factor * a[k][j];
                b[i][j] -= factor * b[k][j];
            }
        }
    }
    b
}

#[cfg(test)]
mod tests;

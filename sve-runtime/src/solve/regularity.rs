//! Regularity of an interval matrix: decides whether every matrix within given distances of another one is regular. A step
//! accepts its root by this test.
//!
//! Input: midpoints and radii of the entries. Output: whether all matrices in between have an inverse. Invariant: no
//! branches, so that a loop over lanes compiles to vector instructions, and the answer is the same for a single state and in lanes.
//!
//! Let C be the inverse of the midpoint matrix, R the radii and `E = |C| R`. Then `C A` differs from the identity by at most E in each entry, and A is
//! regular if the spectral radius of E is below 1. This holds if `1 − E` is an M-matrix, whose pivots are positive. The test
//! does not depend on the units of equations and unknowns.
//!
//! Sources: Neumaier, *Interval Methods for Systems of Equations* (1990), proposition 4.1.1; Berman, Plemmons, *Nonnegative
//! Matrices in the Mathematical Sciences* (1994), chapter 6, for M-matrices.

#![allow(clippy::needless_bitwise_bool)] // both sides are computed: a branch would prevent vector instructions

use super::diagonal::Diagonal;

/// Bound of the spectral radius. Its distance from 1 covers the rounding errors of the radii and of a nearly singular inverse.
const BOUND: f64 = 0.95;

/// The midpoints of an interval matrix.
pub trait Midpoints<const K: usize> {
    /// Returns whether every matrix whose entries are within `radius` of the midpoints is regular.
    fn is_regular_within(&self, radius: &[[f64; K]; K]) -> bool;
}

/// Returns whether every matrix whose entries are within `radius` of those of `middle` is regular; `false` if an entry is NaN.
#[inline(always)]
pub fn is_regular_within<const K: usize>(
    middle: &impl Midpoints<K>,
    radius: &[[f64; K]; K],
) -> bool {
    middle.is_regular_within(radius)
}

impl<const K: usize> Midpoints<K> for [[f64; K]; K] {
    #[inline(always)]
    fn is_regular_within(&self, radius: &[[f64; K]; K]) -> bool {
        is_regular_within_dense(self, radius)
    }
}

impl<const K: usize> Midpoints<K> for Diagonal<K> {
    /// `1 − E` times the midpoint is an M-matrix if `1 − E` is, so that no inverse is needed.
    #[inline(always)]
    fn is_regular_within(&self, radius: &[[f64; K]; K]) -> bool {
        let mut difference = *radius;
        for i in 0..K {
            for j in 0..K {
                difference[i][j] = -radius[i][j];
            }
            difference[i][i] += BOUND * self.0[i][0].abs();
        }
        has_positive_pivots(difference)
    }
}

#[inline(always)]
fn is_regular_within_dense<const K: usize>(middle: &[[f64; K]; K], radius: &[[f64; K]; K]) -> bool {
    match K {
        1 => radius[0][0] < BOUND * middle[0][0].abs(),
        2 => {
            let [a, b, c, d] = [middle[0][0], middle[0][1], middle[1][0], middle[1][1]];
            // (1 − E) times the determinant of the midpoint: the adjugate needs no division
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

/// Calls a function on a path that is rarely taken, so that the compiler optimises the rest of the step for the other path.
#[cold]
#[inline(never)]
pub fn cold<T>(f: impl FnOnce() -> T) -> T {
    f()
}

/// Returns `E = |C| R`.
#[inline(always)]
fn deviation<const K: usize>(inverse: &[[f64; K]; K], radius: &[[f64; K]; K]) -> [[f64; K]; K] {
    let mut e = [[0.0; K]; K];
    for i in 0..K {
        for k in 0..K {
            let size = inverse[i][k].abs();
            for j in 0..K {
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

/// Returns the inverse, by Gauss–Jordan elimination with partial pivoting; NaN or infinite if the matrix is singular.
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
mod tests {
    use super::is_regular_within;
    use crate::solve::dense::tests::Random;
    use crate::solve::diagonal::Diagonal;

    /// Returns the determinant of a small matrix, by elimination with partial pivoting.
    fn determinant<const K: usize>(mut a: [[f64; K]; K]) -> f64 {
        let mut product = 1.0;
        for k in 0..K {
            let pivot = (k..K).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs()));
            let pivot = pivot.unwrap_or(k);
            if pivot != k {
                a.swap(k, pivot);
                product = -product;
            }
            product *= a[k][k];
            for i in k + 1..K {
                let factor = a[i][k] / a[k][k];
                for j in k..K {
                    a[i][j] -= factor * a[k][j];
                }
            }
        }
        product
    }

    /// Checks that no matrix within the radii of an accepted one has a determinant of the other sign. Returns the numbers of refused and accepted matrices.
    fn samples<const K: usize>(random: &mut Random) -> [u32; 2] {
        let mut counts = [0; 2];
        for _ in 0..400 {
            let middle: [[f64; K]; K] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            let size = 0.4 * random.next().abs();
            let radius = middle.map(|row| row.map(|x| size * (x.abs() + 0.1)));
            let accepted = is_regular_within(&middle, &radius);
            counts[usize::from(accepted)] += 1;
            if !accepted {
                continue;
            }
            let sign = determinant(middle).signum();
            for _ in 0..50 {
                let corner = core::array::from_fn(|i| {
                    core::array::from_fn(|j| middle[i][j] + radius[i][j] * random.next().signum())
                });
                assert!(determinant::<K>(corner) * sign > 0.0, "{middle:?}");
            }
        }
        counts
    }

    #[test]
    fn accepted_neighbourhoods_contain_no_singular_matrix() {
        let mut random = Random(11);
        let counts = [
            samples::<1>(&mut random),
            samples::<2>(&mut random),
            samples::<3>(&mut random),
            samples::<4>(&mut random),
        ];
        for [refused, accepted] in counts {
            assert!(refused > 10 && accepted > 50, "{counts:?}");
        }
    }

    #[test]
    fn the_test_is_sharp_for_diagonal_matrices_in_any_units() {
        let middle: [[f64; 3]; 3] = [[2e150, 0.0, 0.0], [0.0, -3.0, 0.0], [0.0, 0.0, 1e-150]];
        let scaled = |by: f64| middle.map(|row| row.map(|x| by * x.abs()));
        assert!(is_regular_within(&middle, &scaled(0.94)));
        assert!(!is_regular_within(&middle, &scaled(0.96)));
    }

    #[test]
    fn diagonal_midpoints_are_accepted_as_the_same_matrix_written_in_full() {
        let mut random = Random(5);
        let mut counts = [0; 2];
        for _ in 0..2000 {
            let diagonal: [f64; 3] = core::array::from_fn(|_| random.next() * random.unit());
            let full: [[f64; 3]; 3] = core::array::from_fn(|i| {
                core::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 })
            });
            let size = random.next().abs();
            let radius =
                diagonal.map(|x| core::array::from_fn(|_| size * x.abs() * random.next().abs()));
            let accepted = is_regular_within(&Diagonal(diagonal.map(|x| [x])), &radius);
            assert_eq!(accepted, is_regular_within(&full, &radius));
            counts[usize::from(accepted)] += 1;
        }
        assert!(counts.iter().all(|&count| count > 100), "{counts:?}");
        assert!(!is_regular_within(&Diagonal([[0.0]; 3]), &[[0.0; 3]; 3]));
        assert!(!is_regular_within(
            &Diagonal([[1.0]; 3]),
            &[[f64::NAN; 3]; 3]
        ));
    }

    #[test]
    fn singular_matrices_and_nan_are_refused() {
        assert!(!is_regular_within(&[[f64::NAN]], &[[0.0]]));
        assert!(!is_regular_within(&[[1.0]], &[[f64::NAN]]));
        assert!(!is_regular_within(
            &[[1.0, 0.0], [0.0, 0.0]],
            &[[0.0; 2]; 2]
        ));
        assert!(!is_regular_within(&[[0.0; 3]; 3], &[[0.0; 3]; 3]));
    }
}

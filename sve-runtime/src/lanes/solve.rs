//! Linear systems of a few unknowns, without branches, for loops over lanes.
//!
//! Input: matrix and right-hand side of a lane. Output: the solution; NaN or infinite if the matrix is singular.
//! One and two unknowns are solved by the formulas of [`dense`](crate::solve::dense), bit for bit. Three and more are solved by Gaussian elimination
//! with partial pivoting. Pivots may differ from those of the scalar solve, which scales rows before comparing them; [`solve_with_sign`] scales them too.

#![allow(clippy::needless_bitwise_bool)] // both sides are computed: a branch would prevent vector instructions

use crate::solve::dense::SINGULAR;

/// A pivot that is smaller than this, in units of the threshold of the scalar solve, has too few correct digits for a lane. The scalar solve decides whether it
/// is a rounding error; the factor leaves room for the different roundings of the two solves.
const UNSURE: f64 = 1024.0;

/// Solves `a x = b`; the solution is NaN or infinite if `a` is singular.
#[inline(always)]
pub fn solve<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> [f64; K] {
    let mut x = [0.0; K];
    match K {
        0 => {}
        1 => x[0] = b[0] / a[0][0],
        2 => {
            let (ad, bc) = (a[0][0] * a[1][1], a[0][1] * a[1][0]);
            let det = ad - bc;
            let inverse = if det.abs() <= SINGULAR * (ad.abs() + bc.abs()) {
                f64::NAN
            } else {
                1.0 / det
            };
            x[0] = (b[0] * a[1][1] - b[1] * a[0][1]) * inverse;
            x[1] = (b[1] * a[0][0] - b[0] * a[1][0]) * inverse;
        }
        _ => x = factored(a).solve(b),
    }
    x
}

/// Solves `a x = b` with the pivots of the scalar solve. Returns the solution and a number with the sign of the determinant.
#[inline(always)]
pub fn solve_with_sign<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> ([f64; K], f64) {
    solve_scaled::<K, false>(a, b)
}

/// Solves `a x = b` as [`solve_with_sign`]. The solution is NaN or infinite wherever the scalar solve takes `a` for singular to rounding.
#[inline(always)]
pub fn solve_regular<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> ([f64; K], f64) {
    solve_scaled::<K, true>(a, b)
}

#[inline(always)]
fn solve_scaled<const K: usize, const TESTS_PIVOTS: bool>(
    a: &[[f64; K]; K],
    b: &[f64; K],
) -> ([f64; K], f64) {
    match K {
        0 => ([0.0; K], 1.0),
        1 => (solve(a, b), a[0][0]),
        2 => (solve(a, b), a[0][0] * a[1][1] - a[0][1] * a[1][0]),
        _ => eliminate::<K, TESTS_PIVOTS>(*a, *b),
    }
}

/// Gaussian elimination with scaled partial pivoting. Rows are exchanged by selecting each entry, without a branch. The sum of the magnitudes of the terms of a pivot
/// tells how many of its digits are correct.
#[inline(always)]
fn eliminate<const K: usize, const TESTS_PIVOTS: bool>(
    mut a: [[f64; K]; K],
    mut x: [f64; K],
) -> ([f64; K], f64) {
    // the largest entry of each row, and the magnitudes of the terms of each entry
    let mut scale = [0.0; K];
    let mut terms = a;
    for i in 0..K {
        for j in 0..K {
            terms[i][j] = a[i][j].abs();
            let is_larger = terms[i][j] > scale[i];
            scale[i] = if is_larger { terms[i][j] } else { scale[i] };
        }
    }
    let (mut sign, mut is_sure) = (1.0, true);
    for k in 0..K {
        for i in k + 1..K {
            let larger = a[i][k].abs() * scale[k] > a[k][k].abs() * scale[i];
            for j in k..K {
                (a[k][j], a[i][j]) = exchanged(larger, a[k][j], a[i][j]);
                if TESTS_PIVOTS {
                    (terms[k][j], terms[i][j]) = exchanged(larger, terms[k][j], terms[i][j]);
                }
            }
            (x[k], x[i]) = exchanged(larger, x[k], x[i]);
            (scale[k], scale[i]) = exchanged(larger, scale[k], scale[i]);
            sign = if larger { -sign } else { sign };
        }
        if TESTS_PIVOTS {
            is_sure &= a[k][k].abs() > UNSURE * K as f64 * SINGULAR * terms[k][k];
        }
        sign = if a[k][k] < 0.0 { -sign } else { sign };
        let inverse = 1.0 / a[k][k];
        for i in k + 1..K {
            let factor = a[i][k] * inverse;
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
                if TESTS_PIVOTS {
                    terms[i][j] += factor.abs() * terms[k][j];
                }
            }
            x[i] -= factor * x[k];
        }
        a[k][k] = inverse;
    }
    for k in (0..K).rev() {
        for j in k + 1..K {
            x[k] -= a[k][j] * x[j];
        }
        x[k] *= a[k][k];
    }
    x[0] = if is_sure { x[0] } else { f64::NAN };
    (x, sign)
}

/// Returns two numbers, exchanged if asked for.
#[inline(always)]
fn exchanged(exchanges: bool, a: f64, b: f64) -> (f64, f64) {
    (if exchanges { b } else { a }, if exchanges { a } else { b })
}

/// The LU factors of a matrix, for several right-hand sides.
#[derive(Clone, Copy)]
pub struct Factors<const K: usize> {
    /// The upper factor with the inverses of its diagonal. Below it, in column `k`, the multiples of row `k` that the elimination of this
    /// column subtracts, in the order of the rows at that time.
    lu: [[f64; K]; K],
    /// Whether row `k` was exchanged with a row below it, by the number of `k` and of that row.
    is_exchanged: [[bool; K]; K],
}

/// Factors a matrix by Gaussian elimination with partial pivoting. Rows are exchanged by selecting each entry, without a branch. The
/// factors of a singular matrix are not finite.
#[inline(always)]
pub fn factored<const K: usize>(a: &[[f64; K]; K]) -> Factors<K> {
    let mut a = *a;
    let mut is_exchanged = [[false; K]; K];
    for k in 0..K {
        for i in k + 1..K {
            let larger = a[i][k].abs() > a[k][k].abs();
            is_exchanged[k][i] = larger;
            for j in k..K {
                let (upper, lower) = (a[k][j], a[i][j]);
                a[k][j] = if larger { lower } else { upper };
                a[i][j] = if larger { upper } else { lower };
            }
        }
        let inverse = 1.0 / a[k][k];
        for i in k + 1..K {
            let factor = a[i][k] * inverse;
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
            }
            a[i][k] = factor;
        }
        a[k][k] = inverse;
    }
    Factors {
        lu: a,
        is_exchanged,
    }
}

impl<const K: usize> Factors<K> {
    /// Solves `a x = b`, bit for bit as [`solve`] does for three and more unknowns.
    #[inline(always)]
    pub fn solve(&self, b: &[f64; K]) -> [f64; K] {
        let mut x = *b;
        for k in 0..K {
            for i in k + 1..K {
                let larger = self.is_exchanged[k][i];
                let (upper, lower) = (x[k], x[i]);
                x[k] = if larger { lower } else { upper };
                x[i] = if larger { upper } else { lower };
            }
            for i in k + 1..K {
                x[i] -= self.lu[i][k] * x[k];
            }
        }
        for k in (0..K).rev() {
            let mut sum = x[k];
            for j in k + 1..K {
                sum -= self.lu[k][j] * x[j];
            }
            x[k] = sum * self.lu[k][k];
        }
        x
    }
}

/// Returns the inverse of `a`; NaN or infinite if `a` is singular.
#[inline(always)]
pub fn inverse<const K: usize>(a: &[[f64; K]; K]) -> [[f64; K]; K] {
    let mut inverse = [[0.0; K]; K];
    match K {
        1 => inverse[0][0] = 1.0 / a[0][0],
        2 => {
            let scale = 1.0 / (a[0][0] * a[1][1] - a[0][1] * a[1][0]);
            inverse[0][0] = a[1][1] * scale;
            inverse[0][1] = -a[0][1] * scale;
            inverse[1][0] = -a[1][0] * scale;
            inverse[1][1] = a[0][0] * scale;
        }
        _ => {
            let factors = factored(a);
            for column in 0..K {
                let mut unit = [0.0; K];
                unit[column] = 1.0;
                let solution = factors.solve(&unit);
                for row in 0..K {
                    inverse[row][column] = solution[row];
                }
            }
        }
    }
    inverse
}

#[cfg(test)]
mod tests {
    use super::{factored, inverse, solve};
    use crate::solve::dense::{self, tests::Random};

    fn compare_with_the_scalar_solve<const K: usize>(random: &mut Random, tolerance: f64) {
        for _ in 0..200 {
            let a: [[f64; K]; K] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            let b: [f64; K] = core::array::from_fn(|_| random.next());
            let x = solve(&a, &b);
            let expected = dense::solve(&a, &b).unwrap();
            // A backward stable solution has a residual that is small relative to its terms, whatever the condition of the matrix.
            for i in 0..K {
                let terms = (0..K).map(|j| a[i][j] * x[j]);
                let (mut residual, mut size) = (-b[i], b[i].abs());
                for term in terms {
                    residual += term;
                    size += term.abs();
                }
                let largest = x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
                assert!(
                    residual.abs() <= 1e-15 * K as f64 * (size + largest),
                    "{residual:e}"
                );
                if tolerance == 0.0 {
                    assert_eq!(x[i], expected[i]);
                }
            }
        }
    }

    #[test]
    fn solutions_are_those_of_the_scalar_solve() {
        let mut random = Random(5);
        compare_with_the_scalar_solve::<1>(&mut random, 0.0);
        compare_with_the_scalar_solve::<2>(&mut random, 0.0);
        compare_with_the_scalar_solve::<3>(&mut random, 1.0);
        compare_with_the_scalar_solve::<6>(&mut random, 1.0);
    }

    fn compare_with_the_identity<const K: usize>(random: &mut Random) {
        let mut a: [[f64; K]; K] =
            core::array::from_fn(|_| core::array::from_fn(|_| 0.5 * random.next()));
        for (i, row) in a.iter_mut().enumerate() {
            row[i] += 2.0;
        }
        let inverse = inverse(&a);
        for (i, row) in a.iter().enumerate() {
            for j in 0..K {
                let entry: f64 = (0..K).map(|k| row[k] * inverse[k][j]).sum();
                let expected = f64::from(u8::from(i == j));
                assert!((entry - expected).abs() < 1e-14, "{K} rows: {entry}");
            }
        }
    }

    #[test]
    fn a_matrix_times_its_inverse_is_the_identity() {
        let mut random = Random(11);
        compare_with_the_identity::<1>(&mut random);
        compare_with_the_identity::<2>(&mut random);
        compare_with_the_identity::<3>(&mut random);
        compare_with_the_identity::<5>(&mut random);
    }

    #[test]
    fn rows_are_exchanged_for_a_pivot() {
        let a = [[0.0, 1.0, 0.0], [0.0, 0.0, 2.0], [4.0, 0.0, 0.0]];
        assert_eq!(solve(&a, &[1.0, 2.0, 4.0]), [1.0, 1.0, 1.0]);
    }

    #[test]
    fn singular_matrices_have_no_finite_solution() {
        let finite = |x: &[f64]| x.iter().all(|x| x.is_finite());
        assert!(!finite(&solve(&[[0.0]], &[1.0])));
        assert!(!finite(&solve(&[[1.0, 2.0], [0.5, 1.0]], &[1.0, 1.0])));
        let a = [[1.0, 2.0, 3.0], [2.0, 4.0, 6.0], [1.0, 1.0, 1.0]];
        assert!(!finite(&solve(&a, &[1.0, 1.0, 1.0])));
    }

    /// Elimination with the right-hand side carried along.
    fn eliminated<const K: usize>(mut a: [[f64; K]; K], mut b: [f64; K]) -> [f64; K] {
        for k in 0..K {
            for i in k + 1..K {
                if a[i][k].abs() > a[k][k].abs() {
                    a.swap(i, k);
                    b.swap(i, k);
                }
            }
            let inverse = 1.0 / a[k][k];
            for i in k + 1..K {
                let factor = a[i][k] * inverse;
                for j in k + 1..K {
                    a[i][j] -= factor * a[k][j];
                }
                b[i] -= factor * b[k];
            }
            a[k][k] = inverse;
        }
        for k in (0..K).rev() {
            for j in k + 1..K {
                b[k] -= a[k][j] * b[j];
            }
            b[k] *= a[k][k];
        }
        b
    }

    #[test]
    fn factors_give_the_bits_of_elimination() {
        let mut random = Random(9);
        for _ in 0..200 {
            let a: [[f64; 5]; 5] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            let factors = factored(&a);
            for _ in 0..3 {
                let b: [f64; 5] = core::array::from_fn(|_| random.next());
                assert_eq!(factors.solve(&b), eliminated(a, b));
            }
        }
    }
}

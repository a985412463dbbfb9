//! Linear systems of a few unknowns, without branches, for loops over lanes.
//!
//! Input: matrix and right-hand side of a lane. Output: the solution; NaN or infinite if the matrix
//! is singular. One and two unknowns are solved by the formulas of [`dense`](crate::solve::dense),
//! bit for bit. Three and more are solved by Gaussian elimination with partial pivoting. Its pivots
//! may differ from the pivots of the scalar solve, which scales rows before comparing them. Steps
//! with constraints solve three and more unknowns by code that the macro writes for the zeros of
//! their matrices.

use crate::solve::dense::SINGULAR;

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

/// A solution, and a number with the sign of the determinant.
#[derive(Clone, Copy)]
pub struct Solved<const K: usize> {
    /// The solution.
    pub by: [f64; K],
    /// The entry of a single row, otherwise a number with the sign of the determinant.
    pub determinant: f64,
}

/// Solves `a x = b` for one or two unknowns, as [`solve`] does.
#[inline(always)]
pub fn solved<const K: usize>(a: &[[f64; K]; K], b: &[f64; K]) -> Solved<K> {
    const { assert!(K == 1 || K == 2, "one or two unknowns") };
    let determinant = if K == 1 {
        a[0][0]
    } else {
        a[0][0] * a[K - 1][K - 1] - a[0][K - 1] * a[K - 1][0]
    };
    let by = solve(a, b);
    Solved { by, determinant }
}

/// Size of a pivot at which a lane is sure that it is not rounding error, in units of the threshold
/// of the scalar solve. The scalar solve has other pivots with other rounding errors; it decides
/// where a lane is not sure.
const SURE: f64 = 1024.0;

/// Returns whether a pivot of a matrix of `K` rows has correct digits. `terms` is the sum of the
/// magnitudes of the terms whose sum is the pivot.
#[inline(always)]
pub fn has_digits<const K: usize>(pivot: f64, terms: f64) -> bool {
    pivot.abs() > SURE * K as f64 * SINGULAR * terms
}

/// Returns whether a matrix is surely regular, without branches. The scalar test decides where a
/// lane is not sure.
#[inline(always)]
pub fn is_regular<const K: usize>(a: &[[f64; K]; K]) -> bool {
    if K == 1 {
        return a[0][0] != 0.0;
    }
    let (mut a, mut terms) = (*a, *a);
    for entry in terms.as_flattened_mut() {
        *entry = entry.abs();
    }
    let mut is_sure = true;
    for k in 0..K {
        for i in k + 1..K {
            let is_larger = a[i][k].abs() > a[k][k].abs();
            for j in k..K {
                for rows in [&mut a, &mut terms] {
                    let (upper, lower) = (rows[k][j], rows[i][j]);
                    rows[k][j] = if is_larger { lower } else { upper };
                    rows[i][j] = if is_larger { upper } else { lower };
                }
            }
        }
        is_sure &= has_digits::<K>(a[k][k], terms[k][k]);
        let inverse = 1.0 / a[k][k];
        for i in k + 1..K {
            let factor = a[i][k] * inverse;
            for j in k + 1..K {
                a[i][j] -= factor * a[k][j];
                terms[i][j] += factor.abs() * terms[k][j];
            }
        }
    }
    is_sure
}

/// The LU factors of a matrix, for several right-hand sides.
#[derive(Clone, Copy)]
pub struct Factors<const K: usize> {
    /// The upper factor with the inverses of its diagonal. Below it, in column `k`, the multiples
    /// of row `k` that the elimination of this column subtracts, in the order of the rows at that
    /// time.
    lu: [[f64; K]; K],
    /// True if row `k` was exchanged with row `i` below it, for the indices `[k][i]`.
    is_exchanged: [[bool; K]; K],
}

/// Factors a matrix by Gaussian elimination with partial pivoting. Rows are exchanged by selecting
/// each entry, without a branch. The factors of a singular matrix are not finite.
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
    use super::{factored, inverse, is_regular, solve};
    use crate::solve::dense::{self, tests::Random};

    fn compare_with_the_scalar_solve<const K: usize>(random: &mut Random, tolerance: f64) {
        for _ in 0..200 {
            let a: [[f64; K]; K] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            let b: [f64; K] = core::array::from_fn(|_| random.next());
            let x = solve(&a, &b);
            let expected = dense::solve(&a, &b).unwrap();
            // A backward stable solution has a residual that is small relative to its terms,
            // whatever the condition of the matrix.
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

    #[test]
    fn a_lane_is_sure_of_no_singular_matrix() {
        let mut random = Random(7);
        for _ in 0..500 {
            let mut a: [[f64; 4]; 4] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            assert!(is_regular(&a), "{a:?}");
            let (x, y) = (random.next(), random.next());
            a[3] = core::array::from_fn(|j| x * a[0][j] + y * a[1][j]);
            assert!(!is_regular(&a), "{a:?}");
        }
        assert!(is_regular(&[[1e-300]]) && !is_regular(&[[0.0]]));
        assert!(is_regular(&[[1.0, 1.0], [1.0, 1.0 + 1e-9]]));
        assert!(!is_regular(&[[1.0, 1.0], [1.0, 1.0]]));
        assert!(!is_regular(&[[f64::NAN, 1.0], [1.0, 1.0]]));
    }

    /// Solves by elimination that carries the right-hand side along.
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

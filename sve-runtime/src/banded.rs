//! Banded linear systems of a size known at compile time.
//!
//! Input: the entries near the diagonal and a right-hand side. Output: what [`linear::solve`](crate::linear::solve) gives for
//! the same matrix written in full, bit for bit: the same pivots, the same operations on what is not zero, the same test for
//! singular matrices. Rows that are left of their first column eliminated move to the left, so that the factors need no more
//! room than the matrix (Martin and Wilkinson, Solution of symmetric and unsymmetric band equations, 1967).

use crate::linear::{Matrix, SINGULAR};

/// A matrix of `K` rows with at most `LOWER` entries before the diagonal, and `WIDTH` entries a row.
///
/// Row `i` begins at column 0 up to `i = LOWER`, then at column `i − LOWER`; entries beyond the last column are zero.
#[derive(Clone, Copy, Debug)]
pub struct Banded<const K: usize, const LOWER: usize, const WIDTH: usize>(pub [[f64; WIDTH]; K]);

impl<const K: usize, const LOWER: usize, const WIDTH: usize> Matrix<K> for Banded<K, LOWER, WIDTH> {
    fn solve_oriented(&self, rhs: &[f64; K]) -> Option<([f64; K], f64)> {
        let (mut a, mut b) = (self.0, *rhs);
        let mut negative = false;
        let mut scale = a.map(|row| largest(&row));
        for k in 0..K {
            let end = end::<K, LOWER>(k);
            let pivot = pivot(&a, &scale, k, end);
            let size = a[pivot][0].abs();
            if size <= K as f64 * SINGULAR * scale[pivot] && self.cancelled(k) {
                return None;
            }
            a.swap(k, pivot);
            b.swap(k, pivot);
            scale.swap(k, pivot);
            negative ^= (a[k][0] < 0.0) ^ (pivot != k);
            for i in k + 1..end {
                let factor = a[i][0] / a[k][0];
                for j in 1..WIDTH {
                    a[i][j - 1] = a[i][j] - factor * a[k][j];
                }
                a[i][WIDTH - 1] = 0.0;
                b[i] -= factor * b[k];
            }
        }
        let mut x = [0.0; K];
        for k in (0..K).rev() {
            let mut sum = b[k];
            for j in 1..WIDTH.min(K - k) {
                sum -= a[k][j] * x[k + j];
            }
            x[k] = sum / a[k][0];
        }
        Some((x, if negative { -1.0 } else { 1.0 }))
    }

    fn is_finite(&self) -> bool {
        self.0.as_flattened().iter().all(|x| x.is_finite())
    }

    #[inline]
    fn first(&self) -> f64 {
        self.0[0][0]
    }
}

impl<const K: usize, const LOWER: usize, const WIDTH: usize> Banded<K, LOWER, WIDTH> {
    /// Whether the pivot of column `column` is the rounding of the terms it is what is left of, as for a full matrix.
    #[cold]
    fn cancelled(&self, column: usize) -> bool {
        let mut a = self.0;
        let mut terms = a.map(|row| row.map(f64::abs));
        let mut scale = a.map(|row| largest(&row));
        for k in 0..=column {
            let end = end::<K, LOWER>(k);
            let pivot = pivot(&a, &scale, k, end);
            a.swap(k, pivot);
            terms.swap(k, pivot);
            scale.swap(k, pivot);
            if k == column {
                break;
            }
            for i in k + 1..end {
                let factor = a[i][0] / a[k][0];
                for j in 1..WIDTH {
                    a[i][j - 1] = a[i][j] - factor * a[k][j];
                    terms[i][j - 1] = terms[i][j] + factor.abs() * terms[k][j];
                }
                a[i][WIDTH - 1] = 0.0;
                terms[i][WIDTH - 1] = 0.0;
            }
        }
        a[column][0].abs() <= K as f64 * SINGULAR * terms[column][0]
    }
}

/// The row after the last one that has column `k`; all from `k` to there begin at that column when its turn comes.
#[inline]
fn end<const K: usize, const LOWER: usize>(k: usize) -> usize {
    (k + LOWER + 1).min(K)
}

/// The row with the largest first entry relative to its scale.
#[inline]
fn pivot<const K: usize, const WIDTH: usize>(
    a: &[[f64; WIDTH]; K],
    scale: &[f64; K],
    k: usize,
    end: usize,
) -> usize {
    let mut pivot = k;
    for i in k + 1..end {
        if a[i][0].abs() * scale[pivot] > a[pivot][0].abs() * scale[i] {
            pivot = i;
        }
    }
    pivot
}

/// Largest magnitude in a row.
#[inline]
fn largest<const WIDTH: usize>(row: &[f64; WIDTH]) -> f64 {
    row.iter().fold(0.0, |m: f64, x| m.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::Banded;
    use crate::linear::tests::Random;
    use crate::linear::{Matrix, solve, solve_oriented};

    /// The first column of a row.
    fn first<const LOWER: usize>(row: usize) -> usize {
        row.saturating_sub(LOWER)
    }

    fn full<const K: usize, const LOWER: usize, const WIDTH: usize>(
        a: &Banded<K, LOWER, WIDTH>,
    ) -> [[f64; K]; K] {
        let mut full = [[0.0; K]; K];
        for i in 0..K {
            for (j, &x) in a.0[i].iter().enumerate() {
                if first::<LOWER>(i) + j < K {
                    full[i][first::<LOWER>(i) + j] = x;
                }
            }
        }
        full
    }

    /// Entries in [−1, 1), a part of them zero, each row and each column in a unit of its own.
    fn random<const K: usize, const LOWER: usize, const WIDTH: usize>(
        random: &mut Random,
        zeros: f64,
        units: bool,
    ) -> Banded<K, LOWER, WIDTH> {
        let mut unit = || if units { random.unit() } else { 1.0 };
        let columns: [f64; K] = core::array::from_fn(|_| unit());
        let rows: [f64; K] = core::array::from_fn(|_| unit());
        let mut a = [[0.0; WIDTH]; K];
        for i in 0..K {
            let begin = first::<LOWER>(i);
            // to the right of the diagonal as many in each row, so fewer before it in the first rows
            let end = (i + WIDTH - LOWER).min(K);
            for j in begin..end {
                if random.next().abs() >= zeros {
                    a[i][j - begin] = random.next() * rows[i] * columns[j];
                }
            }
        }
        Banded(a)
    }

    fn as_dense<const K: usize, const LOWER: usize, const WIDTH: usize>() {
        let mut generator = Random((K + 10 * LOWER + 100 * WIDTH) as u64);
        let (mut solved, mut refused, mut swapped) = (0, 0, 0);
        for sample in 0..4000 {
            let zeros = [0.0, 0.1, 0.3][sample % 3];
            let mut a = random::<K, LOWER, WIDTH>(&mut generator, zeros, sample % 2 == 0);
            if sample % 5 == 0 {
                // a column that is a multiple of another to rounding, where both are in the same rows
                let factor = generator.next();
                for i in 0..K {
                    let begin = first::<LOWER>(i);
                    if begin == 0 && WIDTH > 1 {
                        a.0[i][1] = factor * a.0[i][0];
                    }
                }
            }
            let b: [f64; K] = core::array::from_fn(|_| generator.next());
            let dense = full(&a);
            swapped += u32::from((1..K).any(|i| dense[i][i - 1].abs() > dense[i - 1][i - 1].abs()));
            let (x, y) = (solve_oriented(&a, &b), solve_oriented(&dense, &b));
            let signs = |x: Option<([f64; K], f64)>| x.map(|(x, o)| (x, o < 0.0));
            assert_eq!(signs(x), signs(y), "{dense:?} {b:?}");
            *(if x.is_some() {
                &mut solved
            } else {
                &mut refused
            }) += 1;
        }
        assert!(solved > 500 && refused > 100, "{solved} {refused}");
        assert!(LOWER == 0 || swapped > 100, "{swapped}");
    }

    #[test]
    fn banded_and_dense_elimination_agree_in_every_bit() {
        as_dense::<7, 0, 1>();
        as_dense::<7, 1, 2>();
        as_dense::<7, 0, 2>();
        as_dense::<3, 1, 3>();
        as_dense::<8, 1, 3>();
        as_dense::<9, 2, 5>();
        as_dense::<9, 1, 4>();
        as_dense::<9, 3, 5>();
        as_dense::<6, 5, 11>();
    }

    #[test]
    fn what_is_not_finite_is_noticed() {
        let mut a = Banded::<3, 1, 3>([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [1.0, 2.0, 0.0]]);
        assert!(a.is_finite());
        assert_eq!(a.first(), 2.0);
        assert_eq!(solve(&a, &[3.0, 4.0, 3.0]), Some([1.0; 3]));
        a.0[2][1] = f64::NAN;
        assert!(!a.is_finite());
    }
}

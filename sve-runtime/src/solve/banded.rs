//! Linear systems with a banded matrix of a size known at compile time.
//!
//! Input: the entries near the diagonal and a right-hand side. Output: bit for bit what
//! [`dense`](super::dense) gives for the same matrix written in full: the same pivots, the same
//! operations on entries that are not zero, the same test for singular matrices. Each elimination
//! step shifts the rows below the pivot by one entry to the left, so that the factors need no more
//! room than the matrix (Martin and Wilkinson, *Solution of symmetric and unsymmetric band
//! equations*, 1967).

use super::dense::{DeterminantSign, Matrix, all_finite, largest_magnitude};

/// A matrix of `K` rows with at most `LOWER` entries before the diagonal, and `WIDTH` entries in a
/// row.
///
/// Row `i` begins at column 0 if `i ≤ LOWER`, otherwise at column `i − LOWER`. Entries beyond the
/// last column are zero.
#[derive(Clone, Copy, Debug)]
pub struct Banded<const K: usize, const LOWER: usize, const WIDTH: usize>(pub [[f64; WIDTH]; K]);

impl<const K: usize, const LOWER: usize, const WIDTH: usize> Matrix<K> for Banded<K, LOWER, WIDTH> {
    fn solve_above(&self, rounding: f64, rhs: &[f64; K]) -> Option<([f64; K], DeterminantSign)> {
        let (mut a, mut b) = (self.0, *rhs);
        let mut is_negative = false;
        let mut scale = a.map(|row| largest_magnitude(&row));
        for k in 0..K {
            let end = end_of_column::<K, LOWER>(k);
            let pivot = pivot_row(&a, &scale, k, end);
            let size = a[pivot][0].abs();
            if size <= K as f64 * rounding * scale[pivot] && self.is_rounding_error(rounding, k) {
                return None;
            }
            a.swap(k, pivot);
            b.swap(k, pivot);
            scale.swap(k, pivot);
            is_negative ^= (a[k][0] < 0.0) ^ (pivot != k);
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
        Some((x, DeterminantSign::from_is_negative(is_negative)))
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        all_finite(self.0.as_flattened())
    }

    #[inline]
    fn first(&self) -> f64 {
        self.0[0][0]
    }
}

impl<const K: usize, const LOWER: usize, const WIDTH: usize> Banded<K, LOWER, WIDTH> {
    /// Returns whether the pivot of column `column` is only rounding error, by the method of
    /// [`dense`](super::dense).
    #[cold]
    fn is_rounding_error(&self, rounding: f64, column: usize) -> bool {
        let mut a = self.0;
        let mut terms = a.map(|row| row.map(f64::abs));
        let mut scale = a.map(|row| largest_magnitude(&row));
        for k in 0..=column {
            let end = end_of_column::<K, LOWER>(k);
            let pivot = pivot_row(&a, &scale, k, end);
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
        a[column][0].abs() <= K as f64 * rounding * terms[column][0]
    }
}

/// Returns the number of the first row below row `k` that has no entry in column `k`. When column
/// `k` is eliminated, the rows before it begin at that column.
#[inline]
fn end_of_column<const K: usize, const LOWER: usize>(k: usize) -> usize {
    (k + LOWER + 1).min(K)
}

/// Returns the row from `k` to `end` with the largest first entry relative to the row's scale.
#[inline]
fn pivot_row<const K: usize, const WIDTH: usize>(
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

#[cfg(test)]
mod tests {
    use super::Banded;
    use crate::solve::dense::tests::Random;
    use crate::solve::dense::{DeterminantSign, Matrix, solve, solve_with_sign};

    /// Returns the first column of a row.
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

    /// Returns a matrix with entries in [−1, 1). A part of the entries is zero; each row and each
    /// column has its own unit.
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
            // The number of entries to the right of the diagonal is the same in each row.
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
                // One column is a multiple of another to rounding, in the rows that have both.
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
            let (x, y) = (solve_with_sign(&a, &b), solve_with_sign(&dense, &b));
            let signs =
                |x: Option<([f64; K], DeterminantSign)>| x.map(|(x, sign)| (x, sign.is_negative()));
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
    fn entries_that_are_not_finite_are_noticed() {
        let mut a = Banded::<3, 1, 3>([[2.0, 1.0, 0.0], [1.0, 2.0, 1.0], [1.0, 2.0, 0.0]]);
        assert!(a.is_finite());
        assert_eq!(a.first(), 2.0);
        assert_eq!(solve(&a, &[3.0, 4.0, 3.0]), Some([1.0; 3]));
        a.0[2][1] = f64::NAN;
        assert!(!a.is_finite());
    }
}

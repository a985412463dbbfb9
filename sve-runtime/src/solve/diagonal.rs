//! Diagonal linear systems of a size known at compile time: a division per unknown.
//!
//! Input: the diagonal and a right-hand side. Output: what [`dense::solve`](super::dense::solve)
//! gives for the same matrix written in full, from three unknowns on, up to the sign of a zero.

use super::dense::{DeterminantSign, Matrix, all_finite};

/// A diagonal matrix of `K` rows; the one entry of each stored row is the diagonal entry.
#[derive(Clone, Copy, Debug)]
pub struct Diagonal<const K: usize>(pub [[f64; 1]; K]);

impl<const K: usize> Matrix<K> for Diagonal<K> {
    #[inline(always)]
    fn solve_above(&self, _: f64, b: &[f64; K]) -> Option<([f64; K], DeterminantSign)> {
        let (mut x, mut is_negative, mut is_singular) = ([0.0; K], false, false);
        for i in 0..K {
            let pivot = self.0[i][0];
            // one branch for all pivots
            is_singular |= (pivot == 0.0) | (pivot.abs() == f64::INFINITY);
            x[i] = b[i] / pivot;
            is_negative ^= pivot < 0.0;
        }
        if is_singular {
            return None;
        }
        Some((x, DeterminantSign::from_is_negative(is_negative)))
    }

    #[inline(always)]
    fn is_finite(&self) -> bool {
        all_finite(self.0.as_flattened())
    }

    #[inline(always)]
    fn first(&self) -> f64 {
        self.0[0][0]
    }
}

/// Solves with a diagonal matrix in a lane. From three unknowns on, the result is bit for bit the
/// result of [`lanes::solve`](crate::lanes::solve::solve), which multiplies by the inverses of the
/// pivots.
#[inline(always)]
pub fn solve_in_lane<const K: usize>(diagonal: &[f64; K], b: &[f64; K]) -> [f64; K] {
    let mut x = [0.0; K];
    for i in 0..K {
        x[i] = b[i] * (1.0 / diagonal[i]);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::{Diagonal, solve_in_lane};
    use crate::lanes;
    use crate::solve::dense::tests::Random;
    use crate::solve::dense::{Matrix, solve_with_sign};

    fn full<const K: usize>(diagonal: &[f64; K]) -> [[f64; K]; K] {
        core::array::from_fn(|i| core::array::from_fn(|j| if i == j { diagonal[i] } else { 0.0 }))
    }

    fn as_elimination<const K: usize>() {
        let mut random = Random(400 + K as u64);
        let special = [0.0, -0.0, f64::INFINITY, f64::MIN_POSITIVE / 8.0, 1e308];
        let (mut solved, mut refused) = (0, 0);
        for sample in 0..2000 {
            let mut diagonal: [f64; K] = core::array::from_fn(|_| random.next() * random.unit());
            if sample % 4 == 0 {
                diagonal[sample / 4 % K] = special[sample / 4 % special.len()];
            }
            let b: [f64; K] = core::array::from_fn(|_| random.next());
            let (matrix, dense) = (Diagonal(diagonal.map(|x| [x])), full(&diagonal));
            let found = solve_with_sign(&matrix, &b);
            let expected = solve_with_sign(&dense, &b);
            match (found, expected) {
                (Some((x, sign)), Some((y, expected))) => {
                    solved += 1;
                    // By elimination, an overflow of one unknown makes others NaN. Here it stays
                    // with the one unknown.
                    let finite = y.iter().all(|y| y.is_finite());
                    assert!(!finite || x == y, "{diagonal:?} {b:?}");
                    assert!(finite || x.iter().any(|x| !x.is_finite()));
                    assert_eq!(sign.is_negative(), expected.is_negative(), "{diagonal:?}");
                }
                (None, None) => refused += 1,
                _ => panic!("{diagonal:?}: {found:?} for {expected:?}"),
            }
            assert_eq!(matrix.is_finite(), dense.is_finite());
            let (x, y) = (
                solve_in_lane(&diagonal, &b),
                lanes::solve::solve(&dense, &b),
            );
            let finite = y.iter().all(|y| y.is_finite());
            assert!(!finite || x == y, "{diagonal:?} {b:?}");
            assert!(finite || x.iter().any(|x| !x.is_finite()), "{diagonal:?}");
        }
        assert!(solved > 1500 && refused > 200, "{solved} {refused}");
    }

    #[test]
    fn diagonal_and_dense_solves_agree_in_every_bit() {
        as_elimination::<3>();
        as_elimination::<4>();
        as_elimination::<6>();
        as_elimination::<12>();
    }
}

//! The equation that makes a matrix singular: elimination finds no pivot for it.
//!
//! Input: matrix and right-hand side. Output: numbers for a message. Runs off the hot path.

use super::dense::WITHOUT_DIGITS;

/// Rounding error of a right-hand side in the elimination, in units of the rounding error of a
/// pivot.
const ROUNDING_OF_RIGHT_SIDE: f64 = 4.0;

/// An equation of a singular system for which the elimination found no pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Deficiency {
    /// Number of the equation.
    pub(crate) row: usize,
    /// The largest coefficient of the equation after elimination.
    pub(crate) pivot: f64,
    /// The sum of the magnitudes of the terms of this coefficient.
    pub(crate) terms: f64,
    /// The right-hand side after elimination; 0 if it is only rounding error. If it is not 0, the
    /// equations contradict one another.
    pub(crate) rest: f64,
}

/// Eliminates with scaled partial pivoting and passes over columns whose pivots are only rounding
/// error, by the criterion of [`is_regular`](super::dense::is_regular). Returns, among the
/// equations without a pivot, the one with the largest contradiction.
pub(crate) fn deficiency<const K: usize>(matrix: &[[f64; K]; K], b: &[f64; K]) -> Deficiency {
    let (mut a, mut terms) = (*matrix, matrix.map(|row| row.map(f64::abs)));
    let (mut rest, mut rest_terms) = (*b, b.map(f64::abs));
    let scale = terms.map(|row| row.into_iter().fold(0.0, f64::max));
    let mut is_left = [true; K];
    let mut has_pivot = [false; K];
    let is_rounding = |x: f64, terms: f64| x.abs() <= K as f64 * WITHOUT_DIGITS * terms;
    for k in 0..K {
        let candidates = (0..K).filter(|&i| is_left[i] && !is_rounding(a[i][k], terms[i][k]));
        let relative = |i: usize| a[i][k].abs() / scale[i];
        let Some(row) = candidates.max_by(|&i, &j| relative(i).total_cmp(&relative(j))) else {
            continue;
        };
        (is_left[row], has_pivot[k]) = (false, true);
        for i in (0..K).filter(|&i| is_left[i]) {
            let factor = a[i][k] / a[row][k];
            for j in k + 1..K {
                a[i][j] -= factor * a[row][j];
                terms[i][j] += factor.abs() * terms[row][j];
            }
            rest[i] -= factor * rest[row];
            rest_terms[i] += factor.abs() * rest_terms[row];
        }
    }
    let contradiction = |i: usize| {
        let is_rounding = is_rounding(rest[i], ROUNDING_OF_RIGHT_SIDE * rest_terms[i]);
        if is_rounding { 0.0 } else { rest[i] }
    };
    let size = |i: usize| (contradiction(i) / (rest_terms[i] + f64::MIN_POSITIVE)).abs();
    let left = (0..K).filter(|&i| is_left[i]);
    // A matrix that is singular in another order of the pivots can be regular here: no equation is
    // left.
    let row = left.max_by(|&i, &j| size(i).total_cmp(&size(j)));
    let row = row.unwrap_or(K.saturating_sub(1));
    let columns = (0..K).filter(|&j| !has_pivot[j]);
    let column = columns.max_by(|&i, &j| a[row][i].abs().total_cmp(&a[row][j].abs()));
    let column = column.unwrap_or(row);
    Deficiency {
        row,
        pivot: a[row][column].abs(),
        terms: terms[row][column],
        rest: contradiction(row).abs(),
    }
}

#[cfg(test)]
mod tests {
    use super::{Deficiency, deficiency};
    use crate::solve::dense::tests::Random;

    #[test]
    fn an_equation_of_zeros_is_named() {
        let matrix = [[1.0, 0.0], [0.0, 0.0]];
        let expected = Deficiency {
            row: 1,
            pivot: 0.0,
            terms: 0.0,
            rest: 0.25,
        };
        assert_eq!(deficiency(&matrix, &[3.0, -0.25]), expected);
        let solvable = Deficiency {
            rest: 0.0,
            ..expected
        };
        assert_eq!(deficiency(&matrix, &[3.0, 0.0]), solvable);
        assert_eq!(deficiency(&[[0.0]], &[0.5]).rest, 0.5);
    }

    #[test]
    fn contradictions_are_told_from_rounding_in_all_units() {
        let mut random = Random(3);
        for _ in 0..1000 {
            // a Gram matrix of two vectors in three dimensions has rank 2
            let mut b: [[f64; 2]; 3] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            for row in &mut b {
                let unit = (60.0 * random.next()).round().exp2();
                *row = row.map(|x| unit * x);
            }
            // rows that are nearly parallel lose the digits that tell a contradiction
            let sine = |i: usize, j: usize| {
                let cross = b[i][0] * b[j][1] - b[i][1] * b[j][0];
                (cross / (b[i][0].hypot(b[i][1]) * b[j][0].hypot(b[j][1]))).abs()
            };
            if sine(0, 1).min(sine(1, 2)).min(sine(2, 0)) < 0.05 {
                continue;
            }
            let matrix: [[f64; 3]; 3] = core::array::from_fn(|i| {
                core::array::from_fn(|j| b[i][0] * b[j][0] + b[i][1] * b[j][1])
            });
            let v: [f64; 2] = core::array::from_fn(|_| random.next());
            let image: [f64; 3] = core::array::from_fn(|i| b[i][0] * v[0] + b[i][1] * v[1]);
            let found = deficiency(&matrix, &image);
            assert!(found.pivot <= 1e-14 * found.terms, "{found:?}");
            assert_eq!(found.rest, 0.0, "{matrix:?} {image:?}");
            // The change has the size of the terms, since the image itself may be a small
            // difference of terms.
            let mut outside = image;
            let terms = (0..2).map(|j| (b[found.row][j] * v[j]).abs());
            outside[found.row] += terms.sum::<f64>();
            let found = deficiency(&matrix, &outside);
            assert!(found.rest > 0.0, "{matrix:?} {outside:?}");
        }
    }
}

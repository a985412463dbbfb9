//! Linear systems with a dense matrix of three rows, by Cramer's rule.
//!
//! Input: the matrix and a right-hand side. Output: the solution and the sign of the determinant,
//! or `None` if the matrix is singular to rounding. The solution needs a single division, where
//! elimination needs five that wait for one another.
//!
//! The rule is for the equations of a rotation, whose three unknowns have one unit, as their
//! equations have. There is no pivot to be chosen by units then. The relative error of the solution
//! is bounded by the condition number of the matrix times a few units of rounding (Higham,
//! *Accuracy and Stability of Numerical Algorithms*, section 1.10.1), and Newton's method, which
//! uses it, corrects such errors in its next update.

use super::dense::{DeterminantSign, Matrix, all_finite};

/// Number of rows: the rounding error of the determinant is proportional to it.
const ROWS: f64 = 3.0;

/// A dense matrix that is solved by Cramer's rule.
#[derive(Clone, Copy, Debug)]
pub struct Cofactors(pub [[f64; 3]; 3]);

impl Matrix<3> for Cofactors {
    #[inline(always)]
    fn solve_above(&self, rounding: f64, b: &[f64; 3]) -> Option<([f64; 3], DeterminantSign)> {
        let [x, y, z] = self.0;
        // the columns of the inverse, but for the determinant
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = (x[0] * columns[0][0] + x[1] * columns[0][1]) + x[2] * columns[0][2];
        // the product of the sums of rows is at least the sum of the magnitudes of the terms of the
        // determinant
        let size = |row: [f64; 3]| (row[0].abs() + row[1].abs()) + row[2].abs();
        let bound = size(x) * size(y) * size(z);
        // false for NaN
        let is_clear = determinant.abs() > ROWS * rounding * bound;
        if !is_clear && self.is_singular(rounding, determinant) {
            return None;
        }
        let inverse = 1.0 / determinant;
        let mut solution = [0.0; 3];
        for i in 0..3 {
            let sum = (b[0] * columns[0][i] + b[1] * columns[1][i]) + b[2] * columns[2][i];
            solution[i] = sum * inverse;
        }
        Some((solution, DeterminantSign::of(determinant)))
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

impl Cofactors {
    /// Returns whether the determinant is only rounding error: far below the sum of the magnitudes
    /// of its terms.
    #[cold]
    fn is_singular(&self, rounding: f64, determinant: f64) -> bool {
        let [x, y, z] = self.0.map(|row| row.map(f64::abs));
        let minor = |i: usize, j: usize| y[i] * z[j] + y[j] * z[i];
        let terms = x[0] * minor(1, 2) + x[1] * minor(2, 0) + x[2] * minor(0, 1);
        determinant.abs() <= ROWS * rounding * terms
    }
}

/// Returns the cross product of two rows.
#[inline(always)]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::Cofactors;
    use crate::solve::dense::tests::Random;
    use crate::solve::dense::{Matrix, solve_with_sign};

    #[test]
    fn solutions_are_those_of_elimination() {
        let mut random = Random(77);
        for sample in 0..2000 {
            let rows: [[f64; 3]; 3] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.next()));
            let unit = if sample % 2 == 0 { random.unit() } else { 1.0 };
            let rows = rows.map(|row| row.map(|x| unit * x));
            let b: [f64; 3] = core::array::from_fn(|_| random.next());
            let (x, sign) = Cofactors(rows).solve_with_sign(&b).expect("regular");
            let (expected, other) = solve_with_sign(&rows, &b).expect("regular");
            assert_eq!(sign.is_negative(), other.is_negative());
            // the residual of a solution with an error of the condition number times rounding
            let largest = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let size = largest(rows.as_flattened());
            let condition: f64 = (0..3)
                .map(|k| {
                    let unit = core::array::from_fn(|i| f64::from(u8::from(i == k)));
                    largest(&solve_with_sign(&rows, &unit).expect("regular").0) * size
                })
                .fold(0.0, f64::max);
            for i in 0..3 {
                let error = (x[i] - expected[i]).abs();
                let bound = 32.0 * f64::EPSILON * condition * largest(&expected);
                assert!(error <= bound, "{error:e} {bound:e} {condition:e}");
            }
        }
    }

    #[test]
    fn singular_matrices_are_refused_in_any_unit() {
        for unit in [-200, -60, 0, 60, 200].map(|k| 2.0_f64.powi(k)) {
            let rows = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]];
            let singular = rows.map(|row| row.map(|x| unit * x / 3.0));
            assert!(Cofactors(singular).solve_with_sign(&[1.0; 3]).is_none());
            // regular, with entries of very different sizes
            let regular = [[1e-12, 0.0, 0.0], [0.0, 1e9, 0.0], [0.0, 1e9, 1.0]];
            let regular = Cofactors(regular.map(|row| row.map(|x| unit * x)));
            let (x, _) = regular.solve_with_sign(&[unit; 3]).expect("regular");
            for (x, expected) in x.iter().zip([1e12, 1e-9, 0.0]) {
                assert!((x - expected).abs() <= 1e-15 * (1.0 + expected), "{x:e}");
            }
        }
        let not_finite = Cofactors([[f64::NAN, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!(!not_finite.is_finite());
        assert!(
            Cofactors([[0.0; 3]; 3])
                .solve_with_sign(&[1.0; 3])
                .is_none()
        );
    }
}

//! Dense linear systems of a size known at run time, with many right-hand sides.
//!
//! Input: matrix and right-hand sides. Output: the solutions, or an error if the matrix is
//! singular. The functions allocate, so only derivatives of a step call them.

use nalgebra::DMatrix;

use super::SolveError;

/// Solves `a x = b` for many right-hand sides, the columns of `b`, by LU decomposition with partial
/// pivoting. Rows are first multiplied by powers of two so that their largest entries are
/// comparable: equations in different units choose the same pivots.
///
/// # Errors
/// [`SolveError::Singular`] if a pivot vanishes.
pub(crate) fn solve(mut a: DMatrix<f64>, mut b: DMatrix<f64>) -> Result<DMatrix<f64>, SolveError> {
    if a.is_empty() {
        // nalgebra's substitution needs a row.
        return Ok(b);
    }
    for i in 0..a.nrows() {
        let unit = power_of_two(a.row(i).amax());
        a.row_mut(i).iter_mut().for_each(|x| *x /= unit);
        b.row_mut(i).iter_mut().for_each(|x| *x /= unit);
    }
    if a.lu().solve_mut(&mut b) {
        Ok(b)
    } else {
        Err(SolveError::Singular { iteration: 0 })
    }
}

/// Returns the power of two of a normal number, and 1 for other numbers.
fn power_of_two(x: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    if x.is_normal() {
        f64::from_bits(x.to_bits() & EXPONENT)
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::{SolveError, solve};
    use crate::solve::dense::tests::Random;

    /// The bound of Gaussian elimination with partial pivoting, whose growth is small for random
    /// matrices.
    #[test]
    fn many_right_hand_sides_are_solved_to_rounding() {
        let mut random = Random(7);
        for size in [1, 2, 5, 12, 30] {
            let a = DMatrix::from_fn(size, size, |_, _| random.next());
            let b = DMatrix::from_fn(size, 4, |_, _| random.next());
            let x = solve(a.clone(), b.clone()).unwrap();
            let magnitude = a.abs() * x.abs() + b.abs();
            let error = (&a * &x - &b).abs().component_div(&magnitude).max();
            assert!(error <= 8.0 * size as f64 * f64::EPSILON, "{error:e}");

            // Other units of the equations give the same pivots, so the same bits.
            let units: Vec<f64> = (0..size).map(|_| random.unit()).collect();
            let scaled = |m: &DMatrix<f64>| m.map_with_location(|i, _, x| x * units[i]);
            assert_eq!(solve(scaled(&a), scaled(&b)), Ok(x));
        }
        let none = solve(DMatrix::zeros(0, 0), DMatrix::zeros(0, 3)).unwrap();
        assert_eq!(none.shape(), (0, 3));
    }

    #[test]
    fn a_vanishing_pivot_is_an_error() {
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0]);
        let solved = solve(singular, DMatrix::from_element(2, 1, 1.0));
        assert_eq!(solved, Err(SolveError::Singular { iteration: 0 }));
        let solved = solve(DMatrix::zeros(3, 3), DMatrix::zeros(3, 2));
        assert_eq!(solved, Err(SolveError::Singular { iteration: 0 }));
    }
}

//! Dense linear systems of a size known at run time.
//!
//! Input: a square matrix and the columns of right-hand sides, both stored row by row. Output: the solutions, in place.
//! Gauss–Jordan elimination with scaled partial pivoting. It is off the hot path: derivatives of a step use it.

use super::SolveError;
use super::dense::largest_magnitude;

/// Solves `a x = b` for each column of `b` and writes the solutions to `b`. Overwrites `a`.
///
/// # Errors
/// [`SolveError::Singular`] if a pivot vanishes.
pub(crate) fn solve_columns(a: &mut [f64], b: &mut [f64], size: usize) -> Result<(), SolveError> {
    let columns = b.len().checked_div(size).unwrap_or(0);
    let mut scale: Vec<f64> = (0..size)
        .map(|i| largest_magnitude(&a[size * i..size * (i + 1)]))
        .collect();
    for k in 0..size {
        let weight = |i: usize| a[size * i + k].abs() / scale[i];
        let pivot = (k..size).max_by(|&i, &j| weight(i).total_cmp(&weight(j)));
        let pivot = pivot.filter(|&i| a[size * i + k] != 0.0);
        let pivot = pivot.ok_or(SolveError::Singular { iteration: 0 })?;
        scale.swap(k, pivot);
        for j in 0..size {
            a.swap(size * k + j, size * pivot + j);
        }
        for j in 0..columns {
            b.swap(columns * k + j, columns * pivot + j);
        }
        // Rows above the pivot are eliminated too, so no back substitution follows.
        for i in (0..size).filter(|&i| i != k) {
            let factor = a[size * i + k] / a[size * k + k];
            if factor == 0.0 {
                continue;
            }
            for j in k..size {
                a[size * i + j] -= factor * a[size * k + j];
            }
            for j in 0..columns {
                b[columns * i + j] -= factor * b[columns * k + j];
            }
        }
    }
    for k in 0..size {
        let pivot = a[size * k + k];
        for x in &mut b[columns * k..columns * (k + 1)] {
            *x /= pivot;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{SolveError, solve_columns};

    #[test]
    fn columns_are_solved_with_rows_exchanged() {
        // the first pivot is zero, so the rows have to be exchanged
        let mut a = [0.0, 2.0, 1.0, 1.0];
        let mut b = [2.0, 4.0, 3.0, 5.0];
        solve_columns(&mut a, &mut b, 2).unwrap();
        assert_eq!(b, [2.0, 3.0, 1.0, 2.0]);
    }

    #[test]
    fn a_singular_matrix_is_an_error() {
        let mut a = [1.0, 2.0, 2.0, 4.0];
        let singular = Err(SolveError::Singular { iteration: 0 });
        assert_eq!(solve_columns(&mut a, &mut [1.0, 1.0], 2), singular);
        assert_eq!(solve_columns(&mut [], &mut [], 0), Ok(()));
    }
}

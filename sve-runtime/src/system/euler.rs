//! The increment of Euler's method, from which the explicit baselines are built. Generated code
//! computes it and calls functions of this file.
//!
//! Input: a state, a step size and increments of the noises. Output: `h f(z) + Σ g_a(z) ΔW_a` for
//! `z = (q, p)`, with the drift f and the noise fields g of the first-order form, and the Itô
//! correction. Invariant: nothing is checked here; a method checks its whole step.

pub use crate::phase::Field;

use crate::solve::dense;

/// The increment of Euler's method over a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EulerIncrement<V> {
    /// `h f + Σ g_a ΔW_a`, in the sense of Stratonovich.
    pub increment: Field<V>,
    /// The Itô correction `½ h Σ (Dg_a) g_a`, unless it vanishes identically.
    pub correction: Option<Field<V>>,
}

/// Returns the inverse of a mass matrix, unless the matrix is singular to rounding.
pub fn inverse<const N: usize>(mass: &[[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut inverse = [[0.0; N]; N];
    for column in 0..N {
        let mut unit = [0.0; N];
        unit[column] = 1.0;
        let solution = dense::solve(mass, &unit)?;
        for row in 0..N {
            inverse[row][column] = solution[row];
        }
    }
    Some(inverse)
}

/// Returns the product of a matrix and a vector.
#[inline(always)]
pub fn product<const N: usize>(matrix: &[[f64; N]; N], vector: &[f64; N]) -> [f64; N] {
    let mut product = [0.0; N];
    for row in 0..N {
        product[row] = matrix[row][0] * vector[0];
        for column in 1..N {
            product[row] += matrix[row][column] * vector[column];
        }
    }
    product
}

#[cfg(test)]
mod tests {
    use super::{inverse, product};

    #[test]
    fn an_inverse_solves_with_its_matrix() {
        let mass = [[4.0, 1.0, 0.5], [1.0, 3.0, -1.0], [0.5, -1.0, 2.0]];
        let inverse = inverse(&mass).unwrap();
        let x = [0.3, -1.2, 2.5];
        let solved = product(&inverse, &product(&mass, &x));
        for i in 0..3 {
            assert!((solved[i] - x[i]).abs() < 1e-15, "{solved:?}");
        }
    }

    #[test]
    fn a_singular_matrix_has_no_inverse() {
        assert_eq!(inverse(&[[1.0, 2.0], [0.5, 1.0]]), None);
        assert_eq!(inverse(&[[0.1, 0.3], [0.2, 0.6]]), None);
    }
}

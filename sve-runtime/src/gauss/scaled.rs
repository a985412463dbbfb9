//! The coefficients of the second-order form of a Gauss rule, times the step size.
//!
//! Input: the step size. Output: `h c_i`, `h (1 − c_i)` and `h η_ij`, rounded to multiples of the
//! unit in the last place of h, so that the condition of symplecticity holds exactly:
//!
//! ```text
//! h η_ji = h η_ij − (h c_i − h c_j)
//! ```
//!
//! No number of a step is multiplied by h itself. If h is near a simple fraction, such as 0.2, the
//! rounding error of products with h has a mean that depends on the other factor, and the energy
//! drifts by some 10⁻¹⁸ a step.

use super::tableau::Tableau;
use crate::phase::configuration::VectorCoordinates;
use crate::solve::dense;
use crate::system::{Dims, System};

/// Numbers that a step of a system of second order computes from parameters and step size alone.
#[derive(Clone, Copy, Debug)]
pub struct SecondOrderCoefficients<const S: usize, const N: usize> {
    /// The inverse of the constant mass matrix; NaN if the mass matrix is singular.
    pub(super) inverse_mass: [[f64; N]; N],
    pub(super) scaled: Scaled<S>,
    /// `h Σ_k η_ik x_kj`, where x extrapolates the impulses of a step to those of the next one.
    pub(super) second_order_ahead: [[f64; S]; S],
}

/// The coefficients for a step size. Matrices are stored column by column, as in [`Tableau`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Scaled<const S: usize> {
    /// `h c_i`.
    pub(super) nodes: [f64; S],
    /// `h − h c_i`, exactly.
    pub(super) rest: [f64; S],
    /// `h η_ij`.
    pub(super) second_order: [[f64; S]; S],
}

impl<const S: usize> Scaled<S> {
    /// Returns the products with the step size, rounded each for itself, so that the condition of
    /// symplecticity holds to rounding errors alone.
    #[inline]
    pub(super) fn product(h: f64) -> Self {
        let tableau = const { &Tableau::<S>::VALUES };
        let nodes = tableau.c.map(|c| h * c);
        Self {
            nodes,
            rest: nodes.map(|node| h - node),
            second_order: tableau.second_order.map(|row| row.map(|eta| h * eta)),
        }
    }

    fn new(h: f64) -> Self {
        let tableau = const { &Tableau::<S>::VALUES };
        // The unit is the distance to the next number towards zero. All its multiples up to h are
        // representable.
        let unit = h.abs() - h.abs().next_down();
        let nodes = tableau.c.map(|c| to_multiple(h * c, unit));
        let mut second_order = [[0.0; S]; S];
        for i in 0..S {
            for j in i..S {
                let eta = to_multiple(h * tableau.second_order[j][i], unit);
                second_order[j][i] = eta;
                second_order[i][j] = eta - (nodes[i] - nodes[j]);
            }
        }
        Self {
            nodes,
            rest: nodes.map(|node| h - node),
            second_order,
        }
    }
}

/// Returns the nearest multiple of `unit`, a power of two, for magnitudes below `2⁵³ unit`.
#[inline]
fn to_multiple(x: f64, unit: f64) -> f64 {
    const BITS: f64 = 4_503_599_627_370_496.0;
    let multiple = x / unit;
    // above 2⁵² every number is whole
    if multiple.abs() < BITS {
        let shift = BITS.copysign(multiple);
        ((multiple + shift) - shift) * unit
    } else {
        x
    }
}

impl<const S: usize, const N: usize> SecondOrderCoefficients<S, N> {
    /// Returns the coefficients of a system's steps of size `h`.
    pub fn new<Sys, Q, const M: usize>(system: &Sys, h: f64) -> Self
    where
        Sys: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let tableau = const { &Tableau::<S>::VALUES };
        Self {
            inverse_mass: inverse_mass(system),
            scaled: Scaled::new(h),
            second_order_ahead: tableau.second_order_ahead.map(|row| row.map(|x| h * x)),
        }
    }
}

/// Returns the inverse of a constant mass matrix; NaN if the mass matrix is singular.
pub fn inverse_mass<Sys, Q, const N: usize, const M: usize>(system: &Sys) -> [[f64; N]; N]
where
    Sys: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let mass = system.lagrangian_jet(0.0, &[0.0; N], &[0.0; N]).dvv;
    let mut inverse_mass = [[f64::NAN; N]; N];
    for column in 0..N {
        let mut unit = [0.0; N];
        unit[column] = 1.0;
        if let Some(solution) = dense::solve(&mass, &unit) {
            for row in 0..N {
                inverse_mass[row][column] = solution[row];
            }
        }
    }
    inverse_mass
}

#[cfg(test)]
mod tests {
    use super::{Scaled, Tableau};

    fn check<const S: usize>(h: f64) {
        let tableau = Tableau::<S>::VALUES;
        let Scaled {
            nodes,
            rest,
            second_order,
            ..
        } = Scaled::<S>::new(h);
        let unit = h.abs() - h.abs().next_down();
        let near = |x: f64, y: f64| (x - y).abs() <= 2.0 * unit;
        for i in 0..S {
            assert!(near(nodes[i], h * tableau.c[i]), "{S} stages, h = {h:e}");
            // The equality is exact, since the sum of multiples of the unit stays below 2⁵³ units.
            assert_eq!(nodes[i] + rest[i], h);
            assert_eq!((nodes[i] / unit).fract(), 0.0);
            for j in 0..S {
                assert!(near(second_order[j][i], h * tableau.second_order[j][i]));
                assert_eq!((second_order[j][i] / unit).fract(), 0.0);
                let difference = second_order[j][i] - second_order[i][j];
                assert_eq!(difference, nodes[i] - nodes[j], "{S} stages, h = {h:e}");
            }
        }
    }

    #[test]
    fn coefficients_are_exactly_symplectic_for_any_step() {
        for h in [
            0.2,
            -0.2,
            0.25,
            1.0,
            1.0 / 3.0,
            1817.3,
            1e-300,
            -1e300,
            5e-310,
        ] {
            check::<2>(h);
            check::<4>(h);
            check::<5>(h);
            check::<8>(h);
        }
    }
}

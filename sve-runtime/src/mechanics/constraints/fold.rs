//! Folds: places at which the gradients of the constraints become dependent, as where a linkage is stretched into a line.
//!
//! Near a fold that is not quite reached the motion turns within a distance that is as short as the fold is near. A step across such a place has a solution that is
//! connected with h → 0 and conserves nothing: its velocities turn by the whole angle of the corner, which multiplies the kinetic energy by up to the inverse square of its cosine. The
//! place shows in `A = ∂φ/∂q M⁻¹ ∂φ/∂qᵀ` along the path of solutions from h → 0 to the step, not in A at its ends.
//!
//! Called off the fast path, at the points of the continuation: a step that turns by much is accepted neither by the contraction of its iteration nor by bounds.

use nalgebra::{Cholesky, DMatrix, Dyn};

use super::Linearised;
use crate::phase::configuration::Coordinates;
use crate::system::{Dims, System};

/// Smallest part of the start's `∂φ/∂q M⁻¹ ∂φ/∂qᵀ` that is left along a step, for the combination of gradients that shrinks most: the gradient falls to a half. The step is then as long as
/// the distance over which the constraints change.
const SMALLEST_PART: f64 = 0.25;

/// The gradients of the constraints at the start of a step.
pub(crate) struct Fold {
    factor: Cholesky<f64, Dyn>,
}

impl Fold {
    /// The gradients at a point; `None` without constraints, or where they are dependent.
    pub(crate) fn from<S, Q, const N: usize, const M: usize>(
        system: &S,
        t: f64,
        q: &Q::Flat,
    ) -> Option<Self>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        if S::CONSTRAINTS.is_empty() {
            return None;
        }
        let factor = Linearised::at(system, t, q)?.matrix.cholesky()?;
        Some(Self { factor })
    }

    /// Returns the smallest eigenvalue of A at a point relative to A at the start, if it is too small for the point to be in the step.
    pub(crate) fn met_at<S, Q, const N: usize, const M: usize>(
        &self,
        system: &S,
        t: f64,
        q: &Q::Flat,
    ) -> Option<f64>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let there = Linearised::at(system, t, q)?;
        // L⁻¹ A L⁻ᵀ
        let half = self.factor.l().solve_lower_triangular(&there.matrix)?;
        let relative: DMatrix<f64> = self.factor.l().solve_lower_triangular(&half.transpose())?;
        let smallest = relative.symmetric_eigenvalues().min();
        (smallest < SMALLEST_PART).then_some(smallest)
    }
}

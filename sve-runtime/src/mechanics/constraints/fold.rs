//! Folds: places at which the gradients of the constraints become dependent, for example where a
//! linkage is stretched into a line.
//!
//! Near a fold that is not quite reached the motion turns within a distance as short as the
//! distance of the fold. A step across such a place has a solution that is connected with h → 0 and
//! conserves nothing: its velocities turn by the whole angle of the corner, which multiplies the
//! kinetic energy by up to the inverse square of its cosine. The matrix `A = ∂φ/∂q M⁻¹ ∂φ/∂qᵀ`
//! reveals the place along the path of solutions from h → 0 to the step, but not at the ends of the
//! path.
//!
//! Called off the fast path, at the points of the continuation: neither the contraction of the
//! iteration nor bounds accept a step with a large turn.

use nalgebra::{Cholesky, DMatrix, Dyn};

use super::Linearised;
use crate::phase::configuration::Coordinates;
use crate::system::{Dims, System};

/// Smallest allowed eigenvalue of A along a step, relative to A at the start of the step, with
/// `A = ∂φ/∂q M⁻¹ ∂φ/∂qᵀ`. At this value the combination of gradients that shrinks most has fallen
/// to a half: the step is then as long as the distance over which the constraints change.
const SMALLEST_PART: f64 = 0.25;

/// The gradients of the constraints at the start of a step.
pub(crate) struct Fold {
    factor: Cholesky<f64, Dyn>,
}

impl Fold {
    /// Returns the gradients at a point; `None` without constraints, or if the gradients are
    /// dependent.
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

    /// Returns the smallest eigenvalue of A at a point relative to A at the start, if it is too
    /// small for the point to be in the step.
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
        // The matrix L⁻¹ A L⁻ᵀ.
        let half = self.factor.l().solve_lower_triangular(&there.matrix)?;
        let relative: DMatrix<f64> = self.factor.l().solve_lower_triangular(&half.transpose())?;
        let smallest = relative.symmetric_eigenvalues().min();
        (smallest < SMALLEST_PART).then_some(smallest)
    }
}

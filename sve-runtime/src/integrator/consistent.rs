//! States on the constraints.

use super::Integrator;
use crate::error::StepError;
use crate::mechanics::constraints::project;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::rule::Rule;
use crate::system::{Dims, System};

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: VectorCoordinates<N>,
{
    /// Returns the state on the constraints that is nearest to `state` in the metric of the masses:
    /// first the configuration, then the momentum, whose part across the constraints is removed.
    /// Without constraints it is the state itself.
    ///
    /// A step refuses a start whose configuration does not satisfy the constraints. It takes any
    /// momentum: the part across the constraints has no effect on the motion.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A particle on the unit sphere.
    /// struct Sphere { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Sphere {
    ///     fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
    ///         0.5 * v.norm_squared() - self.g * q.z
    ///     }
    ///     #[constraint]
    ///     fn sphere(&self, q: Vector3<f64>) -> f64 {
    ///         0.5 * (q.norm_squared() - 1.0)
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let sphere = Integrator::new(Sphere { g: 9.8 }, Midpoint);
    /// let near = State::new(Vector3::new(0.6, 0.0, 0.81), Vector3::new(0.1, 0.5, 0.0));
    /// let refused = sphere.step(&mut near.clone(), 0.01, &[]);
    /// assert!(matches!(refused, Err(StepError::InconsistentStart { .. })));
    /// let mut state = sphere.consistent(near)?;
    /// assert!((state.q.norm() - 1.0).abs() < 1e-15 && state.q.dot(&state.p).abs() < 1e-15);
    /// sphere.step(&mut state, 0.01, &[])?;
    /// assert!((state.q.norm() - 1.0).abs() < 1e-15 && state.q.dot(&state.p).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`StepError::NoConsistentState`] if no such configuration is found near the given one;
    /// [`StepError::ConstraintRank`] if the constraints are dependent;
    /// [`StepError::ConstraintGradient`] if the gradient of a constraint vanishes with the
    /// constraint; [`StepError::Singular`] if a matrix is singular; [`StepError::NonFiniteInput`]
    /// if a number of the state is not finite.
    pub fn consistent(&self, state: State<Q>) -> Result<State<Q>, StepError> {
        if S::CONSTRAINTS.is_empty() {
            return Ok(state);
        }
        let flat = state.to_coordinates();
        project(self.system(), &flat).map(|flat| State::from_coordinates(&flat))
    }
}

//! Trajectories that compensate the rounding errors of the state.

use super::{RefinedTrajectory, Trajectory};
use crate::Integrator;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::method::Method;
use crate::noise::Noise;
use crate::state::State;
use crate::system::{Dims, IncrementsOf, System, Variational};

impl<I: Method, W: Noise> Trajectory<'_, I, W> {
    /// Makes a step that carries the low parts of the state.
    #[inline(never)]
    pub(super) fn compensated_step(
        &mut self,
        dw: &IncrementsOf<I::System>,
    ) -> Result<(), StepError> {
        match (&self.prepared, &mut self.low) {
            (Some(prepared), Some(low)) => {
                self.method
                    .compensated_step(prepared, &mut self.state, low, self.h, dw)
            }
            _ => Ok(()),
        }
    }
}

impl<S, R, W: Noise, Q, const N: usize, const M: usize> Trajectory<'_, Integrator<S, R>, W>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Compensates the rounding errors of the state: keeps the rounding errors of coordinates and momenta at each step, and adds them at the next
    /// one. In a run of many steps this reduces the random walk of rounding errors.
    ///
    /// Compensation helps if the increments of a step have digits that the state does not have: in explicit and linear steps, and for coordinates. The
    /// momentum of an implicit midpoint step is p₀ + 2(p̄ − p₀), where p̄ is rounded like the state: nothing can be kept, and
    /// the walk remains. Compensation does not reduce a systematic error of a step, and thus a drift. A refined step, see [`refine`](Self::refine), keeps the low parts that it starts with.
    ///
    /// A compile-time error for linear steps with noise in the momentum, which return states and no increments.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator;
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let oscillator = Integrator::new(Oscillator, Endpoint);
    /// let h = 1e-3;
    /// // what this rule conserves exactly
    /// let conserved = |s: &State<[f64; 1]>| s.q[0] * s.q[0] + s.p[0] * s.p[0] + h * s.q[0] * s.p[0];
    /// let path = oscillator.trajectory(State::new([1.0], [0.0]), h, NoNoise).compensated();
    /// let end = path.take(100_000).last().unwrap()?;
    /// assert!((conserved(&end) - 1.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section VIII.5.
    #[must_use]
    pub fn compensated(mut self) -> Self {
        const {
            assert!(
                !S::RETURNS.is_state(),
                "this step is a linear map from state to state: it has no increments to be summed with compensation"
            );
        }
        // A resumed trajectory has its low parts.
        self.low
            .get_or_insert_with(|| State::new(Q::origin(), Q::no_momentum()));
        self
    }
}

impl<S, R, W: Noise, Q, const N: usize, const M: usize> RefinedTrajectory<'_, Integrator<S, R>, W>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Compensates the rounding errors of the state, see [`Trajectory::compensated`].
    #[must_use]
    pub fn compensated(self) -> Self {
        self.map(Trajectory::compensated)
    }
}

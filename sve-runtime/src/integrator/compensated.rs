//! One step with compensated summation: the rounding errors of the state are kept and added at the next step.
//!
//! Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section VIII.5.

use super::Integrator;
use super::accept::replace;
use super::modes::SingleMode;
use super::rescue::explain_step;
use super::start;
use super::step::solve_step;
use crate::configuration::{Coordinates, FlatConfiguration};
use crate::equations::StepEquations;
use crate::error::StepError;
use crate::noise::Noise;
use crate::rule::{Rule, Walker};
use crate::solve::SolveError;
use crate::start::Tested;
use crate::state::State;
use crate::system::{Dims, Increments, System};
use crate::trajectory::{RefinedTrajectory, Trajectory};

/// The mode that makes steps with compensated sums. It adds the low parts of the state, and writes its rounding errors there. After a failure
/// they are those of the substeps before it.
pub(super) struct Compensate<'a, F> {
    pub(super) low: &'a mut F,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Compensate<'_, State<Q::Flat>>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: Increments,
    Q: Coordinates<N>,
{
    #[inline]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        let Ok((dq, dp, _)) = start::increment(walker, prepared, memory, state, h, dw) else {
            // Continuation is rare, and returns a state without the digits that compensation needs.
            return solve_step(walker, prepared, memory, state, h, dw).map(|_| ());
        };
        let mut new_low = *self.low;
        let (q, p) = Q::Flat::moved_with_low_parts(state, &mut new_low, &dq, &dp);
        if !replace(state, h, &q, &p) {
            let error = SolveError::NonFinite;
            return Err(explain_step(walker, error, &{ *state }, h, &{ *dw }));
        }
        *self.low = new_low;
        Ok(())
    }
}

/// Fails to compile if the rounding errors of a configuration cannot be carried.
const fn assert_low_parts<F: FlatConfiguration<N>, const N: usize>() {
    assert!(
        F::HAS_LOW_PARTS,
        "a system with rotations has no compensated sums: its quaternions are normalised in each step"
    );
}

/// Fails to compile if a step returns states and no increments.
const fn assert_increments<S, R: Rule<S>>() {
    assert!(
        R::HAS_INCREMENTS,
        "this step is a linear map from state to state: it has no increments to be summed with compensation"
    );
}

impl<S, R, W: Noise, Q, const N: usize, const M: usize> Trajectory<'_, Integrator<S, R>, W>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
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
    pub fn compensated(self) -> Self {
        const {
            assert_increments::<S::Itself, R>();
            assert_low_parts::<Q::Flat, N>();
        }
        self.carry_low_parts(State::new(Q::origin(), Q::no_momentum()))
    }
}

impl<S, R, W: Noise, Q, const N: usize, const M: usize> RefinedTrajectory<'_, Integrator<S, R>, W>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    /// Compensates the rounding errors of the state, see [`Trajectory::compensated`], which has an example.
    #[must_use]
    pub fn compensated(self) -> Self {
        const {
            assert_increments::<S::Itself, R>();
            assert_low_parts::<Q::Flat, N>();
        }
        self.carry_low_parts(State::new(Q::origin(), Q::no_momentum()))
    }
}

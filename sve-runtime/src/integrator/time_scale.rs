//! Steps of systems with a time scale.
//!
//! Input: an integrator of the system in the time τ, with the energy of the path. Output: a method
//! whose steps of τ add the time t that they take. Invariant: the time of a step is the derivative
//! of its discrete action by the energy, `h Σ b_i s(Q_i)` over the nodes of the rule.

use core::fmt;
use core::hash::Hasher;

use super::Integrator;
use super::modes::SingleMode;
use super::step::solve_step;
use super::steps::{Prepared, Steps, walk_on};
use crate::error::StepError;
use crate::mechanics::Mechanics;
use crate::mechanics::time_scale::{TimeScale, WithTimeScale, is_time_scale};
use crate::method::OneStepMethod;
use crate::phase::configuration::{Coordinates, FlatConfiguration, two_sum};
use crate::phase::state::State;
use crate::rule::{Rule, Walker};
use crate::system::equations::StepEquations;
use crate::system::start::Tested;
use crate::system::{AnyIncrements, Dims, FixedSizes, System};
use crate::time::is_next_time;

/// The mode that makes steps of τ and adds the time that they take.
struct Elapse<'a> {
    elapsed: &'a mut f64,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Elapse<'_>
where
    S: TimeScale<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
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
        let start = *state;
        let unknowns = solve_step(walker, prepared, memory, state, h, dw)?;
        let (mut elapsed, mut bad) = (0.0, None);
        let mut at = start;
        let mut visit = |weight: f64, q: &Q::Flat| {
            at.q = *q;
            let scale = walker.system.time_scale(&State::from_coordinates(&at));
            if !is_time_scale(scale) {
                bad = Some((scale, *q));
            }
            elapsed += weight * scale;
        };
        walker.system.nodes(&start, state, h, &unknowns, &mut visit);
        if let Some((scale, q)) = bad {
            *state = start;
            return Err(StepError::TimeScale {
                t: start.t,
                h,
                scale,
                q: q.values(),
            });
        }
        *self.elapsed += h * elapsed;
        Ok(())
    }
}

/// The method of a path of a system with a time scale.
#[doc(hidden)]
pub struct InScaledTime<H: TimeScale, R> {
    /// The integrator in the time τ.
    integrator: Integrator<H, R>,
    energy: f64,
}

impl<H: TimeScale, R> fmt::Debug for InScaledTime<H, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("InScaledTime")
            .field("energy", &self.energy)
            .finish_non_exhaustive()
    }
}

impl<S: WithTimeScale, R: Copy> Integrator<S, R> {
    /// Returns the integrator in the time τ on paths of an energy, whose Lagrangian is
    /// s (L(q, w/s) + E): an integrator as any other, with the energy as the parameter `E`.
    ///
    /// It has all that depends on the maps between equal steps of τ with a fixed energy: tangent
    /// maps, which are symplectic, exponents, and gradients. The `t` of its states is τ, and its
    /// velocities are dq/dτ.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Planet;
    ///
    /// #[variational(midpoint)]
    /// impl Planet {
    ///     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
    ///         0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / q[0].hypot(q[1])
    ///     }
    ///     #[time_scale]
    ///     fn scale(&self, q: [f64; 2]) -> f64 { q[0].hypot(q[1]).powf(1.5) }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let planet = Integrator::new(Planet, Midpoint);
    /// let start = TimedState::new(planet.system(), [1.0, 0.0], [0.0, 1.2])?;
    /// let tangent = planet.at_energy(start.energy()).tangent(&start, 0.1, &[])?;
    /// // the bracket of the two coordinates stays zero
    /// let (x, y) = (&tangent[0], &tangent[1]);
    /// let bracket = x[0] * y[2] - x[2] * y[0] + x[1] * y[3] - x[3] * y[1];
    /// assert!(bracket.abs() < 1e-14);
    /// # Ok(())
    /// # }
    /// ```
    pub fn at_energy<'a>(&'a self, energy: f64) -> Integrator<S::Held<'a>, R>
    where
        R: Rule<S::Held<'a>>,
    {
        Integrator::new(self.system.with_energy(energy), self.rule).with_newton(self.newton)
    }

    /// Returns the method of a path of an energy.
    pub(crate) fn in_scaled_time<'a>(&'a self, energy: f64) -> InScaledTime<S::Held<'a>, R>
    where
        R: Rule<S::Held<'a>>,
    {
        InScaledTime {
            integrator: self.at_energy(energy),
            energy,
        }
    }
}

impl<H: TimeScale, R> InScaledTime<H, R> {
    /// Returns the energy of the path.
    pub(crate) fn energy(&self) -> f64 {
        self.energy
    }

    /// Returns the integrator in the time τ.
    pub(super) fn in_tau(&self) -> &Integrator<H, R> {
        &self.integrator
    }
}

/// The values of a step of τ, and the low part of the time.
#[derive(Clone, Copy, Debug)]
pub struct Timed<P> {
    steps: P,
    low: f64,
}

impl<H, R, Q, const N: usize, const M: usize> InScaledTime<H, R>
where
    H: TimeScale + System<Dims = Dims<N, M, Q>, Itself = H>,
    R: Rule<H>,
    Q: Coordinates<N>,
{
    /// Makes one step of τ, and adds its time and the low part of the time. A part of a step may be
    /// too short to change the time, a step may not.
    ///
    /// The equations of a step do not depend on the time. It is solved from the time 0, so that a
    /// step of τ may be smaller than the rounding error of t.
    fn advance(
        &self,
        prepared: &mut Timed<Prepared<R::Prepared, R::Memory>>,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
        is_part: bool,
    ) -> Result<(), StepError> {
        let Timed { steps, low } = prepared;
        let (walker, t) = (self.integrator.walker(), state.t);
        let mut end = state.to_coordinates();
        let mut elapsed = 0.0;
        end.t = if t.is_finite() { 0.0 } else { t };
        let mode = Elapse {
            elapsed: &mut elapsed,
        };
        if let Err(error) = walk_on(walker, steps, &mut end, h, dw, mode) {
            return Err(self.explain(error, state, h));
        }
        let added = elapsed + *low;
        let to = t + added;
        if !(is_next_time(t, to) || is_part && to == t) {
            return Err(StepError::Time { t, h, end: to });
        }
        (end.t, *low) = two_sum(t, added);
        *state = State::from_coordinates(&end);
        Ok(())
    }

    /// Returns the error of a step that failed, with its time: that of the time scale, if it has no
    /// value at the start, or, where the solution is lost, at the place to which the velocity at
    /// the start leads.
    #[cold]
    fn explain(&self, error: StepError, state: &State<Q>, h: f64) -> StepError {
        let (system, t) = (self.system(), state.t);
        let without_scale = |at: &State<Q>| {
            let (scale, q) = (system.time_scale(at), at.to_coordinates().q.values());
            let is_place = t.is_finite() && q.iter().all(|x| x.is_finite());
            (is_place && !is_time_scale(scale)).then_some(StepError::TimeScale { t, h, scale, q })
        };
        let ahead = || {
            // other errors have a reason of their own
            if !matches!(
                error,
                StepError::BranchLost { .. } | StepError::NotConverged { .. }
            ) {
                return None;
            }
            let v = system.velocity(state).ok()?;
            let mut end = state.to_coordinates();
            let dq = Q::components(&v).map(|v| h * v);
            end.q = Q::Flat::moved(&end, &dq, &[0.0; N]).0;
            Some(State::from_coordinates(&end))
        };
        let reason = without_scale(state).or_else(|| without_scale(&ahead()?));
        reason.unwrap_or_else(|| error.at_time(t))
    }
}

impl<H, R, Q, const N: usize, const M: usize> OneStepMethod for InScaledTime<H, R>
where
    H: TimeScale + System<Dims = Dims<N, M, Q>, Itself = H>,
    R: Rule<H>,
    Q: Coordinates<N>,
{
    type System = H;
    type Increments = R::Increments;
    type Prepared = Timed<Prepared<R::Prepared, R::Memory>>;
    const HAS_OWN_TIME: bool = true;

    fn rate(&self, state: &State<Q>) -> f64 {
        self.system().time_scale(state)
    }

    fn system(&self) -> &H {
        self.integrator.system()
    }

    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        let steps = OneStepMethod::prepare(&self.integrator, h)?;
        Ok(Timed { steps, low: 0.0 })
    }

    fn prepare_within(&self, step: &Self::Prepared, h: f64) -> Result<Self::Prepared, StepError> {
        let low = step.low;
        Ok(Timed {
            low,
            ..self.prepare(h)?
        })
    }

    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        let mut prepared = prepared.clone();
        <FixedSizes as Steps<H, R>>::recall(&mut prepared.steps, &[]);
        self.advance(&mut prepared, state, h, dw, true)
    }

    fn next_step(
        &self,
        prepared: &mut Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<(), StepError> {
        self.advance(prepared, state, h, dw, false)
    }

    fn memory(&self, prepared: &Self::Prepared) -> Vec<f64> {
        let mut numbers = self.integrator.memory(&prepared.steps);
        numbers.push(prepared.low);
        numbers
    }

    fn recall(&self, prepared: &mut Self::Prepared, numbers: &[f64]) -> bool {
        let (steps, low) = match numbers {
            [] => (&[][..], 0.0),
            [steps @ .., low] => (steps, *low),
        };
        prepared.low = low;
        self.integrator.recall(&mut prepared.steps, steps)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        self.integrator.identify(to);
    }

    fn describe(&self) -> String {
        self.integrator.describe()
    }

    fn order(&self) -> Option<f64> {
        self.integrator.order()
    }
}

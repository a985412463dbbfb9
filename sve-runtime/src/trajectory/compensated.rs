//! Trajectories that compensate the rounding errors of the state.
//!
//! Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006),
//! section VIII.5.

use super::{FixedSteps, StepKind, Trajectory};
use crate::error::StepError;
use crate::integrator::Integrator;
use crate::integrator::driven::Driven;
use crate::integrator::inputs::Holding;
use crate::method::OneStepMethod;
use crate::noise::Noise;
use crate::phase::configuration::{Coordinates, FlatConfiguration};
use crate::phase::state::State;
use crate::rule::Rule;
use crate::system::{Dims, StateOf, System, WithInputs};

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Makes a step that carries the low parts of the state.
    #[inline(never)]
    pub(super) fn compensated_step(&mut self, dw: &I::Increments) -> Result<(), StepError> {
        match (&mut self.prepared, &mut self.low) {
            (Some(prepared), Some(low)) => {
                self.method
                    .compensated_step(prepared, &mut self.state, low, self.h, dw)
            }
            _ => Ok(()),
        }
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

/// A method whose steps can carry the low parts of the state.
#[diagnostic::on_unimplemented(
    message = "steps of `{Self}` have no compensated sums",
    note = "`compensated` is for trajectories of an `Integrator` of a system with a fixed number of coordinates",
    note = "paths with equal steps in the time of a time scale carry no low parts of their states: leave `.compensated()` out"
)]
pub trait CompensatedSums: OneStepMethod {
    /// Returns low parts that are zero.
    fn no_low_parts() -> StateOf<Self::System>;
}

#[diagnostic::do_not_recommend]
impl<S, R, Q, const N: usize, const M: usize> CompensatedSums for Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    fn no_low_parts() -> State<Q> {
        const {
            assert_increments::<S::Itself, R>();
            assert_low_parts::<Q::Flat, N>();
        }
        State::new(Q::origin(), Q::no_momentum())
    }
}

#[diagnostic::do_not_recommend]
impl<'a, S, R, F> CompensatedSums for Driven<'a, S, R, F>
where
    S: WithInputs,
    Self: OneStepMethod<System = S::Held<'a>>,
    Holding<'a, S, R>: CompensatedSums<System = S::Held<'a>>,
{
    fn no_low_parts() -> StateOf<S::Held<'a>> {
        Holding::<'a, S, R>::no_low_parts()
    }
}

impl<I: OneStepMethod, W: Noise, K: StepKind<I, W>> Trajectory<'_, I, W, K> {
    /// Compensates the rounding errors of the state: keeps the rounding errors of coordinates and
    /// momenta at each step, and adds them at the next one. In a run of many steps this reduces the
    /// random walk of rounding errors.
    ///
    /// Compensation helps if the increments of a step have digits that the state does not have: in
    /// explicit and linear steps, and for coordinates. The momentum of an implicit midpoint step is
    /// p₀ + 2(p̄ − p₀), where p̄ is rounded like the state: nothing can be kept, and the walk
    /// remains. Compensation does not reduce a systematic error of a step, and thus a drift. A
    /// refined step, see [`refine`](Self::refine), keeps the low parts that it starts with.
    ///
    /// A compile-time error for linear steps with noise in the momentum, which return states and no
    /// increments.
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
    /// let conserved = |s: &State<[f64; 1]>| {
    ///     let (q, p) = (s.q[0], s.p[0]);
    ///     q * q + p * p + h * q * p
    /// };
    /// let path = oscillator.trajectory(State::new([1.0], [0.0]), h, NoNoise).compensated();
    /// let end = path.take(100_000).last().unwrap()?;
    /// assert!((conserved(&end) - 1.0).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Source: Kahan's sum as in Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006),
    /// section VIII.5.
    #[must_use]
    pub fn compensated(mut self) -> Self
    where
        I: CompensatedSums,
        K: FixedSteps,
    {
        // a resumed trajectory keeps its own low parts
        self.low.get_or_insert_with(I::no_low_parts);
        self
    }
}

//! A system with the step of a rule: the interface between integrators and rules, derived ones and compositions of them.
//!
//! Input: a state, a step size and increments. Output: the state after the step, or a [`StepError`]; the state is then unchanged.

use core::fmt::Debug;

use nalgebra::DMatrix;

use crate::error::StepError;
use crate::lanes::tangents::LaneDirections;
use crate::lanes::{ALL, Mask};
use crate::linearisation::{Covector, Directions};
use crate::plan::Plan;
use crate::solve::newton::Newton;
use crate::system::{
    FlatStateOf, IncrementLanesOf, Increments, IncrementsOf, StateLanesOf, System, TangentLanesOf,
    VectorOf,
};

/// What a trajectory carries from one step to the next: numbers that the next step would compute again, or that its iteration starts from.
///
/// A step from no numbers gives the same result, up to the rounding error of the iteration.
pub trait Memory: Clone + Debug {
    /// Returns the memory before the first step.
    fn none() -> Self;
    /// Returns the numbers; none before the first step.
    fn numbers(&self) -> &[f64];
    /// Returns the memory with these numbers; `None` if their count is wrong.
    fn from_numbers(numbers: &[f64]) -> Option<Self>;
}

/// Nothing is carried.
impl Memory for () {
    #[inline(always)]
    fn none() -> Self {}

    fn numbers(&self) -> &[f64] {
        &[]
    }

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        numbers.is_empty().then_some(())
    }
}

/// `K` numbers, or none before the first step.
impl<const K: usize> Memory for Option<[f64; K]> {
    #[inline(always)]
    fn none() -> Self {
        None
    }

    fn numbers(&self) -> &[f64] {
        self.as_ref().map_or(&[], |numbers| numbers.as_slice())
    }

    fn from_numbers(numbers: &[f64]) -> Option<Self> {
        if numbers.is_empty() {
            return Some(None);
        }
        numbers.try_into().ok().map(Some)
    }
}

/// A system for which the rule `R` has been derived, or put together from derived rules.
///
/// Implemented by `#[variational(…)]`.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{R}` has been derived for `{Self}`",
    label = "this rule is not in the attribute of the `impl` block",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`; \
            the attribute names are `initial_point`, `endpoint`, `midpoint`, `stormer_verlet`, `gauss(2)` to `gauss(8)`, `taylor2`"
)]
pub trait Discretised<R>: System {
    /// The increments of a step: one number for each process, or for each process and stage.
    type Increments: Increments;
    /// Values that depend on parameters and step size only.
    type Prepared: Clone;
    /// What a trajectory carries from step to step.
    type Memory: Memory;
    /// Increments of a process in a step: 1, or the stages of a rule with stage noise.
    const STAGES: usize = 1;
    /// The plan of the step.
    const PLAN: &'static Plan;
    /// Whether a step is a sum of the state and an increment, so that its rounding errors can be compensated.
    const HAS_INCREMENTS: bool;

    /// Computes the values that depend on parameters and step size only.
    fn prepare(&self, h: f64) -> Self::Prepared;

    /// Makes one step, with the values that [`prepare`](Self::prepare) returned for the same `h`.
    ///
    /// # Errors
    /// A [`StepError`] when the step fails; `state` is then unchanged.
    fn advance(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        memory: &mut Self::Memory,
        state: &mut FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError>;

    /// Makes one step that adds the low parts `low` of the state, and writes its rounding errors to `low`.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn advance_compensated(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        memory: &mut Self::Memory,
        state: [&mut FlatStateOf<Self>; 2],
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError>;

    /// Advances every lane on the fast path and writes the result to `next`. Returns the mask of lanes that the fast path could not solve; their
    /// states are copied unchanged. Times in `next` are not written. `prepared` is that of `h`.
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    fn advance_lanes(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self>,
    ) -> Mask;

    /// Advances every lane as [`advance_lanes`](Self::advance_lanes) does, bit for bit, and carries tangent vectors along. Returns the mask of lanes that the fast path
    /// could not solve, and the mask of lanes whose vectors have no meaning. The default carries none.
    #[doc(hidden)]
    #[inline(always)]
    #[allow(clippy::too_many_arguments)] // those of a step and the vectors
    fn push_forward_lanes(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self>,
        tangents: LaneDirections<'_, TangentLanesOf<Self>>,
    ) -> [Mask; 2] {
        let _ = tangents;
        let unsolved = self.advance_lanes(newton, prepared, states, next, h, dw);
        [unsolved, ALL]
    }

    /// Makes one step and returns the derivatives of its result: rows by `(q₁, p₁)`, columns by `(q₀, p₀)` and the parameters.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); [`StepError::Singular`] if the Jacobian of the equations is singular at their solution.
    fn advance_with_derivatives(
        &self,
        newton: &Newton,
        state: &mut FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<DMatrix<f64>, StepError>;

    /// Makes one step and carries tangent vectors along it.
    ///
    /// # Errors
    /// As [`advance_with_derivatives`](Self::advance_with_derivatives); the vectors have no meaning then.
    #[doc(hidden)]
    fn push_forward(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        state: &mut FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        directions: Directions<'_, VectorOf<Self>>,
    ) -> Result<(), StepError>;

    /// Carries the derivatives of a function by the result of a step back to `state`, the start of the step.
    ///
    /// # Errors
    /// As [`advance_with_derivatives`](Self::advance_with_derivatives); the derivatives have no meaning then.
    #[doc(hidden)]
    fn pull_back(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        covector: Covector<'_, VectorOf<Self>>,
    ) -> Result<(), StepError>;

    /// Returns the largest number of Newton iterations of a block in a step; `None` if the step fails.
    fn newton_iterations(
        &self,
        newton: &Newton,
        prepared: &Self::Prepared,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
    ) -> Option<u32>;
}

/// A system with the step of the rule `R`, which takes one increment for each Wiener process.
///
/// All rules do, except those with stage noise. Code for any rule asks for this trait, since it knows the type of the increments then.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{R}` with one increment a process has been derived for `{Self}`",
    label = "this rule is not in the attribute of the `impl` block, or takes the increments of stages",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`"
)]
pub trait Variational<R>: Discretised<R, Increments = IncrementsOf<Self>> {}

impl<S: Discretised<R, Increments = IncrementsOf<S>>, R> Variational<R> for S {}

/// A system with a step of the rule `R` that tells the impulses of its constraints: every derived rule, and no composition.
#[diagnostic::on_unimplemented(
    message = "the step of the rule `{R}` tells no forces of constraints",
    label = "a composition has forces in each of its substeps",
    note = "ask an integrator with one of the rules of the attribute"
)]
pub trait ConstraintImpulses<R>: Discretised<R> {
    /// Makes one step and visits the multipliers of the constraints: all at the start of the step, then all at its end.
    ///
    /// # Errors
    /// As [`advance`](Discretised::advance).
    fn advance_with_impulses(
        &self,
        newton: &Newton,
        state: &mut FlatStateOf<Self>,
        h: f64,
        dw: &Self::Increments,
        visit: &mut dyn FnMut(f64),
    ) -> Result<(), StepError>;
}

#[diagnostic::do_not_recommend]
impl<S: ConstraintImpulses<R>, R> ConstraintImpulses<R> for &S {
    fn advance_with_impulses(
        &self,
        newton: &Newton,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
        visit: &mut dyn FnMut(f64),
    ) -> Result<(), StepError> {
        (**self).advance_with_impulses(newton, state, h, dw, visit)
    }
}

/// A rule that has been derived for the system `S`.
///
/// [`Integrator::new`](crate::Integrator::new) requires this trait and not `S: Discretised<R>`: with a single derived rule the compiler would
/// expect that rule, and report a type mismatch for any other one.
pub trait DerivedFor<S> {}

impl<S: Discretised<R>, R> DerivedFor<S> for R {}

#[diagnostic::do_not_recommend]
impl<S: Discretised<R>, R> Discretised<R> for &S {
    type Increments = S::Increments;
    type Prepared = S::Prepared;
    type Memory = S::Memory;
    const STAGES: usize = S::STAGES;
    const PLAN: &'static Plan = S::PLAN;
    const HAS_INCREMENTS: bool = S::HAS_INCREMENTS;

    #[inline]
    fn prepare(&self, h: f64) -> S::Prepared {
        (**self).prepare(h)
    }

    #[inline]
    fn advance(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        memory: &mut S::Memory,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        (**self).advance(newton, prepared, memory, state, h, dw)
    }

    #[inline]
    fn advance_compensated(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        memory: &mut S::Memory,
        state: [&mut FlatStateOf<S>; 2],
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        (**self).advance_compensated(newton, prepared, memory, state, h, dw)
    }

    #[inline(always)]
    fn advance_lanes(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
    ) -> Mask {
        (**self).advance_lanes(newton, prepared, states, next, h, dw)
    }

    #[inline(always)]
    fn push_forward_lanes(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        tangents: LaneDirections<'_, TangentLanesOf<S>>,
    ) -> [Mask; 2] {
        (**self).push_forward_lanes(newton, prepared, states, next, h, dw, tangents)
    }

    fn advance_with_derivatives(
        &self,
        newton: &Newton,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<DMatrix<f64>, StepError> {
        (**self).advance_with_derivatives(newton, state, h, dw)
    }

    #[inline]
    fn push_forward(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
        directions: Directions<'_, VectorOf<S>>,
    ) -> Result<(), StepError> {
        (**self).push_forward(newton, prepared, state, h, dw, directions)
    }

    #[inline]
    fn pull_back(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
        covector: Covector<'_, VectorOf<S>>,
    ) -> Result<(), StepError> {
        (**self).pull_back(newton, prepared, state, h, dw, covector)
    }

    fn newton_iterations(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &S::Increments,
    ) -> Option<u32> {
        (**self).newton_iterations(newton, prepared, state, h, dw)
    }
}

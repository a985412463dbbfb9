//! The step of a derived rule: the equations of the macro with the options of Newton's method, and the macro that makes them a
//! [`Discretised`](crate::Discretised) system.

use core::marker::PhantomData;

use super::start;
use crate::configuration::Coordinates;
use crate::equations::StepEquations;
use crate::solve::newton::Newton;
use crate::start::Tested;
use crate::state::State;
use crate::system::{Dims, System};
use crate::variational::Memory;

pub use super::compensated::solve_compensated_step;
pub use super::gradient::{pull_back, push_forward, push_forward_lanes};
pub use super::start::{increment_lanes, prepare};
pub use super::step::solve_step;
pub use super::tangent::solve_with_derivatives;

/// A system with the equations of the rule `R`, and the options of Newton's method.
#[derive(Debug)]
pub struct DerivedStep<'a, S, R> {
    pub(super) system: &'a S,
    pub(super) newton: &'a Newton,
    rule: PhantomData<R>,
}

impl<S, R> Clone for DerivedStep<'_, S, R> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, R> Copy for DerivedStep<'_, S, R> {}

impl<'a, S, R> DerivedStep<'a, S, R> {
    /// A step of the system.
    #[inline(always)]
    pub fn new(system: &'a S, newton: &'a Newton) -> Self {
        Self {
            system,
            newton,
            rule: PhantomData,
        }
    }
}

/// Returns the largest number of Newton iterations of a block in a step, `None` if the step fails.
///
/// Finds the lowest limit of iterations with which the step has the same bits: with a lower limit an attempt fails, and the next attempt reaches
/// the root along another path.
pub fn count_iterations<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Option<u32>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let increment = |max_iterations| {
        let newton = Newton {
            max_iterations,
            ..*derived.newton
        };
        let derived = DerivedStep {
            newton: &newton,
            ..derived
        };
        let memory = &mut S::Memory::none();
        let step = start::increment(derived, prepared, memory, state, h, dw);
        step.ok().map(|(q, p, _)| (q, p))
    };
    let max_iterations = derived.newton.max_iterations;
    let step = increment(max_iterations)?;
    (0..=max_iterations).find(|&limit| increment(limit) == Some(step))
}

/// Makes one step and visits the multipliers of the constraints.
///
/// # Errors
/// As [`Discretised::advance`](crate::Discretised::advance).
pub fn solve_with_impulses<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
    visit: &mut dyn FnMut(f64),
) -> Result<(), crate::error::StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = derived.system;
    let start = *state;
    let memory = &mut S::Memory::none();
    let unknowns = solve_step(derived, &start::prepare(system, h), memory, state, h, dw)?;
    system.multipliers(&start, h, dw, &unknowns, visit);
    Ok(())
}

/// Implements [`Discretised`](crate::Discretised) for a system with the [`StepEquations`] of a rule.
#[doc(hidden)]
#[macro_export]
macro_rules! __derived_rule {
    ($system:ty, $rule:ty) => {
        impl $crate::ConstraintImpulses<$rule> for $system {
            fn advance_with_impulses(
                &self,
                newton: &$crate::Newton,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &<Self as $crate::Discretised<$rule>>::Increments,
                visit: &mut dyn ::core::ops::FnMut(f64),
            ) -> ::core::result::Result<(), $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::solve_with_impulses(derived, state, h, dw, visit)
            }
        }

        impl $crate::Discretised<$rule> for $system {
            type Increments = <Self as $crate::__private::StepEquations<$rule>>::Increments;
            type Prepared = $crate::__private::Tested<
                <Self as $crate::__private::StepEquations<$rule>>::Prepared,
            >;
            type Memory = <Self as $crate::__private::StepEquations<$rule>>::Memory;
            const STAGES: usize = <Self as $crate::__private::StepEquations<$rule>>::STAGES;
            const PLAN: &'static $crate::Plan =
                <Self as $crate::__private::StepEquations<$rule>>::PLAN;
            const HAS_INCREMENTS: bool = !::core::matches!(
                <Self as $crate::__private::StepEquations<$rule>>::RETURNS,
                $crate::__private::Returns::State
            );

            #[inline]
            fn prepare(&self, h: f64) -> Self::Prepared {
                $crate::__private::prepare::<Self, $rule>(self, h)
            }

            // see `solve_step`
            #[inline(always)]
            fn advance(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                memory: &mut Self::Memory,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::solve_step(derived, prepared, memory, state, h, dw).map(|_| ())
            }

            #[inline]
            fn advance_compensated(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                memory: &mut Self::Memory,
                state: [&mut $crate::FlatStateOf<Self>; 2],
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::solve_compensated_step(derived, prepared, memory, state, h, dw)
            }

            #[inline(always)]
            fn advance_lanes(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                states: &$crate::StateLanesOf<Self>,
                next: &mut $crate::StateLanesOf<Self>,
                h: f64,
                dw: &$crate::IncrementLanesOf<Self>,
            ) -> $crate::__private::Mask {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::increment_lanes(derived, prepared, states, next, h, dw, &mut ())
            }

            #[inline(always)]
            fn push_forward_lanes(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                states: &$crate::StateLanesOf<Self>,
                next: &mut $crate::StateLanesOf<Self>,
                h: f64,
                dw: &$crate::IncrementLanesOf<Self>,
                tangents: $crate::__private::lane::LaneDirections<
                    '_,
                    $crate::__private::lane::TangentLanesOf<Self>,
                >,
            ) -> [$crate::__private::Mask; 2] {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::push_forward_lanes(
                    derived, prepared, states, next, h, dw, tangents,
                )
            }

            fn advance_with_derivatives(
                &self,
                newton: &$crate::Newton,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::result::Result<$crate::nalgebra::DMatrix<f64>, $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::solve_with_derivatives(derived, state, h, dw)
            }

            #[inline]
            fn push_forward(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &mut $crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
                directions: $crate::__private::Directions<'_, $crate::VectorOf<Self>>,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::push_forward(derived, prepared, state, h, dw, directions)
            }

            #[inline]
            fn pull_back(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &$crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
                covector: $crate::__private::Covector<'_, $crate::VectorOf<Self>>,
            ) -> ::core::result::Result<(), $crate::StepError> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::pull_back(derived, prepared, state, h, dw, covector)
            }

            fn newton_iterations(
                &self,
                newton: &$crate::Newton,
                prepared: &Self::Prepared,
                state: &$crate::FlatStateOf<Self>,
                h: f64,
                dw: &Self::Increments,
            ) -> ::core::option::Option<u32> {
                let derived = $crate::__private::DerivedStep::<Self, $rule>::new(self, newton);
                $crate::__private::count_iterations(derived, prepared, state, h, dw)
            }
        }
    };
}

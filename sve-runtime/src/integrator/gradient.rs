//! Derivatives along paths: steps that carry tangent vectors forwards, and derivatives of a function of their results backwards.

use super::{DerivedStep, Integrator, start};
use crate::configuration::Coordinates;
use crate::equations::StepEquations;
use crate::error::{StepError, step_error};
use crate::lanes::Mask;
use crate::lanes::tangents::LaneDirections;
use crate::linearisation::{Covector, Directions, Unknowns};
use crate::method::{Differentiable, OneStepMethod};
use crate::start::Tested;
use crate::state::State;
use crate::system::{Dims, IncrementLanesOf, StateLanesOf, System, TangentLanesOf};
use crate::variational::{Discretised, Memory};

use super::step::solve_step;

/// Makes a derived step and carries tangent vectors along it, see [`Discretised::push_forward`].
///
/// # Errors
/// As that function.
#[inline]
pub fn push_forward<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
    directions: Directions<'_, [f64; N]>,
) -> Result<(), StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let (system, mut end) = (derived.system, *state);
    let unknowns = solve_step(derived, prepared, &mut S::Memory::none(), &mut end, h, dw)?;
    let carried = system.linearise(state, h, dw, &unknowns, |linear| {
        S::Unknowns::push_forward(&linear, !S::RETURNS.is_state(), directions)
    });
    carried.map_err(|error| step_error(error, state, h, dw.as_ref()))?;
    *state = end;
    Ok(())
}

/// Makes a derived step in every lane and carries tangent vectors along it, see [`Discretised::push_forward_lanes`].
#[inline(always)]
pub fn push_forward_lanes<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    states: &StateLanesOf<S>,
    next: &mut StateLanesOf<S>,
    h: f64,
    dw: &IncrementLanesOf<S>,
    tangents: LaneDirections<'_, TangentLanesOf<S>>,
) -> [Mask; 2]
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let mut unknowns = S::Unknowns::lanes();
    let unsolved = start::increment_lanes(derived, prepared, states, next, h, dw, &mut unknowns);
    let unfinished = (derived.system).linearise_lanes(states, h, dw, &unknowns, tangents);
    [unsolved, unsolved | unfinished]
}

/// Carries derivatives by the result of a derived step back to its start, see [`Discretised::pull_back`].
///
/// # Errors
/// As that function.
#[inline]
pub fn pull_back<S, R, Q, const N: usize, const M: usize>(
    derived: DerivedStep<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
    covector: Covector<'_, [f64; N]>,
) -> Result<(), StepError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let (system, end) = (derived.system, &mut { *state });
    let unknowns = solve_step(derived, prepared, &mut S::Memory::none(), end, h, dw)?;
    let carried = system.linearise(state, h, dw, &unknowns, |linear| {
        S::Unknowns::pull_back(&linear, !S::RETURNS.is_state(), covector)
    });
    carried.map_err(|error| step_error(error, state, h, dw.as_ref()))
}

impl<S, R, Q, const N: usize, const M: usize> Differentiable for Integrator<S, R>
where
    S: Discretised<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    #[inline]
    fn push_forward(
        &self,
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &S::Increments,
        directions: Directions<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        let (system, prepared) = (OneStepMethod::system(self), prepared.coefficients());
        Q::in_coordinates(state, |state| {
            system.push_forward(self.newton(), prepared, state, h, dw, directions)
        })
    }

    #[inline(always)]
    fn push_forward_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        tangents: LaneDirections<'_, TangentLanesOf<S>>,
    ) -> [Mask; 2] {
        let (system, newton) = (OneStepMethod::system(self), self.newton());
        let prepared = prepared.coefficients();
        system.push_forward_lanes(newton, prepared, states, next, h, dw, tangents)
    }

    #[inline]
    fn pull_back(
        &self,
        prepared: &Self::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &S::Increments,
        covector: Covector<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        let (system, prepared) = (OneStepMethod::system(self), prepared.coefficients());
        let state = &state.to_coordinates();
        system.pull_back(self.newton(), prepared, state, h, dw, covector)
    }
}

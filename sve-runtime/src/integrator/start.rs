//! The tests of the start of a step, around the equations of any derived rule.
//!
//! Input: the step of a rule. Output: the same step, or an error where no isolated velocity has the
//! momentum at the start ([`start`](crate::start)). Single steps, compensated steps, derivatives
//! and lanes call the equations through the functions of this file.
//!
//! Checks without a cost come first: the mass matrix of parameters was tested in `prepare`; a rule
//! whose equations cannot be solved where the mass matrix is singular
//! ([`StepEquations::PROVES_START`]) tests nothing. A lane that is not sure takes the scalar step.
//! Increments of forces of velocities divide: an infinite one would give a finite state, so they
//! are tested. All other increments that are not finite show in the state.

use super::modes::LanesMode;
use super::step::iterates;
use crate::lanes::{ALL, LANES, Mask, marked};
use crate::mechanics::{legendre, reach_of_noise};
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::phase::tangents::KeepUnknowns;
use crate::rule::Walker;
use crate::solve::SolveError;
use crate::solve::newton::BlockSolver;
use crate::system::equations::{Memory, StepEquations, StepOf};
use crate::system::start::Tested;
use crate::system::{Dimensions, Dims, IncrementLanesOf, Increments as _, StateLanesOf, System};

/// Returned by a failed test. The error of the step is made off the fast path, from the inverse
/// Legendre transform.
const NO_START: SolveError = SolveError::Singular { iteration: 0 };

/// Below this reach of the noise forces of velocities no rule has a pole. From here on the solution
/// is followed: where several eigenvalues pass a pole together, no determinant changes its sign.
pub(super) const NO_POLE: f64 = 1.0;

/// Returns whether the mass matrix has to be tested in each step.
const fn tests_state<S: StepEquations<R>, R>() -> bool {
    S::TESTS_STATE && !S::PROVES_START
}

/// Returns whether a velocity of the momentum has to be found in each step.
const fn tests_velocity<S: StepEquations<R>, R>() -> bool {
    S::TESTS_VELOCITY && !S::PROVES_START
}

/// Solves the equations of a step from a start that is tested.
///
/// # Errors
/// As [`StepEquations::increment`]; a [`SolveError`] if no isolated velocity has the momentum at
/// the start.
#[inline(always)]
pub(super) fn increment<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    memory: &mut S::Memory,
    state: &State<Q::Flat>,
    h: f64,
    dw: &S::Increments,
) -> Result<StepOf<S, R>, SolveError>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let system = walker.system;
    if const { S::TESTS_PARAMETERS } && !prepared.has_regular_mass {
        return Err(NO_START);
    }
    if const { tests_state::<S, R>() } && !system.state_gives_regular_mass(state.t, &state.q) {
        return Err(NO_START);
    }
    if S::NOISE_READS_VELOCITY && !is_finite(dw.as_ref()) {
        return Err(SolveError::NonFinite);
    }
    if const { S::NOISE_READS_VELOCITY && iterates(S::PLAN) }
        && reach_of_noise(system, state, dw.as_ref()) >= NO_POLE
    {
        return Err(SolveError::OtherBranch);
    }
    let solver = BlockSolver::new(walker.newton);
    let step = system.increment(&prepared.coefficients, memory, state, h, dw, &solver)?;
    if const { tests_velocity::<S, R>() } {
        let (dq, dp, _) = &step;
        let guess = dq.map(|d| d / h);
        if !legendre::has_velocity_near(system, state, &guess, dp) {
            *memory = S::Memory::none();
            return Err(NO_START);
        }
    }
    Ok(step)
}

/// The mode that makes steps in lanes.
pub(super) struct AdvanceLanes;

impl<S, Q, const N: usize, const M: usize> LanesMode<S> for AdvanceLanes
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    #[inline(always)]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S::Increments>,
    ) -> Mask
    where
        S: StepEquations<R>,
    {
        increment_lanes(walker, prepared, states, next, h, dw, &mut ())
    }
}

/// Advances every lane whose start is tested, as [`StepEquations::increment_lanes`] does.
#[inline(always)]
#[allow(clippy::too_many_arguments)] // those of a step and the unknowns
pub(super) fn increment_lanes<S, R, Q, const N: usize, const M: usize>(
    walker: Walker<'_, S, R>,
    prepared: &Tested<S::Prepared>,
    states: &StateLanesOf<S>,
    next: &mut StateLanesOf<S>,
    h: f64,
    dw: &IncrementLanesOf<S::Increments>,
    unknowns: &mut impl KeepUnknowns,
) -> Mask
where
    S: StepEquations<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let Walker { system, newton, .. } = walker;
    let fails = const { S::TESTS_PARAMETERS } && !prepared.has_regular_mass;
    if fails || const { tests_velocity::<S, R>() } {
        next.clone_from(states);
        return ALL;
    }
    let coefficients = &prepared.coefficients;
    let unsolved = system.increment_lanes(coefficients, states, next, h, dw, newton, unknowns);
    let mut unsure = 0;
    if S::NOISE_READS_VELOCITY {
        let processes = dw.as_ref().iter();
        let sizes = processes.fold([0.0; LANES], |mut sizes, process| {
            for lane in 0..LANES {
                // NaN for a number that is not finite
                sizes[lane] += 0.0 * process[lane];
            }
            sizes
        });
        unsure |= marked(&sizes);
    }
    // bounds of the Jacobian reject a pole in steps without constraints
    if const { S::NOISE_READS_VELOCITY && !S::CONSTRAINTS.is_empty() && iterates(S::PLAN) } {
        unsure |= lanes_where::<S, Q, N, M>(states, |lane, state| {
            let dw = S::Increments::of_lane(dw, lane);
            reach_of_noise(system, state, dw.as_ref()) >= NO_POLE
        });
    }
    if const { tests_state::<S, R>() } {
        let is_singular =
            |_, state: &State<Q::Flat>| !system.state_gives_regular_mass(state.t, &state.q);
        let singular = system.lanes_of_singular_mass(states);
        unsure |= singular.unwrap_or_else(|| lanes_where::<S, Q, N, M>(states, is_singular));
    }
    if unsure != 0 {
        restore::<S>(unsure, states, next);
    }
    unsolved | unsure
}

#[inline(always)]
fn is_finite(increments: &[f64]) -> bool {
    // NaN if a number is not finite
    increments.iter().fold(0.0, |sum, dw| sum + 0.0 * dw) == 0.0
}

/// Returns the lanes whose states pass a test, lane by lane. Inputs differ from lane to lane, and
/// the test of a single state does not know those of its lane: with inputs all lanes are returned.
fn lanes_where<S, Q, const N: usize, const M: usize>(
    states: &StateLanesOf<S>,
    test: impl Fn(usize, &State<Q::Flat>) -> bool,
) -> Mask
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    if S::INPUTS > 0 {
        return ALL;
    }
    let mut mask = 0;
    for lane in 0..LANES {
        let state = S::Dims::get(states, lane).to_coordinates();
        mask |= Mask::from(test(lane, &state)) << lane;
    }
    mask
}

/// Copies the states of some lanes back.
#[cold]
fn restore<S: System>(lanes: Mask, states: &StateLanesOf<S>, next: &mut StateLanesOf<S>) {
    for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
        S::Dims::set(next, lane, &S::Dims::get(states, lane));
    }
}

//! Derivatives along paths: steps that carry tangent vectors forwards, and derivatives of a
//! function of their results backwards.

use super::modes::{LanesMode, SingleMode};
use super::step::solve_step;
use super::steps::{walk_from, walk_in_lanes};
use super::{Integrator, start};
use crate::error::{StepError, step_error};
use crate::lanes::Mask;
use crate::method::Differentiable;
use crate::phase::configuration::Coordinates;
use crate::phase::state::State;
use crate::phase::tangents::LaneDirections;
use crate::rule::{Mode, Rule, Walker};
use crate::system::equations::{Memory, StepEquations};
use crate::system::linearisation::{Covector, Directions, Unknowns};
use crate::system::start::Tested;
use crate::system::{AnyIncrements, Dims, IncrementLanesOf, StateLanesOf, System, TangentLanesOf};

/// The mode that makes steps and carries tangent vectors along them.
struct PushForward<'a, V> {
    directions: Directions<'a, V>,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for PushForward<'_, [f64; N]>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    #[inline]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        _: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        let (mut end, memory) = (*state, &mut S::Memory::none());
        let unknowns = solve_step(walker, prepared, memory, &mut end, h, dw)?;
        let directions = self.directions.reborrow();
        let carried = (walker.system).linearise(state, h, dw, &unknowns, |linear| {
            S::Unknowns::push_forward(&linear, !S::RETURNS.is_state(), directions)
        });
        carried.map_err(|error| step_error(error, state, h, dw.as_ref()))?;
        *state = end;
        Ok(())
    }
}

/// The mode that stores the starts of all substeps but the first, which is known. The last substep
/// is not made.
struct Starts<F> {
    has_begun: bool,
    states: Vec<F>,
    /// Number of states that are stored at the end.
    count: usize,
}

impl<S, I, Q, const N: usize, const M: usize> SingleMode<S, I> for Starts<State<Q::Flat>>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    #[inline]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        _: &mut S::Memory,
        state: &mut State<Q::Flat>,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        if self.has_begun {
            self.states.push(*state);
        }
        self.has_begun = true;
        if self.states.len() == self.count {
            return Ok(());
        }
        solve_step(walker, prepared, &mut S::Memory::none(), state, h, dw).map(|_| ())
    }
}

/// The mode that carries derivatives by the result of a step back to its start.
struct PullBack<'a, F, V> {
    first: &'a F,
    /// The starts of the remaining substeps, without the first substep.
    starts: Vec<F>,
    covector: Covector<'a, V>,
}

impl<S, I, Q, const N: usize, const M: usize> Mode<S, I> for PullBack<'_, State<Q::Flat>, [f64; N]>
where
    S: System<Dims = Dims<N, M, Q>>,
    I: AnyIncrements + ?Sized,
    Q: Coordinates<N>,
{
    type Increments = I;
    type Part = I::Owned;
    type Failure = StepError;
    type Start = ();
    const IS_BACKWARD: bool = true;

    #[inline]
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        _: &mut S::Memory,
        h: f64,
        dw: &I,
    ) -> Result<(), StepError>
    where
        S: StepEquations<R, Increments = I>,
    {
        let state = &self.starts.pop().unwrap_or(*self.first);
        let (end, memory) = (&mut { *state }, &mut S::Memory::none());
        let unknowns = solve_step(walker, prepared, memory, end, h, dw)?;
        let covector = self.covector.reborrow();
        let carried = (walker.system).linearise(state, h, dw, &unknowns, |linear| {
            S::Unknowns::pull_back(&linear, !S::RETURNS.is_state(), covector)
        });
        carried.map_err(|error| step_error(error, state, h, dw.as_ref()))
    }

    #[inline]
    fn begin(&mut self) {}

    #[inline]
    fn end(&mut self, (): (), _: f64) {}

    #[inline]
    fn part(dw: &I, part: f64) -> I::Owned {
        dw.times(part)
    }
}

/// The mode that makes steps in lanes and carries tangent vectors along them.
struct PushForwardLanes<'a, L> {
    tangents: LaneDirections<'a, L>,
    /// The vectors before the substep, from the second one on.
    start: Vec<L>,
    has_begun: bool,
    /// The lanes whose vectors are invalid.
    unfinished: Mask,
}

impl<S, Q, const N: usize, const M: usize> LanesMode<S> for PushForwardLanes<'_, TangentLanesOf<S>>
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
        if self.has_begun {
            self.start.clear();
            self.start.extend_from_slice(self.tangents.next);
        }
        let directions = LaneDirections {
            start: if self.has_begun {
                &self.start
            } else {
                self.tangents.start
            },
            next: &mut *self.tangents.next,
            parameters: self.tangents.parameters,
        };
        self.has_begun = true;
        let mut unknowns = S::Unknowns::lanes();
        let unsolved = start::increment_lanes(walker, prepared, states, next, h, dw, &mut unknowns);
        let unfinished = (walker.system).linearise_lanes(states, h, dw, &unknowns, directions);
        self.unfinished |= unsolved | unfinished;
        unsolved
    }
}

impl<S, R, Q, const N: usize, const M: usize> Differentiable for Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: Coordinates<N>,
{
    #[inline]
    fn push_forward(
        &self,
        prepared: &Self::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &R::Increments,
        directions: Directions<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            let mode = PushForward { directions };
            walk_from(self.walker(), prepared, state, h, dw, mode).map(|_| ())
        })
    }

    #[inline(always)]
    fn push_forward_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<R::Increments>,
        tangents: LaneDirections<'_, TangentLanesOf<S>>,
    ) -> [Mask; 2] {
        let mode = PushForwardLanes {
            tangents,
            start: Vec::new(),
            has_begun: false,
            unfinished: 0,
        };
        let (unsolved, mode) = walk_in_lanes(self.walker(), prepared, states, next, h, dw, mode);
        [unsolved, mode.unfinished]
    }

    #[inline]
    fn pull_back(
        &self,
        prepared: &Self::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &R::Increments,
        covector: Covector<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        let first = &state.to_coordinates();
        let count = R::SUBSTEPS - 1;
        let mode = Starts {
            has_begun: false,
            states: Vec::with_capacity(count),
            count,
        };
        let walker = self.walker();
        let Starts { states, .. } = walk_from(walker, prepared, &mut { *first }, h, dw, mode)?;
        let mut mode = PullBack {
            first,
            starts: states,
            covector,
        };
        let (prepared, memory) = (prepared.coefficients(), &mut R::Memory::none());
        R::walk(walker, prepared, memory, h, dw, &mut mode)
    }
}

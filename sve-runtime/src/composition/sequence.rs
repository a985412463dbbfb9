//! A step that is a sequence of substeps.
//!
//! Input: the substeps of a rule. Output: what [`Discretised`](crate::Discretised) asks for. Substep `k` has the length `wₖ h` and the increments `wₖ ΔW`.

use nalgebra::DMatrix;

pub use super::lanes::{advance_lanes, push_forward_lanes};
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::lanes::Mask;
use crate::lanes::tangents::LaneDirections;
use crate::linearisation::{Covector, Directions};
use crate::plan::{Operations, Plan, Substeps};
use crate::solve::newton::Newton;
use crate::state::State;
use crate::system::{
    Dims, FlatStateOf, IncrementLanesOf, Increments, StateLanesOf, System, TangentLanesOf, VectorOf,
};
use crate::variational::Memory;

/// A rule whose step is a sequence of steps of other rules.
pub trait Sequence<S: System> {
    /// The increments of a step.
    type Increments: Increments;
    /// Values that depend on parameters and step size only, of all substeps.
    type Prepared: Clone;
    /// What a trajectory, and a step from substep to substep, carries.
    type Memory: Memory;
    /// Increments of a process in a step.
    const STAGES: usize;
    /// The plan of the step.
    const PLAN: &'static Plan;
    /// Whether the rounding errors of every substep can be compensated.
    const HAS_INCREMENTS: bool;
    /// The fractions `wₖ`.
    const FRACTIONS: &'static [f64];

    /// Computes the values that depend on parameters and step size only.
    fn prepare(system: &S, h: f64) -> Self::Prepared;

    /// Makes substep `number`, of length `h`.
    ///
    /// # Errors
    /// A [`StepError`] when the substep fails; `state` is then unchanged.
    fn advance(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        memory: &mut Self::Memory,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError>;

    /// Makes substep `number`, which adds the low parts of the state and writes its rounding errors to them.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn advance_compensated(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        memory: &mut Self::Memory,
        state: [&mut FlatStateOf<S>; 2],
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError>;

    /// Makes substep `number` in every lane.
    fn advance_lanes(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
    ) -> Mask;

    /// Makes substep `number` in every lane and carries tangent vectors along it.
    fn push_forward_lanes(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        tangents: LaneDirections<'_, TangentLanesOf<S>>,
    ) -> [Mask; 2];

    /// Makes substep `number` and returns the derivatives of its result.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn advance_with_derivatives(
        shared: Shared<'_, S, ()>,
        number: usize,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<DMatrix<f64>, StepError>;

    /// Makes substep `number` and carries tangent vectors along it.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn push_forward(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &mut FlatStateOf<S>,
        h: f64,
        dw: &Self::Increments,
        directions: Directions<'_, VectorOf<S>>,
    ) -> Result<(), StepError>;

    /// Carries derivatives by the result of substep `number` back to its start.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn pull_back(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &Self::Increments,
        covector: Covector<'_, VectorOf<S>>,
    ) -> Result<(), StepError>;

    /// Returns the number of Newton iterations of substep `number`.
    fn newton_iterations(
        shared: Shared<'_, S, Self::Prepared>,
        number: usize,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &Self::Increments,
    ) -> Option<u32>;
}

/// What all substeps of a step share.
#[derive(Debug)]
pub struct Shared<'a, S, P> {
    /// The system.
    pub system: &'a S,
    /// The options of Newton's method.
    pub newton: &'a Newton,
    /// What was prepared for all substeps.
    pub prepared: &'a P,
}

impl<S, P> Clone for Shared<'_, S, P> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, P> Copy for Shared<'_, S, P> {}

/// Returns the plan of `count` substeps, of which equally many are those of each of the given plans.
pub(super) const fn plan_of<const K: usize>(
    plans: [&Plan; K],
    rule: &'static str,
    composition: &'static str,
    order: u32,
    count: usize,
) -> Plan {
    let none = Operations {
        arithmetic: 0,
        transcendental: 0,
        angle_additions: 0,
    };
    let (mut prepare, mut step, mut carried) = (none, none, none);
    let (mut iteration, mut at) = (none, 0);
    let mut in_lanes = true;
    while at < K {
        let times = count / K;
        prepare = prepare.plus(times, plans[at].prepare);
        step = step.plus(times, plans[at].step);
        carried = carried.plus(times, plans[at].carried);
        iteration = iteration.plus(times, plans[at].iteration);
        in_lanes = in_lanes && plans[at].in_lanes;
        at += 1;
    }
    Plan {
        rule,
        substeps: Some(Substeps { composition, count }),
        deterministic_order: order,
        weak_order: if plans[0].noises == 0 {
            order
        } else {
            plans[0].weak_order
        },
        in_lanes,
        prepare,
        step,
        carried,
        iteration,
        ..*plans[0]
    }
}

/// Makes the substeps one after the other. After an error the state is unchanged and nothing is carried.
///
/// # Errors
/// As [`Discretised::advance`](crate::Discretised::advance).
#[inline]
pub fn advance<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    memory: &mut K::Memory,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &K::Increments,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let mut end = *state;
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let dw = dw.times(part);
        if let Err(error) = K::advance(shared, number, memory, &mut end, part * h, &dw) {
            *memory = K::Memory::none();
            return Err(error);
        }
    }
    // rounded once
    end.t = state.t + h;
    *state = end;
    Ok(())
}

/// Makes the substeps with compensated sums.
///
/// # Errors
/// As [`Discretised::advance_compensated`](crate::Discretised::advance_compensated).
#[inline]
pub fn advance_compensated<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    memory: &mut K::Memory,
    [state, low]: [&mut State<Q::Flat>; 2],
    h: f64,
    dw: &K::Increments,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let (mut end, mut end_low) = (*state, *low);
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let (dw, both) = (dw.times(part), [&mut end, &mut end_low]);
        if let Err(error) = K::advance_compensated(shared, number, memory, both, part * h, &dw) {
            *memory = K::Memory::none();
            return Err(error);
        }
    }
    end.t = state.t + h;
    (*state, *low) = (end, end_low);
    Ok(())
}

/// Makes the substeps and returns the derivatives of the result of all of them, by the chain rule.
///
/// # Errors
/// As [`Discretised::advance_with_derivatives`](crate::Discretised::advance_with_derivatives).
pub fn advance_with_derivatives<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, ()>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &K::Increments,
) -> Result<DMatrix<f64>, StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let (size, columns) = (2 * N, 2 * N + S::PARAMETERS.len());
    let (mut end, mut all) = (*state, DMatrix::identity(size, columns));
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let dw = dw.times(part);
        let step = K::advance_with_derivatives(shared, number, &mut end, part * h, &dw)?;
        let before = all;
        // Term by term: a product of matrices may contract operations, with other bits on other machines.
        all = DMatrix::from_fn(size, columns, |row, column| {
            let direct = if column < size {
                0.0
            } else {
                step[(row, column)]
            };
            (0..size).fold(direct, |sum, k| sum + step[(row, k)] * before[(k, column)])
        });
    }
    end.t = state.t + h;
    *state = end;
    Ok(all)
}

/// Makes the substeps and carries tangent vectors along them.
///
/// # Errors
/// As [`Discretised::advance_with_derivatives`](crate::Discretised::advance_with_derivatives).
pub fn push_forward<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    state: &mut State<Q::Flat>,
    h: f64,
    dw: &K::Increments,
    mut directions: Directions<'_, [f64; N]>,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let mut end = *state;
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let (h, dw) = (part * h, dw.times(part));
        K::push_forward(shared, number, &mut end, h, &dw, directions.reborrow())?;
    }
    end.t = state.t + h;
    *state = end;
    Ok(())
}

/// Makes the substeps, and carries derivatives by their result back to `state`.
///
/// # Errors
/// As [`Discretised::advance_with_derivatives`](crate::Discretised::advance_with_derivatives).
pub fn pull_back<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    state: &State<Q::Flat>,
    h: f64,
    dw: &K::Increments,
    mut covector: Covector<'_, [f64; N]>,
) -> Result<(), StepError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let (mut here, mut starts) = (*state, Vec::with_capacity(K::FRACTIONS.len()));
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        starts.push(here);
        let (h, dw, memory) = (part * h, dw.times(part), &mut K::Memory::none());
        K::advance(shared, number, memory, &mut here, h, &dw)?;
    }
    for (number, start) in starts.iter().enumerate().rev() {
        let part = K::FRACTIONS[number];
        let (h, dw) = (part * h, dw.times(part));
        K::pull_back(shared, number, start, h, &dw, covector.reborrow())?;
    }
    Ok(())
}

/// Returns the largest number of Newton iterations of a substep.
pub fn newton_iterations<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    state: &State<Q::Flat>,
    h: f64,
    dw: &K::Increments,
) -> Option<u32>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let (mut here, mut most, mut memory) = (*state, 0, K::Memory::none());
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let (h, dw) = (part * h, dw.times(part));
        most = most.max(K::newton_iterations(shared, number, &here, h, &dw)?);
        K::advance(shared, number, &mut memory, &mut here, h, &dw).ok()?;
    }
    Some(most)
}

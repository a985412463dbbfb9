//! The substeps of a step in lanes, and tangent vectors along them.
//!
//! Input: states and tangent vectors in lanes. Output: those after all substeps. Invariant: tangent vectors change no bit of the states.

use super::sequence::{Sequence, Shared};
use crate::configuration::Coordinates;
use crate::lanes::tangents::{LaneDirections, TangentLanes};
use crate::lanes::{LANES, Mask};
use crate::system::{Dimensions, Dims, IncrementLanesOf, StateLanesOf, System};

/// Makes the substeps in every lane. A lane that a substep could not solve is restored.
#[inline(always)]
pub fn advance_lanes<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    states: &StateLanesOf<S>,
    next: &mut StateLanesOf<S>,
    h: f64,
    dw: &IncrementLanesOf<S>,
) -> Mask
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let (mut here, mut unsolved) = (*states, 0);
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let mut dw = *dw;
        for w in dw.as_mut().iter_mut().flatten() {
            *w *= part;
        }
        unsolved |= K::advance_lanes(shared, number, &here, next, part * h, &dw);
        for (t, start) in S::Dims::times(next)
            .iter_mut()
            .zip(S::Dims::times(&mut here))
        {
            *t = *start + part * h;
        }
        here = *next;
    }
    if unsolved != 0 {
        for lane in (0..LANES).filter(|lane| unsolved >> lane & 1 == 1) {
            S::Dims::set(next, lane, &S::Dims::get(states, lane));
        }
    }
    unsolved
}

/// Makes the substeps in every lane and carries tangent vectors along them, see
/// [`Discretised::push_forward_lanes`](crate::Discretised::push_forward_lanes). A lane that a substep could not solve is restored.
#[inline(always)]
pub fn push_forward_lanes<K, S, Q, const N: usize, const M: usize>(
    shared: Shared<'_, S, K::Prepared>,
    states: &StateLanesOf<S>,
    next: &mut StateLanesOf<S>,
    h: f64,
    dw: &IncrementLanesOf<S>,
    tangents: LaneDirections<'_, TangentLanes<N>>,
) -> [Mask; 2]
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
    K: Sequence<S>,
{
    let LaneDirections {
        start,
        next: end,
        parameters,
    } = tangents;
    let (mut here, mut start) = (*states, start.to_vec());
    let [mut unsolved, mut unfinished] = [0; 2];
    for (number, &part) in K::FRACTIONS.iter().enumerate() {
        let mut dw = *dw;
        for w in dw.iter_mut().flatten() {
            *w *= part;
        }
        let directions = LaneDirections {
            start: &start,
            next: &mut *end,
            parameters,
        };
        let masks = K::push_forward_lanes(shared, number, &here, next, part * h, &dw, directions);
        unsolved |= masks[0];
        unfinished |= masks[1];
        let times = S::Dims::times(next).iter_mut();
        for (t, start) in times.zip(S::Dims::times(&mut here)) {
            *t = *start + part * h;
        }
        here = *next;
        start.copy_from_slice(end);
    }
    for lane in (0..LANES).filter(|lane| unsolved >> lane & 1 == 1) {
        S::Dims::set(next, lane, &S::Dims::get(states, lane));
    }
    [unsolved, unfinished]
}

//! States of many lanes.

use crate::lanes::{LANES, Lane, Mask, needs_scalar_step};
use crate::phase::configuration::Configuration;
use crate::phase::state::State;

/// [`LANES`] states. Each component is an array over the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct StateLanes<const N: usize> {
    /// Times.
    pub t: Lane,
    /// Configurations, one row for each coordinate.
    pub q: [Lane; N],
    /// Momenta, one row for each coordinate.
    pub p: [Lane; N],
}

/// States of many lanes.
pub trait LaneStates<Q: Configuration>: Clone + Copy + core::fmt::Debug {
    /// Returns the same state in each lane.
    fn splat(state: &State<Q>) -> Self;
    /// Returns the state of a lane.
    fn get(&self, lane: usize) -> State<Q>;
    /// Replaces the state of a lane.
    fn set(&mut self, lane: usize, state: &State<Q>);
    /// Returns the times of the lanes.
    fn times(&mut self) -> &mut Lane;
}

impl<const N: usize> LaneStates<[f64; N]> for StateLanes<N> {
    fn splat(state: &State<[f64; N]>) -> Self {
        Self::splat(state)
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> State<[f64; N]> {
        Self::get(self, lane)
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, state: &State<[f64; N]>) {
        Self::set(self, lane, state);
    }

    #[inline(always)]
    fn times(&mut self) -> &mut Lane {
        &mut self.t
    }
}

/// States that are stepped one after the other, lane by lane, for configurations that have no steps
/// in lanes.
#[derive(Clone, Copy, Debug)]
pub struct ScalarLanes<Q: Configuration<Momentum: Copy> + Copy> {
    t: Lane,
    states: [State<Q>; LANES],
}

impl<Q: Configuration<Momentum: Copy> + Copy> LaneStates<Q> for ScalarLanes<Q> {
    fn splat(state: &State<Q>) -> Self {
        Self {
            t: [state.t; LANES],
            states: [*state; LANES],
        }
    }

    #[inline(always)]
    fn get(&self, lane: usize) -> State<Q> {
        State {
            t: self.t[lane],
            ..self.states[lane]
        }
    }

    #[inline(always)]
    fn set(&mut self, lane: usize, state: &State<Q>) {
        self.t[lane] = state.t;
        self.states[lane] = *state;
    }

    #[inline(always)]
    fn times(&mut self) -> &mut Lane {
        &mut self.t
    }
}

impl<const N: usize> StateLanes<N> {
    /// Returns the same state in each lane.
    pub const fn splat(state: &State<[f64; N]>) -> Self {
        let mut lanes = Self {
            t: [state.t; LANES],
            q: [[0.0; LANES]; N],
            p: [[0.0; LANES]; N],
        };
        let mut i = 0;
        while i < N {
            lanes.q[i] = [state.q[i]; LANES];
            lanes.p[i] = [state.p[i]; LANES];
            i += 1;
        }
        lanes
    }

    /// Returns the state of a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> State<[f64; N]> {
        State {
            t: self.t[lane],
            q: core::array::from_fn(|i| self.q[i][lane]),
            p: core::array::from_fn(|i| self.p[i][lane]),
        }
    }

    /// Replaces the state of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, state: &State<[f64; N]>) {
        self.t[lane] = state.t;
        for i in 0..N {
            self.q[i][lane] = state.q[i];
            self.p[i][lane] = state.p[i];
        }
    }

    /// Restores the states `before` a step in the lanes that need the scalar step
    /// ([`needs_scalar_step`]). Returns the mask of these lanes. `any` is 0 if there are no such
    /// lanes, so that the lanes are seldom searched. Times do not change.
    #[inline(always)]
    pub fn restore_unsolved(
        &mut self,
        before: &Self,
        any: u64,
        solved: impl Fn(usize) -> bool,
    ) -> Mask {
        if any == 0 {
            return 0;
        }
        self.restore_some(before, solved)
    }

    #[cold]
    fn restore_some(&mut self, before: &Self, solved: impl Fn(usize) -> bool) -> Mask {
        let mut mask = 0;
        for lane in 0..LANES {
            let State { q, p, t } = self.get(lane);
            if needs_scalar_step(q, p, solved(lane)) != 0 {
                mask |= 1 << lane;
                self.set(
                    lane,
                    &State {
                        t,
                        ..before.get(lane)
                    },
                );
            }
        }
        mask
    }
}

//! Several states at once, a lane each: what an ensemble steps.
//!
//! Invariant: what happens in a lane depends on that lane alone, and no operation is contracted into another, so a path has
//! the same bits in any lane, beside any neighbours, with vectors of any width.

#[cfg(feature = "ensemble")]
pub(crate) mod dispatch;
pub(crate) mod elementary;
pub(crate) mod newton;
pub(crate) mod solve;

use crate::state::State;

/// How many states are stepped at once: four registers of AVX-512, eight of AVX2. The loops of a step over them are fused, so
/// that as many chains of operations are in flight.
pub const LANES: usize = 32;

/// A number of each lane.
pub type Lane = [f64; LANES];

/// A set of lanes, bit `l` for lane `l`.
pub type Mask = u32;

/// All lanes.
pub(crate) const ALL: Mask = Mask::MAX >> (Mask::BITS as usize - LANES);

/// [`LANES`] states, each component an array over the lanes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct StateLanes<const N: usize> {
    /// Times.
    pub t: Lane,
    /// Configurations, one row a coordinate.
    pub q: [Lane; N],
    /// Momenta, one row a coordinate.
    pub p: [Lane; N],
}

impl<const N: usize> StateLanes<N> {
    /// The same state in each lane.
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

    /// The state of a lane.
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

    /// Completes the states after a step: the lanes that are left ([`is_left`]) get back those `before` it; the set of these.
    /// Whether there are any is known, which of them is seldom asked. Times stay.
    #[inline(always)]
    pub fn complete(&mut self, before: &Self, any: u64, solved: impl Fn(usize) -> bool) -> Mask {
        if any == 0 {
            return 0;
        }
        self.complete_some(before, solved)
    }

    #[cold]
    fn complete_some(&mut self, before: &Self, solved: impl Fn(usize) -> bool) -> Mask {
        let mut mask = 0;
        for lane in 0..LANES {
            let State { q, p, t } = self.get(lane);
            if is_left(q, p, solved(lane)) != 0 {
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

/// 0 where the equations of a lane are `solved` and its new state is finite, otherwise 1.
#[inline(always)]
pub fn is_left<const N: usize>(q: [f64; N], p: [f64; N], solved: bool) -> u64 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += q[i] + p[i];
    }
    u64::from(!((sum.abs() < f64::INFINITY) & solved))
}

/// Numbers of each lane, on the boundaries of vectors: across two lines of the cache, loads and stores take twice as long.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct Aligned<T>(pub T);

/// Numbers of each lane that one loop over the lanes hands to a later one.
#[inline(always)]
pub const fn rows<const K: usize>() -> Aligned<[Lane; K]> {
    Aligned([[0.0; LANES]; K])
}

//! Several states at once, a lane each: what an ensemble steps.
//!
//! Invariant: what happens in a lane depends on that lane alone, and no operation is contracted into another, so a path has
//! the same bits in any lane, beside any neighbours, with vectors of any width.

#[cfg(feature = "ensemble")]
pub(crate) mod dispatch;

use crate::state::State;

/// How many states are stepped at once: two registers of AVX-512, four of AVX2. The loops of a step over them are fused, so that
/// two chains of operations are always in flight.
pub const LANES: usize = 16;

/// A number of each lane.
pub type Lane = [f64; LANES];

/// A set of lanes, bit `l` for lane `l`.
pub type Mask = u32;

/// All lanes.
pub(crate) const ALL: Mask = (1 << LANES) - 1;

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
    pub const fn splat(state: &State<N>) -> Self {
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
    pub fn get(&self, lane: usize) -> State<N> {
        State {
            t: self.t[lane],
            q: core::array::from_fn(|i| self.q[i][lane]),
            p: core::array::from_fn(|i| self.p[i][lane]),
        }
    }

    /// Replaces the state of a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, state: &State<N>) {
        self.t[lane] = state.t;
        for i in 0..N {
            self.q[i][lane] = state.q[i];
            self.p[i][lane] = state.p[i];
        }
    }
}

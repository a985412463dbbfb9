//! The state of a path at the end of a run.

use crate::state::State;

/// The state of a path at the end, from [`Summary::final_states`](super::Summary::final_states): its components are read like those of a
/// [`State`], without a number of coordinates in the type.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinalState<'a> {
    /// Time.
    pub t: f64,
    /// Configuration.
    pub q: &'a [f64],
    /// Momentum.
    pub p: &'a [f64],
}

impl FinalState<'_> {
    /// The same as a [`State`]; `None` where `N` is not the system's number of coordinates.
    pub fn state<const N: usize>(&self) -> Option<State<N>> {
        let q = self.q.try_into().ok()?;
        let p = self.p.try_into().ok()?;
        Some(State::at(self.t, q, p))
    }
}

impl<const N: usize> PartialEq<State<N>> for FinalState<'_> {
    fn eq(&self, other: &State<N>) -> bool {
        self.t == other.t && self.q == other.q && self.p == other.p
    }
}

impl<const N: usize> PartialEq<FinalState<'_>> for State<N> {
    fn eq(&self, other: &FinalState<'_>) -> bool {
        other == self
    }
}

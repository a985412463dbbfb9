//! The state of a path at the end of a run.

use crate::phase::configuration::{Configuration, FixedSize};
use crate::phase::state::State;

/// The state of a path at the end, from [`Summary::final_states`](super::Summary::final_states):
/// its components are read like the components of a [`State`], without a number of coordinates in
/// the type.
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
    /// Returns the state as a [`State`]; `None` if configurations of the type `Q` have another
    /// number of stored values.
    pub fn state<Q: FixedSize>(&self) -> Option<State<Q>> {
        let lengths = [Q::STORED_VALUES, Q::DEGREES_OF_FREEDOM];
        if [self.q.len(), self.p.len()] != lengths {
            return None;
        }
        let mut state = State::at(self.t, Q::origin(), Q::no_momentum());
        state.q.restore(self.q);
        state.p.restore(self.p);
        Some(state)
    }
}

impl<Q: FixedSize> PartialEq<State<Q>> for FinalState<'_> {
    fn eq(&self, other: &State<Q>) -> bool {
        self.state().as_ref() == Some(other)
    }
}

impl<Q: FixedSize> PartialEq<FinalState<'_>> for State<Q> {
    fn eq(&self, other: &FinalState<'_>) -> bool {
        other == self
    }
}

//! A bound on the work of an arena, so that no input runs away in time or memory.
//!
//! Every walk and every construction spends from the budget of the current stage, in units of one
//! operand looked at. When it is used up nothing is built any more: derivatives are zero,
//! substitutions do nothing, walks find nothing. What comes of the stage is then worthless but
//! comes soon, and its caller asks [`Arena::is_exhausted`] before anyone looks at it.

use super::expr::Arena;

impl Arena {
    /// Grants work to a stage, in place of what is left from the last.
    pub(crate) fn grant(&mut self, work: usize) {
        self.budget.set(work);
    }

    /// Spends work, down to nothing.
    pub(crate) fn spend(&self, work: usize) {
        self.budget.set(self.budget.get().saturating_sub(work));
    }

    /// Whether the work that was granted is used up.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.budget.get() == 0
    }
}

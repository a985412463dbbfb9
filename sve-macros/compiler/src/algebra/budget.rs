//! A bound on the work of an arena, so that no input makes an expansion run away in time or memory.
//!
//! Every walk and every construction spends from the budget of the current stage, in units of one
//! visited operand. When the budget is used up, nothing is built any more: derivatives are zero,
//! substitutions do nothing, walks find nothing. The result of the stage is then worthless but
//! comes soon, and the caller asks [`Arena::is_exhausted`] before it uses the result.

use super::expr::Arena;

impl Arena {
    /// Grants work to a stage, in place of the remaining budget of the previous stage.
    pub(crate) fn grant(&mut self, work: usize) {
        self.budget.set(work);
    }

    /// Spends work; the budget does not go below zero.
    pub(crate) fn spend(&self, work: usize) {
        self.budget.set(self.budget.get().saturating_sub(work));
    }

    /// Returns whether the granted work is used up.
    pub(crate) fn is_exhausted(&self) -> bool {
        self.budget.get() == 0
    }
}

//! Expressions → straight-line instructions in tiers, each computed once and as early as its inputs are known.
//!
//! Input: expressions wanted by the emitter. Output: a [`Program`] of two-operand instructions. Sums and products of many
//! operands are cut so that the operands known earliest come first: what depends on parameters and h alone leaves the step,
//! what depends on the state leaves the iteration. Invariant: an instruction's operands precede it and are of its tier or
//! an earlier one.

mod angles;
mod instructions;
mod scheduler;
mod sums;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use instructions::{Operation, Program, Tier, Value, operands};
pub(crate) use scheduler::{Scheduler, Tiers};

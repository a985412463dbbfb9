//! Expressions → straight-line instructions in tiers, each computed once and as early as its inputs are known.
//!
//! Input: expressions wanted by the emitter. Output: a [`Program`] of two-operand instructions. Sums and products of many
//! operands are cut so that the operands known earliest come first: what depends on parameters and h alone leaves the step,
//! what depends on the state leaves the iteration. Invariant: an instruction's operands precede it and are of its tier or
//! an earlier one.
//!
//! What a back end prints is decided here: the program of a step, its costs, the names of its values, and how a step in lanes is cut
//! into loops.

mod angles;
mod costs;
mod factors;
mod instructions;
mod labels;
mod loops;
mod names;
mod numbering;
mod scheduler;
mod step;
mod sums;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use costs::{Operations, Work};
pub(crate) use factors::Factored;
pub(crate) use instructions::{Operation, Program, Tier, Value, operands};
pub(crate) use labels::Labels;
pub(crate) use loops::{Loops, in_lanes};
pub(crate) use names::{Names, symbol_name};
pub(crate) use scheduler::{Scheduler, Tiers};
pub(crate) use step::{Residual, Step};

//! Expressions → straight-line instructions in tiers. Each value is computed once, in the earliest
//! tier in which its inputs are known.
//!
//! Input: the expressions that a back end needs. Output: a [`Program`] of two-operand instructions.
//! In sums and products of many operands, the operands of the earliest tiers are combined first. So
//! values that depend on parameters and h alone are computed once for all steps, and values that
//! depend on the state are computed outside of the iteration. Invariant: an instruction's operands
//! precede it and are of its tier or an earlier one.
//!
//! This stage decides everything that a back end prints: the program of a step, its costs, the
//! values that a trajectory carries, the names of its values, and the loops of a step in lanes.

mod angles;
mod carry;
mod costs;
mod factors;
mod instructions;
mod kernel;
mod labels;
pub(crate) mod limits;
mod loops;
mod names;
mod numbering;
mod scheduler;
mod step;
mod sums;
#[cfg(test)]
pub(crate) mod tests;

pub(crate) use carry::Carried;
pub(crate) use costs::{Operations, Work};
pub(crate) use factors::Factored;
pub(crate) use instructions::{Operation, Program, Tier, Value, operands};
pub(crate) use kernel::{Array, Kernel, Shape, entries};
pub(crate) use labels::Labels;
pub(crate) use loops::{Loops, in_lanes, is_single};
pub(crate) use names::{Names, symbol_name};
pub(crate) use scheduler::{Scheduler, Tiers};
pub(crate) use step::{Residual, Step};

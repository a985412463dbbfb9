//! The results of the derivation as text: the system, its equations of motion, the discrete action
//! of a rule, and the equations of its step.
//!
//! Input: the outputs of the stages. Output: lines of readable mathematics for doc comments and for
//! the plan, of bounded length. Each formula is printed from the expression that is differentiated
//! or scheduled, so the text shows what the step computes. `docs/mathematics.md`, section 1, has
//! the equations of motion.
//!
//! # Notation
//!
//! - Time levels are subscripts, `q₀` and `q₁`, start and end of a step; components are in
//!   brackets, `q₀[2]`, as in the source. A single coordinate has none: `q`, `v`, `p`.
//! - `q̄`, `t̄` are the node of the midpoint rule; `q̂`, `v̂` the predicted end of `taylor2`, where
//!   `a` is the acceleration and `μ`, `ν` are multipliers. `Δq = q₁ − q₀`; `ΔW[a]` is the increment
//!   of process `a`, in the order of `dw`.
//! - Parameters have the names of their fields; `self.` stands in front if the notation uses the
//!   name for something else.
//! - `s1`, `c1`, `r1`, `f1`, `u1`, …: sines, cosines, roots, other functions and sums that occur
//!   more than once in long formulas.

mod action;
mod gauss;
mod motion;
mod names;
mod page;
mod scene;
mod step;
mod system;

pub(crate) use gauss::gauss;
pub(crate) use scene::{SceneTexts, scene};
pub(crate) use step::{StepTexts, step};
pub(crate) use system::{SystemTexts, symmetry_caveat, system};

/// Number of lines that are shown of a list longer than [`ALL`].
const SOME: usize = 3;

/// Largest length of a list that is shown whole.
const ALL: usize = 4;

/// Returns the number of lines that are shown of a list.
fn shown(length: usize) -> usize {
    if length <= ALL { length } else { SOME }
}

//! Discrete action → equations of the step, and their linearisation around a solution.

mod chart;
mod constrained;
pub(crate) mod equations;
pub(crate) mod node_bounds;
pub(crate) mod stages;
pub(crate) mod tangent;

//! Discrete action → equations of the step.

mod constrained;
pub(crate) mod equations;
pub(crate) mod node_bounds;
pub(crate) mod stages;

//! Discrete action → equations of the step, and the step to first order around a solution.

pub(crate) mod equations;
pub(crate) mod stages;
pub(crate) mod tangent;

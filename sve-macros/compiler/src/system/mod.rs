//! What a system is: symbols and formulas, derivatives, and what is checked of them before any rule.

pub(crate) mod mechanics;
pub(crate) mod model;
pub(crate) mod regular;
pub(crate) mod symmetry;

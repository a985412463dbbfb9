//! Holonomic constraints.

mod reference;
mod plan;

//! Holonomic constraints.

mod reference;

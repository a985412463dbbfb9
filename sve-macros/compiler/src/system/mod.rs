//! The mechanical system: its symbols and formulas, their derivatives, and the checks that do not
//! depend on a rule.

pub(crate) mod applicable;
pub(crate) mod classify;
pub(crate) mod commutation;
pub(crate) mod constraints;
pub(crate) mod degeneracy;
pub(crate) mod drag;
pub(crate) mod energy;
pub(crate) mod euler;
pub(crate) mod functions;
pub(crate) mod inverse_mass;
pub(crate) mod mechanics;
pub(crate) mod regular;
pub(crate) mod size;
pub(crate) mod symmetry;

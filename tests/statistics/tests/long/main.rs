//! Long paths: energies and momenta wander by rounding and do not drift.

mod paths;
mod walks;

//! A step and its derivatives: right values, exact identities, rounding, units, and errors.

mod backwards;
mod cancellation;
mod closed_forms;
mod compositions;
mod derivatives;
mod failures;
mod forces;
mod momentum;
mod reference;
mod scales;
mod small_steps;
mod symplectic;
mod tangent;
mod units;
mod unresolved;
mod vanishing_mass;
mod verlet;
mod walks;
mod weak2;
mod weak_coupling;

//! A step and its derivatives: right values, exact identities, rounding, units, and errors.

mod backwards;
mod cancellation;
mod closed_forms;
mod compositions;
mod derivatives;
mod failures;
mod forces;
mod inputs;
mod inputs_along_paths;
mod inputs_in_all_functions;
mod inputs_of_blocks;
mod literals;
mod momentum;
mod noise_forces;
mod reference;
mod tangent;
mod units;
mod unresolved;
mod vanishing_mass;
mod verlet;

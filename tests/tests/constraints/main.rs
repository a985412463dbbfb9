//! Holonomic constraints: steps, what they preserve, what they refuse, and their forces.

mod compositions;
mod drift;
mod ensembles;
mod errors;
mod folds;
mod forces;
mod friction;
mod lane_failures;
mod lanes;
mod path;
mod plan;
mod preserved;
mod rattle;
mod reference;
mod rest;
mod roots;
mod starts;
mod symplectic;
mod systems;
mod timed;
mod vanishing;

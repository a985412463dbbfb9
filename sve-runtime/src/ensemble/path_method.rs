//! Methods whose paths an ensemble runs.

use crate::method::OneStepMethod;
use crate::system::{Increments, System};

/// A [`OneStepMethod`] for a system of fixed sizes, whose paths an ensemble runs: every
/// [`Method`](crate::Method), and every rule with [stage noise](crate::StageNoise).
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no paths for an ensemble",
    note = "an ensemble runs a method for a system of fixed sizes: an `Integrator` or a baseline",
    note = "systems whose `q` is a slice, and systems with a time scale, have single steps and trajectories: let `rayon` or another library run trajectories side by side"
)]
pub trait PathMethod: OneStepMethod<System: System, Increments: Increments> {}

#[diagnostic::do_not_recommend]
impl<I: OneStepMethod<System: System, Increments: Increments>> PathMethod for I {}

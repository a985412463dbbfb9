//! Lagrangians that do not determine every velocity.

mod plans;
mod reference;
mod systems;
mod two_form;

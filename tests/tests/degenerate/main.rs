//! Lagrangians that do not determine every velocity.

mod paths;
mod plans;
mod reference;
mod states;
mod two_form;

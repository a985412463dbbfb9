//! Lagrangians that do not determine every velocity.

mod reference;
mod systems;

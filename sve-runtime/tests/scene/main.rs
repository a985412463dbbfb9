//! Steps of scenes of any size, through the interface of generated code.

mod by_hand;
mod failures;
mod gathered;
mod integrators;
mod scenes;
mod undo;

//! Steps of scenes of any size, through the interface of generated code.

mod failures;
mod gathered;
mod integrators;
mod scenes;
mod undo;

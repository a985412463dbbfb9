//! Solvers for the equations of a step. Nothing here knows mechanics.
//!
//! | module | solves |
//! | --- | --- |
//! | [`dense`] | a linear system of a size known at compile time |
//! | [`banded`] | the same with a banded matrix |
//! | [`diagonal`] | the same with a diagonal matrix |
//! | [`cofactors`] | the same with three rows, by Cramer's rule |
//! | [`deficiency`] | no system: names the equation that makes a matrix singular |
//! | [`lu`] | a dense linear system of a size known at run time, for many right-hand sides |
//! | [`newton`] | a system of nonlinear equations |
//! | [`regularity`] | no system: decides whether all matrices of an interval matrix are regular |
//!
//! The versions that treat many states at once are in [`lanes`](crate::lanes).

pub(crate) mod banded;
pub(crate) mod cofactors;
pub(crate) mod deficiency;
pub(crate) mod dense;
pub(crate) mod diagonal;
mod error;
pub(crate) mod lu;
pub(crate) mod newton;
pub(crate) mod regularity;

pub use error::{MomentumVelocities, SingularRow, SolveError};

//! The language of a body with vectors, matrices and rotations of nalgebra. The derived value
//! equals the user's function, and the derived derivatives equal its difference quotients.

// bodies may have references and copies wherever nalgebra takes them
#![allow(clippy::op_ref, clippy::clone_on_copy, clippy::needless_borrow)]

mod matrices;
mod roles;
mod rotations;
mod vectors;

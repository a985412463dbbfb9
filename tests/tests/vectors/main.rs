//! The language of a body with vectors, matrices and rotations of nalgebra: the derived value is the user's own function, the
//! derived derivatives are its differences.

// bodies may have references and copies wherever nalgebra takes them
#![allow(clippy::op_ref, clippy::clone_on_copy, clippy::needless_borrow)]

mod matrices;
mod roles;
mod rotations;
mod vectors;

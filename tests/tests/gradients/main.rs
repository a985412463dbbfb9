//! Gradients along paths: the discrete adjoint of a loss, and gradients of means of ensembles.

// closures are written as users write them
#![allow(clippy::redundant_closure_for_method_calls)]

mod adjoint;
mod ensembles;
mod lanes;
mod likelihood;
mod many_coordinates;
mod means;
mod moments;

//! Baselines and mechanics on systems whose derivatives are written by hand.

mod baoab;
mod convergence;
mod failures;
mod increments;
mod mechanics;
mod models;
mod random;
mod steps;

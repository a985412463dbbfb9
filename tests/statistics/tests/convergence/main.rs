//! Orders of convergence, and moments of paths with noise.

mod kubo;
mod moments;
mod stage_noise;
mod rotations;
mod strong_order;
mod weak_order;

//! Orders of convergence, and moments of paths with noise.

mod commuting;
mod compositions;
mod constrained;
mod degenerate;
mod kubo;
mod moments;
mod noise_forces;
mod rotations;
mod stage_noise;
mod strong_order;
mod weak_order;

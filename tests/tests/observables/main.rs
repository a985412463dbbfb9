//! Quantities that are read off paths: sections and events, temperatures and other averages,
//! weights of paths.

mod averages;
mod changes;
mod constrained;
mod feynman_kac;
mod noise;
mod sections;
mod systems;

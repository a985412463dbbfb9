//! The sources of noise: what they promise, recorded and refined paths, and the distribution of the increments.

mod distribution;
mod recorded;
mod refined;
mod sources;
mod statistics;

//! Ensembles: what a summary says against paths integrated one by one, and that threads and shards change no bit of it.

// closures are written as users write them
#![allow(clippy::redundant_closure_for_method_calls)]

mod checkpoints;
mod divergence;
mod exact;
mod failures;
mod files;
mod memory;
mod naive;
mod settings;
mod shards;
mod statistics;
mod threads;

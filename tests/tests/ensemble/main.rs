//! Ensembles: summaries against paths that are integrated one by one. Threads and shards do not
//! change the bits of a summary.

// closures are written as users write them
#![allow(clippy::redundant_closure_for_method_calls)]

mod antithetic;
mod checkpoints;
mod divergence;
mod exact;
mod failures;
mod files;
mod inputs;
mod inputs_of_observers;
mod joint;
mod memory;
mod multilevel;
mod naive;
mod other_runs;
mod passage_files;
mod passages;
mod quantiles;
mod rare;
mod refined;
mod runs;
mod settings;
mod shards;
mod stage_noise;
mod statistics;
mod stopped;
mod survival;
mod sweeps;
mod unwritable;
mod zeros;

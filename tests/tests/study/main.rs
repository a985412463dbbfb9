//! Work–precision studies.

mod report;
mod settings;
mod stage_noise;
mod threads;
mod without_noise;

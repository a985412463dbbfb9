//! Work–precision studies.

mod report;
mod settings;
mod threads;
mod without_noise;

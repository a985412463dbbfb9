//! The options of a run, checked.

use std::path::PathBuf;

use clap::Parser;

/// The horizon of the paper's figures.
pub(crate) const PAPER_HORIZON: f64 = 2000.0;
/// The step size of the paper's figures.
pub(crate) const H: f64 = 0.1;

/// Draws figures 1 to 4 of a text called "Stochastic Variational Integrators" (not Bou-Rabee and
/// Owhadi's, which it cites) from integrators derived at compile time, and compares numbers with
/// what its schemes must give. Ends with status 1 where one is off.
#[derive(Clone, Debug, Parser)]
#[command(name = "paper")]
pub(crate) struct Options {
    /// Seed of the Wiener paths
    #[arg(long, default_value_t = 42)]
    pub(crate) seed: u64,
    /// Paths in figure 3
    #[arg(long, default_value_t = 100, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub(crate) paths: u32,
    /// Time at which the runs end; the step size is 0.1
    #[arg(long, default_value_t = PAPER_HORIZON, value_parser = horizon)]
    pub(crate) horizon: f64,
    /// Folder for figures, data and page
    #[arg(long, default_value = "target/paper")]
    pub(crate) out: PathBuf,
}

fn horizon(text: &str) -> Result<f64, String> {
    let t: f64 = text.parse().map_err(|e| format!("{e}"))?;
    // Below this range hardly a revolution is visible; above it a run takes too much memory for a
    // figure.
    if (10.0..=1e5).contains(&t) {
        Ok(t)
    } else {
        Err("the horizon has to be between 10 and 100000".to_owned())
    }
}

/// Returns the number of the step that ends at a time, which is not negative.
#[allow(clippy::cast_sign_loss)]
pub(crate) fn step_of(t: f64) -> usize {
    (t / H).round() as usize
}

impl Options {
    /// Returns the number of steps to the horizon.
    pub(crate) fn steps(&self) -> usize {
        step_of(self.horizon)
    }

    /// Returns whether numbers stated for the paper's horizon can be compared.
    pub(crate) fn paper_horizon(&self) -> bool {
        self.horizon == PAPER_HORIZON
    }
}

//! Shared code of the example programs: pages with figures, and checks of measured numbers.
//!
//! A program describes a [`Figure`](figure::Figure), [`report`] draws it, and [`check`] compares
//! measured with expected numbers. [`gaussian`] computes expectations of linear schemes without
//! Monte Carlo.

pub mod cells;
pub mod check;
pub mod directions;
pub mod envelope;
pub mod gaussian;
pub mod hues;
pub mod machine;
pub mod page;
pub mod render;
pub mod report;
pub mod shades;

pub use sve_runtime::plot::{figure, palette};

#[cfg(test)]
mod documents;

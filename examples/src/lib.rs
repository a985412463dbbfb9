//! Shared code of the example programs: figures as data, their drawing, and checks of measured numbers.
//!
//! A program describes a [`Figure`](figure::Figure), [`render`] turns it into SVG and PNG with an embedded font (so that
//! it looks the same on a machine without fonts or display), and [`check`] compares what was measured with what was
//! expected. [`gaussian`] computes expectations of linear schemes without Monte Carlo.

mod axes;
pub mod check;
mod clip;
mod draw;
pub mod figure;
pub mod gaussian;
pub mod page;
pub mod palette;
mod raster;
pub mod render;
pub mod report;

#[cfg(test)]
mod documents;

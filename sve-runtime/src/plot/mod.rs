//! Pictures: figures as data, drawn into SVG and PNG, and pages that show the results of ensembles
//! and studies.
//!
//! A program describes a [`Figure`](figure::Figure), [`render`] turns it into SVG and PNG with an
//! embedded font, so that it looks the same on a machine without fonts or display.
//! `Report::write_html` of a study and `Summary::write_html` of an ensemble write a page with one
//! call.
//!
//! ```
//! use sve_runtime::plot::figure::{Axis, Figure, Layer, Panel, Pen, Row};
//! use sve_runtime::plot::{palette, render};
//!
//! # fn main() -> Result<(), sve_runtime::plot::PlotError> {
//! let wave = (0..=100).map(|k| 0.0628 * f64::from(k)).map(|x| (x, x.sin())).collect();
//! let panel = Panel::new("A wave", Axis::angle("angle", 0.0..6.3), Axis::new("sine", -1.1..1.1))
//!     .with(Layer::new("sin", wave, Pen::line(palette::BLUE, 2.0)));
//! let rows = vec![Row { height: 300, panels: vec![panel] }];
//! let figure = Figure { name: "wave", width: 480, rows };
//! assert!(render::svg(&figure)?.starts_with("<svg"));
//! # Ok(())
//! # }
//! ```

mod axes;
#[cfg(feature = "ensemble")]
mod bounds;
mod build;
mod clip;
mod draw;
#[cfg(feature = "ensemble")]
mod ensemble;
mod error;
pub mod figure;
mod labels;
#[cfg(test)]
mod layout_tests;
mod legend;
mod limits;
mod numbers;
#[doc(hidden)]
pub mod page;
pub mod palette;
mod raster;
pub mod render;
mod spread;
#[cfg(feature = "study")]
mod study;
mod text;
mod vision;

pub use error::PlotError;

//! Figures as SVG and PNG, drawn if no two of their series differ by their hue alone.

use sve_runtime::plot::{PlotError, figure::Figure, render};

/// Returns the figure as an SVG document that can also stand inside an HTML page.
///
/// # Errors
/// If it cannot be drawn, or two of its series differ by their hue alone.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    figure.check_series()?;
    render::svg(figure)
}

/// Returns the figure as a PNG file.
///
/// # Errors
/// If it cannot be drawn, or two of its series differ by their hue alone.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    figure.check_series()?;
    render::png(figure)
}

//! Figures as SVG and PNG, drawn if no two of their series differ by their hue alone.

use sve_runtime::plot::{PlotError, figure::Figure, render};

/// The figure as an SVG document that can also stand inside an HTML page.
///
/// # Errors
/// When it cannot be drawn, or two of its series differ by their hue alone.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    figure.check_series()?;
    render::svg(figure)
}

/// The figure as a PNG file.
///
/// # Errors
/// When it cannot be drawn, or two of its series differ by their hue alone.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    figure.check_series()?;
    render::png(figure)
}

//! A figure as SVG and PNG.
//!
//! Both are drawn with the same code at `SCALE` device units a CSS pixel: plotters has integer
//! coordinates, and whole CSS pixels would make curves jagged. The font is embedded in the program;
//! SVG names the generic family.

use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;

use super::PlotError;
use super::draw;
use super::figure::Figure;
use super::raster::{self, Raster};
use super::text::prepare_font;

/// Number of device units in a CSS pixel.
pub(crate) const SCALE: u32 = 4;
/// Number of device units averaged into a pixel of the PNG, which then has two pixels for each CSS
/// pixel.
const SMOOTHING: u32 = 2;

fn device_size(figure: &Figure) -> (u32, u32) {
    let (width, height) = figure.size();
    (width * SCALE, height * SCALE)
}

/// Returns the figure as an SVG document that can also stand inside an HTML page.
///
/// # Errors
/// If it cannot be drawn.
pub fn svg(figure: &Figure) -> Result<String, PlotError> {
    prepare_font();
    let mut text = String::new();
    let device = device_size(figure);
    {
        let area = SVGBackend::with_string(&mut text, device).into_drawing_area();
        draw::figure(&area, figure, draw::Detail::Thinned).map_err(PlotError::drawing)?;
        area.present().map_err(PlotError::drawing)?;
    }
    let (width, height) = figure.size();
    // Attributes with their default values would double the size of a dot.
    Ok(text
        .replacen(
            &format!("width=\"{}\" height=\"{}\"", device.0, device.1),
            &format!("width=\"{width}\" height=\"{height}\""),
            1,
        )
        .replace(" opacity=\"1\"", "")
        .replace(" stroke=\"none\" stroke-width=\"1\"", ""))
}

/// Returns the figure as a PNG file.
///
/// # Errors
/// If it cannot be drawn.
pub fn png(figure: &Figure) -> Result<Vec<u8>, PlotError> {
    prepare_font();
    let device = device_size(figure);
    let mut pixels = vec![255; 3 * device.0 as usize * device.1 as usize];
    {
        let area = Raster::new(&mut pixels, device).into_drawing_area();
        draw::figure(&area, figure, draw::Detail::Full).map_err(PlotError::drawing)?;
        area.present().map_err(PlotError::drawing)?;
    }
    raster::png(&pixels, device, SMOOTHING).map_err(PlotError::drawing)
}

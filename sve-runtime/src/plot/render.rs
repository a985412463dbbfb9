//! A figure as SVG and PNG.
//!
//! Both are drawn with the same code at `SCALE` device units a CSS pixel: plotters has integer
//! coordinates, and whole CSS pixels would make curves jagged. The font is embedded in the program;
//! SVG names the generic family.

use std::fmt::Write as _;

use plotters::backend::SVGBackend;
use plotters::drawing::IntoDrawingArea;

use super::PlotError;
use super::draw;
use super::figure::Figure;
use super::raster::{self, Raster};
use super::text::{self, prepare_font};

/// Number of device units in a CSS pixel.
pub(crate) const SCALE: u32 = 4;
/// Number of device units averaged into a pixel of the PNG, which then has two pixels for each CSS
/// pixel.
const SMOOTHING: u32 = 2;

fn device_size(figure: &Figure) -> (u32, u32) {
    let (width, height) = figure.size();
    (width * SCALE, height * SCALE)
}

/// Returns the figure as an SVG document that can also stand inside an HTML page. Of a layer with
/// more than some thousand dots, the document has a part, evenly along the points; areas are drawn
/// with lines.
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
    Ok(raise_exponents(&text)
        .replacen(
            &format!("width=\"{}\" height=\"{}\"", device.0, device.1),
            &format!("width=\"{width}\" height=\"{height}\""),
            1,
        )
        .replace(" opacity=\"1\"", "")
        .replace(" stroke=\"none\" stroke-width=\"1\"", ""))
}

/// Returns an SVG document whose exponents are raised digits; only texts have characters of
/// exponents. Lengths are numbers, since not all programs know units relative to the font.
fn raise_exponents(svg: &str) -> String {
    let mut raised = String::with_capacity(svg.len());
    let (mut size, mut is_raised) = (0.0, false);
    for (is_exponent, part) in text::parts(svg) {
        // Writing into a String cannot fail.
        if is_exponent {
            let (rise, size) = (text::RAISED * size, text::EXPONENT * size);
            let _ = write!(
                raised,
                "<tspan dy=\"-{rise:.1}\" font-size=\"{size:.1}\">{part}</tspan>"
            );
        } else {
            // The next characters of the same text return to its line.
            let end = part.find('<').unwrap_or(part.len());
            let (rest, after) = part.split_at(if is_raised { end } else { 0 });
            if rest.trim().is_empty() {
                raised.push_str(&part);
            } else {
                let fall = text::RAISED * size;
                // Some programs drop a space at the start of an element.
                let (first, rest) = rest
                    .strip_prefix(' ')
                    .map_or(("", rest), |rest| ("\u{a0}", rest));
                let _ = write!(
                    raised,
                    "<tspan dy=\"{fall:.1}\">{first}{rest}</tspan>{after}"
                );
            }
            size = last_font_size(&part).unwrap_or(size);
        }
        is_raised = is_exponent;
    }
    raised
}

/// Returns the last font size of a part of a document.
fn last_font_size(svg: &str) -> Option<f64> {
    let (_, rest) = svg.rsplit_once("font-size=\"")?;
    rest.split_once('"')?.0.parse().ok()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_are_raised() {
        let svg = "<text font-size=\"40\">\n10⁻² m\n</text>\n<text font-size=\"20\">\n5\n</text>";
        let expected = "<text font-size=\"40\">\n10<tspan dy=\"-16.0\" font-size=\"32.0\">−2</tspan>\
             <tspan dy=\"16.0\">\u{a0}m\n</tspan></text>\n<text font-size=\"20\">\n5\n</text>";
        assert_eq!(raise_exponents(svg), expected);
        let plain = "<text font-size=\"40\">\n10²\n</text>";
        let raised =
            "<text font-size=\"40\">\n10<tspan dy=\"-16.0\" font-size=\"32.0\">2</tspan>\n</text>";
        assert_eq!(raise_exponents(plain), raised);
        let two = "<text font-size=\"40\">\nω²⟨Q²⟩\n</text>";
        let raised = "<text font-size=\"40\">\nω<tspan dy=\"-16.0\" font-size=\"32.0\">2</tspan>\
             <tspan dy=\"16.0\">⟨Q</tspan><tspan dy=\"-16.0\" font-size=\"32.0\">2</tspan>\
             <tspan dy=\"16.0\">⟩\n</tspan></text>";
        assert_eq!(raise_exponents(two), raised);
    }
}

//! A drawing backend of plotters on a buffer of pixels, and its PNG.
//!
//! plotters' own bitmap backend fills the outline of a whole thick polyline as one polygon, which
//! is wrong for lines that cross themselves, as orbits do. Here each segment is painted alone: all
//! pixels within half of its width. As in the SVG, a line ends square; its segments have round
//! joints. Drawing at a larger size and averaging makes edges smooth.

use std::convert::Infallible;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

use super::render::SCALE;
use super::text;

type Drawn = Result<(), DrawingErrorKind<Infallible>>;

/// Pixels, three bytes each, rows from the top.
pub(crate) struct Raster<'a> {
    pixels: &'a mut [u8],
    width: u32,
    height: u32,
}

impl<'a> Raster<'a> {
    /// Returns a raster on a buffer of `3 · width · height` bytes.
    pub(crate) fn new(pixels: &'a mut [u8], (width, height): (u32, u32)) -> Self {
        Self {
            pixels,
            width,
            height,
        }
    }

    fn blend(&mut self, (x, y): BackendCoord, color: BackendColor) {
        let (Ok(x), Ok(y)) = (u32::try_from(x), u32::try_from(y)) else {
            return;
        };
        if x >= self.width || y >= self.height {
            return;
        }
        let at = 3 * (y as usize * self.width as usize + x as usize);
        let (r, g, b) = color.rgb;
        for (old, new) in self.pixels[at..at + 3].iter_mut().zip([r, g, b]) {
            let mixed = f64::from(*old) * (1.0 - color.alpha) + f64::from(new) * color.alpha;
            *old = to_byte(mixed);
        }
    }

    /// Paints every pixel within `radius` of the segment. Nothing is painted beyond an end that is
    /// square.
    fn segment(
        &mut self,
        [from, to]: [BackendCoord; 2],
        is_square: [bool; 2],
        radius: f64,
        color: BackendColor,
    ) {
        let reach = radius.ceil() as i32;
        let (x0, y0) = (f64::from(from.0), f64::from(from.1));
        let (dx, dy) = (f64::from(to.0) - x0, f64::from(to.1) - y0);
        let length2 = dx * dx + dy * dy;
        let columns = from.0.min(to.0) - reach..=from.0.max(to.0) + reach;
        for x in columns {
            // The rows of the segment's part above this column, widened by the radius.
            let rows = if dx.abs() > 2.0 * radius {
                let low = ((f64::from(x) - radius - x0) / dx).clamp(0.0, 1.0);
                let high = ((f64::from(x) + radius - x0) / dx).clamp(0.0, 1.0);
                let (a, b) = (y0 + low * dy, y0 + high * dy);
                (a.min(b) as i32 - reach)..=(a.max(b) as i32 + reach + 1)
            } else {
                from.1.min(to.1) - reach..=from.1.max(to.1) + reach
            };
            for y in rows {
                let (px, py) = (f64::from(x) - x0, f64::from(y) - y0);
                let along = if length2 > 0.0 {
                    (px * dx + py * dy) / length2
                } else {
                    0.0
                };
                if (is_square[0] && along < 0.0) || (is_square[1] && along > 1.0) {
                    continue;
                }
                let along = along.clamp(0.0, 1.0);
                let (ex, ey) = (px - along * dx, py - along * dy);
                if ex * ex + ey * ey <= radius * radius {
                    self.blend((x, y), color);
                }
            }
        }
    }
}

impl DrawingBackend for Raster<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    fn ensure_prepared(&mut self) -> Drawn {
        Ok(())
    }

    fn present(&mut self) -> Drawn {
        Ok(())
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Drawn {
        self.blend(point, color);
        Ok(())
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Drawn {
        self.draw_path([from, to], style)
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x0, y0): BackendCoord,
    ) -> Drawn {
        let failed = |e| DrawingErrorKind::FontError(Box::new(e));
        let em = style.size() / text::LINE;
        let size = em / f64::from(SCALE);
        let width = (text::width(text, size) * f64::from(SCALE)).round() as i32;
        let mut dx = match style.anchor().h_pos {
            HPos::Left => 0,
            HPos::Right => -width,
            HPos::Center => -width / 2,
        };
        let height = em as i32;
        let dy = match style.anchor().v_pos {
            VPos::Top => 0,
            // The box has room for descenders, which most labels lack.
            VPos::Center => (SINK * style.size()).round() as i32 - height / 2,
            VPos::Bottom => -height,
        };
        let (transform, BackendColor { alpha, rgb }) = (style.transform(), style.color());
        for part in text::parts(text) {
            let (font, text) = (text::font_of(&part, size), &part.1);
            let ((left, top), (right, _)) = font.layout_box(text).map_err(failed)?;
            let raise = if part.0 {
                // plotters draws the baseline half the size of a font below a point.
                (text::RAISED * em - 0.5 * (style.size() - font.get_size())).round() as i32
            } else {
                0
            };
            let drawn = font.draw(text, (0, 0), |x, y, opacity| {
                let (x, y) = transform.transform(x + dx - left, y + dy - top - raise);
                let alpha = alpha * f64::from(opacity);
                self.draw_pixel((x0 + x, y0 + y), BackendColor { alpha, rgb })
            });
            drawn.map_err(failed)??;
            dx += right - left;
        }
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Drawn {
        let points: Vec<_> = path.into_iter().collect();
        let radius = f64::from(style.stroke_width()) / 2.0;
        let is_open = points.first() != points.last();
        let count = points.len().saturating_sub(1);
        for (k, ends) in points.windows(2).enumerate() {
            let is_square = [is_open && k == 0, is_open && k + 1 == count];
            self.segment([ends[0], ends[1]], is_square, radius, style.color());
        }
        Ok(())
    }
}

/// Distance by which a line of text is moved down, in units of its height, so that its capitals and
/// digits are centred.
const SINK: f64 = 0.1;

/// Returns the PNG of pixels averaged over squares of `factor` × `factor`.
pub(crate) fn png(
    pixels: &[u8],
    (width, height): (u32, u32),
    factor: u32,
) -> Result<Vec<u8>, png::EncodingError> {
    let (columns, rows) = (width / factor, height / factor);
    let mut smooth = Vec::with_capacity(3 * columns as usize * rows as usize);
    for row in 0..rows {
        for column in 0..columns {
            let mut sum = [0_u32; 3];
            for y in row * factor..(row + 1) * factor {
                for x in column * factor..(column + 1) * factor {
                    let at = 3 * (y as usize * width as usize + x as usize);
                    for channel in 0..3 {
                        sum[channel] += u32::from(pixels[at + channel]);
                    }
                }
            }
            smooth.extend(sum.map(|s| to_byte(f64::from(s) / f64::from(factor * factor))));
        }
    }
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, columns, rows);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&smooth)?;
    writer.finish()?;
    Ok(file)
}

#[allow(clippy::cast_sign_loss)] // clamped to the range of a byte
fn to_byte(x: f64) -> u8 {
    x.round().clamp(0.0, 255.0) as u8
}

#[cfg(test)]
mod tests {
    use super::super::draw::stroke;
    use super::super::palette::BLACK;
    use super::*;

    /// Returns a function that says whether a black path 2 CSS pixels wide covers a pixel.
    fn painted(path: &[BackendCoord]) -> impl Fn(usize, usize) -> bool + use<> {
        let mut pixels = vec![255; 3 * 40 * 40];
        let style = stroke(BLACK, 2.0);
        let drawn = Raster::new(&mut pixels, (40, 40)).draw_path(path.iter().copied(), &style);
        assert!(drawn.is_ok());
        move |x, y| pixels[3 * (y * 40 + x)] == 0
    }

    #[test]
    fn a_line_ends_square_and_has_round_joints() {
        let line = painted(&[(10, 10), (20, 10)]);
        assert!(line(10, 7) && line(20, 13));
        assert!(!line(9, 10) && !line(21, 10));
        let corner = painted(&[(10, 10), (20, 10), (20, 30)]);
        assert!(corner(22, 8) && !corner(20, 31));
        let closed = painted(&[(10, 10), (20, 10), (20, 20), (10, 10)]);
        assert!(closed(9, 10));
    }
}

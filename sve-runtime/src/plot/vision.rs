//! Checks whether the series of a panel are distinguishable without colours, or by their colours
//! with the most common colour-vision deficiency.
//!
//! Colours are compared as a reader with deuteranopia sees them: F. Viénot, H. Brettel, J. D.
//! Mollon, "Digital video colourmaps for checking the legibility of displays by dichromats", Color
//! Research & Application 24 (1999). Their lightness is the lightness of CIE 1976.

use super::PlotError;
use super::figure::{Figure, Layer, Pen};
use super::palette::Color;

/// Difference of lightness, out of 100, that is visible between thin lines, also in grey print.
const LIGHTNESS: f64 = 18.0;
/// Ratio of widths that is visible between two lines.
const WIDTH: f64 = 1.5;

impl Figure {
    /// Checks that no two series of a legend differ by their hue alone: they need different
    /// symbols, dashes or widths, or colours that remain of different lightness with deuteranopia.
    ///
    /// # Errors
    /// [`PlotError::Indistinct`] with the first two series that fail the check.
    pub fn check_series(&self) -> Result<(), PlotError> {
        let panels = self.rows.iter().flat_map(|row| &row.panels);
        for panel in panels.filter(|panel| panel.legend.is_some()) {
            let listed: Vec<&Layer> = panel.layers.iter().filter(|layer| layer.listed).collect();
            for (k, first) in listed.iter().enumerate() {
                if let Some(second) = listed[..k].iter().find(|second| alike(first, second)) {
                    return Err(PlotError::Indistinct {
                        panel: panel.title.clone(),
                        first: second.label.clone(),
                        second: first.label.clone(),
                    });
                }
            }
        }
        Ok(())
    }
}

fn alike(first: &Layer, second: &Layer) -> bool {
    let lightness = |layer: &Layer| lightness(with_deuteranopia(layer.pen.color));
    first.is_filled() == second.is_filled()
        && same_marks(&first.pen, &second.pen)
        && (lightness(first) - lightness(second)).abs() < LIGHTNESS
}

fn same_marks(first: &Pen, second: &Pen) -> bool {
    let lines = match (first.line, second.line) {
        (Some(a), Some(b)) => {
            let ratio = a.width.max(b.width) / a.width.min(b.width);
            a.dash == b.dash && ratio < WIDTH
        }
        (None, None) => true,
        _ => false,
    };
    let symbols = match (first.symbol, second.symbol) {
        (Some(a), Some(b)) => {
            let ratio = a.radius.max(b.radius) / a.radius.min(b.radius);
            a.shape == b.shape && ratio < WIDTH
        }
        (None, None) => true,
        _ => false,
    };
    lines && symbols
}

/// Returns the intensities of red, green and blue light, from 0 to 1.
fn light((r, g, b): Color) -> [f64; 3] {
    let channel = |byte: u8| {
        let x = f64::from(byte) / 255.0;
        if x <= 0.040_45 {
            x / 12.92
        } else {
            ((x + 0.055) / 1.055).powf(2.4)
        }
    };
    [channel(r), channel(g), channel(b)]
}

/// Returns the light that a reader with deuteranopia cannot distinguish from the light of a colour.
fn with_deuteranopia(color: Color) -> [f64; 3] {
    let [r, g, b] = light(color);
    let yellow = 0.292_75 * r + 0.707_25 * g;
    [yellow, yellow, (0.022_34 * (g - r) + b).clamp(0.0, 1.0)]
}

/// Returns the CIE 1976 lightness, 0 … 100.
fn lightness([r, g, b]: [f64; 3]) -> f64 {
    let luminance = 0.212_6 * r + 0.715_2 * g + 0.072_2 * b;
    if luminance > (6.0_f64 / 29.0).powi(3) {
        116.0 * luminance.cbrt() - 16.0
    } else {
        luminance * (29.0_f64 / 3.0).powi(3)
    }
}

#[cfg(test)]
mod tests {
    use super::super::figure::{Axis, Corner, Panel, Row, Shape};
    use super::super::palette::{BLACK, BLUE, GREEN, ORANGE, PURPLE, VERMILION};
    use super::*;

    fn figure(pens: [Pen; 2]) -> Figure {
        let axis = || Axis::new("", 0.0..1.0);
        let empty = Panel::new("two", axis(), axis()).legend(Corner::TopLeft);
        let panel = pens.into_iter().enumerate().fold(empty, |panel, (k, pen)| {
            panel.with(Layer::new(k.to_string(), vec![], pen))
        });
        Figure {
            name: "two",
            width: 100,
            rows: vec![Row {
                height: 100,
                panels: vec![panel],
            }],
        }
    }

    #[test]
    fn white_and_black_keep_their_lightness() {
        assert!((lightness(with_deuteranopia((255, 255, 255))) - 100.0).abs() < 0.1);
        assert_eq!(lightness(with_deuteranopia(BLACK)), 0.0);
    }

    /// Checks that a red and a green of the same lightness are one colour to a reader with
    /// deuteranopia.
    #[test]
    fn red_and_green_become_one() {
        let (red, green) = (
            with_deuteranopia((200, 0, 0)),
            with_deuteranopia((0, 129, 0)),
        );
        for (a, b) in red.iter().zip(green) {
            assert!((a - b).abs() < 0.02, "{red:?} {green:?}");
        }
    }

    #[test]
    fn hue_alone_is_not_enough() {
        let lines = |a, b| figure([Pen::line(a, 2.0), Pen::line(b, 2.0)]);
        for (a, b) in [(BLUE, VERMILION), (GREEN, PURPLE), (GREEN, VERMILION)] {
            assert!(lines(a, b).check_series().is_err());
        }
        assert!(lines(BLUE, ORANGE).check_series().is_ok());
        for second in [
            Pen::line(VERMILION, 3.2),
            Pen::dashed(VERMILION, 2.0, (4.0, 3.0)),
            Pen::line(VERMILION, 2.0).symbols(Shape::Cross, 9),
        ] {
            assert!(
                figure([Pen::line(BLUE, 2.0), second])
                    .check_series()
                    .is_ok()
            );
        }
    }
}

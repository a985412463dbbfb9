//! Legends: the listed series, their texts in lines, and their places.
//!
//! Input: the layers of a panel and the width of its axes. Output: a box with a sample of each
//! listed series. Invariant: the box is no wider than its place.

use std::error::Error;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::draw::{Area, draw_line, draw_symbol, font, px, stroke};
use super::figure::{Corner, Layer};
use super::palette;
use super::spread;
use super::text::{LABEL, lines, width};

/// Room for a legend beside the axes, in CSS pixels.
const BESIDE: f64 = 256.0;
/// Height of a line, length of a sample and distances, in CSS pixels.
const LINE: f64 = 16.0;
const SAMPLE: f64 = 30.0;
const GAP: f64 = 6.0;
const FROM_AXES: f64 = 8.0;
/// Factor for fonts of a browser that are wider than the embedded font.
const WIDER: f64 = 1.1;
/// Largest number of lines of a text.
const LINES: usize = 3;

/// The legend of a panel.
pub(crate) struct Legend {
    corner: Corner,
    /// The number and the text of each listed layer.
    entries: Vec<(usize, Vec<String>)>,
    /// Width and height in CSS pixels.
    size: (f64, f64),
}

impl Legend {
    /// Returns the legend of some layers, for axes of this width in CSS pixels.
    pub(crate) fn new(layers: &[Layer], corner: Corner, axes: f64) -> Self {
        let place = match corner {
            Corner::Outside => BESIDE - FROM_AXES,
            _ => axes - FROM_AXES,
        };
        let around = SAMPLE + 3.0 * GAP;
        let widest = ((place - around) / WIDER).max(0.0);
        let listed = layers.iter().enumerate().filter(|(_, layer)| layer.listed);
        let entries: Vec<_> = listed
            .map(|(number, layer)| (number, lines(&layer.label, LABEL, widest, LINES)))
            .collect();
        let texts = entries.iter().flat_map(|(_, lines)| lines);
        let text_width = texts
            .clone()
            .fold(0.0, |widest: f64, line| widest.max(width(line, LABEL)));
        let size = (
            around + WIDER * text_width,
            LINE * texts.count() as f64 + GAP,
        );
        Self {
            corner,
            entries,
            size,
        }
    }

    /// Returns the room that the legend takes right of the axes.
    pub(crate) fn beside(&self) -> f64 {
        if self.corner == Corner::Outside {
            BESIDE
        } else {
            0.0
        }
    }

    /// Returns the room that the legend takes below the axes and their name.
    pub(crate) fn below(&self) -> f64 {
        if self.corner == Corner::Below {
            self.size.1
        } else {
            0.0
        }
    }

    /// Returns this room in whole pixels.
    #[cfg(feature = "study")]
    #[allow(clippy::cast_sign_loss)] // a height
    pub(crate) fn rows_below(&self) -> u32 {
        self.below().ceil() as u32
    }

    /// Draws the legend of layers on axes with these edges.
    pub(crate) fn draw<DB>(
        &self,
        area: &Area<DB>,
        [west, north, east, south]: [i32; 4],
        layers: &[Layer],
    ) -> Result<(), Box<dyn Error>>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let (width, height) = (px(self.size.0), px(self.size.1));
        let left = match self.corner {
            Corner::TopLeft | Corner::BottomLeft => west + px(FROM_AXES),
            Corner::TopRight | Corner::BottomRight => east - width - px(4.0),
            Corner::Outside => east + px(FROM_AXES),
            Corner::Below => west,
        };
        let top = match self.corner {
            Corner::TopLeft | Corner::TopRight | Corner::Outside => north + px(4.0),
            Corner::BottomLeft | Corner::BottomRight => south - height - px(4.0),
            // The place of the legend is at the lower edge of the panel.
            Corner::Below => i32::try_from(area.dim_in_pixel().1)? - height,
        };
        let corners = [(left, top), (left + width, top + height)];
        area.draw(&Rectangle::new(corners, WHITE.filled()))?;
        let style = font(LABEL, palette::BLACK).pos(Pos::new(HPos::Left, VPos::Center));
        let mut line = 0.5;
        for (number, lines) in &self.entries {
            let from = (left + px(GAP), top + px(0.5 * GAP + LINE * line));
            draw_sample(area, from, &layers[*number])?;
            for text in lines {
                let at = (from.0 + px(SAMPLE + GAP), top + px(0.5 * GAP + LINE * line));
                area.draw(&Text::new(&**text, at, style.clone()))?;
                line += 1.0;
            }
        }
        Ok(())
    }
}

/// Draws a line, a symbol and an area in the look of a layer.
fn draw_sample<DB>(
    area: &Area<DB>,
    (from, y): (i32, i32),
    layer: &Layer,
) -> Result<(), Box<dyn Error>>
where
    DB: DrawingBackend,
    DB::ErrorType: 'static,
{
    let to = from + px(SAMPLE);
    if layer.is_filled() {
        let corners = [(from, y - px(4.0)), (to, y + px(4.0))];
        area.draw(&Rectangle::new(corners, spread::style(layer)))?;
    }
    if let Some(stroke_of) = layer.pen.line {
        let style = stroke(layer.pen.color, stroke_of.width.max(1.2));
        draw_line(area, vec![(from, y), (to, y)], stroke_of.dash, style)?;
    }
    if let Some(mut symbols) = layer.pen.symbol {
        symbols.radius = symbols.radius.max(1.5);
        draw_symbol(area, (i32::midpoint(from, to), y), &layer.pen, symbols)?;
    }
    Ok(())
}

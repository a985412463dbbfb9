//! Axes: the map from coordinates to device units, round numbers to label, and their drawing.
//!
//! Done here so that an axis without a finite range is an error: plotters' search for round numbers would not end.

use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::draw::{Area, font, px, stroke};
use super::figure::{Corner, Panel};
use super::labels::{labels, ticks};
use super::palette;

/// Room around the axes, in CSS pixels.
const LEFT: f64 = 62.0;
const BOTTOM: f64 = 44.0;
const TOP: f64 = 30.0;
const RIGHT: f64 = 16.0;
/// Room for a legend outside of them.
const LEGEND: f64 = 256.0;
/// Sizes of text and length of a tick, in CSS pixels.
pub(crate) const LABEL: f64 = 11.0;
const NAME: f64 = 12.0;
const TITLE: f64 = 13.0;
const TICK: f64 = 4.0;
/// Largest distance of a point from the frame, in device units.
const FAR: f64 = 1e8;

/// Where coordinates are on a panel's area.
pub(crate) struct Frame {
    /// Range of the horizontal axis.
    pub(crate) x: Range<f64>,
    /// Range of the vertical axis.
    pub(crate) y: Range<f64>,
    /// Corners in device units: left, top, right, bottom.
    pub(crate) edges: [i32; 4],
}

impl Frame {
    /// The frame of a panel on an area of the given size in device units.
    pub(crate) fn new(panel: &Panel, (width, height): (u32, u32)) -> Result<Self, Box<dyn Error>> {
        let right = match panel.legend {
            Some(Corner::Outside) => RIGHT + LEGEND,
            _ => RIGHT,
        };
        let edges = [
            px(LEFT),
            px(TOP),
            i32::try_from(width)? - px(right),
            i32::try_from(height)? - px(BOTTOM),
        ];
        let (x, y) = (panel.x.range.clone(), panel.y.range.clone());
        if [&x, &y]
            .iter()
            .any(|range| !(length(range) > 0.0 && length(range).is_finite()))
        {
            return Err(format!(
                "the axes {x:?} and {y:?} of “{}” need finite lengths",
                panel.title
            )
            .into());
        }
        let mut frame = Self { x, y, edges };
        let (width, height) = frame.size();
        if width <= 0.0 || height <= 0.0 {
            return Err("a panel is too small for its labels".into());
        }
        if panel.equal {
            let unit = (length(&frame.x) / width).max(length(&frame.y) / height);
            frame.x = widened(&frame.x, unit * width);
            frame.y = widened(&frame.y, unit * height);
        }
        Ok(frame)
    }

    fn size(&self) -> (f64, f64) {
        let [left, top, right, bottom] = self.edges;
        (f64::from(right - left), f64::from(bottom - top))
    }

    /// Device units of a point inside the frame.
    pub(crate) fn device(&self, &(x, y): &(f64, f64)) -> (i32, i32) {
        let (width, height) = self.size();
        let [left, _, _, bottom] = self.edges;
        let units = |part: f64, size: f64| (part * size).round().clamp(-FAR, FAR) as i32;
        (
            left + units((x - self.x.start) / length(&self.x), width),
            bottom - units((y - self.y.start) / length(&self.y), height),
        )
    }

    /// Draws title, axes, ticks and labels.
    pub(crate) fn draw<DB>(&self, area: &Area<DB>, panel: &Panel) -> Result<(), Box<dyn Error>>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let [left, top, right, bottom] = self.edges;
        let line = stroke(palette::BLACK, 1.0);
        let text = |size: f64, h: HPos, v: VPos| font(size, palette::BLACK).pos(Pos::new(h, v));
        let title = text(TITLE, HPos::Left, VPos::Center);
        area.draw(&Text::new(panel.title.clone(), (left, top / 2), title))?;
        area.draw(&PathElement::new(
            vec![(left, top), (left, bottom), (right, bottom)],
            line,
        ))?;
        for x in ticks(&panel.x, &self.x) {
            let (u, _) = self.device(&(x, self.y.start));
            let tick = vec![(u, bottom), (u, bottom + px(TICK / 2.0))];
            area.draw(&PathElement::new(tick, line))?;
        }
        for y in ticks(&panel.y, &self.y) {
            let (_, v) = self.device(&(self.x.start, y));
            let tick = vec![(left - px(TICK / 2.0), v), (left, v)];
            area.draw(&PathElement::new(tick, line))?;
        }
        for (x, label) in labels(&panel.x, &self.x) {
            let (u, _) = self.device(&(x, self.y.start));
            let style = text(LABEL, HPos::Center, VPos::Top);
            area.draw(&PathElement::new(
                vec![(u, bottom), (u, bottom + px(TICK))],
                line,
            ))?;
            area.draw(&Text::new(label, (u, bottom + px(TICK + 4.0)), style))?;
        }
        for (y, label) in labels(&panel.y, &self.y) {
            let (_, v) = self.device(&(self.x.start, y));
            let style = text(LABEL, HPos::Right, VPos::Center);
            area.draw(&PathElement::new(
                vec![(left - px(TICK), v), (left, v)],
                line,
            ))?;
            area.draw(&Text::new(label, (left - px(TICK + 3.0), v), style))?;
        }
        let name = text(NAME, HPos::Center, VPos::Center);
        let under = (i32::midpoint(left, right), bottom + px(BOTTOM - 11.0));
        area.draw(&Text::new(panel.x.name.clone(), under, name.clone()))?;
        let beside = (px(13.0), i32::midpoint(top, bottom));
        let turned = name.transform(FontTransform::Rotate270);
        area.draw(&Text::new(panel.y.name.clone(), beside, turned))?;
        Ok(())
    }
}

pub(super) fn length(range: &Range<f64>) -> f64 {
    range.end - range.start
}

fn widened(range: &Range<f64>, to: f64) -> Range<f64> {
    let middle = f64::midpoint(range.start, range.end);
    middle - to / 2.0..middle + to / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::figure::Axis;

    #[test]
    fn axes_need_a_length() {
        for end in [0.0, f64::NAN, f64::INFINITY] {
            let panel = Panel::new("", Axis::new("", 0.0..end), Axis::new("", 0.0..1.0));
            assert!(Frame::new(&panel, (2000, 2000)).is_err());
        }
    }

    /// A point may be anywhere, and so may a line.
    #[test]
    fn far_points_do_not_overflow() {
        let panel = Panel::new("", Axis::new("", 0.0..1.0), Axis::new("", 0.0..1.0));
        let frame = Frame::new(&panel, (2000, 2000)).unwrap();
        for point in [(1e308, -1e308), (-1e308, 1e308), (f64::INFINITY, f64::NAN)] {
            let (x, y) = frame.device(&point);
            assert!(x.abs() < 1_000_000_000 && y.abs() < 1_000_000_000);
        }
    }
}

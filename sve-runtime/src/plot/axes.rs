//! Axes: the map from coordinates to device units, room for texts, and their drawing.
//!
//! Input: a panel and its size. Output: a [`Frame`] with the texts of its axes. Invariant: no text
//! of a panel touches another text or leaves the panel, for any numbers and names; the room around
//! the axes is measured in the embedded font.
//!
//! This file does not use the axes of plotters, so that an axis without a finite range is an error:
//! plotters' search for round numbers would not end.

use std::error::Error;
use std::ops::Range;

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::draw::{Area, font, px, stroke};
use super::figure::{Axis, Panel};
use super::labels::{Labels, labels, ticks};
use super::legend::Legend;
use super::palette;
use super::render::SCALE;
use super::text::{LABEL, LINE, NAME, TITLE, lines, width};

/// Least room around the axes, in CSS pixels.
const LEFT: f64 = 62.0;
const BOTTOM: f64 = 44.0;
const TOP: f64 = 30.0;
const RIGHT: f64 = 16.0;
/// Length of a tick, in CSS pixels.
const TICK: f64 = 4.0;
/// Distance of the middle of a name from the edge of the panel, in CSS pixels.
const EDGE: f64 = 13.0;
/// Distances from line to line of names and titles, in CSS pixels.
const NAME_LINE: f64 = 15.0;
const TITLE_LINE: f64 = 17.0;
/// Least distances between texts, in CSS pixels.
const GAP: f64 = 4.0;
const BETWEEN_LABELS: f64 = 8.0;
/// Largest number of lines of a name or a title.
const LINES: usize = 3;
/// Number of passes in which the room for texts and the number of labels are fitted to each other.
const PASSES: usize = 3;
/// Largest distance of a point from the frame, in device units.
const FAR: f64 = 1e8;

/// The place of the coordinates on a panel's area, and the texts around the axes.
pub(crate) struct Frame {
    /// Range of the horizontal axis.
    pub(crate) x: Range<f64>,
    /// Range of the vertical axis.
    pub(crate) y: Range<f64>,
    /// Corners in device units: left, top, right, bottom.
    pub(crate) edges: [i32; 4],
    /// The legend, if there is one.
    pub(crate) legend: Option<Legend>,
    x_labels: Labels,
    y_labels: Labels,
    title: Vec<String>,
    x_name: Vec<String>,
    y_name: Vec<String>,
}

impl Frame {
    /// Returns the frame of a panel on an area of the given size in device units.
    pub(crate) fn new(panel: &Panel, (width, height): (u32, u32)) -> Result<Self, Box<dyn Error>> {
        let (width, height) = (i32::try_from(width)?, i32::try_from(height)?);
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
        let mut frame = Self {
            x,
            y,
            edges: [px(LEFT), px(TOP), width - px(RIGHT), height - px(BOTTOM)],
            legend: None,
            x_labels: Labels::default(),
            y_labels: Labels::default(),
            title: Vec::new(),
            x_name: Vec::new(),
            y_name: Vec::new(),
        };
        for _ in 0..PASSES {
            frame.fit_texts(panel)?;
            let [left, top, right, bottom] = frame.room().map(px);
            frame.edges = [left, top, width - right, height - bottom];
        }
        frame.fit_texts(panel)?;
        Ok(frame)
    }

    /// Fits texts and ranges to the present size of the axes.
    fn fit_texts(&mut self, panel: &Panel) -> Result<(), Box<dyn Error>> {
        let (width, height) = self.size();
        if width <= 0.0 || height <= 0.0 {
            return Err("a panel is too small for its labels".into());
        }
        (self.x, self.y) = (panel.x.range.clone(), panel.y.range.clone());
        if panel.equal {
            let unit = (length(&self.x) / width).max(length(&self.y) / height);
            self.x = widened(&self.x, unit * width);
            self.y = widened(&self.y, unit * height);
        }
        let (width, height) = (width / f64::from(SCALE), height / f64::from(SCALE));
        self.legend = (panel.legend).map(|corner| Legend::new(&panel.layers, corner, width));
        let side = |text: &str| self::width(text, LABEL) + BETWEEN_LABELS;
        self.x_labels = fitting(&panel.x, &self.x, width, &side);
        self.y_labels = fitting(&panel.y, &self.y, height, &|_| LINE * LABEL);
        self.title = lines(&panel.title, TITLE, width, LINES);
        self.x_name = lines(&self.x_labels.name(&panel.x.name), NAME, width, LINES);
        self.y_name = lines(&self.y_labels.name(&panel.y.name), NAME, height, LINES);
        Ok(())
    }

    /// Returns the room that the texts need: left, top, right, bottom, in CSS pixels.
    fn room(&self) -> [f64; 4] {
        let more = |lines: &[String]| lines.len().saturating_sub(1) as f64;
        let widths = self
            .y_labels
            .marks
            .iter()
            .map(|(_, text)| width(text, LABEL));
        let name = EDGE + NAME_LINE * (more(&self.y_name) + 0.5);
        let left = name + GAP + widths.fold(0.0, f64::max) + GAP + TICK;
        let end = self.size().0 / f64::from(SCALE);
        let beyond = self.x_labels.marks.iter().map(|(x, text)| {
            let at = (x - self.x.start) / length(&self.x) * end;
            at + 0.5 * width(text, LABEL) - end
        });
        let right = beyond.fold(0.0, f64::max) + GAP;
        let top = TOP + TITLE_LINE * more(&self.title);
        let bottom = self.under() + NAME_LINE * more(&self.x_name);
        let legend = |of: fn(&Legend) -> f64| self.legend.as_ref().map_or(0.0, of);
        let least = if self.y_labels.marks.is_empty() {
            0.0
        } else {
            LEFT
        };
        [
            left.max(least),
            top,
            right.max(RIGHT) + legend(Legend::beside),
            bottom + legend(Legend::below),
        ]
    }

    /// Returns the room for labels and one line of the name under the axes.
    fn under(&self) -> f64 {
        if self.x_labels.marks.is_empty() {
            BOTTOM - LINE * LABEL
        } else {
            BOTTOM
        }
    }

    fn size(&self) -> (f64, f64) {
        let [left, top, right, bottom] = self.edges;
        (f64::from(right - left), f64::from(bottom - top))
    }

    /// Returns the device units of a point inside the frame.
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
        for (x, label) in &self.x_labels.marks {
            let (u, _) = self.device(&(*x, self.y.start));
            let style = text(LABEL, HPos::Center, VPos::Top);
            area.draw(&PathElement::new(
                vec![(u, bottom), (u, bottom + px(TICK))],
                line,
            ))?;
            area.draw(&Text::new(&**label, (u, bottom + px(TICK + GAP)), style))?;
        }
        for (y, label) in &self.y_labels.marks {
            let (_, v) = self.device(&(self.x.start, *y));
            let style = text(LABEL, HPos::Right, VPos::Center);
            area.draw(&PathElement::new(
                vec![(left - px(TICK), v), (left, v)],
                line,
            ))?;
            area.draw(&Text::new(&**label, (left - px(TICK + 3.0), v), style))?;
        }
        self.draw_names(area)
    }

    /// Draws the title and the names of the axes.
    fn draw_names<DB>(&self, area: &Area<DB>) -> Result<(), Box<dyn Error>>
    where
        DB: DrawingBackend,
        DB::ErrorType: 'static,
    {
        let [left, top, right, bottom] = self.edges;
        for (number, line) in self.title.iter().enumerate() {
            let style = text(TITLE, HPos::Left, VPos::Center);
            let height = px(0.5 * TOP + TITLE_LINE * number as f64);
            area.draw(&Text::new(&**line, (left, height), style))?;
        }
        let name = text(NAME, HPos::Center, VPos::Center);
        for (number, line) in self.x_name.iter().enumerate() {
            let height = bottom + px(self.under() - 11.0 + NAME_LINE * number as f64);
            let under = (i32::midpoint(left, right), height);
            area.draw(&Text::new(&**line, under, name.clone()))?;
        }
        let turned = name.transform(FontTransform::Rotate270);
        for (number, line) in self.y_name.iter().enumerate() {
            let beside = px(EDGE + NAME_LINE * number as f64);
            let beside = (beside, i32::midpoint(top, bottom));
            area.draw(&Text::new(&**line, beside, turned.clone()))?;
        }
        Ok(())
    }
}

fn text(size: f64, h: HPos, v: VPos) -> TextStyle<'static> {
    font(size, palette::BLACK).pos(Pos::new(h, v))
}

/// Returns as many labels as an axis asks for, or fewer, so that no label touches the next one on
/// an axis of this length. A label takes up `side` along the axis.
fn fitting(axis: &Axis, range: &Range<f64>, extent: f64, side: &dyn Fn(&str) -> f64) -> Labels {
    let at = |x: f64| (x - range.start) / length(range) * extent;
    let do_fit = |labels: &Labels| {
        labels.marks.windows(2).all(|pair| {
            let room = 0.5 * (side(&pair[0].1) + side(&pair[1].1));
            at(pair[1].0) - at(pair[0].0) >= room
        })
    };
    // No label is narrower than a digit.
    let most = (1..=axis.labels).take_while(|&count| count as f64 * side("0") < extent);
    let mut found = Labels::default();
    for count in (1..=axis.labels.min(most.count().max(1))).rev() {
        found = labels(axis, range, count);
        if do_fit(&found) {
            return found;
        }
    }
    // On an axis of powers the count alone does not determine the labels.
    let all = found.marks.clone();
    for stride in 2..=all.len() {
        found.marks = all.iter().step_by(stride).cloned().collect();
        if do_fit(&found) {
            break;
        }
    }
    found
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

    #[test]
    fn axes_without_labels_are_near_their_names() {
        let frame = |labels| {
            let axis = || Axis {
                labels,
                ..Axis::new("x", 0.0..1.0)
            };
            Frame::new(&Panel::new("", axis(), axis()), (2000, 2000)).unwrap()
        };
        let ([left, top, right, bottom], with) = (frame(0).edges, frame(6).edges);
        assert!(left < with[0] && bottom > with[3], "{left} {bottom}");
        assert_eq!([top, right], [with[1], with[2]]);
    }

    /// Checks that points and lines may be anywhere.
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

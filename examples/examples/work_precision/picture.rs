//! A picture of one question: one panel, with the names of the methods beside their curves.

use sve_examples::figure::{Axis, Figure, Layer, Panel, Pen, Row};
use sve_examples::palette::Color;

use crate::plots::{band, range};

const WIDTH: u32 = 760;
const HEIGHT: u32 = 460;

/// Room for the names beside the curves, as a fraction of the range of times.
const ROOM: f64 = 0.42;

/// Least distance of two names, as a fraction of the range of errors.
const DISTANCE: f64 = 0.05;

/// A method's curve: exponents of its times and errors, from the longest step on.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) pen: Pen,
    pub(crate) points: Vec<(f64, f64)>,
}

/// What a picture shows.
pub(crate) struct Picture<'a> {
    /// File name without extension.
    pub(crate) name: &'static str,
    /// The question.
    pub(crate) title: String,
    pub(crate) x: &'a str,
    pub(crate) y: &'a str,
    /// Exponents of points of a wide band below the curves; empty for no band.
    pub(crate) band: Vec<(f64, f64)>,
    pub(crate) curves: Vec<Named>,
}

impl Picture<'_> {
    pub(crate) fn draw(self) -> Figure {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let mut times = range(points().map(|p| p.0));
        let errors = range(points().map(|p| p.1));
        let names_at = times.end;
        times.end += ROOM * (times.end - times.start);
        let distance = DISTANCE * (errors.end - errors.start);
        let mut panel = Panel::new(
            self.title,
            Axis::powers(self.x, times),
            Axis::powers(self.y, errors),
        );
        if !self.band.is_empty() {
            panel = panel.with(band(self.band).unlisted());
        }
        let mut names = Vec::new();
        for curve in self.curves.into_iter().filter(|c| !c.points.is_empty()) {
            let height = curve.points[curve.points.len() - 1].1;
            names.push((height, curve.name.clone(), curve.pen.color));
            panel = panel.with(Layer::new(curve.name, curve.points, curve.pen).unlisted());
        }
        for (height, name, color) in apart(names, distance) {
            panel = panel.note((names_at, height), name, color);
        }
        Figure {
            name: self.name,
            width: WIDTH,
            rows: vec![Row {
                height: HEIGHT,
                panels: vec![panel],
            }],
        }
    }
}

/// Moves names up until none is nearer to the next one than a distance.
fn apart(mut names: Vec<(f64, String, Color)>, distance: f64) -> Vec<(f64, String, Color)> {
    names.sort_by(|a, b| a.0.total_cmp(&b.0));
    for k in 1..names.len() {
        names[k].0 = names[k].0.max(names[k - 1].0 + distance);
    }
    names
}

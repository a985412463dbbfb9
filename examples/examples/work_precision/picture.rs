//! A picture of one question: one panel, with the names of the methods beside their curves.

use std::ops::Range;

use sve_examples::figure::{Axis, Figure, Layer, Panel, Pen, Row};
use sve_examples::palette;

use crate::plots::{band, range};

const WIDTH: u32 = 760;
const HEIGHT: u32 = 460;

/// Size of the axes in CSS pixels, up to the widths of labels.
const AXES: [f64; 2] = [680.0, 385.0];
/// Mean width of a character, and half the height of a name with room around it, in CSS pixels.
const CHARACTER: f64 = 6.8;
const HALF: f64 = 8.0;
/// Least distance of the middles of two names, in CSS pixels.
const LINE: f64 = 12.5;
/// Length of the leader of a name that nothing is in the way of, and the gap before the name.
const LEADER: f64 = 14.0;
const GAP: f64 = 4.0;
/// Length by which a leader to the right may be longer than one in another direction.
const ASIDE: f64 = 50.0;
/// Distance of points of a curve that a name has to avoid, and of possible places of a name.
const FINE: f64 = 3.0;

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
    /// Exponents of points of the fastest method of sve.
    pub(crate) band: Vec<(f64, f64)>,
    pub(crate) curves: Vec<Named>,
}

/// The text beside a sample of the band, and the length of the sample in CSS pixels.
const OF_BAND: &str = "fastest method of sve";
const SAMPLE: f64 = 30.0;

impl Picture<'_> {
    pub(crate) fn draw(mut self) -> Figure {
        let end = |curve: &Named| curve.points.last().map_or(f64::NAN, |point| point.0);
        self.curves.retain(|curve| !curve.points.is_empty());
        // The names of curves that end farther right are in the way of other names.
        self.curves.sort_by(|a, b| end(b).total_cmp(&end(a)));
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let (mut times, errors) = (range(points().map(|p| p.0)), range(points().map(|p| p.1)));
        let of_band = SAMPLE + room(OF_BAND);
        let names = self.curves.iter().map(|curve| room(&curve.name));
        let room = names.fold(of_band, f64::max);
        times.end += (times.end - times.start) * room / (AXES[0] - room);
        let pixels = Pixels(&times, &errors);
        // Curves end left of the names, so the upper right corner is free.
        let corner = AXES[0] - of_band;
        let [from, to, text] = [0.0, SAMPLE, SAMPLE + LEADER]
            .map(|shift| pixels.inverse((corner + shift, AXES[1] - HALF)));
        let places = places(&self.curves, &pixels);
        let mut panel = Panel::new(
            self.title,
            Axis::powers(self.x, times),
            Axis::powers(self.y, errors),
        )
        .with(band(self.band).unlisted())
        .with(band(vec![from, to]).unlisted())
        .note(text, OF_BAND, palette::GREY);
        for (curve, [end, at]) in self.curves.into_iter().zip(places) {
            let leader = vec![curve.points[curve.points.len() - 1], end];
            let thin = Pen::line(curve.pen.color, 0.8);
            panel = panel
                .with(Layer::new("", leader, thin).unlisted())
                .note(at, curve.name.clone(), curve.pen.color)
                .with(Layer::new(curve.name, curve.points, curve.pen).unlisted());
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

/// Returns the width of a name with its leader.
fn room(name: &str) -> f64 {
    LEADER + GAP + CHARACTER * name.chars().count() as f64
}

/// Axes, which determine places in CSS pixels from the lower left corner.
struct Pixels<'a>(&'a Range<f64>, &'a Range<f64>);

impl Pixels<'_> {
    fn of(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let [width, height] = self.units();
        ((x - self.0.start) / width, (y - self.1.start) / height)
    }

    fn inverse(&self, (u, v): (f64, f64)) -> (f64, f64) {
        let [width, height] = self.units();
        (self.0.start + u * width, self.1.start + v * height)
    }

    /// Returns the lengths of a pixel on the axes.
    fn units(&self) -> [f64; 2] {
        let length = |range: &Range<f64>| range.end - range.start;
        [length(self.0) / AXES[0], length(self.1) / AXES[1]]
    }
}

/// Returns the end of each curve's leader and the place of its name: as near to the curve's last
/// point as the curves and other names permit.
fn places(curves: &[Named], pixels: &Pixels<'_>) -> Vec<[(f64, f64); 2]> {
    let (mut lines, mut names) = (Vec::new(), Vec::new());
    for curve in curves {
        let points: Vec<_> = curve.points.iter().map(|&p| pixels.of(p)).collect();
        lines.extend(points.windows(2).flat_map(|ends| along(ends[0], ends[1])));
    }
    let length = |shift: &(f64, f64)| shift.0.hypot(shift.1);
    let steps = (-20..100).flat_map(|i| (-60..=60).map(move |j| (f64::from(i), f64::from(j))));
    let shifts = steps.map(|(i, j)| (FINE * i, FINE * j));
    let mut shifts: Vec<_> = shifts.filter(|shift| length(shift) >= LEADER).collect();
    let cost = |shift: &(f64, f64)| length(shift) + if shift.0 < LEADER { ASIDE } else { 0.0 };
    shifts.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    let place = |curve: &Named| {
        let last = pixels.of(curve.points[curve.points.len() - 1]);
        let length = room(&curve.name) - LEADER;
        let is_free = |&(u, v): &(f64, f64)| {
            let is_inside = u + length < AXES[0] && HALF < v && v < AXES[1] - 2.0 * HALF;
            let is_near = |points: &[(f64, f64)], distance: f64| {
                let columns = u - GAP..u + length;
                let is_hit =
                    |&(a, b): &(f64, f64)| columns.contains(&a) && (b - v).abs() < distance;
                points.iter().any(is_hit)
            };
            is_inside && !is_near(&lines, HALF) && !is_near(&names, LINE)
        };
        // A leader crosses no name, unless there is no other way to a free place.
        let is_near = |(a, b): (f64, f64)| {
            let is_beside = |&(c, d): &(f64, f64)| (c - a).abs() < FINE && (d - b).abs() < HALF;
            names.iter().any(is_beside)
        };
        let crosses = |&end: &(f64, f64)| along(last, end).any(is_near);
        let ends = shifts
            .iter()
            .map(|shift| (last.0 + shift.0, last.1 + shift.1));
        let mut free = ends.filter(is_free);
        let first = free.clone().next().unwrap_or((last.0 + LEADER, last.1));
        let end = free.find(|end| !crosses(end)).unwrap_or(first);
        let at = (end.0 + GAP, end.1);
        lines.extend(along(last, end));
        names.extend(along(at, (end.0 + length, end.1)));
        [pixels.inverse(end), pixels.inverse(at)]
    };
    curves.iter().map(place).collect()
}

/// Returns points on a segment, with at most the distance [`FINE`] between them.
fn along(from: (f64, f64), to: (f64, f64)) -> impl Iterator<Item = (f64, f64)> {
    let (x, y) = (to.0 - from.0, to.1 - from.1);
    let count = (x.hypot(y) / FINE).ceil();
    let steps = (0..).map(f64::from).take_while(move |k| *k <= count);
    steps.map(move |k| {
        let part = k / count.max(1.0);
        (from.0 + part * x, from.1 + part * y)
    })
}

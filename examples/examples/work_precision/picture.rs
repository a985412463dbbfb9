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
/// Half the width of the band.
const BAND: f64 = 5.5;
/// Least length of the leader of a name, and the gap before the name.
const LEADER: f64 = 14.0;
const GAP: f64 = 4.0;
/// Distance of points of a curve that a name has to avoid.
const FINE: f64 = 3.0;
/// Distance of possible places of a name.
const GRID: f64 = 6.0;

/// Costs of a place of a name beside the length of its leader, as such a length: a leader that
/// does not point to the right, one from the first point of a curve, one that crosses a curve, one
/// that crosses a name, and a name without a free place.
const ASIDE: f64 = 50.0;
const FROM_FIRST: f64 = 20.0;
const ACROSS_CURVE: f64 = 60.0;
const ACROSS_NAME: f64 = 400.0;
const HIDDEN: f64 = 1e4;
/// The same for each pixel right of all curves, and the distance of widths that are tried.
const EMPTY: f64 = 1.5;
const WIDTHS: f64 = 30.0;

/// A method's curve: exponents of its times and errors, from the longest step on.
pub(crate) struct Named {
    pub(crate) name: String,
    pub(crate) pen: Pen,
    pub(crate) points: Vec<(f64, f64)>,
}

/// The contents of a picture.
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
        let (axes, places) = self.layout();
        // The name of the band is in the upper right corner, where curves do not end.
        let corner = AXES[0] - SAMPLE - room(OF_BAND);
        let [from, to, text] = [0.0, SAMPLE, SAMPLE + LEADER]
            .map(|shift| axes.inverse((corner + shift, AXES[1] - HALF)));
        let Axes(times, errors) = axes;
        let mut panel = Panel::new(
            self.title,
            Axis::powers(self.x, times),
            Axis::powers(self.y, errors),
        )
        .with(band(self.band).unlisted())
        .with(band(vec![from, to]).unlisted())
        .note(text, OF_BAND, palette::GREY);
        for (curve, Place { leader, name }) in self.curves.into_iter().zip(places) {
            let thin = Pen::line(curve.pen.color, 0.8);
            panel = panel
                .with(Layer::new("", leader.to_vec(), thin).unlisted())
                .note(name, curve.name.clone(), curve.pen.color)
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

    /// Returns axes, which leave as much room right of the curves as names need, and the places of
    /// the names.
    fn layout(&self) -> (Axes, Vec<Place>) {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let (times, errors) = (range(points().map(|p| p.0)), range(points().map(|p| p.1)));
        let widths = (1..).map(|k| WIDTHS * f64::from(k));
        let of_width = |width: f64| {
            let longer = (times.end - times.start) * width / (AXES[0] - width);
            let axes = Axes(times.start..times.end + longer, errors.clone());
            let (places, cost) = self.places(&axes);
            (axes, places, cost + EMPTY * width)
        };
        let layouts = widths
            .take_while(|width| *width < 0.5 * AXES[0])
            .map(of_width);
        let best = layouts.min_by(|a, b| a.2.total_cmp(&b.2));
        best.map_or_else(
            || (Axes(times, errors), Vec::new()),
            |(axes, places, _)| (axes, places),
        )
    }

    /// Returns the places of the names, and what they cost together.
    fn places(&self, axes: &Axes) -> (Vec<Place>, f64) {
        let pixels = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            let points: Vec<_> = points.iter().map(|&point| axes.of(point)).collect();
            points
                .windows(2)
                .flat_map(|ends| along(ends[0], ends[1]))
                .collect()
        };
        let curves = self
            .curves
            .iter()
            .map(|curve| pixels(&curve.points))
            .collect();
        let mut taken = Taken {
            curves,
            band: pixels(&self.band),
            names: Vec::new(),
        };
        let corner = (AXES[0] - SAMPLE - room(OF_BAND), AXES[1] - HALF);
        let mut total = if taken.is_free(corner, room(OF_BAND)) {
            0.0
        } else {
            HIDDEN
        };
        taken.names.extend(along(corner, (AXES[0], corner.1)));
        let place = |curve: &Named| {
            let ends = [curve.points[curve.points.len() - 1], curve.points[0]];
            let length = room(&curve.name) - LEADER;
            let (from, to, cost) = taken.place(ends.map(|end| axes.of(end)), length);
            total += cost;
            let at = (to.0 + GAP, to.1);
            taken.names.extend(along(at, (to.0 + length, to.1)));
            taken.curves.push(along(from, to).collect());
            Place {
                leader: [from, to].map(|end| axes.inverse(end)),
                name: axes.inverse(at),
            }
        };
        let places = self.curves.iter().map(place).collect();
        (places, total)
    }
}

/// Returns the width of a name with its leader.
fn room(name: &str) -> f64 {
    LEADER + GAP + CHARACTER * name.chars().count() as f64
}

/// A name beside a curve: its leader and where its text begins.
struct Place {
    leader: [(f64, f64); 2],
    name: (f64, f64),
}

/// Axes, which determine places in CSS pixels from the lower left corner.
struct Axes(Range<f64>, Range<f64>);

impl Axes {
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
        [length(&self.0) / AXES[0], length(&self.1) / AXES[1]]
    }
}

/// The places that names have to avoid: points of curves with leaders, of the band and of other
/// names.
struct Taken {
    curves: Vec<Vec<(f64, f64)>>,
    band: Vec<(f64, f64)>,
    names: Vec<(f64, f64)>,
}

impl Taken {
    /// Returns the leader of a name from one of these ends of its curve, and what it costs: as
    /// little as curves and other names permit.
    fn place(&self, ends: [(f64, f64); 2], length: f64) -> ((f64, f64), (f64, f64), f64) {
        let steps = (-10..50).flat_map(|i| (-30..=30).map(move |j| (f64::from(i), f64::from(j))));
        let shifts = steps.map(|(i, j)| (GRID * i, GRID * j));
        let of_shift = |(x, y): (f64, f64)| {
            let cost = x.hypot(y) + if x < LEADER { ASIDE } else { 0.0 };
            let to = ends.map(|end| (end.0 + x, end.1 + y));
            [(ends[0], to[0], cost), (ends[1], to[1], cost + FROM_FIRST)]
        };
        let long = shifts.filter(|(x, y)| x.hypot(*y) >= LEADER);
        let mut leaders: Vec<_> = long.flat_map(of_shift).collect();
        leaders.sort_by(|a, b| a.2.total_cmp(&b.2));
        let mut best = (ends[0], (ends[0].0 + LEADER, ends[0].1), HIDDEN);
        for (from, to, cost) in leaders {
            if cost >= best.2 {
                break;
            }
            if self.is_free(to, length) {
                let cost = cost + self.crossed(from, to);
                if cost < best.2 {
                    best = (from, to, cost);
                }
            }
        }
        best
    }

    fn is_free(&self, (u, v): (f64, f64), length: f64) -> bool {
        let is_inside = u + length <= AXES[0] && HALF < v && v + HALF <= AXES[1];
        let is_near = |points: &[(f64, f64)], distance: f64| {
            let columns = u - GAP..u + length;
            let is_hit = |&(a, b): &(f64, f64)| columns.contains(&a) && (b - v).abs() < distance;
            points.iter().any(is_hit)
        };
        let is_hidden = || self.curves.iter().any(|curve| is_near(curve, HALF));
        is_inside
            && !is_near(&self.names, LINE)
            && !is_near(&self.band, HALF + BAND)
            && !is_hidden()
    }

    /// Returns what it costs that a leader crosses curves and names.
    fn crossed(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
        let leader: Vec<_> = along(from, to).skip(3).collect();
        let crosses = |points: &[(f64, f64)], height: f64| {
            let is_beside = |&(a, b): &(f64, f64)| {
                leader
                    .iter()
                    .any(|(u, v)| (a - u).abs() < FINE && (b - v).abs() < height)
            };
            points.iter().any(is_beside)
        };
        let curves = self.curves.iter().filter(|curve| crosses(curve, FINE));
        let names = if crosses(&self.names, HALF) {
            ACROSS_NAME
        } else {
            0.0
        };
        ACROSS_CURVE * curves.count() as f64 + names
    }
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

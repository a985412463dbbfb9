//! The figure of a problem: errors against time to solution and against the step size, on
//! logarithmic axes.
//!
//! The wide band under the first panel's lines follows the fastest method of sve at each error.

use std::ops::Range;

use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::palette::{self, Color};
use sve_runtime::study::Record;

use crate::look::pen;
use crate::picture::{Named, Picture};
use crate::verdict::{Curve, Winner};

/// Number of standard errors below which a weak error is not distinguishable from zero.
const SIGNIFICANT: f64 = 2.0;

/// The range of errors that an axis can show.
const ERRORS: Range<f64> = 1e-15..30.0;

/// The colour of the band, paler than that of any method.
const BAND: Color = (222, 222, 222);
const WIDTH: u32 = 1240;
const HEIGHT: u32 = 380;

/// Height of an entry of the legends below the panels of the first row.
const ENTRY: u32 = 16;

/// The methods that figures of problems without noise omit, since other methods need less time for
/// every error. The tables have their numbers.
const LEFT_OUT: [&str; 15] = [
    "endpoint",
    "initial point",
    "taylor2",
    "Taylor series 2",
    "Heun",
    "Euler",
    "scipy: Radau",
    "numba: midpoint",
    "numba: symplectic Euler",
    "diffrax: SemiImplicitEuler",
    "diffrax: LeapfrogMidpoint",
    "diffrax: Dopri5",
    "diffrax: Dopri8",
    "diffrax: Kvaerno5",
    "midpoint, Kahan–Li 8",
];

/// The methods of the picture that shows one panel: the first [`MOST`] of these that a problem has.
const IN_PICTURE: [&str; 16] = [
    "midpoint",
    "Störmer–Verlet",
    "Blanes–Moan RKN 6",
    "Gauss 8",
    "Gauss 4, stage noise",
    "heyoka: Taylor",
    "scipy: DOP853",
    "diffrax: SPaRK",
    "diffrax: ShARK",
    "Runge–Kutta 4",
    "numba: Heun",
    "numba: midpoint",
    "numba: symplectic Euler",
    "Heun",
    "Euler–Maruyama",
    "Gauss 2",
];

/// Number of curves whose names have room beside them.
const MOST: usize = 7;

const TIME: &str = "time to solution of one path (s)";

/// A quantity of a record, if it is known.
pub(crate) type Quantity = fn(&Record) -> Option<f64>;

/// One method's records, in order of the step size.
pub(crate) struct Series {
    pub(crate) name: String,
    pub(crate) records: Vec<Record>,
    /// True if the records come from another program.
    pub(crate) is_peer: bool,
}

/// The series that a figure shows.
fn shown(all: &[Series], has_noise: bool) -> Vec<&Series> {
    let shown = |series: &&Series| has_noise || !LEFT_OUT.contains(&&*series.name);
    all.iter().filter(shown).collect()
}

/// Returns the records of each method. Records of other programs have the program's name.
pub(crate) fn series(own: &[Record], peers: &[Record]) -> Vec<Series> {
    let mut all: Vec<Series> = Vec::new();
    for (record, is_peer) in own
        .iter()
        .map(|r| (r, false))
        .chain(peers.iter().map(|r| (r, true)))
    {
        let name = if is_peer {
            let program = record.source.split_whitespace().next();
            format!("{}: {}", program.unwrap_or_default(), record.method)
        } else {
            record.method.clone()
        };
        match all.iter_mut().find(|series| series.name == name) {
            Some(series) => series.records.push(record.clone()),
            None => all.push(Series {
                name,
                records: vec![record.clone()],
                is_peer,
            }),
        }
    }
    all
}

pub(crate) fn time(record: &Record) -> Option<f64> {
    record.time_to_solution_s
}

fn step(record: &Record) -> Option<f64> {
    record.h
}

pub(crate) fn strong(record: &Record) -> Option<f64> {
    record.error
}

fn weak(record: &Record) -> Option<f64> {
    record.weak_error.map(f64::abs)
}

/// Returns zero as the standard error of an exact quantity.
#[allow(clippy::unnecessary_wraps)] // a quantity
fn certain(_: &Record) -> Option<f64> {
    Some(0.0)
}

/// Returns the standard error of a strong error; 0 if there is none.
#[allow(clippy::unnecessary_wraps)] // a quantity
fn strong_spread(record: &Record) -> Option<f64> {
    Some(record.error_se.unwrap_or(0.0))
}

fn weak_spread(record: &Record) -> Option<f64> {
    record.weak_error_se
}

/// Returns an upper bound of the weak error, with the confidence of [`SIGNIFICANT`].
pub(crate) fn weak_bound(record: &Record) -> Option<f64> {
    let (error, spread) = (record.weak_error?.abs(), record.weak_error_se?);
    Some(error.max(SIGNIFICANT * spread))
}

pub(crate) fn largest(record: &Record) -> Option<f64> {
    record.energy_error
}

fn drift(record: &Record) -> Option<f64> {
    record.energy_drift.map(f64::abs)
}

impl Series {
    pub(crate) fn points(&self, x: Quantity, y: Quantity) -> Vec<(f64, f64)> {
        let shown = |y: &f64| ERRORS.contains(y);
        let point = |record: &Record| Some((x(record)?, y(record).filter(shown)?));
        self.records.iter().filter_map(point).collect()
    }

    /// Returns a kind of error against time.
    pub(crate) fn curve(&self, error: Quantity) -> Curve {
        Curve {
            name: self.name.clone(),
            points: self.points(time, error),
        }
    }
}

pub(crate) fn exponents(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    points.iter().map(|(x, y)| (x.log10(), y.log10())).collect()
}

/// Returns the range of some numbers with room around them; a decade if there are no numbers.
pub(crate) fn range(numbers: impl Iterator<Item = f64>) -> Range<f64> {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    });
    if low <= high {
        low - 0.25..high + 0.25
    } else {
        -1.0..0.0
    }
}

/// A kind of error: its name, and the functions that return it and its standard error from a
/// record.
type Kind<'a> = (&'a str, Quantity, Quantity);

/// Draws a panel of one kind of error against another quantity.
fn panel(
    title: String,
    (x_name, x): (&str, Quantity),
    (y_name, y, spread): Kind<'_>,
    all: &[&Series],
) -> Panel {
    let curves: Vec<[Layer; 2]> = all
        .iter()
        .enumerate()
        .map(|(number, series)| {
            let shown = |y: &f64| ERRORS.contains(y);
            let point =
                |record: &Record| Some((x(record)?, y(record).filter(shown)?, spread(record)?));
            // A method without points is in the legend too: its errors are too large or too small
            // to be shown.
            let points = series.records.iter().filter_map(point);
            Layer::errors(series.name.clone(), pen(series, number), points)
        })
        .collect();
    let points = || curves.iter().flatten().flat_map(|layer| &layer.points);
    let mut panel = Panel::new(
        title,
        Axis::powers(x_name, range(points().map(|p| p.0))),
        Axis::powers(y_name, range(points().map(|p| p.1))),
    );
    for layer in curves.into_iter().flatten() {
        panel = panel.with(layer);
    }
    panel
}

/// Adds a short line of each order, below the lowest part of a curve that has this slope.
fn slopes(mut panel: Panel, orders: &[u32]) -> Panel {
    panel.y.range.start -= 0.05 * (panel.y.range.end - panel.y.range.start);
    let (x, y) = (&panel.x.range, &panel.y.range);
    let (width, height) = (x.end - x.start, y.end - y.start);
    let lowest = |part: &[(f64, f64)]| part.iter().copied().min_by(|a, b| a.1.total_cmp(&b.1));
    let curves = panel.layers.clone();
    for order in orders {
        let slope = f64::from(*order);
        let has_slope = |part: &&[(f64, f64)]| {
            let slopes = part
                .windows(2)
                .map(|p| (p[1].1 - p[0].1) / (p[1].0 - p[0].0));
            slopes.clone().all(|found| (found - slope).abs() < 0.2)
        };
        let parts = curves.iter().flat_map(|layer| layer.points.windows(3));
        let ends = parts.filter(has_slope).filter_map(lowest);
        let Some((left, low)) = ends.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            continue;
        };
        let from = (left + 0.02 * width, low - 0.03 * height);
        let length = (0.12 * width).min(0.2 * height / slope);
        let to = (from.0 + length, from.1 + slope * length);
        let at = (
            from.0 + 0.5 * length + 0.01 * width,
            from.1 + 0.4 * slope * length,
        );
        panel = panel
            .with(Layer::new("", vec![from, to], Pen::line(palette::GREY, 1.0)).unlisted())
            .note(at, format!("order {order}"), palette::GREY);
    }
    panel
}

/// The texts and quantities that a figure shows beside the errors at the end.
pub(crate) struct Shown<'a> {
    /// The problem, as a title.
    pub(crate) problem: &'a str,
    /// The norm of the error at the end.
    pub(crate) norm: &'a str,
    /// The observable of the weak error, for problems with noise.
    pub(crate) weak: Option<&'a str>,
    /// The conserved quantity, if there is one.
    pub(crate) invariant: Option<&'a str>,
}

/// Returns the band below the fastest method of sve.
pub(crate) fn band(points: Vec<(f64, f64)>) -> Layer {
    Layer::new("band: fastest method of sve", points, Pen::line(BAND, 11.0))
}

/// Returns the exponents of the least times of sve and their errors.
pub(crate) fn fastest(winners: &[Winner]) -> Vec<(f64, f64)> {
    let trace: Vec<(f64, f64)> = winners.iter().flat_map(|w| w.trace.clone()).collect();
    exponents(&trace)
}

/// Returns the picture of the errors at the end, with few methods.
pub(crate) fn picture(
    name: &'static str,
    all: &[Series],
    winners: &[Winner],
    shown: &Shown<'_>,
) -> Figure {
    let number = |name: &&str| all.iter().position(|series| series.name == **name);
    let numbers = IN_PICTURE.iter().filter_map(number).take(MOST);
    let curves = numbers.map(|number| Named {
        name: all[number].name.clone(),
        pen: pen(&all[number], number),
        points: exponents(&all[number].points(time, strong)),
    });
    Picture {
        name,
        title: format!("Which error in which time? {}", shown.problem),
        x: TIME,
        y: shown.norm,
        band: fastest(winners),
        curves: curves.collect(),
    }
    .draw()
}

/// Draws the figure: strong errors in the first row; weak errors, or errors of the invariant, in
/// the second row. Each panel has its question as the title.
pub(crate) fn figure(
    name: &'static str,
    all: &[Series],
    winners: &[Winner],
    shown: &Shown<'_>,
) -> Figure {
    let all = &self::shown(all, shown.weak.is_some());
    let times = (TIME, time as Quantity);
    let steps = ("step size h", step as Quantity);
    let error: Kind<'_> = (shown.norm, strong, strong_spread);
    let title = format!("{}: which error in which time?", shown.problem);
    let mut first = panel(title, times, error, all);
    first.layers.insert(0, band(fastest(winners)));
    first.legend = Some(Corner::Below);
    let orders: &[u32] = if shown.weak.is_some() {
        &[1, 2, 3]
    } else {
        &[2, 4, 8]
    };
    let title = "Which error with which step size?".to_owned();
    let mut second = slopes(panel(title, steps, error, all), orders).legend(Corner::Below);
    // Each panel of the first row names half of the methods.
    let half = all.len().div_ceil(2);
    let is_of_first = |layer: &Layer| all[..half].iter().any(|series| series.name == layer.label);
    for layer in &mut second.layers {
        layer.listed &= !is_of_first(layer);
    }
    for layer in first.layers.iter_mut().skip(1) {
        layer.listed &= is_of_first(layer);
    }
    let mut rows = vec![vec![first, second]];
    let below = below(all, times, steps, shown);
    if !below.is_empty() {
        rows.push(below);
    }
    // The band has an entry too.
    let heights = [HEIGHT + ENTRY * (half as u32 + 1), HEIGHT];
    let row = |(panels, height)| Row { height, panels };
    Figure {
        name,
        width: WIDTH,
        rows: rows.into_iter().zip(heights).map(row).collect(),
    }
}

/// Draws the second row.
fn below(
    all: &[&Series],
    times: (&str, Quantity),
    steps: (&str, Quantity),
    shown: &Shown<'_>,
) -> Vec<Panel> {
    let mut panels = Vec::new();
    if let Some(observed) = shown.weak {
        let what = format!("|weak error of {observed}|");
        let kind: Kind<'_> = (&what, weak, weak_spread);
        let title = format!("Which weak error of {observed} in which time?");
        panels.push(panel(title, times, kind, all));
        if shown.invariant.is_none() {
            let title = format!("Which weak error of {observed} with which step size?");
            panels.push(panel(title, steps, kind, all));
        }
    }
    if let Some(invariant) = shown.invariant {
        let what = format!("largest |error of {invariant}|");
        let title = format!("Which error of {invariant} in which time?");
        panels.push(panel(title, times, (&what, largest, certain), all));
        if panels.len() < 2 {
            let what = format!("|slope| of the line through {invariant}");
            let title = format!("Which drift of {invariant} in which time?");
            panels.push(panel(title, times, (&what, drift, certain), all));
        }
    }
    panels
}

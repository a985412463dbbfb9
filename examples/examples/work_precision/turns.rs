//! Pictures of the comparison in turns with other programs: one panel a problem, with the names of
//! the methods beside their curves.

use std::error::Error;
use std::path::Path;

use sve_examples::figure::{Figure, Pen, Shape, Stroke, Symbols};
use sve_examples::hues;
use sve_examples::palette::{self, Color};
use sve_runtime::study::Record;

use crate::LARGEST;
use crate::picture::{Named, Picture};
use crate::plots::{Series, exponents, fastest, series, strong, time};
use crate::verdict::{Curve, winners};

/// The problems: their names in files, and what the titles say.
const PROBLEMS: [(&str, &str); 9] = [
    ("pendulum", "Pendulum, t = 2000"),
    (
        "double_pendulum",
        "Double pendulum, first of six starts, t = 10",
    ),
    ("separatrix", "Pendulum at its separatrix, t = 50"),
    ("kepler", "Kepler, e = 0.6, 1,000 periods"),
    ("kepler_90", "Kepler, e = 0.9, 100 periods"),
    ("kepler_99", "Kepler, e = 0.99, 100 periods"),
    (
        "three_bodies",
        "Pythagorean problem of three bodies, t = 20",
    ),
    ("outer_solar_system", "Outer solar system, 10⁶ days"),
    ("quiet_henon_heiles", "Hénon–Heiles, t = 1000"),
];

/// An error counts if so many finer settings have it too: at a zero crossing it is small by chance.
const CONFIRMATIONS: usize = 2;

/// How a method is drawn: its name in records, its name in pictures, and its look.
type Look = (&'static str, &'static str, Color, Shape, Dash);

/// The lengths of dash and gap of a line.
type Dash = Option<(f64, f64)>;

/// The rule of Gauss with a time scale: a darker shade of its hue.
const IN_TIME_SCALE: Color = (126, 52, 94);

/// The lines of paths with a tolerance, and of other programs.
const TOLERANCE: Dash = Some((9.0, 4.0));
const PEER: Dash = Some((1.5, 3.0));

const LOOKS: [Look; 8] = [
    ("fixed", "sve, equal steps", hues::GAUSS, Shape::Plus, None),
    (
        "compensated",
        "sve, equal steps, compensated",
        hues::GAUSS,
        Shape::Circle,
        None,
    ),
    (
        "tolerance",
        "sve, tolerance",
        hues::GAUSS,
        Shape::Disc,
        TOLERANCE,
    ),
    (
        "time_scale",
        "sve, time scale",
        IN_TIME_SCALE,
        Shape::Square,
        None,
    ),
    (
        "time_scale_tolerance",
        "sve, time scale and tolerance",
        IN_TIME_SCALE,
        Shape::Triangle,
        TOLERANCE,
    ),
    ("heyoka: Taylor", "heyoka", hues::HEYOKA, Shape::Disc, PEER),
    (
        "heyoka: Taylor, compensated",
        "heyoka, high accuracy",
        hues::HEYOKA,
        Shape::Circle,
        PEER,
    ),
    ("rebound: IAS15", "IAS15", palette::GREY, Shape::Cross, PEER),
];

/// Writes a picture of each problem whose records are among these.
pub(crate) fn write(records: &[Record], out: &Path) -> Result<(), Box<dyn Error>> {
    for (name, title) in PROBLEMS {
        let (own, others): (Vec<Record>, Vec<Record>) = records
            .iter()
            .filter(|record| record.problem == name)
            .cloned()
            .partition(|record| record.source == "sve");
        let all = series(&own, &others);
        if all.is_empty() {
            continue;
        }
        let figure = figure(name, title, &all);
        let file = out.join(format!("turns-{name}"));
        crate::write(&figure, &file)?;
        println!("wrote {}", file.with_extension("svg").display());
    }
    Ok(())
}

/// Returns the times and errors of the methods, with their looks. Equal steps with and without
/// compensated sums take almost the same time, so the more exact ones are shown.
fn curves(all: &[Series]) -> Vec<(Look, Vec<(f64, f64)>)> {
    let is_compensated = all.iter().any(|series| series.name == "compensated");
    let curve = |look: &Look| {
        let series = all.iter().find(|series| series.name == look.0)?;
        let points = from_fastest(confirmed(&series.points(time, strong)));
        let is_shown = points.len() > 1 && !(look.0 == "fixed" && is_compensated);
        is_shown.then_some((*look, points))
    };
    LOOKS.iter().filter_map(curve).collect()
}

/// Returns the points with the largest error of each setting and the finer ones that confirm it,
/// without the finest settings, which none confirm.
fn confirmed(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let windows = points.windows(CONFIRMATIONS + 1);
    let largest = |window: &[(f64, f64)]| window.iter().map(|p| p.1).fold(f64::MIN, f64::max);
    windows
        .map(|window| (window[0].0, largest(window)))
        .collect()
}

/// Returns the points from the fastest setting on: with longer steps, which need more iterations,
/// the method takes more time.
fn from_fastest(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    let times = points.iter().map(|point| point.0);
    let fastest = times.enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    points.drain(..fastest.map_or(0, |(at, _)| at));
    points
}

fn figure(name: &'static str, title: &str, all: &[Series]) -> Figure {
    let curves = curves(all);
    let own = curves.iter().filter(|(look, _)| look.4 != PEER);
    let own = own.map(|(look, points)| Curve {
        name: look.0.into(),
        points: points.clone(),
    });
    let winners = winners(&own.collect::<Vec<_>>(), LARGEST);
    let named = |((_, name, color, shape, dash), points): &(Look, Vec<_>)| Named {
        name: (*name).into(),
        pen: pen(*color, *shape, *dash),
        points: exponents(points),
    };
    Picture {
        name,
        title: format!("Which error in which time? {title}"),
        x: "processor time of a path (s)",
        y: "error of the coordinates at the end",
        band: fastest(&winners),
        curves: curves.iter().map(named).collect(),
    }
    .draw()
}

fn pen(color: Color, shape: Shape, dash: Dash) -> Pen {
    Pen {
        color,
        line: Some(Stroke {
            width: if dash == PEER { 1.6 } else { 2.2 },
            dash,
        }),
        symbol: Some(Symbols {
            shape,
            radius: 3.0,
            count: None,
        }),
    }
}

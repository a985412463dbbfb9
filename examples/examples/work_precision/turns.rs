//! Pictures of the comparison in turns with other programs: one panel a problem, with the names of
//! the methods beside their curves.

use std::error::Error;
use std::path::Path;

use sve_examples::figure::{Figure, Pen, Shape, Stroke, Symbols};
use sve_examples::palette::{self, Color};
use sve_runtime::study::Record;

use crate::picture::{Named, Picture};
use crate::plots::{Series, exponents, series, strong, time};

/// The problems: their names in files, and what the titles say.
const PROBLEMS: [(&str, &str); 9] = [
    ("pendulum", "Pendulum, t = 2000"),
    ("double_pendulum", "Double pendulum, t = 10"),
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
type Look = (&'static str, &'static str, Color, Shape, bool);

const LOOKS: [Look; 8] = [
    (
        "fixed",
        "sve, equal steps",
        palette::PURPLE,
        Shape::Plus,
        false,
    ),
    (
        "compensated",
        "sve, equal steps, compensated",
        palette::PURPLE,
        Shape::Circle,
        false,
    ),
    (
        "tolerance",
        "sve, tolerance",
        palette::BLUE,
        Shape::Disc,
        false,
    ),
    (
        "time_scale",
        "sve, time scale",
        palette::GREEN,
        Shape::Square,
        false,
    ),
    (
        "time_scale_tolerance",
        "sve, time scale and tolerance",
        palette::VERMILION,
        Shape::Triangle,
        false,
    ),
    (
        "heyoka: Taylor",
        "heyoka",
        palette::ORANGE,
        Shape::Disc,
        true,
    ),
    (
        "heyoka: Taylor, compensated",
        "heyoka, high accuracy",
        palette::ORANGE,
        Shape::Circle,
        true,
    ),
    ("rebound: IAS15", "IAS15", palette::GREY, Shape::Cross, true),
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

/// Returns the curves of the methods, with their looks. Of equal steps with and without compensated
/// sums, which take almost the same time, the more exact ones are shown.
fn curves(all: &[Series]) -> Vec<(Look, Vec<(f64, f64)>)> {
    let is_compensated = all.iter().any(|series| series.name == "compensated");
    let curve = |look: &Look| {
        let series = all.iter().find(|series| series.name == look.0)?;
        let points = confirmed(&exponents(&series.points(time, strong)));
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

fn figure(name: &'static str, title: &str, all: &[Series]) -> Figure {
    let curves = curves(all).into_iter();
    let curves = curves.map(|((_, name, color, shape, is_peer), points)| Named {
        name: name.into(),
        pen: pen(color, shape, is_peer),
        points,
    });
    Picture {
        name,
        title: format!("Which error in which time? {title}"),
        x: "processor time of a path (s)",
        y: "error of the coordinates at the end",
        band: Vec::new(),
        curves: curves.collect(),
    }
    .draw()
}

fn pen(color: Color, shape: Shape, is_peer: bool) -> Pen {
    Pen {
        color,
        line: Some(Stroke {
            width: if is_peer { 1.6 } else { 2.2 },
            dash: is_peer.then_some((1.5, 3.0)),
        }),
        symbol: Some(Symbols {
            shape,
            radius: 3.0,
            count: None,
        }),
    }
}

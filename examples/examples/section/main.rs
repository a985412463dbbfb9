//! Poincaré sections of the system of Hénon and Heiles, without noise and with it.
//!
//! Many starts with one energy are followed to their crossings of x = 0 with a positive velocity.
//! Without noise a start gives a closed curve or a cloud; additive noise moves the energy, and the
//! curves dissolve. Each crossing is a step solved anew with a part of its length. The program
//! compares the crossings with the rule of order 16, checks the local order of each rule, and
//! checks that a repetition with noise has the same bits. Status 1 if a number is off. Writes
//! `target/section/`.

mod accuracy;

use std::error::Error;
use std::fs;
use std::path::Path;
use std::process::ExitCode;

use sve_examples::check::{self, Check};
use sve_examples::figure::{Axis, Figure, Layer, Panel, Pen, Row};
use sve_examples::page::{self, Section};
use sve_examples::render;
use sve_examples::shades::shade;
use sve_runtime::prelude::*;

/// A star in a galaxy (Hénon and Heiles 1964), pushed at random.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HenonHeiles {
    pub(crate) sigma: f64,
}

#[variational(midpoint, stormer_verlet, gauss(2), gauss(4), gauss(8))]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y * y * y / 3.0
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> [f64; 2] {
        [self.sigma * q[0], self.sigma * q[1]]
    }
}

/// The energies of the two columns.
const ENERGIES: [(f64, &str); 2] = [(1.0 / 12.0, "1/12"), (1.0 / 8.0, "1/8")];
/// Strength of the noise of the lower row.
const SIGMA: f64 = 3e-4;
/// Number of crossings of each start.
const CROSSINGS: usize = 400;
/// Step size.
const H: f64 = 0.1;

type Point = State<[f64; 2]>;

/// Returns starts on the section x = 0 with an energy: some on the axis of y, some on the axis of
/// its momentum.
fn starts(energy: f64) -> Vec<Point> {
    let start = |y: f64, p: f64| {
        let rest = 2.0 * energy - y * y + 2.0 * y.powi(3) / 3.0 - p * p;
        (rest > 0.0).then(|| State::new([0.0, y], [rest.sqrt(), p]))
    };
    let on_axis = (-12..=16).filter_map(|k| start(0.04 * f64::from(k), 0.0));
    let both = (-6..=6).filter(|k| *k != 0);
    let off_axis = both.filter_map(|k| start(0.05, 0.065 * f64::from(k)));
    on_axis.chain(off_axis).collect()
}

/// Returns the points (y, `p_y`) of a section, and the largest relative change of the energy.
fn section(sigma: f64, start: Point, path: u64) -> Result<(Vec<(f64, f64)>, f64), StepError> {
    let system = HenonHeiles { sigma };
    let motion = Integrator::new(system, Gauss::<4>);
    let energy = system.hamiltonian(&start)?;
    let (mut points, mut drift) = (Vec::new(), 0.0_f64);
    let crossings = motion
        .trajectory(start, H, Wiener::new(1).path(path))
        .crossings(|_, state| state.q[0])
        .rising()
        .stop_at(|_, state| state.q[0].hypot(state.q[1]) - 1.5);
    for state in crossings.take(CROSSINGS) {
        let state = state?;
        points.push((state.q[1], state.p[1]));
        drift = drift.max((system.hamiltonian(&state)? / energy - 1.0).abs());
    }
    Ok((points, drift))
}

/// Draws a panel with the sections of all starts of an energy. Adds the largest change of the
/// energy to the checks.
fn panel(
    (energy, name): (f64, &str),
    sigma: f64,
    checks: &mut Vec<Check>,
) -> Result<Panel, Box<dyn Error>> {
    let noise = if sigma == 0.0 {
        "without noise".to_owned()
    } else {
        format!("noise σ = {sigma}")
    };
    let title = format!("E = {name}, {noise}");
    let size = if energy < 0.1 { 0.45 } else { 0.6 };
    let y = Axis::new("y", -size + 0.05..size + 0.1);
    let mut panel = Panel::new(&title, y, Axis::new("momentum along y", -size..size));
    let mut largest = 0.0_f64;
    let starts = starts(energy);
    let last = (starts.len() - 1) as f64;
    for (number, start) in starts.into_iter().enumerate() {
        let (points, drift) = section(sigma, start, number as u64)?;
        largest = largest.max(drift);
        let color = shade(number as f64 / last);
        panel = panel.with(Layer::new(
            format!("start {number}"),
            points,
            Pen::dots(color, 0.7),
        ));
    }
    let what = format!("{title}: largest relative change of the energy");
    checks.push(if sigma == 0.0 {
        Check::new(what, largest).near(
            0.0,
            1e-9,
            "`gauss(4)` with h = 0.1 keeps the energy within 10⁻⁹",
        )
    } else {
        Check::new(what, largest).reported("the noise changes the energy")
    });
    Ok(panel)
}

fn run() -> Result<bool, Box<dyn Error>> {
    let folder = Path::new("target/section");
    fs::create_dir_all(folder)?;
    let mut checks = accuracy::checks()?;
    let mut rows = Vec::new();
    for sigma in [0.0, SIGMA] {
        let mut panels = Vec::new();
        for energy in ENERGIES {
            panels.push(panel(energy, sigma, &mut checks)?);
        }
        rows.push(Row {
            height: 480,
            panels,
        });
    }
    let figure = Figure {
        name: "section",
        width: 1080,
        rows,
    };
    println!("{}", check::table("Sections of Hénon and Heiles", &checks));
    fs::write(folder.join("section.svg"), render::svg(&figure)?)?;
    fs::write(folder.join("section.png"), render::png(&figure)?)?;
    fs::write(folder.join("section.csv"), figure.csv())?;
    let caption = "Crossings of x = 0 with a positive velocity: position and momentum along y. Each colour is one start; colours go from blue to red along the starts with increasing y, then along those with increasing momentum.";
    let sections = [Section {
        title: "Poincaré sections",
        svg: &render::panels(&figure)?,
        caption,
        checks: &checks,
    }];
    let html = page::html("Sections of Hénon and Heiles", "", &sections, "");
    fs::write(folder.join("index.html"), html)?;
    println!("wrote {}", folder.join("index.html").display());
    Ok(checks.iter().all(|check| !check.failed()))
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => {
            eprintln!("some of the numbers above are off");
            ExitCode::FAILURE
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

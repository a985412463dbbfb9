//! The dynamic aperture of a storage ring of FODO cells with a sextupole and a ripple of the power
//! supplies.
//!
//! The ring has six cells. A cell is a focusing thin lens, a drift, a defocusing thin lens and a
//! drift; one focusing quadrupole of the ring carries a sextupole. Both transverse planes are
//! tracked, for the reference momentum only: there is no dispersion and no chromaticity. A step of
//! `initial_point` of length 1 is a kick of strengths u, the inputs of the step, followed by a
//! drift. The ripple multiplies each kick by 1 + σ ΔW.
//!
//! `cargo run --release --example ring` draws `target/ring/ring.svg` and `.png`, and exits with
//! status 1 if a number is off.

use std::error::Error;
use std::f64::consts::TAU;
use std::iter::once;
use std::process::ExitCode;

use sve_examples::cells::runs;
use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Layer, Panel, Pen};
use sve_examples::palette::{BLACK, BLUE, ORANGE};
use sve_examples::report::{one_row, report};
use sve_examples::shades::shade;
use sve_runtime::nalgebra::DMatrix;
use sve_runtime::prelude::*;

/// A ring whose magnets are given by the inputs.
struct Ring {
    /// Strength σ of the ripple.
    ripple: f64,
}

#[variational(initial_point)]
impl Ring {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2], u: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) - self.lens(q, u)
    }
    #[gamma]
    fn supplies(&self, q: [f64; 2], u: [f64; 2]) -> f64 {
        -self.ripple * self.lens(q, u)
    }
    /// Potential of a thin lens: a quadrupole of strength u₀ and a sextupole of strength u₁.
    fn lens(&self, q: [f64; 2], u: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * u[0] * (x * x - y * y) + u[1] * (x * x * x - 3.0 * x * y * y) / 3.0
    }
}

/// Strengths of the focusing and of the defocusing quadrupoles, in units of an inverse drift.
const FOCUSING: f64 = 1.2;
const DEFOCUSING: f64 = 1.25;
/// Strength of the sextupole. It sets the unit of length of the transverse coordinates.
const SEXTUPOLE: f64 = 1.0;
/// Strength of the ripple, the standard deviation of the relative error of a kick.
const RIPPLE: f64 = 0.005;
/// Steps of a turn, two for each of six cells, and number of turns.
const CELLS: u64 = 6;
const TURN: u64 = 2 * CELLS;
const TURNS: u64 = 500;
const STEPS: u64 = TURN * TURNS;
/// Distance from the axis at which a particle is lost.
const APERTURE: f64 = 10.0;
/// Size of the plane of starts, |x| < SIZE and 0 < y < SIZE.
const SIZE: f64 = 0.35;
/// Columns of starts of the picture, 100,352 starts, and of the checks, 1058 starts.
const FINE: u64 = 448;
const COARSE: u64 = 46;

type Particle = State<[f64; 2]>;

/// Returns the strengths of the magnets at the start of a step.
fn lattice(step: u64, sextupole: f64) -> [f64; 2] {
    match step % TURN {
        0 => [FOCUSING, sextupole],
        k if k % 2 == 0 => [FOCUSING, 0.0],
        _ => [-DEFOCUSING, 0.0],
    }
}

/// Returns a start on a grid of so many columns. The motion is symmetric in y, so the grid covers
/// half a plane.
fn start(columns: u64, number: u64) -> [f64; 2] {
    let place = |k: u64| SIZE * (2 * k + 1) as f64 / columns as f64;
    [place(number % columns) - SIZE, place(number / columns)]
}

/// Tracks particles from rest until they are lost.
fn track(ripple: f64, sextupole: f64, columns: u64) -> Result<Summary, EnsembleError> {
    let ring = Integrator::new(Ring { ripple }, InitialPoint);
    let ensemble = Ensemble::new(&ring)
        .inputs("lattice", move |_, step, _| lattice(step, sextupole))
        .paths(columns * columns / 2)
        .seed(1)
        .steps(1.0, STEPS)
        .every(STEPS)
        .start(Starts::each(move |number, _| {
            State::new(start(columns, number), [0.0; 2])
        }))
        .stop_at("lost", |_, particle| distance(particle.q) - APERTURE)
        .stop_on_failure(true)
        .keep_final_states(true);
    if ripple == 0.0 {
        ensemble.noise(NoNoise).run()
    } else {
        ensemble.run()
    }
}

fn distance([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

/// Returns the number of whole turns that each start survived, `TURNS` if it was kept.
fn turns(summary: &Summary) -> Vec<u64> {
    let steps = summary.final_states().map(|(_, end)| match end.t {
        t if t < STEPS as f64 => (t.ceil() as i64).unsigned_abs() - 1,
        _ => STEPS,
    });
    steps.map(|step| step / TURN).collect()
}

/// Returns the same number from a loop of kicks and drifts without the library.
fn turns_by_hand([mut x, mut y]: [f64; 2]) -> u64 {
    let [mut px, mut py] = [0.0; 2];
    for step in 0..STEPS {
        let [quadrupole, sextupole] = lattice(step, SEXTUPOLE);
        px -= quadrupole * x + sextupole * (x * x - y * y);
        py += quadrupole * y + sextupole * 2.0 * x * y;
        x += px;
        y += py;
        if distance([x, y]) >= APERTURE {
            return step / TURN;
        }
    }
    TURNS
}

/// Returns the tangent map of the steps with these strengths, in a given ripple.
fn tangent(
    magnets: impl IntoIterator<Item = [f64; 2]>,
    mut particle: Particle,
    increment: f64,
) -> Result<DMatrix<f64>, StepError> {
    let ring = Integrator::new(Ring { ripple: RIPPLE }, InitialPoint);
    let mut map = DMatrix::identity(4, 4);
    for u in magnets {
        let held = ring.holding(&u);
        map = held.tangent(&particle, 1.0, &[increment])?.to_dmatrix() * map;
        held.step(&mut particle, 1.0, &[increment])?;
    }
    Ok(map)
}

/// Returns half the trace of the map of a cell, in both planes.
fn half_traces(focusing: f64, defocusing: f64) -> Result<[f64; 2], StepError> {
    let magnets = [[focusing, 0.0], [-defocusing, 0.0]];
    let map = tangent(magnets, State::new([0.0; 2], [0.0; 2]), 0.0)?;
    Ok([0, 1].map(|plane| 0.5 * (map[(plane, plane)] + map[(plane + 2, plane + 2)])))
}

/// Returns the largest error of ½ tr = 1 − l²/(2f²) over cells with focal lengths ±f.
fn half_trace_error() -> Result<f64, StepError> {
    let mut worst = 0.0_f64;
    for strength in (1..=25).map(|k| 0.1 * f64::from(k)) {
        for half in half_traces(strength, strength)? {
            worst = worst.max((half - (1.0 - 0.5 * strength * strength)).abs());
        }
    }
    Ok(worst)
}

/// Returns the growth rate of the distance in a cell of focal lengths ±1/strength, from 500 cells.
fn growth(strength: f64) -> Result<f64, StepError> {
    let ring = Integrator::new(Ring { ripple: 0.0 }, InitialPoint);
    let first = State::new([0.01; 2], [0.0; 2]);
    let path = ring.trajectory(first, 1.0, NoNoise);
    let path = path.inputs(|step, _| [if step % 2 == 0 { strength } else { -strength }, 0.0]);
    let mut farthest = 0.0_f64;
    for particle in path.take(1000) {
        farthest = farthest.max(distance(particle?.q));
    }
    Ok((farthest / distance(first.q)).ln() / 500.0)
}

/// Returns the largest entry of `MᵀΩM − Ω` for the map M of a turn with sextupole and ripple.
fn symplectic_defect() -> Result<f64, StepError> {
    let magnets = (0..TURN).map(|step| lattice(step, SEXTUPOLE));
    let map = tangent(magnets, State::new([0.2, 0.1], [0.0, 0.05]), 0.7)?;
    let mut omega = DMatrix::zeros(4, 4);
    omega.view_mut((0, 2), (2, 2)).fill_with_identity();
    omega.view_mut((2, 0), (2, 2)).fill_diagonal(-1.0);
    Ok((map.transpose() * &omega * map - omega).amax())
}

/// Returns the particle at the start of each turn on one path of the ensemble.
fn path(ripple: f64, first: [f64; 2], number: u64) -> Result<Vec<Particle>, StepError> {
    let ring = Integrator::new(Ring { ripple }, InitialPoint);
    let first = State::new(first, [0.0; 2]);
    let path = ring.trajectory(first, 1.0, Wiener::new(1).path(number));
    let path = path
        .inputs(|step, _| lattice(step, SEXTUPOLE))
        .stop_at(|_, particle| distance(particle.q) - APERTURE);
    let states = once(Ok(first)).chain(path.take(STEPS as usize));
    states.step_by(TURN as usize).collect()
}

/// Returns the largest difference of the ends of kept particles in the ensemble from those of
/// single trajectories, NaN if no particle was kept.
fn difference(summary: &Summary) -> Result<f64, StepError> {
    let mut worst = f64::NAN;
    for (number, end) in summary.final_states() {
        if end.t == STEPS as f64 {
            let path = path(RIPPLE, start(COARSE, number), number)?;
            let last = path[path.len() - 1];
            let [x, y] = [0, 1].map(|plane| (last.q[plane] - end.q[plane]).abs());
            worst = worst.max(x).max(y);
        }
    }
    Ok(worst)
}

fn kept(turns: &[u64]) -> f64 {
    turns.iter().filter(|&&turns| turns == TURNS).count() as f64
}

fn checks(calm: &[u64], noisy: &[u64]) -> Result<Vec<Check>, Box<dyn Error>> {
    let [linear, bare] = [0.0, SEXTUPOLE].map(|strength| track(0.0, strength, COARSE));
    let [linear, bare, noise] = [linear?, bare?, track(RIPPLE, SEXTUPOLE, COARSE)?];
    let by_hand = (0..bare.paths()).map(|number| turns_by_hand(start(COARSE, number)));
    let others: Vec<_> = by_hand.zip(turns(&bare)).filter(|(a, b)| a != b).collect();
    let fates = others.iter().filter(|(a, b)| a.max(b) == &TURNS).count() as f64;
    let fraction = kept(calm) / calm.len() as f64;
    let tunes = half_traces(FOCUSING, DEFOCUSING)?.map(|half| CELLS as f64 * half.acos() / TAU);
    let lost = linear.paths() as f64 - kept(&turns(&linear));
    let others = others.len() as f64;
    let rate = (0.5_f64 * 2.1 * 2.1 - 1.0).acosh();
    let new = Check::new;
    Ok(vec![
        new("error of half the trace, FODO cell", half_trace_error()?).near(
            0.0,
            1e-14,
            "1 − l²/(2f²)",
        ),
        new("growth rate, l = 1.9 f", growth(1.9)?).near(0.0, 0.01, "stable for l < 2f"),
        new("growth rate, l = 2.1 f", growth(2.1)?).near(rate, 0.01, "eigenvalue"),
        new("horizontal tune", tunes[0]).reported("linear"),
        new("vertical tune", tunes[1]).reported("linear"),
        new("symplectic defect of a turn", symplectic_defect()?).near(0.0, 1e-13, "rounding"),
        new("largest |ensemble − trajectory|", difference(&noise)?).near(0.0, 0.0, "same bits"),
        new("lost or kept unlike a plain loop", fates).near(0.0, 0.0, "of 1058 starts"),
        new("lost in another turn than in a loop", others).near(0.0, 10.0, "chaotic paths"),
        new("lost without sextupole", lost).near(0.0, 0.0, "linear"),
        new("kept with sextupole", fraction).near(0.17, 0.03, "bounded aperture"),
        new("kept in ripple over kept", kept(noisy) / kept(calm)).near(0.53, 0.1, "fewer"),
    ])
}

/// Returns the panel of the starts, coloured by the number of turns that they survived.
fn aperture(title: &str, turns: &[u64]) -> Panel {
    let (x, y) = (-SIZE..SIZE, 0.0..SIZE);
    let fates = turns.iter().map(|turns| match turns {
        TURNS.. => Some(0),
        50.. => Some(1),
        10.. => Some(2),
        _ => None,
    });
    let lines = runs::<3>(&fates.collect::<Vec<_>>(), FINE as usize, &x, &y);
    let labels = [
        ("kept for 500 turns", BLUE),
        ("lost after 50 turns or more", BLACK),
        ("lost after 10 to 49 turns", ORANGE),
    ];
    let panel = Panel::new(title, Axis::new("x", x), Axis::new("y", y));
    let mut panel = panel.equal().legend(Corner::Below);
    for (line, (label, color)) in lines.into_iter().zip(labels) {
        // a row of starts is little more than a pixel high; lines that overlap leave no seams
        let starts = Layer::new(label, line, Pen::line(color, 1.75)).unlisted();
        let sample = Layer::new(label, Vec::new(), Pen::line(color, 8.0));
        panel = panel.with(starts).with(sample);
    }
    panel
}

/// Returns the panel of paths from rest in the horizontal plane, a point for each turn.
fn portrait(title: &str, ripple: f64) -> Result<Panel, StepError> {
    let [x, p] = [
        Axis::new("x", -0.25..0.25),
        Axis::new("momentum along x", -0.15..0.15),
    ];
    let mut panel = Panel::new(title, x, p);
    for number in 1..=12 {
        let path = path(ripple, [0.01 * number as f64, 0.0], number)?;
        let points = path.iter().map(|particle| (particle.q[0], particle.p[0]));
        let pen = Pen::dots(shade(number as f64 / 12.0), 1.0);
        panel = panel.with(Layer::new(format!("path {number}"), points.collect(), pen));
    }
    Ok(panel)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let [calm, noisy] = [0.0, RIPPLE].map(|ripple| track(ripple, SEXTUPOLE, FINE));
    let [calm, noisy] = [turns(&calm?), turns(&noisy?)];
    let starts = vec![
        aperture("Which starts stay, no ripple", &calm),
        aperture("Which starts stay, ripple of 0.5 %", &noisy),
    ];
    let paths = vec![
        portrait("Paths with y = 0, no ripple", 0.0)?,
        portrait("Paths with y = 0, ripple of 0.5 %", RIPPLE)?,
    ];
    let mut figure = one_row("ring", [1080, 358], starts);
    figure.rows.extend(one_row("", [1080, 480], paths).rows);
    let caption = "The ripple is a random error of the strength of the magnets at each kick; the sextupole sets the unit of x and y. Top: starts from rest in the plane of x and y, coloured by the number of turns that they survive; white ones are lost in ten turns. Bottom: paths from rest at x = 0.01 (blue) to 0.12 (red), 500 turns, a point for each turn at the entrance of the sextupole. Seed 1.";
    report(
        "Dynamic aperture of a ring",
        &figure,
        caption,
        &checks(&calm, &noisy)?,
    )
}

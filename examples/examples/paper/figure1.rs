//! Figure 1: level sets of the pendulum, exact, by the second-order Taylor rule, and by the
//! second-order Taylor method.

use std::error::Error;
use std::f64::consts::PI;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::palette;
use sve_examples::report::one_row;
use sve_runtime::baseline::TaylorSeries2;
use sve_runtime::prelude::*;

use crate::Report;
use crate::run::{Run, run};
use crate::settings::{H, Options, step_of};
use crate::systems::Pendulum;

const PENDULUM: Pendulum = Pendulum { g: 9.8 };
/// Starts `(q, p)`: five at rest and two that go round.
const STARTS: [(f64, f64); 7] = [
    (0.5, 0.0),
    (1.0, 0.0),
    (1.5, 0.0),
    (2.0, 0.0),
    (2.5, 0.0),
    (0.0, 7.5),
    (0.0, -7.5),
];
/// Largest energy deviation of the rule over T = 2000 from a start at rest, computed independently
/// by `examples/peers/paper.py`, to the given digits. The text prints no numbers for its figures.
const DEVIATIONS: [(f64, f64, f64); 3] =
    [(0.5, 0.0051, 5e-5), (1.5, 0.062, 5e-4), (2.5, 0.238, 5e-4)];

pub(crate) fn report(options: &Options, tick: &dyn Fn()) -> Result<Report, Box<dyn Error>> {
    let rule = Integrator::new(PENDULUM, Taylor2);
    let series = TaylorSeries2::new(PENDULUM);
    let mut runs = Vec::new();
    for (q, p) in STARTS {
        let start = State::new([q], [p]);
        let by_rule = run(&rule, start, H, NoNoise, options.steps())?;
        let by_series = run(&series, start, H, NoNoise, options.steps())?;
        runs.push((by_rule, by_series));
        tick();
    }
    let mut checks = Vec::new();
    for (q, expected, tolerance) in DEVIATIONS {
        let index = STARTS.iter().position(|start| *start == (q, 0.0));
        let (by_rule, _) = &runs[index.ok_or("a start of figure 1 is missing")?];
        checks.extend(rule_checks(options, q, by_rule, expected, tolerance)?);
    }
    checks.extend(series_checks(options, &runs[1].1)?);
    Ok(Report {
        title: "Figure 1. Pendulum: level sets of the energy",
        figure: draw(&runs),
        caption: format!(
            "H = p²/2 − 9.8 cos q, h = {H}, T = {}. Left: exact level sets, with the separatrix dashed. Middle: the \
             second-order Taylor variational integrator. Right: the second-order Taylor method from the same starts; \
             its vertical axis is longer. Starts: at rest from the angles written in the left panel, and from q = 0 with \
             p = ±7.5. Angles are shown modulo 2π, every fourth state.",
            options.horizon
        ),
        checks,
    })
}

/// Returns the energies of a run.
fn energies(run: &Run) -> Result<Vec<f64>, StepError> {
    run.states.iter().map(|z| PENDULUM.hamiltonian(z)).collect()
}

fn rule_checks(
    options: &Options,
    q: f64,
    run: &Run,
    expected: f64,
    tolerance: f64,
) -> Result<[Check; 2], StepError> {
    let energies = energies(run)?;
    let deviation = |part: &[f64]| {
        part.iter()
            .map(|e| (e - energies[0]).abs())
            .fold(0.0, f64::max)
    };
    let tenth = energies.len() / 10;
    let (first, last) = (&energies[..tenth], &energies[energies.len() - tenth..]);
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = (mean(last) - mean(first)) / deviation(&energies);
    Ok([
        Check::new(format!("Taylor rule from q = {q}: largest energy deviation"), deviation(&energies)).near(expected, tolerance, "computed independently to the digits given; half a unit of the last one")
        .only_if(options.paper_horizon(), "stated for a horizon of 2000"),
        Check::new(format!("Taylor rule from q = {q}: mean energy, last tenth − first tenth, over that deviation"), drift).near(0.0, 0.02, "no drift; a tenth of the run holds about 100 periods, and its mean depends on the phase at its ends")
        .only_if(options.horizon >= 1000.0, "a tenth of the run holds too few periods"),
    ])
}

fn series_checks(options: &Options, run: &Run) -> Result<Vec<Check>, StepError> {
    let energies = energies(run)?;
    let mut checks = vec![
        Check::new("Taylor method from q = 1: energy at t = 0", energies[0]).near(
            -9.8 * 1.0_f64.cos(),
            1e-14,
            "−9.8 cos 1, rounded",
        ),
    ];
    for (t, expected, tolerance) in [(200.0, 45.3, 0.05), (2000.0, 471.0, 0.5)] {
        let step = step_of(t);
        let what = format!("Taylor method from q = 1: energy at t = {t}");
        checks.push(match energies.get(step) {
            Some(&energy) => {
                let reason =
                    "computed independently to the digits given; half a unit of the last one";
                Check::new(what, energy).near(expected, tolerance, reason)
            }
            None => Check::new(what, f64::NAN).reported("not applicable: beyond the horizon"),
        });
    }
    if !options.paper_horizon() {
        let last = energies.last().copied().unwrap_or(f64::NAN);
        let what = format!(
            "Taylor method from q = 1: energy at t = {}",
            options.horizon
        );
        checks.push(
            Check::new(what, last).reported("nothing was computed independently for this horizon"),
        );
    }
    Ok(checks)
}

/// Returns the angle between −π and π.
fn wrap(q: f64) -> f64 {
    (q + PI).rem_euclid(2.0 * PI) - PI
}

/// Returns every fourth state: five thousand dots show an orbit as well as twenty thousand.
fn wrapped(run: &Run) -> Vec<(f64, f64)> {
    run.orbit()
        .into_iter()
        .step_by(4)
        .map(|(q, p)| (wrap(q), p))
        .collect()
}

/// Returns the level set of energy `e` through `q = limit sin s`, upper half with `sign = 1`, lower
/// half with `sign = −1`.
fn level(e: f64, sign: f64) -> Vec<(f64, f64)> {
    let turning = (-e / PENDULUM.g).clamp(-1.0, 1.0).acos();
    (0..=400)
        .map(|k| {
            // The points are dense at the turning points, where p has a square root.
            let q = turning * (PI * (f64::from(k) / 400.0 - 0.5)).sin();
            (q, sign * (2.0 * (e + PENDULUM.g * q.cos())).max(0.0).sqrt())
        })
        .collect()
}

fn name((q, p): (f64, f64)) -> String {
    format!("start q = {q}, p = {p}")
}

fn draw(runs: &[(Run, Run)]) -> Figure {
    let axes = |title: &str, p: f64| {
        Panel::new(
            title,
            Axis::angle("angle q", -PI..PI),
            Axis::new("momentum p", -p..p),
        )
    };
    let energy = |(q, p): (f64, f64)| 0.5 * p * p - PENDULUM.g * q.cos();
    let mut exact = axes("Exact level sets", 9.0);
    for (start, color) in STARTS.into_iter().zip(palette::CYCLE) {
        let pen = Pen::line(color, 1.4);
        let signs: &[f64] = if start.1 == 0.0 {
            &[1.0, -1.0]
        } else {
            &[start.1.signum()]
        };
        let label = if start.1 == 0.0 {
            format!("{:.1}", start.0)
        } else {
            format!("p = {}", start.1)
        };
        // The label is inside the level set where it crosses the axis of angles or momenta.
        let at = if start.1 == 0.0 {
            (start.0 - 0.4, 0.0)
        } else {
            (-0.5, 0.9 * start.1)
        };
        exact = exact.note(at, label.replace('-', "−"), color);
        for sign in signs {
            exact = exact.with(Layer::new(name(start), level(energy(start), *sign), pen));
        }
    }
    let meaning = "numbers: q of a start at rest";
    exact = exact.note((-3.0, -8.4), meaning, palette::BLACK);
    for sign in [1.0, -1.0] {
        let pen = Pen::dashed(palette::GREY, 1.0, (5.0, 4.0));
        exact = exact.with(Layer::new("separatrix", level(PENDULUM.g, sign), pen));
    }
    let highest = runs.iter().flat_map(|(_, series)| &series.states);
    let highest = highest.map(|z| z.p[0].abs()).fold(9.0, f64::max);
    let mut rule = axes("Second-order Taylor variational integrator", 9.0);
    // Leaves room for the legend above the dots.
    let mut series = axes("Second-order Taylor method", 1.3 * highest).legend(Corner::TopRight);
    for (k, (start, color)) in STARTS.into_iter().zip(palette::CYCLE).enumerate() {
        rule = rule.with(Layer::new(
            name(start),
            wrapped(&runs[k].0),
            Pen::dots(color, 0.8),
        ));
        let layer = Layer::new(name(start), wrapped(&runs[k].1), Pen::dots(color, 0.6));
        series = series.with(layer.unlisted());
    }
    for p in [9.0, -9.0] {
        let pen = Pen::dashed(palette::BLACK, 1.6, (5.0, 4.0));
        let edge = Layer::new("range of the other panels", vec![(-PI, p), (PI, p)], pen);
        series = series.with(if p > 0.0 { edge } else { edge.unlisted() });
    }
    one_row("figure1", [1110, 400], vec![exact, rule, series])
}

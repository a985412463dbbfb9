//! Figure 3 with a thousand times as many paths: growth of the mean energy of the stochastic linear
//! oscillator.
//!
//! dq = p dt, dp = −q dt + σ dW: the mean energy is H₀ + σ²t/2. The energies of a linear scheme
//! `z₁ = A z₀ + b ΔW` are quadratic forms of a Gaussian, whose means and variances follow from a
//! recursion; A and b are read off the scheme's own step, so the expectation belongs to the code
//! that ran.

use std::error::Error;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape, Spread};
use sve_examples::gaussian::{ENERGY, Scheme, linear};
use sve_examples::hues;
use sve_examples::palette::{self, Color};
use sve_examples::report::one_row;
use sve_runtime::Method;
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama};
use sve_runtime::prelude::*;

use crate::{Options, Report, mean};

#[derive(Clone, Copy, Debug)]
struct Oscillator {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

const OSCILLATOR: Oscillator = Oscillator { sigma: 1.0 };
const START: [f64; 2] = [1.0, 0.0];
const H: f64 = 0.1;
/// Number of steps between two records.
const EVERY: usize = 10;
/// Number of steps of the variational rules, to the paper's horizon of 2000.
const LONG: usize = 20_000;
/// Number of steps of the baselines. At t = 100 they already show that their energies explode or
/// stagnate.
const SHORT: usize = 1_000;
/// Number of steps of the second panel.
const EARLY: usize = 400;

/// The mean energy of one method, measured and exact, after each [`EVERY`] steps.
struct Curve {
    name: &'static str,
    color: Color,
    shape: Shape,
    variational: bool,
    times: Vec<f64>,
    means: Vec<f64>,
    /// Standard errors from the sample.
    errors: Vec<f64>,
    /// Exact mean and standard error of the mean, after each step.
    exact: Vec<(f64, f64)>,
}

pub(crate) fn report(options: &Options) -> Result<Report, Box<dyn Error>> {
    let curves = [
        curve(
            options,
            "forward Euler–Maruyama",
            (hues::EULER_MARUYAMA, Shape::Cross),
            &EulerMaruyama::new(OSCILLATOR),
            SHORT,
        )?,
        curve(
            options,
            "backward Euler–Maruyama",
            (hues::EULER_MARUYAMA, Shape::Triangle),
            &BackwardEulerMaruyama::new(OSCILLATOR),
            SHORT,
        )?,
        curve(
            options,
            "midpoint rule",
            (hues::MIDPOINT, Shape::Square),
            &Integrator::new(OSCILLATOR, Midpoint),
            LONG,
        )?,
        curve(
            options,
            "initial-point rule",
            (hues::INITIAL_POINT, Shape::Disc),
            &Integrator::new(OSCILLATOR, InitialPoint),
            LONG,
        )?,
        curve(
            options,
            "endpoint rule",
            (hues::ENDPOINT, Shape::Circle),
            &Integrator::new(OSCILLATOR, Endpoint),
            LONG,
        )?,
    ];
    Ok(Report {
        title: "Figure 3 of the paper with many paths: mean energy of the stochastic linear oscillator",
        figure: draw(&curves),
        caption: format!(
            "σ = 1, start (1, 0), h = {H}, {} paths, the same for all methods. Symbols: means over the paths; lines: expectation of each \
             method by its moment recursion. The means of the other symplectic rules are not distinguishable from that of the midpoint rule \
             on the left; the methods of Euler–Maruyama were run to t = {}. The right panel shows their differences, in which the scatter of the paths cancels. Middle: all times have the same \
             paths, so that differences at neighbouring times are alike.",
            options.paths,
            SHORT as f64 * H
        ),
        checks: curves
            .iter()
            .flat_map(|curve| checks(options, curve))
            .collect(),
    })
}

fn curve<I>(
    options: &Options,
    name: &'static str,
    (color, shape): (Color, Shape),
    method: &I,
    steps: usize,
) -> Result<Curve, Box<dyn Error>>
where
    I: Method<System = Oscillator> + Sync,
{
    let summary = Ensemble::new(method)
        .paths(options.paths)
        .seed(options.seed)
        .steps(H, steps as u64)
        .every(EVERY as u64)
        .start(State::new([START[0]], [START[1]]))
        .observe("energy", |_, state| {
            0.5 * (state.q[0] * state.q[0] + state.p[0] * state.p[0])
        })
        .stop_on_failure(true)
        .run()?;
    let exact = Scheme::driven(linear(method, H)?, H)
        .distributions(START)
        .take(steps + 1)
        .map(|law| {
            let (mean, variance) = law.quadratic(&ENERGY);
            (mean, (variance / options.paths as f64).sqrt())
        })
        .collect();
    let energy = &summary["energy"];
    Ok(Curve {
        name,
        color,
        shape,
        variational: steps == LONG,
        times: summary.times().to_vec(),
        means: energy.mean().to_vec(),
        errors: energy.standard_error(),
        exact,
    })
}

fn checks(options: &Options, curve: &Curve) -> Vec<Check> {
    let last = curve.times.len() - 1;
    let mut records = vec![1, 10, 100, last];
    records.retain(|&k| k <= last);
    records.dedup();
    let at = |&k: &usize| {
        let (expected, error) = curve.exact[k * EVERY];
        mean(
            format!("{}: mean energy at t = {:.0}", curve.name, curve.times[k]),
            curve.means[k],
            expected,
            error,
            options.paths,
            "moment recursion",
        )
    };
    let (_, error) = curve.exact[last * EVERY];
    // The kurtosis of a squared radius is at most 9, the kurtosis of one squared coordinate 15: the
    // relative error of the variance is √(14/n).
    let relative = 0.5 * (14.0 / options.paths as f64).sqrt();
    let spread = Check::new(
        format!(
            "{}: standard error of the last, from the sample",
            curve.name
        ),
        curve.errors[last],
    )
    .near(
        error,
        4.5 * relative * error,
        "moment recursion; 4.5 standard deviations of a sample's standard deviation",
    );
    records.iter().map(at).chain([spread]).collect()
}

fn draw(curves: &[Curve]) -> Figure {
    let whole = Panel::new(
        "Linear oscillator: mean energy",
        Axis::powers("time t", 0.0..3.4),
        Axis::powers("mean energy", -0.3..4.0),
    );
    let (euler, rules): (Vec<_>, Vec<_>) = curves.iter().partition(|curve| !curve.variational);
    // The means of the other symplectic rules are not distinguishable from that of the first one.
    let shown = euler.into_iter().chain(rules[..1].iter().copied());
    let whole = shown.fold(whole, means).legend(Corner::Below);
    let others = rules[1..].iter();
    let pairs: Vec<Layer> = others.flat_map(|curve| paired(curve, rules[0])).collect();
    let panels = vec![
        whole,
        early(
            "Midpoint rule: mean energy less its expectation",
            error(rules[0]).into(),
        ),
        early(
            "Mean energy less that of the midpoint rule, same paths",
            pairs,
        ),
    ];
    one_row("energy", [1260, 440], panels)
}

/// Draws layers up to an early time.
fn early(title: &str, layers: Vec<Layer>) -> Panel {
    let values = |layer: &Layer| match &layer.spread {
        Spread::Band(ends) => ends.iter().flat_map(|end| [end.0, end.1]).collect(),
        _ => layer.points.iter().map(|point| point.1).collect::<Vec<_>>(),
    };
    let values = layers.iter().flat_map(values);
    let (low, high) = values.fold((0.0, 1e-3), |(low, high): (f64, f64), value| {
        (low.min(value), high.max(value))
    });
    let panel = Panel::new(
        title,
        Axis::new("time t", 0.0..EARLY as f64 * H),
        Axis::new("difference", 1.1 * low - 0.1 * high..1.1 * high - 0.1 * low),
    );
    layers
        .into_iter()
        .fold(panel, Panel::with)
        .legend(Corner::Below)
}

/// Returns whole numbers that grow by a factor, from 1 up to a last one.
fn growing(factor: f64, last: usize) -> impl Iterator<Item = usize> {
    #[allow(clippy::cast_sign_loss)] // a count
    let next = move |&k: &usize| Some((factor * k as f64).ceil() as usize);
    std::iter::successors(Some(1), next).take_while(move |&k| k <= last)
}

/// Draws means of a method as symbols on its exact line, both by their logarithms.
fn means(panel: Panel, curve: &Curve) -> Panel {
    let line = growing(1.02, curve.exact.len() - 1);
    let line = line.map(|k| ((k as f64 * H).log10(), curve.exact[k].0.log10()));
    let points = growing(1.5, curve.means.len() - 1);
    let points = points.map(|k| (curve.times[k].log10(), curve.means[k].log10()));
    let points: Vec<_> = points.collect();
    let marks = Pen {
        line: None,
        ..Pen::line(curve.color, 1.0).symbols(curve.shape, points.len())
    };
    let line = Layer::new("", line.collect(), Pen::line(curve.color, 1.2)).unlisted();
    panel.with(line).with(Layer::new(curve.name, points, marks))
}

/// Returns the band of two exact standard errors on either side of the expectation, whose points
/// are at the upper edge, and the mean less its expectation.
fn error(curve: &Curve) -> [Layer; 2] {
    let (mut edge, mut ends, mut points) = (Vec::new(), Vec::new(), Vec::new());
    for (k, &(mean, error)) in curve
        .exact
        .iter()
        .step_by(EVERY)
        .enumerate()
        .take(EARLY / EVERY + 1)
    {
        edge.push((curve.times[k], 2.0 * error));
        ends.push((-2.0 * error, 2.0 * error));
        points.push((curve.times[k], curve.means[k] - mean));
    }
    let none = Pen {
        line: None,
        ..Pen::line(palette::BLACK, 1.0)
    };
    let pen = Pen::line(curve.color, 1.2).symbols(curve.shape, EARLY / EVERY);
    [
        Layer::new("± two standard errors", edge, none).band(ends),
        Layer::new(curve.name, points, pen),
    ]
}

/// Returns the expectation of a method less that of another one, and its means less those of the
/// other one as symbols.
fn paired(curve: &Curve, other: &Curve) -> [Layer; 2] {
    let line = curve
        .exact
        .iter()
        .zip(&other.exact)
        .take(EARLY + 1)
        .enumerate();
    let line = line.map(|(k, (a, b))| (k as f64 * H, a.0 - b.0));
    let means = curve.means.iter().zip(&other.means).take(EARLY / EVERY + 1);
    let points = curve.times.iter().zip(means).map(|(&t, (a, b))| (t, a - b));
    let marks = Pen {
        line: None,
        ..Pen::line(curve.color, 1.0).symbols(curve.shape, EARLY / EVERY)
    };
    [
        Layer::new("", line.collect(), Pen::line(curve.color, 1.2)).unlisted(),
        Layer::new(curve.name, points.collect(), marks),
    ]
}

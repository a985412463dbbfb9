//! The cost of an error: rules with weak order 2 and the trapezoid, and Euler–Maruyama with the sum
//! over the left ends of steps.
//!
//! An error e of the mean over P paths of steps h has e² = bias² + variance/P. Bias and variance
//! are computed without sampling; the time of a path is measured. For each h, the number of paths
//! makes both parts equal, and the time is the time of all these paths.

use std::error::Error;
use std::time::Instant;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Layer, Panel, Pen, Shape};
use sve_examples::hues;
use sve_examples::palette::Color;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

use crate::quadratic::{KAPPA, Oscillator, POINT, TIME, exact, mean_of_steps, potential};

/// Numbers of steps of the rules of weak order 2, and of the other methods. With fewer steps the
/// bias of Euler–Maruyama changes its sign.
const STEPS: [&[u32]; 2] = [&[4, 8, 16, 32, 64, 128], &[16, 32, 64, 128, 256, 512]];
/// Number of path-steps in a measurement: enough to make the preparation of a run negligible.
const PATH_STEPS: u64 = 1 << 23;

/// Times of all paths that an error requires, for each number of steps.
struct Series {
    name: &'static str,
    color: Color,
    shape: Shape,
    /// Errors and seconds.
    points: Vec<(f64, f64)>,
    /// Slope of the logarithm of the bias.
    order: f64,
    expected: f64,
    /// Seconds of a path of 64 steps, per step.
    step: f64,
}

fn measured<I>(
    name: &'static str,
    (color, shape): (Color, Shape),
    method: &I,
    (ends, expected): ([f64; 2], f64),
    mut seconds: impl FnMut(u32) -> Result<f64, Box<dyn Error>>,
) -> Result<Series, Box<dyn Error>>
where
    I: Method<System = Oscillator>,
{
    let value = exact(TIME, POINT);
    let mut points = Vec::new();
    let mut biases = Vec::new();
    let mut step = f64::NAN;
    for &steps in STEPS[usize::from(expected < 2.0)] {
        let mean = mean_of_steps(method, steps, ends, KAPPA)?;
        let square = mean_of_steps(method, steps, ends, 2.0 * KAPPA)?;
        let bias = mean - value;
        let paths = (square - mean * mean) / (bias * bias);
        let time = seconds(steps)?;
        if steps == 64 {
            step = time / 64.0;
        }
        points.push((bias.abs() * 2.0_f64.sqrt(), paths * time));
        biases.push(bias.abs());
    }
    let last = biases.len() - 1;
    let order = (biases[last - 2] / biases[last]).log2() / 2.0;
    Ok(Series {
        name,
        color,
        shape,
        points,
        order,
        expected,
        step,
    })
}

/// Returns the seconds of a path in an ensemble of a derived rule, on one thread.
fn of_ensemble<I>(method: &I, steps: u32) -> Result<f64, Box<dyn Error>>
where
    I: Method<System = Oscillator> + Sync,
{
    let paths = PATH_STEPS / u64::from(steps);
    let ensemble = Ensemble::new(method)
        .paths(paths)
        .threads(1)
        .seed(4)
        .steps(TIME / f64::from(steps), steps.into())
        .start(State::new([POINT[0]], [POINT[1]]))
        .weight(|_, state| potential(state))
        .terminal("u", |_, _| 1.0);
    let mut best = f64::INFINITY;
    for _ in 0..3 {
        let start = Instant::now();
        let summary = ensemble.run()?;
        best = best.min(start.elapsed().as_secs_f64());
        if summary.failed() > 0 {
            return Err("a path failed".into());
        }
    }
    Ok(best / paths as f64)
}

/// Returns the seconds of a path of an ensemble as it is usually written: a loop over paths and
/// steps on one thread.
fn naive(steps: u32) -> f64 {
    let h = TIME / f64::from(steps);
    let paths = PATH_STEPS / 16 / u64::from(steps);
    let start = Instant::now();
    let mut sum = 0.0;
    for path in 0..paths {
        let mut noise = Wiener::new(5).path(path);
        let ([mut q, mut p], mut exponent) = (POINT, 0.0);
        let mut dw = [0.0];
        for step in 0..u64::from(steps) {
            // The only possible error is a step size of zero.
            if noise.increments(step, h, &mut dw).is_err() {
                return f64::NAN;
            }
            exponent += h * 0.5 * KAPPA * q * q;
            (q, p) = (q + h * p, p - h * q + crate::quadratic::SIGMA * dw[0]);
        }
        sum += (-exponent).exp();
    }
    let seconds = start.elapsed().as_secs_f64() / paths as f64;
    // The result is used, so that the compiler does not remove the loop.
    if sum > 0.0 { seconds } else { f64::NAN }
}

/// Measures all methods. Returns the panel and the checks of the orders.
pub(crate) fn measure() -> Result<(Panel, Vec<Check>), Box<dyn Error>> {
    let endpoint = Integrator::new(Oscillator, Endpoint);
    let midpoint = Integrator::new(Oscillator, Midpoint);
    let verlet = Integrator::new(Oscillator, StormerVerlet);
    let euler = EulerMaruyama::new(Oscillator);
    let trapezoid = [0.5, 0.5];
    let all = [
        measured(
            "`midpoint`",
            (hues::MIDPOINT, Shape::Circle),
            &midpoint,
            (trapezoid, 2.0),
            |steps| of_ensemble(&midpoint, steps),
        )?,
        measured(
            "Störmer–Verlet",
            (hues::STORMER_VERLET, Shape::Square),
            &verlet,
            (trapezoid, 2.0),
            |steps| of_ensemble(&verlet, steps),
        )?,
        measured(
            "`endpoint`",
            (hues::ENDPOINT, Shape::Triangle),
            &endpoint,
            (trapezoid, 1.0),
            |steps| of_ensemble(&endpoint, steps),
        )?,
        measured(
            "Euler–Maruyama, naive",
            (hues::EULER_MARUYAMA, Shape::Cross),
            &euler,
            ([1.0, 0.0], 1.0),
            |steps| Ok(naive(steps)),
        )?,
    ];
    let mut panel = Panel::new(
        "Time to error of u at (0.7, −0.4), t = 2",
        Axis::powers("root of the mean squared error", -5.8..-1.6),
        Axis::powers("computed seconds on one thread", -5.0..5.0),
    )
    .legend(Corner::TopRight);
    let mut checks = Vec::new();
    for series in &all {
        let points = series.points.iter().map(|(x, y)| (x.log10(), y.log10()));
        let pen = Pen::line(series.color, 1.5).symbols(series.shape, series.points.len());
        let name = series.name.replace('`', "");
        panel = panel.with(Layer::new(name, points.collect(), pen));
        checks.push(
            Check::new(format!("1: weak order, {}", series.name), series.order).near(
                series.expected,
                0.12,
                "the slope between the finest steps; the next term of the error still counts",
            ),
        );
    }
    for series in &all {
        checks.push(
            Check::new(
                format!("1: nanoseconds a path and step, {}", series.name),
                1e9 * series.step,
            )
            .reported("measured in this run"),
        );
    }
    let at = |series: &Series, error: f64| {
        let logs: Vec<_> = series
            .points
            .iter()
            .map(|(x, y)| (x.ln(), y.ln()))
            .collect();
        let pair = logs.windows(2).find(|pair| pair[1].0 <= error.ln());
        pair.map_or(f64::NAN, |pair| {
            let slope = (pair[1].1 - pair[0].1) / (pair[1].0 - pair[0].0);
            (pair[0].1 + slope * (error.ln() - pair[0].0)).exp()
        })
    };
    for error in [2e-3, 1e-3] {
        let ratio = at(&all[3], error) / at(&all[0], error);
        checks.push(
            Check::new(
                format!(
                    "1: time of naive Euler–Maruyama over `midpoint` for an error of {}",
                    number(error, 1)
                ),
                ratio,
            )
            .reported("both measured in this run, on one thread"),
        );
    }
    Ok((panel, checks))
}

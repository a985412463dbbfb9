//! The first problem: its closed form, the exact mean of a rule without sampling, and its solution
//! at many points.
//!
//! A function exp(−½zᵀAz − c) keeps its form under the equation,
//!
//! ```text
//! A' = BᵀA + AB − σ²A e_p e_pᵀA + κ e_q e_qᵀ,   c' = ½σ²A_pp,   B = (0, 1; −1, 0)
//! ```
//!
//! and under a linear step with the trapezoidal weight.

use std::error::Error;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Layer, Panel, Pen, Shape};
use sve_examples::palette;
use sve_runtime::prelude::*;

use crate::mean;

pub(crate) const SIGMA: f64 = 0.8;
pub(crate) const KAPPA: f64 = 1.3;
pub(crate) const TIME: f64 = 2.0;
/// The point of the comparison with the known value, and this value.
pub(crate) const POINT: [f64; 2] = [0.7, -0.4];
const VALUE: f64 = 0.627_173_387_859;

/// An oscillator that is pushed at random.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator;

#[variational(endpoint, midpoint, stormer_verlet)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        SIGMA * q
    }
}

/// Returns the potential V.
pub(crate) fn potential(state: &State<[f64; 1]>) -> f64 {
    0.5 * KAPPA * state.q[0] * state.q[0]
}

/// The symmetric matrix A (qq, qp, pp) and c.
#[derive(Clone, Copy, Debug)]
struct Exponent([f64; 4]);

impl Exponent {
    fn value(&self, [q, p]: [f64; 2]) -> f64 {
        let [a, b, d, c] = self.0;
        (-0.5 * (a * q * q + 2.0 * b * q * p + d * p * p) - c).exp()
    }

    fn rate(&self) -> [f64; 4] {
        let [a, b, d, _] = self.0;
        let s = SIGMA * SIGMA;
        [
            -2.0 * b - s * b * b + KAPPA,
            a - d - s * b * d,
            2.0 * b - s * d * d,
            0.5 * s * d,
        ]
    }

    /// Returns the exact solution at a time, by Runge–Kutta of order 4 with 4,000 steps.
    fn exact(time: f64) -> Self {
        let mut z = [0.0; 4];
        let h = time / 4000.0;
        let moved =
            |z: &[f64; 4], h: f64, k: &[f64; 4]| Self(core::array::from_fn(|i| z[i] + h * k[i]));
        for _ in 0..4000 {
            let k1 = Self(z).rate();
            let k2 = moved(&z, 0.5 * h, &k1).rate();
            let k3 = moved(&z, 0.5 * h, &k2).rate();
            let k4 = moved(&z, h, &k3).rate();
            z = core::array::from_fn(|i| {
                z[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            });
        }
        Self(z)
    }
}

/// Returns the closed form of the solution.
pub(crate) fn exact(time: f64, point: [f64; 2]) -> f64 {
    Exponent::exact(time).value(point)
}

/// Returns the exact mean of the weight of a linear method, with the given weights of the two ends
/// of a step. The mean of the squared weight is the mean with twice the potential.
pub(crate) fn mean_of_steps<I>(
    method: &I,
    steps: u32,
    ends: [f64; 2],
    kappa: f64,
) -> Result<f64, StepError>
where
    I: Method<System = Oscillator>,
{
    let h = TIME / f64::from(steps);
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        method.step(&mut state, h, &[dw])?;
        Ok::<_, StepError>([state.q[0], state.p[0]])
    };
    let columns = [image(1.0, 0.0, 0.0)?, image(0.0, 1.0, 0.0)?];
    let push = image(0.0, 0.0, 1.0)?;
    let (mut a, mut c) = ([kappa * h * ends[1], 0.0, 0.0], 0.0);
    for step in (0..steps).rev() {
        let form = |x: [f64; 2], y: [f64; 2]| {
            a[0] * x[0] * y[0] + a[1] * (x[0] * y[1] + x[1] * y[0]) + a[2] * x[1] * y[1]
        };
        let variance = 1.0 + h * form(push, push);
        let entry = |i: usize, j: usize| {
            let along = form(columns[i], push) * form(columns[j], push);
            form(columns[i], columns[j]) - h * along / variance
        };
        let next = [entry(0, 0), entry(0, 1), entry(1, 1)];
        c += 0.5 * variance.ln();
        let weight = if step == 0 {
            ends[0]
        } else {
            ends[0] + ends[1]
        };
        a = [next[0] + kappa * h * weight, next[1], next[2]];
    }
    Ok(Exponent([a[0], a[1], a[2], c]).value(POINT))
}

/// Returns an ensemble with the weight of the problem.
fn ensemble(
    motion: &Integrator<Oscillator, Midpoint>,
    paths: u64,
) -> Ensemble<'_, Integrator<Oscillator, Midpoint>> {
    Ensemble::new(motion)
        .paths(paths)
        .seed(1)
        .steps(1.0 / 16.0, 32)
        .weight(|_, state| potential(state))
        .terminal("u", |_, _| 1.0)
}

/// Compares the solution at the known point, by a million paths.
fn at_the_point(motion: &Integrator<Oscillator, Midpoint>) -> Result<Vec<Check>, Box<dyn Error>> {
    let mut checks = vec![
        Check::new("1: closed form at (0.7, −0.4), t = 2", exact(TIME, POINT)).near(
            VALUE,
            1e-12,
            "the value to 12 digits",
        ),
    ];
    let [q, p] = POINT;
    let start = State::new([q], [p]);
    let summary = ensemble(motion, 1_000_000).start(start).run()?;
    let (u, error) = (summary["u"].mean()[1], summary["u"].standard_error()[1]);
    let bias = mean_of_steps(motion, 32, [0.5, 0.5], KAPPA)? - VALUE;
    checks.push(mean(
        "1: u by 10⁶ paths, `midpoint`, h = 1/16".to_owned(),
        u,
        VALUE,
        error,
        bias,
    ));
    let spread =
        (mean_of_steps(motion, 32, [0.5, 0.5], 2.0 * KAPPA)? - (VALUE + bias).powi(2)).sqrt();
    checks.push(Check::new("1: its standard error", error).near(
        spread * 1e-3,
        5e-3 * spread * 1e-3,
        "the exact variance of the weight of a path",
    ));
    Ok(checks)
}

/// Solves at the known point, and at many points and two times.
pub(crate) fn solve() -> Result<([Panel; 2], Vec<Check>), Box<dyn Error>> {
    let motion = Integrator::new(Oscillator, Midpoint);
    let mut checks = at_the_point(&motion)?;
    let points: Vec<State<[f64; 1]>> = (-12..=12)
        .map(|k| State::new([0.25 * f64::from(k)], [0.0]))
        .collect();
    // each point has paths of its own
    let summaries = points.iter().zip(0..).map(|(point, number)| {
        let noise = Wiener::new(1).path(20_000 * number);
        let ensemble = ensemble(&motion, 20_000).every(8).noise(noise);
        ensemble.start(*point).run()
    });
    let summaries = summaries.collect::<Result<Vec<_>, _>>()?;
    let mut worst = 0.0_f64;
    let mut values = Panel::new(
        "Solution u(t, q, 0) at 25 points",
        Axis::new("q", -3.2..3.2),
        Axis::new("u", 0.0..1.05),
    )
    .legend(Corner::TopRight);
    let mut errors = Panel::new(
        "Error of u at these points",
        Axis::new("q", -3.2..3.2),
        Axis::new("mean less closed form", -0.007..0.007),
    )
    .legend(Corner::TopRight);
    let pens = [
        Pen::line(palette::BLUE, 1.5).symbols(Shape::Disc, points.len()),
        Pen::dashed(palette::VERMILION, 1.5, (7.0, 4.0)).symbols(Shape::Square, points.len()),
    ];
    for (record, pen) in [2, 4].into_iter().zip(pens) {
        let time = 0.5 * record as f64;
        let exponent = Exponent::exact(time);
        let curve = (-320..=320).map(|k| 0.01 * f64::from(k));
        let curve = curve.map(|q| (q, exponent.value([q, 0.0]))).collect();
        let (mut found, mut differences, mut bars) = (Vec::new(), Vec::new(), Vec::new());
        for (point, summary) in points.iter().zip(&summaries) {
            let (u, error) = (
                summary["u"].mean()[record],
                summary["u"].standard_error()[record],
            );
            let q = point.q[0];
            found.push((q, u));
            // the bias of the rule is below 10⁻³ of u
            let expected = exponent.value([q, 0.0]);
            worst = worst.max((u - expected).abs() / (error + 1e-3 * expected / 4.5));
            let difference = u - expected;
            differences.push((q + 0.08 * (time - 1.5), difference));
            bars.push((difference - 2.0 * error, difference + 2.0 * error));
        }
        let label = format!("t = {time}");
        let dots = Pen { line: None, ..pen };
        values = values
            .with(Layer::new(
                label.clone(),
                curve,
                Pen {
                    symbol: None,
                    ..pen
                },
            ))
            .with(Layer::new(format!("paths, {label}"), found, dots).unlisted());
        errors = errors.with(Layer::new(label, differences, dots).bars(bars));
    }
    checks.push(
        Check::new(
            "1: largest error at 25 points and 2 times, in standard errors",
            worst,
        )
        .near(0.0, 4.5, "a false alarm in 3,000"),
    );
    Ok(([values, errors], checks))
}

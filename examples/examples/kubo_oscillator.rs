//! The Kubo oscillator, a rotation whose speed is noisy: the midpoint rule keeps its radius,
//! Euler–Maruyama does not.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::hues;
use sve_examples::report::{one_row, report};

use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

/// dq = p (a dt + σ ∘ dW), dp = −q (a dt + σ ∘ dW).
#[derive(Clone, Copy, Debug)]
struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

const H: f64 = 0.01;
/// Smallest error that is drawn.
const LEAST: f64 = 1e-17;

/// Returns the radius at the end of `steps` steps.
fn radius<I: Method<System = Kubo>>(method: &I, steps: usize) -> Result<f64, StepError> {
    let mut trajectory = method.trajectory(State::new([1.0], [0.0]), H, Wiener::new(42));
    for state in trajectory.by_ref().take(steps) {
        state?;
    }
    let state = trajectory.state();
    Ok(state.q[0].hypot(state.p[0]))
}

/// Returns |radius − 1| along the path, at 400 times, as powers of ten.
fn radii<I: Method<System = Kubo>>(method: &I, steps: usize) -> Result<Vec<(f64, f64)>, StepError> {
    let every = steps / 400;
    let trajectory = method.trajectory(State::new([1.0], [0.0]), H, Wiener::new(42));
    let point = |state: Result<State<[f64; 1]>, StepError>| {
        let state = state?;
        let error = (state.q[0].hypot(state.p[0]) - 1.0).abs();
        // A radius of exactly 1 is drawn at the bottom.
        Ok((state.t, error.max(LEAST).log10()))
    };
    trajectory
        .skip(every - 1)
        .step_by(every)
        .take(400)
        .map(point)
        .collect()
}

fn figure(
    midpoint: &Integrator<Kubo, Midpoint>,
    euler: &EulerMaruyama<Kubo>,
) -> Result<Figure, StepError> {
    let steps = 10_000;
    let panel = Panel::new(
        format!("Kubo oscillator: error of the radius on one path, h = {H}"),
        Axis::new("time t", 0.0..100.0),
        Axis::powers("|radius − 1|", -17.0..7.0),
    )
    .with(Layer::new(
        "midpoint rule",
        radii(midpoint, steps)?,
        Pen::line(hues::MIDPOINT, 2.0),
    ))
    .with(Layer::new(
        "Euler–Maruyama",
        radii(euler, steps)?,
        Pen::line(hues::EULER_MARUYAMA, 1.4).symbols(Shape::Triangle, 10),
    ))
    .with(Layer::new(
        "Euler–Maruyama without the Itô correction",
        radii(&euler.uncorrected(), steps)?,
        Pen::dashed(hues::EULER_MARUYAMA, 1.4, (6.0, 3.0)),
    ))
    .legend(Corner::Below);
    Ok(one_row("kubo_oscillator", [760, 440], vec![panel]))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let midpoint = Integrator::new(system, Midpoint);
    let euler = EulerMaruyama::new(system);
    println!("{}\n", midpoint.plan());

    println!("radius after t on one path, h = {H}; it is 1");
    println!(
        "{:>6} {:>20} {:>16} {:>16}",
        "t", "midpoint − 1", "EM, uncorrected", "EM, corrected"
    );
    for t in [1, 10, 100, 1000] {
        let steps = 100 * t;
        println!(
            "{t:>6} {:>20} {:>16} {:>16}",
            number(radius(&midpoint, steps)? - 1.0, 2),
            number(radius(&euler.uncorrected(), steps)?, 7),
            number(radius(&euler, steps)?, 7)
        );
    }
    let off = radius(&midpoint, 100_000)? - 1.0;
    let why =
        "the radius is kept to rounding: 10⁵ steps with an error of 10⁻¹⁶ each, of random sign";
    let checks = [Check::new("midpoint rule, t = 1000: radius − 1", off).near(0.0, 2e-13, why)];
    let caption = "The exact radius is 1 on every path; this is path 0 of seed 42, σ = 0.5. The curve of the midpoint rule goes down to the axis where a radius is 1 to the last digit.";
    report(
        "Kubo oscillator",
        &figure(&midpoint, &euler)?,
        caption,
        &checks,
    )
}

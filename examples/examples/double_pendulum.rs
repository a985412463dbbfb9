//! A double pendulum: a mass matrix that depends on the angles, and two noises that push the first
//! arm.
//!
//! Without noise the energy error of the midpoint rule stays bounded along a chaotic motion, while
//! the error of Heun's method, of the same order, drifts. The same step carries the noise.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::envelope::envelope;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::report::{one_row, report};
use sve_examples::{hues, palette};

use sve_runtime::baseline::Heun;
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

/// Angles from the downward vertical.
#[derive(Clone, Copy, Debug)]
struct DoublePendulum {
    m1: f64,
    m2: f64,
    l1: f64,
    l2: f64,
    g: f64,
    s: f64,
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let both = self.m1 + self.m2;
        let kinetic =
            0.5 * both * (self.l1 * v[0]).powi(2) + 0.5 * self.m2 * (self.l2 * v[1]).powi(2);
        let coupling = self.m2 * self.l1 * self.l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        let height = both * self.l1 * q[0].cos() + self.m2 * self.l2 * q[1].cos();
        kinetic + coupling + self.g * height
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[0].cos()]
    }
}

/// Returns the largest energy error in each of five parts of a run.
fn energy_errors<I>(method: &I, h: f64, steps: usize) -> Result<Vec<f64>, StepError>
where
    I: Method<System = DoublePendulum>,
{
    let start = State::new([2.0, 1.0], [0.0, 0.0]);
    let energy = method.system().hamiltonian(&start)?;
    let mut trajectory = method.trajectory(start, h, NoNoise);
    let mut parts = Vec::new();
    for _ in 0..5 {
        let mut worst: f64 = 0.0;
        for state in trajectory.by_ref().take(steps / 5) {
            worst = worst.max((method.system().hamiltonian(&state?)? - energy).abs());
        }
        parts.push(worst);
    }
    Ok(parts)
}

/// Returns the largest energy error in each two-hundredth of the time.
fn errors<I: Method<System = DoublePendulum>>(
    method: &I,
    h: f64,
    steps: usize,
) -> Result<Vec<(f64, f64)>, StepError> {
    let start = State::new([2.0, 1.0], [0.0, 0.0]);
    let energy = method.system().hamiltonian(&start)?;
    let error = |state: Result<State<[f64; 2]>, StepError>| {
        let state = state?;
        Ok((state.t, method.system().hamiltonian(&state)? - energy))
    };
    let trajectory = method.trajectory(start, h, NoNoise);
    envelope(trajectory.take(steps).map(error), steps / 200)
}

/// Draws the path of the lower bob with and without noise, and the energy errors of both methods.
fn figure(pendulum: DoublePendulum, h: f64, steps: usize) -> Result<Figure, StepError> {
    let midpoint = Integrator::new(pendulum, Midpoint);
    let bob = |state: State<[f64; 2]>| {
        let [upper, lower] = state.q;
        let x = pendulum.l1 * upper.sin() + pendulum.l2 * lower.sin();
        (x, -pendulum.l1 * upper.cos() - pendulum.l2 * lower.cos())
    };
    let start = State::new([2.0, 1.0], [0.0, 0.0]);
    // The drawn part is 8 units of time.
    let drawn = 1600;
    let quiet: Result<Vec<_>, _> = midpoint
        .trajectory(start, h, NoNoise)
        .take(drawn)
        .map(|state| state.map(bob))
        .collect();
    let noisy: Result<Vec<_>, _> = midpoint
        .trajectory(start, h, Wiener::new(42))
        .take(drawn)
        .map(|state| state.map(bob))
        .collect();
    let axis = |name| Axis::new(name, -2.2..2.2);
    let path = Panel::new(
        "Double pendulum: the lower bob, t ≤ 8",
        axis("x"),
        axis("y"),
    )
    .equal()
    .with(Layer::new(
        "with noise",
        noisy?,
        Pen::dashed(hues::WITH_NOISE, 1.2, (7.0, 2.0)),
    ))
    .with(Layer::new(
        "without",
        quiet?,
        Pen::line(hues::MIDPOINT, 1.2),
    ))
    .with(Layer::new("", vec![(0.0, 0.0)], Pen::dots(palette::BLACK, 3.0)).unlisted())
    .legend(Corner::TopLeft);
    let energy = Panel::new(
        format!("Largest |energy error| in each 1/200 of the time, h = {h}"),
        Axis::new("time t", 0.0..h * steps as f64),
        Axis::powers("energy error", -4.0..1.0),
    )
    .with(Layer::new(
        "Heun",
        errors(&Heun::new(pendulum), h, steps)?,
        Pen::dashed(hues::HEUN, 1.5, (6.0, 3.0)),
    ))
    .with(Layer::new(
        "midpoint rule",
        errors(&midpoint, h, steps)?,
        Pen::line(hues::MIDPOINT, 1.5).symbols(Shape::Disc, 8),
    ))
    .legend(Corner::BottomRight);
    Ok(one_row("double_pendulum", [1080, 480], vec![path, energy]))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let pendulum = DoublePendulum {
        m1: 1.0,
        m2: 1.0,
        l1: 1.0,
        l2: 1.0,
        g: 9.8,
        s: 0.2,
    };
    let midpoint = Integrator::new(pendulum, Midpoint);
    println!("{}\n", midpoint.plan());

    let (h, steps) = (0.005, 100_000);
    println!(
        "largest energy error in each fifth of t ≤ {}, h = {h}, no noise",
        h * steps as f64
    );
    let row = |name, parts: Vec<f64>| {
        let cells: Vec<String> = parts
            .iter()
            .map(|part| format!("{:>10}", number(*part, 3)))
            .collect();
        println!("{name:>10} {}", cells.join(" "));
    };
    let bounded = energy_errors(&midpoint, h, steps)?;
    let growth = bounded[4] / bounded[0];
    row("midpoint", bounded);
    row("Heun", energy_errors(&Heun::new(pendulum), h, steps)?);

    println!("\none path with noise, s = {}", pendulum.s);
    println!("{:>4} {:>9} {:>9} {:>11}", "t", "q0", "q1", "energy");
    let trajectory = midpoint.trajectory(State::new([2.0, 1.0], [0.0, 0.0]), h, Wiener::new(42));
    for state in trajectory.take(1000).skip(199).step_by(200) {
        let state = state?;
        println!(
            "{:>4.1} {:>9} {:>9} {:>11}",
            state.t,
            number(state.q[0], 5),
            number(state.q[1], 5),
            number(pendulum.hamiltonian(&state)?, 6)
        );
    }
    let what = "midpoint: largest energy error in the last fifth over that in the first";
    let why = "an error that does not grow along a chaotic motion: the largest of 10⁵ values";
    let checks = [Check::new(what, growth).near(1.0, 0.5, why)];
    let caption = "Left: one path with noise, seed 42, and the motion without it, from the same start. Right: the energy error of the midpoint rule stays bounded, that of Heun’s method grows.";
    report(
        "Double pendulum",
        &figure(pendulum, h, steps)?,
        caption,
        &checks,
    )
}

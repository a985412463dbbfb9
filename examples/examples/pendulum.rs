//! A pendulum by two rules: the energy error decreases with the step size and does not grow with
//! time.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::envelope::envelope;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row, Shape};
use sve_examples::report::report;
use sve_examples::{hues, palette};
use sve_runtime::baseline::{Heun, RungeKutta4};
use sve_runtime::prelude::*;

/// A pendulum of unit mass and length.
#[derive(Clone, Copy, Debug)]
struct Pendulum {
    g: f64,
}

#[variational(midpoint, taylor2, gauss(2))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Returns the largest energy error of a run and of its last tenth.
fn energy_errors<I>(method: &I, h: f64, steps: usize) -> Result<(f64, f64), StepError>
where
    I: Method<System = Pendulum>,
{
    let start = State::new([1.5], [0.0]);
    let energy = method.system().hamiltonian(&start)?;
    let (mut whole, mut end) = (0.0_f64, 0.0_f64);
    for (k, state) in method.trajectory(start, h, NoNoise).take(steps).enumerate() {
        let error = (method.system().hamiltonian(&state?)? - energy).abs();
        whole = whole.max(error);
        if 10 * k >= 9 * steps {
            end = end.max(error);
        }
    }
    Ok((whole, end))
}

/// Draws the motions with the given energies, in units of m g l, that pass q = 0 or begin at rest.
fn portrait(midpoint: &Integrator<Pendulum, Midpoint>) -> Result<Panel, StepError> {
    let g = midpoint.system().g;
    let axes = (
        Axis::angle("angle q", -PI..PI),
        Axis::new("momentum p", -9.0..9.0),
    );
    let mut panel = Panel::new(
        "Pendulum: phase portrait, midpoint rule, h = 0.02",
        axes.0,
        axes.1,
    );
    for energy in [-0.9, -0.5, 0.0, 0.5, 0.9, 1.0, 1.2, 2.0, 3.0] {
        for side in [1.0, -1.0] {
            if energy == 1.0 {
                let layer = Layer::new("", separatrix(g, side), Pen::line(palette::BLACK, 2.0));
                panel = panel.with(layer);
                continue;
            }
            let start = State::new([0.0], [side * (2.0 * g * (energy + 1.0)).sqrt()]);
            let mut points = Vec::new();
            for state in midpoint.trajectory(start, 0.02, NoNoise).take(400) {
                let state = state?;
                let turn = (state.q[0] / (2.0 * PI)).round();
                let point = (state.q[0] - 2.0 * PI * turn, state.p[0]);
                // No line is drawn across the picture where the angle wraps.
                let last = points.last().copied();
                if let Some((q, p)) = last.filter(|(q, _): &(f64, f64)| (point.0 - q).abs() > PI) {
                    let end = PI.copysign(q);
                    points.extend([(end, p), (f64::NAN, f64::NAN), (-end, point.1)]);
                }
                points.push(point);
            }
            panel = panel.with(Layer::new("", points, Pen::line(hues::MIDPOINT, 1.0)));
        }
    }
    Ok(panel.note((-0.35, 8.3), "thick: separatrix", palette::BLACK))
}

/// Returns one side of the separatrix, on which a motion takes for ever to reach ±π.
fn separatrix(g: f64, side: f64) -> Vec<(f64, f64)> {
    let angles = (0..=200).map(|k| PI * (f64::from(k) / 100.0 - 1.0));
    angles
        .map(|q| (q, side * 2.0 * g.sqrt() * (0.5 * q).cos()))
        .collect()
}

/// Returns the largest energy error in each two-hundredth of the time.
fn errors<I: Method<System = Pendulum>>(
    method: &I,
    h: f64,
    steps: usize,
) -> Result<Vec<(f64, f64)>, StepError> {
    let start = State::new([1.5], [0.0]);
    let energy = method.system().hamiltonian(&start)?;
    let error = |state: Result<State<[f64; 1]>, StepError>| {
        let state = state?;
        Ok((state.t, method.system().hamiltonian(&state)? - energy))
    };
    let trajectory = method.trajectory(start, h, NoNoise);
    envelope(trajectory.take(steps).map(error), steps / 200)
}

fn energy_panel(pendulum: Pendulum) -> Result<Panel, StepError> {
    let (h, steps) = (0.05, 20_000);
    let midpoint = errors(&Integrator::new(pendulum, Midpoint), h, steps)?;
    let taylor = errors(&Integrator::new(pendulum, Taylor2), h, steps)?;
    let gauss = errors(&Integrator::new(pendulum, Gauss::<2>), h, steps)?;
    let heun = errors(&Heun::new(pendulum), h, steps)?;
    let rk4 = errors(&RungeKutta4::new(pendulum), h, steps)?;
    let line = |color| Pen::line(color, 1.5);
    let dashed = |color| Pen::dashed(color, 1.5, (6.0, 3.0));
    let symbols = |pen: Pen, shape| pen.symbols(shape, 8);
    Ok(Panel::new(
        "Largest |energy error| in each 1/200 of the time, h = 0.05",
        Axis::new("time t", 0.0..1000.0),
        Axis::powers("energy error", -6.0..2.0),
    )
    .with(Layer::new(
        "Heun, order 2",
        heun,
        symbols(dashed(hues::HEUN), Shape::Cross),
    ))
    .with(Layer::new(
        "Taylor rule, order 2",
        taylor,
        symbols(line(hues::TAYLOR), Shape::Triangle),
    ))
    .with(Layer::new(
        "midpoint rule, order 2",
        midpoint,
        symbols(line(hues::MIDPOINT), Shape::Disc),
    ))
    .with(Layer::new(
        "Runge–Kutta 4",
        rk4,
        symbols(dashed(hues::RUNGE_KUTTA_4), Shape::Square),
    ))
    .with(Layer::new(
        "Gauss rule of order 4",
        gauss,
        symbols(line(hues::GAUSS), Shape::Circle),
    ))
    .legend(Corner::Outside))
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let pendulum = Pendulum { g: 9.8 };
    let midpoint = Integrator::new(pendulum, Midpoint);
    let taylor = Integrator::new(pendulum, Taylor2);
    println!("{}\n\n{}\n", midpoint.plan(), taylor.plan());

    println!(
        "largest energy error from rest at q = 1.5, t ≤ 1000, and in the last tenth of the run"
    );
    println!("{:>8} {:>23} {:>23}", "h", "midpoint", "Taylor");
    let mut last = [(0.0, 0.0); 2];
    for steps in [10_000, 20_000, 40_000, 80_000] {
        let h = 1000.0 / steps as f64;
        let (a, a_end) = energy_errors(&midpoint, h, steps)?;
        let (b, b_end) = energy_errors(&taylor, h, steps)?;
        println!("{h:>8} {a:>11.3e} {a_end:>11.3e} {b:>11.3e} {b_end:>11.3e}");
        last = [(a, a_end), (b, b_end)];
    }
    println!(
        "half the step, a quarter of the error: order 2; the last tenth is no worse: no drift"
    );
    let check = |(rule, (whole, end)): (&str, (f64, f64))| {
        let what =
            format!("{rule}, h = 0.0125: energy error of the last tenth over that of the run");
        Check::new(what, end / whole).near(1.0, 0.1, "an error that does not grow")
    };
    let checks: Vec<Check> = ["midpoint", "Taylor"]
        .into_iter()
        .zip(last)
        .map(check)
        .collect();
    let row = |panel| Row {
        height: 400,
        panels: vec![panel],
    };
    let figure = Figure {
        name: "pendulum",
        width: 860,
        rows: vec![row(portrait(&midpoint)?), row(energy_panel(pendulum)?)],
    };
    let caption = "Motions of equal energy: oscillations inside of the separatrix, rotations outside. Below, from rest at q = 1.5: the errors of variational rules stay bounded, those of the others grow.";
    report("Pendulum", &figure, caption, &checks)
}

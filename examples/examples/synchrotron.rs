//! Synchrotron oscillations of a particle bunch, with noise in phase and amplitude of the
//! accelerating field.
//!
//! H = p²/2 − ω² cos q. Phase and amplitude noise kick the particle: γ₁ = −σ₁ cos q, γ₂ = −σ₂ sin
//! q, two Wiener processes. Particles outside the separatrix H = ω² are lost from the bucket.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::palette;
use sve_examples::report::{one_row, report};

use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Synchrotron {
    omega: f64,
    sigma1: f64,
    sigma2: f64,
}

#[variational(endpoint)]
impl Synchrotron {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.omega.powi(2) * q.cos()
    }

    #[gamma]
    fn kicks(&self, q: f64) -> [f64; 2] {
        [-self.sigma1 * q.cos(), -self.sigma2 * q.sin()]
    }
}

const H: f64 = 0.02;
const PARTICLES: u64 = 1000;

/// Properties of the bunch at a time.
#[derive(Clone, Copy, Debug, Default)]
struct Bunch {
    energy: f64,
    squares: f64,
    outside: u32,
}

/// Draws the bunch at the end within the bucket, and the lost part against time.
fn figure(machine: Synchrotron, ends: &[(f64, f64)], bunches: &[Bunch], times: &[f64]) -> Figure {
    let wrapped = |&(q, p): &(f64, f64)| (q - 2.0 * PI * (q / (2.0 * PI)).round(), p);
    let separatrix = |sign: f64| -> Vec<(f64, f64)> {
        let angles = (-100..=100).map(|k| PI * f64::from(k) / 100.0);
        angles
            .map(|q| (q, sign * 2.0 * machine.omega * (0.5 * q).cos()))
            .collect()
    };
    let t = times.last().copied().unwrap_or_default();
    let bucket = Panel::new(
        format!("Bunch in its bucket at t = {t}"),
        Axis::angle("phase q", -PI..PI),
        Axis::new("momentum p", -4.0..4.0),
    )
    .with(Layer::new(
        "particles",
        ends.iter().map(wrapped).collect(),
        Pen::dots(palette::BLUE, 1.2),
    ))
    .with(Layer::new(
        "separatrix",
        separatrix(1.0),
        Pen::line(palette::BLACK, 1.2),
    ))
    .with(Layer::new("", separatrix(-1.0), Pen::line(palette::BLACK, 1.2)).unlisted())
    .legend(Corner::TopRight);
    let n = PARTICLES as f64;
    let lost = |bunch: &Bunch| f64::from(bunch.outside) / n;
    let points: Vec<(f64, f64)> = times
        .iter()
        .copied()
        .zip(bunches.iter().map(lost))
        .collect();
    let bars = points.iter().map(|&(_, part)| {
        let error = 2.0 * (part * (1.0 - part) / n).sqrt();
        (part - error, part + error)
    });
    let most = points
        .iter()
        .fold(0.01, |most: f64, point| most.max(point.1));
    let loss = Panel::new(
        "Particles outside of the separatrix, ± 2 standard errors",
        Axis::new("time t", 0.0..1.05 * t),
        Axis::new("part of the bunch", 0.0..1.4 * most),
    )
    .with(Layer::new("lost", points.clone(), Pen::series(0)).bars(bars.collect()));
    one_row("synchrotron", [1080, 400], vec![bucket, loss])
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let machine = Synchrotron {
        omega: 1.0,
        sigma1: 0.1,
        sigma2: 0.1,
    };
    let endpoint = Integrator::new(machine, Endpoint);
    println!("{}\n", endpoint.plan());

    // dH = … + ½ (σ₁² sin² q + σ₂² cos² q) dt: for σ₁ = σ₂ = σ the mean energy grows as σ²t/2 for
    // every motion.
    let start = State::new([0.5], [0.0]);
    let first = machine.hamiltonian(&start)?;
    let stops: Vec<usize> = (1..=5).map(|k| 1000 * k).collect();
    let mut bunches = vec![Bunch::default(); stops.len()];
    let mut ends = Vec::new();
    for particle in 0..PARTICLES {
        let mut trajectory = endpoint.trajectory(start, H, Wiener::new(42).path(particle));
        let mut done = 0;
        for (bunch, &stop) in bunches.iter_mut().zip(&stops) {
            for state in trajectory.by_ref().take(stop - done) {
                state?;
            }
            done = stop;
            let energy = machine.hamiltonian(trajectory.state())?;
            bunch.energy += energy / PARTICLES as f64;
            bunch.squares += energy * energy / PARTICLES as f64;
            bunch.outside += u32::from(energy > machine.omega.powi(2));
        }
        let state = trajectory.state();
        ends.push((state.q[0], state.p[0]));
    }
    println!("{PARTICLES} particles from q = 0.5 at rest, h = {H}");
    println!(
        "{:>6} {:>13} {:>13} {:>13}",
        "t", "H₀ + σ²t/2", "mean energy", "lost"
    );
    for (bunch, &stop) in bunches.iter().zip(&stops) {
        let t = stop as f64 * H;
        let exact = first + 0.5 * machine.sigma1.powi(2) * t;
        println!(
            "{t:>6} {:>13} {:>13} {:>11.1} %",
            number(exact, 4),
            number(bunch.energy, 4),
            100.0 * f64::from(bunch.outside) / PARTICLES as f64
        );
    }
    let times: Vec<f64> = stops.iter().map(|&stop| stop as f64 * H).collect();
    let check = |(&t, bunch): (&f64, &Bunch)| {
        let error = ((bunch.squares - bunch.energy.powi(2)) / (PARTICLES as f64 - 1.0)).sqrt();
        let exact = first + 0.5 * machine.sigma1.powi(2) * t;
        let why = "4.5 standard errors, and 0.002 for the step size";
        Check::new(format!("t = {t}: mean energy"), bunch.energy).near(
            exact,
            4.5 * error + 0.002,
            why,
        )
    };
    let checks: Vec<Check> = times.iter().zip(&bunches).map(check).collect();
    let caption = "Endpoint rule, h = 0.02, σ₁ = σ₂ = 0.1, seed 42. The noise heats the bunch; particles that cross the separatrix leave their bucket and go around.";
    report(
        "Synchrotron",
        &figure(machine, &ends, &bunches, &times),
        caption,
        &checks,
    )
}

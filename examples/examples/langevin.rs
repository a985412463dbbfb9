//! Langevin dynamics in a double well: friction and a bath that together sample exp(−H/kT).
//!
//! L = ½v² − V(q), V = a(q² − 1)², friction F = −νv, γ = σq with σ² = 2νkT. The histogram of q is
//! compared with the density exp(−V/kT)/Z; independent particles give its standard error. The page
//! is `target/langevin/index.html`.

use std::error::Error;
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::report::{one_row, report};
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

#[derive(Clone, Copy, Debug)]
struct Langevin {
    /// Height of the barrier between the wells.
    a: f64,
    /// Rate of friction.
    nu: f64,
    /// Temperature times Boltzmann's constant.
    kt: f64,
}

#[variational(midpoint)]
impl Langevin {
    fn potential(&self, q: f64) -> f64 {
        self.a * (q * q - 1.0).powi(2)
    }

    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.potential(q)
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        (2.0 * self.nu * self.kt).sqrt() * q
    }
}

const H: f64 = 0.05;
const PARTICLES: u64 = 400;
/// Number of recorded steps of each particle. As many steps before them are discarded.
const STEPS: usize = 20_000;
const BINS: usize = 32;
const RANGE: f64 = 1.8;
const WIDTH: f64 = 2.0 * RANGE / BINS as f64;

/// Mean and variance over the particles.
#[derive(Clone, Copy, Debug, Default)]
struct Sample {
    sum: f64,
    squares: f64,
}

impl Sample {
    fn add(&mut self, x: f64) {
        self.sum += x;
        self.squares += x * x;
    }

    fn mean(self) -> f64 {
        self.sum / PARTICLES as f64
    }

    fn standard_error(self) -> f64 {
        let n = PARTICLES as f64;
        ((self.squares / n - self.mean().powi(2)) / (n - 1.0)).sqrt()
    }
}

/// Returns the bin of a coordinate.
fn bin(q: f64) -> Option<usize> {
    let at = ((q + RANGE) / WIDTH).floor();
    (0..BINS).find(|&k| k as f64 == at)
}

fn middle(bin: usize) -> f64 {
    -RANGE + (bin as f64 + 0.5) * WIDTH
}

/// Returns the density exp(−V/kT)/Z along the picture. Beyond three times the range it is
/// negligible.
fn curve(system: &Langevin) -> Vec<(f64, f64)> {
    let weight = |k: i32| (-system.potential(0.01 * f64::from(k)) / system.kt).exp();
    let reach = |range: f64| (100.0 * range) as i32;
    let all: f64 = (-reach(3.0 * RANGE)..=reach(3.0 * RANGE)).map(weight).sum();
    let points = -reach(RANGE)..=reach(RANGE);
    points
        .map(|k| (0.01 * f64::from(k), 100.0 * weight(k) / all))
        .collect()
}

/// Returns the part of the density exp(−V/kT)/Z in each bin, by Simpson's rule, divided by the
/// width.
fn density(system: &Langevin) -> Vec<f64> {
    let weight = |q: f64| (-system.potential(q) / system.kt).exp();
    let simpson = |a: f64, b: f64| (weight(a) + 4.0 * weight(0.5 * (a + b)) + weight(b)) / 6.0;
    let part = |at: f64| (0..16).map(move |k| at + WIDTH * f64::from(k) / 16.0);
    let mean =
        |at: f64| -> f64 { part(at).map(|x| simpson(x, x + WIDTH / 16.0)).sum::<f64>() / 16.0 };
    // Beyond three times the range the density is negligible.
    let all: f64 = (0..3 * BINS)
        .map(|k| WIDTH * mean(-3.0 * RANGE + k as f64 * WIDTH))
        .sum();
    (0..BINS)
        .map(|k| mean(-RANGE + k as f64 * WIDTH) / all)
        .collect()
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let system = Langevin {
        a: 1.0,
        nu: 1.0,
        kt: 0.4,
    };
    let midpoint = Integrator::new(system, Midpoint);
    println!("{}\n", midpoint.plan());

    let mut histogram = [Sample::default(); BINS];
    let mut kinetic = Sample::default();
    for particle in 0..PARTICLES {
        let start = State::new([if particle % 2 == 0 { -1.0 } else { 1.0 }], [0.0]);
        let trajectory = midpoint.trajectory(start, H, Wiener::new(42).path(particle));
        let mut counts = [0u32; BINS];
        let mut squares = 0.0;
        for state in trajectory.take(2 * STEPS).skip(STEPS) {
            let state = state?;
            squares += state.p[0].powi(2);
            if let Some(at) = bin(state.q[0]) {
                counts[at] += 1;
            }
        }
        kinetic.add(squares / STEPS as f64);
        for (sample, count) in histogram.iter_mut().zip(counts) {
            sample.add(f64::from(count) / (STEPS as f64 * WIDTH));
        }
    }

    println!(
        "{PARTICLES} particles, {STEPS} steps each, h = {H}, kT = {}",
        system.kt
    );
    println!(
        "⟨p²⟩ = {:.4} ± {:.4}, expected kT = {}\n",
        kinetic.mean(),
        kinetic.standard_error(),
        system.kt
    );
    let exact = density(&system);
    println!(
        "{:>7} {:>9} {:>10} {:>8}",
        "q", "density", "histogram", "± error"
    );
    for (at, (sample, exact)) in histogram.iter().zip(&exact).enumerate() {
        let filled = |k: &i32| f64::from(*k) + 0.5 < 40.0 * sample.mean();
        let bar: String = (0..40).take_while(filled).map(|_| '#').collect();
        println!(
            "{:>7} {exact:>9.4} {:>10.4} {:>8.4}  {bar}",
            number(middle(at), 4),
            sample.mean(),
            sample.standard_error()
        );
    }
    let far = histogram
        .iter()
        .zip(&exact)
        .map(|(s, e)| ((s.mean() - e) / s.standard_error()).abs());
    let far = far.fold(0.0, f64::max);
    println!("\nfarthest bin: {far:.1} standard errors");
    let checks = [
        Check::new("mean of p²", kinetic.mean()).near(
            system.kt,
            4.5 * kinetic.standard_error(),
            "4.5 standard errors",
        ),
        Check::new("farthest bin, in standard errors", far).near(
            0.0,
            4.5,
            "4.5 standard errors for the largest of the bins",
        ),
    ];
    let caption = "Midpoint rule, h = 0.05, seed 42. Time averages over the particles against the density of the canonical ensemble.";
    report(
        "Langevin dynamics",
        &figure(&histogram, curve(&system)),
        caption,
        &checks,
    )
}

/// Draws the histogram as steps, and the density as a line.
fn figure(histogram: &[Sample], exact: Vec<(f64, f64)>) -> Figure {
    let steps = histogram.iter().enumerate().flat_map(|(at, sample)| {
        let (middle, mean) = (middle(at), sample.mean());
        [(middle - 0.5 * WIDTH, mean), (middle + 0.5 * WIDTH, mean)]
    });
    let middles = histogram
        .iter()
        .enumerate()
        .map(|(at, sample)| (middle(at), sample.mean()))
        .collect();
    let bars = histogram.iter().map(|sample| {
        let (mean, error) = (sample.mean(), 2.0 * sample.standard_error());
        (mean - error, mean + error)
    });
    let bars = bars.collect();
    let panel = Panel::new(
        "Langevin dynamics in a double well",
        Axis::new("position q", -RANGE..RANGE),
        Axis::new("probability density", 0.0..1.0),
    )
    .legend(Corner::TopRight)
    .with(
        Layer::new(
            "midpoint rule, ± 2 standard errors",
            steps.collect(),
            Pen::line(hues::MIDPOINT, 1.5),
        )
        .filled(0.0),
    )
    .with(
        Layer::new("", middles, Pen::dots(hues::MIDPOINT, 0.3))
            .bars(bars)
            .unlisted(),
    )
    .with(Layer::new(
        "exp(−V/kT)/Z",
        exact,
        Pen::line(hues::EXACT, 1.2),
    ));
    one_row("langevin", [560, 360], vec![panel])
}

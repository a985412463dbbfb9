//! Rounding in the energy of 10² to 10⁶ coordinates: its random walk, and the error of the sum.
//!
//! L = Σ ½vᵢ² − ½qᵢ² − ½(qᵢ₊₁ − qᵢ)² on a ring. For linear forces −Kq, the rule of Störmer and
//! Verlet conserves H̃ = ½|p|² + ½⟨q, Kq⟩ − h²|Kq|²/8, so that rounding alone changes it. A step
//! rounds each coordinate once and each momentum twice: two kicks in a row, at the end of a step
//! and at the start of the next one, add the same number, and so have the same error. If these
//! errors are uniform and otherwise independent, the variance of H̃ grows by Σ (4 pᵢ² u(pᵢ)² + gᵢ²
//! u(qᵢ)²)/12 a step, where u(x) is the distance of the numbers near x and g = ∂H̃/∂q. In parts of
//! H̃, the walk is therefore of the order ε √(steps/n). With h = 0.1, near a simple fraction, the
//! errors of q + h p are not independent of p, and a drift is left.
//!
//! A sum in one number has an error of its own, which does not fall with n and hides this walk if n
//! is large. The example adds with compensation (T. O. Neumaier's variant of Kahan's sum, in two
//! numbers), finds the walk, and compares other sums. A page with the picture is written to
//! `target/rounding`.

use std::error::Error;
use std::f64::consts::FRAC_1_SQRT_2;
use std::process::ExitCode;

use indicatif::ProgressBar;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Shape};
use sve_examples::palette::{BLACK, BLUE, GREEN, GREY, VERMILION};
use sve_examples::report::{one_row, report};
use sve_runtime::prelude::*;

/// A ring of masses 1 with linear springs to their places and to their neighbours.
struct Ring;

#[variational(stormer_verlet)]
impl Ring {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            l += 0.5 * v[i] * v[i] - 0.5 * q[i] * q[i] - 0.5 * d * d;
        }
        l
    }
}

/// Steps: one far from simple fractions, and one near such a fraction.
const H: f64 = 0.1 * FRAC_1_SQRT_2;
const SIMPLE: f64 = 0.1;

/// Names of the numbers of coordinates.
const NAMES: [&str; 3] = ["10²", "10⁴", "10⁶"];

/// Numbers of coordinates, each with a step and the number of steps from one sample to the next.
const PATHS: [(usize, f64, u64); 4] = [
    (100, H, 2000),
    (10_000, H, 200),
    (1_000_000, H, 10),
    (10_000, SIMPLE, 200),
];
const SAMPLES: usize = 200;
/// Steps before the first sample.
const BEFORE: u64 = 100;

/// A sum in two numbers: the sum, and what rounding has taken from it.
#[derive(Clone, Copy, Default)]
struct Sum {
    high: f64,
    low: f64,
}

impl Sum {
    fn add(&mut self, x: f64) {
        let sum = self.high + x;
        let part = sum - self.high;
        self.low += (self.high - (sum - part)) + (x - part);
        self.high = sum;
    }

    fn minus(self, other: Self) -> f64 {
        (self.high - other.high) + (self.low - other.low)
    }
}

/// Returns K x.
fn forces(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let at = |i: usize| 3.0 * x[i] - x[(i + 1) % n] - x[(i + n - 1) % n];
    (0..n).map(at).collect()
}

/// Returns the distance of the numbers near `x`.
fn unit(x: f64) -> f64 {
    let power = f64::from_bits(x.to_bits() & f64::INFINITY.to_bits());
    f64::EPSILON * power
}

/// A sample of one path.
struct Sample {
    /// The conserved H̃.
    conserved: Sum,
    /// The variance that a step adds to H̃.
    variance: f64,
    /// Relative errors of H: of one sum from the first term to the last, and of `hamiltonian`.
    errors: [f64; 2],
}

impl Sample {
    fn new(state: &State<Vec<f64>>, h: f64) -> Result<Self, StepError> {
        let State { q, p, .. } = state;
        let n = q.len();
        let first = forces(q);
        let second = forces(&first);
        let (mut conserved, mut energy) = (Sum::default(), Sum::default());
        let (mut plain, mut variance) = (0.0, 0.0);
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            for part in [0.5 * p[i] * p[i], 0.5 * q[i] * q[i], 0.5 * d * d] {
                conserved.add(part);
                energy.add(part);
                plain += part;
            }
            conserved.add(-h * h * first[i] * first[i] / 8.0);
            let slope = first[i] - 0.25 * h * h * second[i];
            let [momentum, coordinate] = [p[i] * unit(p[i]), slope * unit(q[i])];
            variance += (4.0 * momentum * momentum + coordinate * coordinate) / 12.0;
        }
        let error = |sum: f64| (sum - energy.high - energy.low) / energy.high;
        Ok(Self {
            conserved,
            variance,
            errors: [plain, Ring.hamiltonian(state)?].map(error),
        })
    }
}

/// Samples of a path of so many coordinates.
struct Walk {
    n: usize,
    every: u64,
    samples: Vec<Sample>,
}

impl Walk {
    fn new((n, h, every): (usize, f64, u64), bar: &ProgressBar) -> Result<Self, StepError> {
        let ring = Integrator::new(Ring, StormerVerlet);
        let mut rng = StdRng::seed_from_u64(1);
        let mut numbers = || (0..n).map(|_| rng.random::<f64>() - 0.5).collect();
        let start = State::new(numbers(), numbers());
        let mut path = ring.trajectory(start, h, NoNoise);
        path.advance(BEFORE)?;
        let mut samples = Vec::new();
        for _ in 0..=SAMPLES {
            samples.push(Sample::new(path.advance(every)?, h)?);
            bar.inc(1);
        }
        Ok(Self { n, every, samples })
    }

    /// Returns the root of the mean squared change of H̃ over so many samples, in parts of H̃.
    fn change(&self, apart: usize) -> f64 {
        let pairs = self.samples.iter().zip(&self.samples[apart..]);
        let changes = pairs.map(|(a, b)| b.conserved.minus(a.conserved).powi(2));
        let mean = changes.sum::<f64>() / (self.samples.len() - apart) as f64;
        mean.sqrt() / self.samples[0].conserved.high
    }

    /// Returns the change over one step of a walk of independent errors, in parts of H̃.
    fn predicted(&self) -> f64 {
        let sum = self.samples.iter().map(|s| s.variance).sum::<f64>();
        (sum / self.samples.len() as f64).sqrt() / self.samples[0].conserved.high
    }

    /// Returns the change from the first sample to the last, in standard deviations of the walk.
    fn whole(&self) -> f64 {
        let [first, last] = [0, SAMPLES].map(|at| self.samples[at].conserved);
        let steps = (SAMPLES as u64 * self.every) as f64;
        last.minus(first) / (first.high * self.predicted() * steps.sqrt())
    }

    /// Returns the root of the mean squared error of a sum, relative.
    fn error(&self, of: usize) -> f64 {
        let squares = self.samples.iter().map(|s| s.errors[of].powi(2));
        (squares.sum::<f64>() / self.samples.len() as f64).sqrt()
    }
}

/// Numbers of samples over which changes are taken.
const APART: [usize; 6] = [1, 2, 4, 8, 16, 32];

fn checks(walks: &[Walk], simple: &Walk) -> Vec<Check> {
    let mut checks = Vec::new();
    for (walk, n) in walks.iter().zip(NAMES) {
        let predicted = walk.predicted() * (walk.every as f64).sqrt();
        checks.push(
            Check::new(
                format!("n = {n}: change in {} steps / predicted", walk.every),
                walk.change(1) / predicted,
            )
            .near(1.0, 0.15, "3 standard errors of 200 changes"),
        );
        let power = (walk.change(8) / walk.change(1)).log2() / 3.0;
        checks.push(
            Check::new(format!("n = {n}: power of the steps"), power).near(
                0.5,
                0.2,
                "3 standard errors of 25 changes over eight samples",
            ),
        );
        checks.push(
            Check::new(
                format!("n = {n}: whole change, in standard deviations"),
                walk.whole(),
            )
            .near(0.0, 3.5, "no drift"),
        );
        let one_sum = Check::new(
            format!("n = {n}: error of one sum / ε"),
            walk.error(0) / f64::EPSILON,
        );
        checks.push(one_sum.reported("term by term"));
        checks.push(
            Check::new(
                format!("n = {n}: error of `hamiltonian` / ε"),
                walk.error(1) / f64::EPSILON,
            )
            .near(
                0.0,
                2.0 + 0.05 * (walk.n as f64).sqrt(),
                "rounding of n terms",
            ),
        );
    }
    checks.push(
        Check::new(
            "n = 10⁴, h = 0.1: whole change, in standard deviations",
            simple.whole(),
        )
        .reported("a drift: h is near a simple fraction"),
    );
    checks
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let bar = ProgressBar::new((PATHS.len() * (SAMPLES + 1)) as u64);
    let walks = PATHS.map(|path| Walk::new(path, &bar));
    bar.finish_and_clear();
    let [first, second, third, simple] = walks;
    let (walks, simple) = ([first?, second?, third?], simple?);
    let caption = "Starts of seed 1. Left: the change of the conserved energy by rounding, root mean square, in parts of the energy, with h = 0.1/√2, which is not near a simple fraction, and with h = 0.1 (black). \
        Lines are the walks of rounding errors that are independent from step to step; that of h = 0.1 is the line of n = 10⁴. \
        Right: the errors of sums of the energy, against a sum in two numbers with compensation. “Derived” is the sum of the function <code>hamiltonian</code> of the library.";
    report(
        "Rounding in the energy",
        &figure(&walks, &simple),
        caption,
        &checks(&walks, &simple),
    )
}

fn figure(walks: &[Walk], simple: &Walk) -> Figure {
    let mut left = Panel::new(
        "Walk of the energy",
        Axis::powers("steps between samples", 0.5..5.6),
        Axis::powers("relative change of the energy", -19.0..-14.0),
    );
    let names = NAMES.into_iter().chain(["10⁴, h = 0.1"]);
    let colors = [BLUE, VERMILION, GREEN, BLACK];
    for ((walk, name), color) in walks.iter().chain([simple]).zip(names).zip(colors) {
        let at = |apart: usize, change: f64| {
            let steps = (walk.every * apart as u64) as f64;
            (steps.log10(), change.log10())
        };
        let walked = |apart: usize| walk.predicted() * (walk.every as f64 * apart as f64).sqrt();
        let line = APART.map(|apart| at(apart, walked(apart)));
        let dots = APART.map(|apart| at(apart, walk.change(apart)));
        let [.., (steps, end)] = dots;
        // the line of the last one is that of the second
        if color != BLACK {
            left = left.with(Layer::new("", line.to_vec(), Pen::line(color, 1.2)));
        }
        left = left
            .with(Layer::new("", dots.to_vec(), Pen::dots(color, 3.0)))
            .note((steps + 0.15, end), format!("n = {name}"), color);
    }
    let of = |error: &dyn Fn(&Walk) -> f64| {
        let points = walks
            .iter()
            .map(|w| ((w.n as f64).log10(), error(w).log10()));
        points.collect::<Vec<_>>()
    };
    let pen = |color, shape| Pen::line(color, 1.4).symbols(shape, walks.len());
    let right = Panel::new(
        "Error of the sum of the energy",
        Axis::powers("coordinates n", 1.8..6.2),
        Axis::powers("relative error", -18.5..-12.5),
    )
    .legend(Corner::TopLeft)
    .with(Layer::new(
        "one sum, term by term",
        of(&|w| w.error(0)),
        pen(BLACK, Shape::Square),
    ))
    .with(Layer::new(
        "derived",
        of(&|w| w.error(1)),
        pen(BLUE, Shape::Disc),
    ))
    .with(Layer::new(
        "the walk in 100 steps",
        of(&|w| 10.0 * w.predicted()),
        Pen::dashed(GREY, 1.4, (5.0, 3.0)),
    ));
    one_row("rounding", [980, 400], vec![left, right])
}

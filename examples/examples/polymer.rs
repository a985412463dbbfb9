//! Stiff chains in a bath: bonds, angles, end-to-end distances and diffusion.
//!
//! Each chain has N beads of mass 1 with V = Σ ½k(|bᵢ| − 1)² − κ Σ cos θᵢ, where bᵢ are the bonds
//! and θᵢ the angles between neighbouring bonds, in a Langevin bath of temperature T. At
//! equilibrium the lengths and the angles of all bonds are independent: ⟨cos θ⟩ = coth x − 1/x with
//! x = κ/T, and ⟨bᵢ·bⱼ⟩ = ⟨|b|⟩² ⟨cos θ⟩^|i − j| for different bonds, as in a chain that rotates
//! freely (P. J. Flory, Statistical Mechanics of Chain Molecules, 1969). Forces within a chain do
//! not move its centre, which is a free particle of mass N in the bath. All chains are one scene.
//! They start from equilibrium, and a wrong force would drive them from it. A page is written to
//! `target/polymer`.

use std::error::Error;
use std::process::ExitCode;

use indicatif::ProgressBar;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sve_examples::check::Check;
use sve_examples::directions::direction;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::palette::BLUE;
use sve_examples::report::{one_row, report};
use sve_runtime::Blocking;
use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

/// Chains of beads, one after the other.
struct Polymer {
    chains: usize,
    beads: usize,
    k: f64,
    kappa: f64,
    nu: f64,
    sigma: f64,
}

#[variational(stormer_verlet)]
impl Polymer {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i].norm_squared();
        }
        for c in 0..self.chains {
            for i in 1..self.beads {
                let bond = q[c * self.beads + i] - q[c * self.beads + i - 1];
                l -= 0.5 * self.k * (bond.norm() - 1.0).powi(2);
            }
            for i in 2..self.beads {
                let one = q[c * self.beads + i - 1] - q[c * self.beads + i - 2];
                let next = q[c * self.beads + i] - q[c * self.beads + i - 1];
                l += self.kappa * one.dot(&next) / (one.norm() * next.norm());
            }
        }
        l
    }

    #[gamma]
    fn bath_x(&self, q: &[Vector3<f64>]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q[0]).collect()
    }

    #[gamma]
    fn bath_y(&self, q: &[Vector3<f64>]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q[1]).collect()
    }

    #[gamma]
    fn bath_z(&self, q: &[Vector3<f64>]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * q[2]).collect()
    }

    #[force]
    fn friction(&self, _q: &[Vector3<f64>], v: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        v.iter().map(|v| v * (-self.nu)).collect()
    }
}

type Beads = State<Vec<Vector3<f64>>>;

const CHAINS: usize = 800;
const BEADS: usize = 20;
const STIFFNESS: f64 = 100.0;
const KAPPA: f64 = 2.0;
const FRICTION: f64 = 1.0;
const TEMPERATURE: f64 = 1.0;
const H: f64 = 0.01;

/// Steps between samples, and the number of samples.
const APART: u64 = 50;
const SAMPLES: u64 = 60;

/// Returns a number with the density `weight`, which is at most 1, between two bounds.
fn drawn(rng: &mut StdRng, [from, to]: [f64; 2], weight: impl Fn(f64) -> f64) -> f64 {
    loop {
        let x = from + (to - from) * rng.random::<f64>();
        if rng.random::<f64>() < weight(x) {
            return x;
        }
    }
}

/// Bounds of the lengths of bonds: ten standard deviations and more.
const LENGTHS: [f64; 2] = [0.0, 2.5];

/// Returns the density of lengths, with a factor.
fn length_weight(b: f64) -> f64 {
    b * b * (-0.5 * STIFFNESS * (b - 1.0).powi(2) / TEMPERATURE).exp() / 1.1
}

/// Returns the means of |b| and |b|².
fn lengths() -> [f64; 2] {
    let n = 10_000;
    let points = (0..n).map(|i| LENGTHS[1] * (f64::from(i) + 0.5) / f64::from(n));
    let [all, one, two] = points.fold([0.0; 3], |[all, one, two], b| {
        let weight = length_weight(b);
        [all + weight, one + b * weight, two + b * b * weight]
    });
    [one / all, two / all]
}

/// Returns a vector whose components are normal, by sums of twelve uniform numbers: their variance
/// is that of the normal distribution, and the bath does the rest.
fn thermal(rng: &mut StdRng) -> Vector3<f64> {
    let mut component = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let [x, y, z] = [component(), component(), component()];
    TEMPERATURE.sqrt() * Vector3::new(x, y, z)
}

/// Returns chains in equilibrium.
fn start() -> Beads {
    let (mut rng, mut q) = (StdRng::seed_from_u64(2), Vec::new());
    for _ in 0..CHAINS {
        let (mut place, mut along) = (Vector3::zeros(), direction(&mut rng));
        q.push(place);
        for _ in 1..BEADS {
            place += drawn(&mut rng, LENGTHS, length_weight) * along;
            q.push(place);
            let x = KAPPA / TEMPERATURE;
            let cosine = drawn(&mut rng, [-1.0, 1.0], |c| (x * (c - 1.0)).exp());
            // a direction at a right angle
            let side = direction(&mut rng).cross(&along).normalize();
            along = cosine * along + (1.0 - cosine * cosine).sqrt() * side;
        }
    }
    let p = q.iter().map(|_| thermal(&mut rng)).collect();
    State::new(q, p)
}

/// Returns of a chain the means of |b|, |b|² and cos θ, the squared end-to-end distance R², and the
/// squared displacement of the centre.
fn quantities(chain: &[Vector3<f64>], first: &[Vector3<f64>]) -> [f64; 5] {
    let bonds: Vec<Vector3<f64>> = chain.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let over = 1.0 / bonds.len() as f64;
    let cosine = |pair: &[Vector3<f64>]| pair[0].normalize().dot(&pair[1].normalize());
    let moved: Vector3<f64> = chain.iter().zip(first).map(|(a, b)| a - b).sum();
    [
        bonds.iter().map(Vector3::norm).sum::<f64>() * over,
        bonds.iter().map(Vector3::norm_squared).sum::<f64>() * over,
        bonds.windows(2).map(cosine).sum::<f64>() / (bonds.len() - 1) as f64,
        (chain[BEADS - 1] - chain[0]).norm_squared(),
        (moved / BEADS as f64).norm_squared(),
    ]
}

/// Returns ⟨R²⟩ from the means of |b|, |b|² and cos θ.
fn end_to_end([length, square]: [f64; 2], cosine: f64) -> f64 {
    let bonds = BEADS - 1;
    let pairs: f64 = (1..bonds)
        .map(|apart| (bonds - apart) as f64 * cosine.powi(apart as i32))
        .sum();
    bonds as f64 * square + 2.0 * length * length * pairs
}

/// Returns the mean squared displacement of the centre after a time, from equilibrium.
fn displacement(t: f64) -> f64 {
    let turns = FRICTION * t;
    6.0 * TEMPERATURE / (BEADS as f64 * FRICTION * FRICTION) * (turns - 1.0 + (-turns).exp())
}

/// Returns the relative standard error of the mean squared displacement of all chains: that of a
/// chain is the square of a vector of three normal numbers, with the relative variance 2/3.
fn of_chains() -> f64 {
    (2.0 / (3 * CHAINS) as f64).sqrt()
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let polymer = Polymer {
        chains: CHAINS,
        beads: BEADS,
        k: STIFFNESS,
        kappa: KAPPA,
        nu: FRICTION,
        sigma: (2.0 * FRICTION * TEMPERATURE).sqrt(),
    };
    let polymer = Integrator::new(polymer, StormerVerlet);
    println!("{}\n", polymer.plan());
    let start = start();
    println!("{}\n", polymer.layout(&start, H)?);
    let mut path = polymer.trajectory(start.clone(), H, Wiener::new(3));
    let (bar, mut samples) = (ProgressBar::new(SAMPLES), Vec::new());
    // for each chain, the means over the time
    let mut over_time = vec![[0.0; 5]; CHAINS];
    for _ in 0..SAMPLES {
        let state = path.advance(APART)?;
        let chains = state.q.chunks(BEADS).zip(start.q.chunks(BEADS));
        let mut over_chains = [0.0; 5];
        for ((chain, first), mean) in chains.zip(&mut over_time) {
            for (k, x) in quantities(chain, first).into_iter().enumerate() {
                mean[k] += x / SAMPLES as f64;
                over_chains[k] += x / CHAINS as f64;
            }
        }
        samples.push((state.t, over_chains));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let end = path.advance(0)?.clone();

    let x = KAPPA / TEMPERATURE;
    let (lengths, cosine) = (lengths(), 1.0 / x.tanh() - 1.0 / x);
    let r2 = end_to_end(lengths, cosine);
    let within = |name: &str, k: usize, expected: f64| {
        // the chains are independent
        let mut values = Blocking::new();
        values.extend(over_time.iter().map(|mean| mean[k]));
        let error = values.standard_error().unwrap_or(f64::NAN);
        Check::new(name, values.mean()).near(expected, 4.0 * error, "4 standard errors")
    };
    let last = samples[samples.len() - 1];
    let checks = [
        within("⟨|b|⟩", 0, lengths[0]),
        within("⟨|b|²⟩", 1, lengths[1]),
        within("⟨cos θ⟩", 2, cosine),
        within("⟨R²⟩", 3, r2),
        Check::new("mean squared displacement at the end", last.1[4]).near(
            displacement(last.0),
            3.0 * of_chains() * displacement(last.0),
            "3 standard errors of 800 chains",
        ),
    ];
    let caption = "Chains of 20 beads of mass 1, h = 0.01, seed 3. Left: the chains at the end, in the plane of x and y. Middle: the mean squared end-to-end distance. \
        Right: the mean squared displacement of the centres of the chains over that of a free particle of mass 20 in the same bath. Bands: two standard errors of 800 chains on either side.";
    let figure = figure(&samples, r2, &end);
    report("Stiff chains in a bath", &figure, caption, &checks)
}

fn figure(samples: &[(f64, [f64; 5])], r2: f64, end: &Beads) -> Figure {
    let axis = |name, to| Axis {
        labels: 0,
        ..Axis::new(name, -10.0..to)
    };
    let mut left = Panel::new(
        "12 of 800 chains, moved apart",
        axis("x", 50.0),
        axis("y", 40.0),
    )
    .equal();
    for (k, chain) in end.q.chunks(BEADS).take(12).enumerate() {
        let place = |q: &Vector3<f64>| {
            let moved = q - chain[0];
            (
                moved.x + 14.0 * (k % 4) as f64,
                moved.y + 14.0 * (k / 4) as f64,
            )
        };
        let points = chain.iter().map(place).collect();
        left = left.with(Layer::new("", points, Pen::line(BLUE, 1.4)));
    }
    let mut squares = Blocking::new();
    let of_chain = |chain: &[Vector3<f64>]| (chain[BEADS - 1] - chain[0]).norm_squared();
    squares.extend(end.q.chunks(BEADS).map(of_chain));
    let error = squares.standard_error().unwrap_or(f64::NAN);
    let middle = beside_exact(
        "End-to-end distance of 800 chains",
        Axis::new("⟨R²⟩", 54.0..68.0),
        ("equilibrium", r2, 2.0 * error),
        samples.iter().map(|s| (s.0, s.1[3])).collect(),
    );
    let right = beside_exact(
        "Displacement of the centres of 800 chains",
        Axis::new("ratio to a free particle", 0.88..1.12),
        ("free particle", 1.0, 2.0 * of_chains()),
        samples
            .iter()
            .map(|s| (s.0, s.1[4] / displacement(s.0)))
            .collect(),
    );
    one_row("polymer", [1200, 400], vec![left, middle, right])
}

/// Draws a course beside its exact value with a band.
fn beside_exact(
    title: &str,
    y: Axis,
    (name, value, band): (&str, f64, f64),
    course: Vec<(f64, f64)>,
) -> Panel {
    let until = course[course.len() - 1].0;
    let exact = vec![(0.0, value), (until, value)];
    let ends = vec![(value - band, value + band); 2];
    Panel::new(title, Axis::new("time t", 0.0..until), y)
        .legend(Corner::BottomRight)
        .with(Layer::new(name, exact, Pen::dashed(hues::EXACT, 1.4, (5.0, 3.0))).band(ends))
        .with(Layer::new(
            "mean of the chains",
            course,
            Pen::line(BLUE, 1.4),
        ))
}

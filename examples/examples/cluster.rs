//! A cluster of 1000 stars: Plummer's model in equilibrium, by the forces of all pairs.
//!
//! L = Σ ½m|vᵢ|² + Σ m²/√(|qᵢ − qⱼ|² + ε²) with N m = 1. In these units of Hénon the energy of
//! Plummer's model is −1/4 and its radius a is 3π/16. Positions and velocities are drawn as
//! Aarseth, Hénon and Wielen do (Astronomy & Astrophysics 37, 183, 1974). All stars of a pair of
//! loops push each other oppositely, so that the momenta are kept to rounding, while the energy has
//! an error of order h². A page with pictures is written to `target/cluster`.

use std::error::Error;
use std::f64::consts::PI;
use std::process::ExitCode;

use indicatif::ProgressBar;
use rand::rngs::StdRng;
use rand::{RngExt, SeedableRng};
use sve_examples::check::Check;
use sve_examples::directions::direction;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::palette::{BLACK, BLUE};
use sve_examples::report::{one_row, report};
use sve_runtime::nalgebra::Vector3;
use sve_runtime::prelude::*;

/// Stars of equal mass.
struct Cluster {
    m: f64,
    /// The square of the softening length.
    eps2: f64,
}

#[variational(stormer_verlet)]
impl Cluster {
    fn lagrangian(&self, q: &[Vector3<f64>], v: &[Vector3<f64>]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.m * v[i].norm_squared();
            for j in 0..i {
                l += self.m * self.m / ((q[i] - q[j]).norm_squared() + self.eps2).sqrt();
            }
        }
        l
    }
}

impl Cluster {
    /// Returns −Σ q·∂V/∂q, which is 2T in the mean of an equilibrium.
    fn virial(&self, q: &[Vector3<f64>]) -> f64 {
        let mut sum = 0.0;
        for (i, a) in q.iter().enumerate() {
            for b in &q[..i] {
                let r2 = (a - b).norm_squared();
                sum += self.m * self.m * r2 / (r2 + self.eps2).powf(1.5);
            }
        }
        sum
    }
}

type Stars = State<Vec<Vector3<f64>>>;

const STARS: usize = 1000;
const SOFTENING: f64 = 0.05;
const H: f64 = 0.01;
const UNTIL: f64 = 20.0;
/// The radius a of Plummer's model, and the one with half of its mass.
const RADIUS: f64 = 3.0 * PI / 16.0;
const HALF_MASS: f64 = 1.3048 * RADIUS;

/// Returns stars of Plummer's model, whose centre is at rest at 0.
fn plummer() -> Stars {
    let (mut rng, m) = (StdRng::seed_from_u64(1), 1.0 / STARS as f64);
    let (mut q, mut p) = (Vec::new(), Vec::new());
    for _ in 0..STARS {
        // one star in a thousand is farther out than the farthest one here
        let part = 0.999 * rng.random::<f64>();
        let r = RADIUS / (part.powf(-2.0 / 3.0) - 1.0).sqrt();
        // the density of v/v_escape is x²(1 − x²)^(7/2), which is below 0.1
        let x = loop {
            let [x, y] = [rng.random::<f64>(), 0.1 * rng.random::<f64>()];
            if y < x * x * (1.0 - x * x).powf(3.5) {
                break x;
            }
        };
        let escape = 2.0f64.sqrt() / (r * r + RADIUS * RADIUS).powf(0.25);
        q.push(r * direction(&mut rng));
        p.push(m * x * escape * direction(&mut rng));
    }
    let [place, momentum] = [&q, &p].map(|all| all.iter().sum::<Vector3<f64>>() * m);
    for (q, p) in q.iter_mut().zip(&mut p) {
        *q -= place;
        *p -= momentum;
    }
    State::new(q, p)
}

/// Returns the total momentum and the total angular momentum.
fn momenta(State { q, p, .. }: &Stars) -> [Vector3<f64>; 2] {
    let turning = q.iter().zip(p).map(|(q, p)| q.cross(p));
    [p.iter().sum(), turning.sum()]
}

/// Returns the radius around 0 with half of the mass.
fn half_mass(q: &[Vector3<f64>]) -> f64 {
    let mut radii: Vec<f64> = q.iter().map(sve_runtime::nalgebra::Matrix::norm).collect();
    radii.sort_by(f64::total_cmp);
    0.5 * (radii[STARS / 2 - 1] + radii[STARS / 2])
}

/// Times and numbers along a path.
#[derive(Default)]
struct Samples {
    energies: Vec<(f64, f64)>,
    ratios: Vec<(f64, f64)>,
    radii: Vec<(f64, f64)>,
}

impl Samples {
    /// Returns the root of the mean squared error of the energy.
    fn rms_error(&self) -> f64 {
        let squares: f64 = self.energies.iter().map(|e| e.1 * e.1).sum();
        (squares / self.energies.len() as f64).sqrt()
    }

    fn largest_error(&self) -> f64 {
        self.energies.iter().fold(0.0, |m, e| m.max(e.1.abs()))
    }
}

/// Runs the cluster, and returns samples, `every` so many steps, and the last state.
fn run(start: &Stars, h: f64, [rounds, every]: [u64; 2]) -> Result<(Samples, Stars), StepError> {
    let cluster = Integrator::new(cluster(), StormerVerlet);
    let first = cluster.system().hamiltonian(start)?;
    let mut path = cluster.trajectory(start.clone(), h, NoNoise);
    let (mut samples, bar) = (Samples::default(), ProgressBar::new(rounds));
    for _ in 0..rounds {
        let state = path.advance(every)?;
        let (t, system) = (state.t, cluster.system());
        let energy = system.hamiltonian(state)?;
        samples.energies.push((t, energy / first - 1.0));
        let ratio = (3 * STARS) as f64 * system.temperature(state)? / system.virial(&state.q);
        samples.ratios.push((t, ratio));
        samples.radii.push((t, half_mass(&state.q)));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let last = path.advance(0)?.clone();
    Ok((samples, last))
}

fn cluster() -> Cluster {
    Cluster {
        m: 1.0 / STARS as f64,
        eps2: SOFTENING * SOFTENING,
    }
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    println!("{}\n", Integrator::new(cluster(), StormerVerlet).plan());
    let start = plummer();
    let (samples, end) = run(&start, H, [100, 20])?;
    // the errors of short paths, before neighbouring paths part
    let [coarse, fine] = [(H, 1), (0.5 * H, 2)].map(|(h, every)| run(&start, h, [100, every]));
    let [coarse, fine] = [coarse?.0.rms_error(), fine?.0.rms_error()];
    let [before, after] = [momenta(&start), momenta(&end)];
    let size: f64 = end.p.iter().map(sve_runtime::nalgebra::Matrix::norm).sum();
    let [push, turn] = [0, 1].map(|k| (after[k] - before[k]).norm() / size);
    let mean = samples.ratios.iter().map(|r| r.1).sum::<f64>() / samples.ratios.len() as f64;
    // the standard error of a median is 1/(2 f √N), and the density f of radii here is 0.722
    let error = 0.5 / (0.722 * (STARS as f64).sqrt());
    let rounding = "rounding of 5·10⁵ pairs in each of 2000 steps";
    let checks = [
        Check::new("half-mass radius at the start", half_mass(&start.q)).near(
            HALF_MASS,
            3.0 * error,
            "3 standard errors",
        ),
        Check::new("2T / Σ q·∂V/∂q, mean", mean).near(
            1.0,
            1.0 / (STARS as f64).sqrt(),
            "an equilibrium, to 1/√N",
        ),
        Check::new("largest |ΔH / H|", samples.largest_error()).near(0.0, 5e-5, "order h²"),
        Check::new("rms error with h / with h/2, t up to 1", coarse / fine).near(
            4.0,
            0.4,
            "order h², and 10 % for higher orders",
        ),
        Check::new("change of the momentum / Σ|p|", push).near(0.0, 1e-14, rounding),
        Check::new("change of the angular momentum / Σ|p|", turn).near(0.0, 1e-14, rounding),
    ];
    let caption = format!(
        "{STARS} stars, softening length {SOFTENING}, h = {H}, seed 1. Left: the stars at the end with |x| and |y| below 2. Middle: the relative energy error. \
         Right: the radius with half of the mass over that of Plummer's model, and 2T over the virial of the forces, which is 1 in the mean. \
         A start of {STARS} stars with softened forces is some per cent from equilibrium."
    );
    report(
        "A cluster of stars",
        &figure(&samples, &end),
        &caption,
        &checks,
    )
}

fn figure(samples: &Samples, end: &Stars) -> Figure {
    let axis = |name| Axis::new(name, -2.0..2.0);
    let is_shown = |q: &&Vector3<f64>| q.x.abs() < 2.0 && q.y.abs() < 2.0;
    let stars: Vec<_> = end.q.iter().filter(is_shown).collect();
    let title = format!("{} of {STARS} stars, t = {UNTIL}", stars.len());
    let stars = stars.iter().map(|q| (q.x, q.y)).collect();
    let left = Panel::new(title, axis("x"), axis("y"))
        .equal()
        .with(Layer::new("", stars, Pen::dots(BLACK, 1.0)));
    let time = || Axis::new("time t", 0.0..UNTIL);
    let largest = 1.2 * samples.largest_error();
    let middle = Panel::new(
        format!("Energy error, h = {H}"),
        time(),
        Axis::new("relative energy error", -largest..largest),
    )
    .with(Layer::new(
        "",
        samples.energies.clone(),
        Pen::line(hues::STORMER_VERLET, 1.2),
    ));
    let right = Panel::new(
        "Does the cluster keep its size?",
        time(),
        Axis::new("ratio to equilibrium", 0.85..1.15),
    )
    .legend(Corner::BottomRight)
    .with(Layer::new(
        "half-mass radius",
        samples
            .radii
            .iter()
            .map(|&(t, r)| (t, r / HALF_MASS))
            .collect(),
        Pen::line(BLUE, 1.4),
    ))
    .with(Layer::new(
        "virial ratio",
        samples.ratios.clone(),
        Pen::line(BLACK, 1.4),
    ));
    one_row("cluster", [1200, 400], vec![left, middle, right])
}

//! Liquid argon: 4000 atoms in a periodic box, their radial distribution and their temperature.
//!
//! L = Σ ½|vᵢ|² − Σ u(|qᵢ − qⱼ|) in units of Lennard-Jones, with u(r) = 4 (r⁻¹² − r⁻⁶) up to 2.5,
//! less its tangent there: the force is continuous. The density 0.8442 and a temperature near 0.72
//! are those of the liquid beside its triple point. Pairs come from lists with a skin, which are
//! made anew when an atom has moved too far.
//!
//! The energy has an error of order h², the momentum is kept to rounding, and two temperatures
//! agree: that of the momenta, and ⟨|∇V|²⟩ / ⟨∇²V⟩ of the positions (H. H. Rugh, Phys. Rev. Lett.
//! 78, 772, 1997), to order 1/N. In a mode of frequency ω the rule of Störmer and Verlet lowers
//! ⟨p²⟩ by h²ω²/4, and the mean of ω² is that of ∇²V. A page with pictures is written to
//! `target/argon`.

use std::error::Error;
use std::f64::consts::{PI, TAU};
use std::process::ExitCode;

use indicatif::ProgressBar;
use rand::SeedableRng;
use rand::rngs::StdRng;
use sve_examples::check::Check;
use sve_examples::directions::direction;
use sve_examples::envelope::range_of;
use sve_examples::figure::{Axis, Figure, Layer, Panel, Pen};
use sve_examples::hues;
use sve_examples::palette::BLUE;
use sve_examples::report::{one_row, report};
use sve_runtime::Blocking;
use sve_runtime::prelude::*;

/// Atoms in a periodic cube.
struct Argon {
    near: Neighbours<3>,
    side: f64,
    /// Cut-off with its square, and potential and slope of Lennard-Jones there.
    cut: f64,
    cut2: f64,
    level: f64,
    slope: f64,
}

#[variational(stormer_verlet)]
impl Argon {
    fn lagrangian(&self, q: &[[f64; 3]], v: &[[f64; 3]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0].powi(2) + v[i][1].powi(2) + v[i][2].powi(2));
            for k in self.near.start[i]..self.near.start[i + 1] {
                let j = self.near.list[k];
                let mut r2 = 0.0;
                for axis in 0..3 {
                    let d = q[j][axis] - q[i][axis];
                    r2 += (d - self.side * (d / self.side).round()).powi(2);
                }
                if r2 > self.cut2 {
                    continue;
                }
                let inverse = 1.0 / (r2 * r2 * r2);
                l -= 4.0 * inverse * (inverse - 1.0)
                    - self.level
                    - self.slope * (r2.sqrt() - self.cut);
            }
        }
        l
    }
}

type Atoms = State<Vec<[f64; 3]>>;

const CELLS: usize = 10;
const ATOMS: usize = 4 * CELLS * CELLS * CELLS;
const DENSITY: f64 = 0.8442;
const TEMPERATURE: f64 = 0.722;
const HOT: f64 = 2.0;
const CUT: f64 = 2.5;
const SKIN: f64 = 0.3;
const H: f64 = 0.005;

/// Bound of the speeds in a block of steps, in parts of the largest at its start.
const FASTER: f64 = 1.5;

/// Steps before the first sample, between energies, and between samples; the number of samples.
const BEFORE: u64 = 2400;
const CLOSE: u64 = 5;
const APART: u64 = 10;
const SAMPLES: u64 = 240;

/// Bins of the radial distribution, up to the cut-off: lists that are valid have all pairs within.
const BINS: usize = 250;

impl Argon {
    fn new() -> Result<Self, NeighbourError> {
        let side = (ATOMS as f64 / DENSITY).cbrt();
        Ok(Self {
            near: Neighbours::periodic(CUT, SKIN, [side; 3])?,
            side,
            cut: CUT,
            cut2: CUT * CUT,
            level: 4.0 * (CUT.powi(-12) - CUT.powi(-6)),
            slope: -48.0 * CUT.powi(-13) + 24.0 * CUT.powi(-7),
        })
    }

    /// Returns a face-centred lattice whose atoms move without order.
    fn start(&self) -> Atoms {
        let cell = self.side / CELLS as f64;
        let corners = [
            [0.0, 0.0, 0.0],
            [0.0, 0.5, 0.5],
            [0.5, 0.0, 0.5],
            [0.5, 0.5, 0.0],
        ];
        let place = |i: usize, corner: [f64; 3]| {
            let steps = [i / (CELLS * CELLS), i / CELLS % CELLS, i % CELLS];
            std::array::from_fn(|axis| cell * (steps[axis] as f64 + corner[axis]))
        };
        let cells = 0..CELLS * CELLS * CELLS;
        let q = cells.flat_map(|i| corners.map(|corner| place(i, corner)));
        let mut rng = StdRng::seed_from_u64(1);
        let mut p: Vec<[f64; 3]> = (0..ATOMS).map(|_| direction(&mut rng).into()).collect();
        let mean = total(&p).map(|sum| sum / ATOMS as f64);
        for (axis, mean) in mean.into_iter().enumerate() {
            for p in &mut p {
                p[axis] -= mean;
            }
        }
        State::new(q.collect(), p)
    }

    /// Adds the pairs to a histogram of distances. Returns |∇V|² and ∇²V.
    fn sample(&self, q: &[[f64; 3]], histogram: &mut [f64; BINS]) -> [f64; 2] {
        let (mut slopes, mut laplacian) = (vec![[0.0; 3]; q.len()], 0.0);
        for i in 0..q.len() {
            for &j in self.near.of(i) {
                let d = self.near.separation(q[i], q[j]);
                let r = (d[0] * d[0] + d[1] * d[1] + d[2] * d[2]).sqrt();
                let bin = usize::try_from((r / CUT * BINS as f64) as i64);
                if let Some(count) = bin.ok().and_then(|bin| histogram.get_mut(bin)) {
                    *count += 1.0;
                }
                if r > self.cut {
                    continue;
                }
                let first = -48.0 * r.powi(-13) + 24.0 * r.powi(-7) - self.slope;
                let second = 624.0 * r.powi(-14) - 168.0 * r.powi(-8);
                laplacian += 2.0 * (second + 2.0 * first / r);
                for axis in 0..3 {
                    slopes[i][axis] += first * d[axis] / r;
                    slopes[j][axis] -= first * d[axis] / r;
                }
            }
        }
        [slopes.iter().flatten().map(|x| x * x).sum(), laplacian]
    }
}

/// Returns |Σ exp(i k·q)|² / N² for a vector k of the lattice of the start: 1 there, and of order
/// 1/N in a liquid.
fn order(q: &[[f64; 3]], side: f64) -> f64 {
    let k = TAU * CELLS as f64 / side;
    let angles = q.iter().map(|q| k * (q[0] + q[1] + q[2]));
    let (x, y) = angles.fold((0.0, 0.0), |(x, y), a| (x + a.cos(), y + a.sin()));
    (x * x + y * y) / (ATOMS * ATOMS) as f64
}

fn total(p: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|axis| p.iter().map(|p| p[axis]).sum())
}

/// Makes steps in blocks, for each of which the lists are valid; at the end they are those of the
/// state.
fn advance(
    argon: &mut Integrator<Argon, StormerVerlet>,
    state: &mut Atoms,
    h: f64,
    steps: u64,
) -> Result<(), Box<dyn Error>> {
    let mut left = steps;
    while left > 0 {
        let speeds2 = (state.p.iter()).map(|p| p.iter().map(|p| p * p).sum::<f64>());
        let bound = FASTER * speeds2.fold(0.0, f64::max).sqrt();
        if argon.system().near.valid_steps(&state.q, bound, h) == 0 {
            argon.system_mut().near.rebuild(&state.q)?;
        }
        let near = &argon.system().near;
        let mut block = near.valid_steps(&state.q, bound, h).clamp(1, left);
        loop {
            let mut path = argon.trajectory(state.clone(), h, NoNoise);
            let end = path.advance(block)?;
            // an atom was faster than the bound: fewer steps from the same state
            if block > 1 && !near.is_valid(&end.q) {
                block /= 2;
                continue;
            }
            state.clone_from(end);
            break;
        }
        left -= block;
    }
    if !argon.system().near.is_valid(&state.q) {
        argon.system_mut().near.rebuild(&state.q)?;
    }
    Ok(())
}

/// Returns the root of the mean squared relative error of the energy at 100 times, `every` so many
/// steps.
fn energy_error(start: &Atoms, h: f64, every: u64) -> Result<f64, Box<dyn Error>> {
    let mut argon = Integrator::new(Argon::new()?, StormerVerlet);
    let (mut state, mut squares) = (start.clone(), 0.0);
    argon.system_mut().near.rebuild(&state.q)?;
    let first = argon.system().hamiltonian(&state)?;
    for _ in 0..100 {
        advance(&mut argon, &mut state, h, every)?;
        squares += (argon.system().hamiltonian(&state)? / first - 1.0).powi(2);
    }
    Ok((squares / 100.0f64).sqrt())
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut argon = Integrator::new(Argon::new()?, StormerVerlet);
    println!("{}\n", argon.plan());
    let mut state = argon.system().start();
    let bar = ProgressBar::new(SAMPLES);
    // hot at first, so that the lattice melts
    for round in 0..BEFORE / 50 {
        let wanted = if round < 16 { HOT } else { TEMPERATURE };
        let factor = (wanted / argon.system().temperature(&state)?).sqrt();
        state.p.iter_mut().flatten().for_each(|p| *p *= factor);
        advance(&mut argon, &mut state, H, 50)?;
    }
    let (before, start) = (total(&state.p), state.clone());
    let first = argon.system().hamiltonian(&state)?;
    let (mut histogram, mut energies) = ([0.0; BINS], Vec::new());
    let (mut differences, mut temperatures) = (Blocking::new(), Blocking::new());
    for _ in 0..SAMPLES {
        for _ in 0..APART / CLOSE {
            advance(&mut argon, &mut state, H, CLOSE)?;
            let error = argon.system().hamiltonian(&state)? / first - 1.0;
            energies.push((state.t - start.t, error));
        }
        let system = argon.system();
        let [squares, laplacian] = system.sample(&state.q, &mut histogram);
        let mean_square = laplacian / (3 * ATOMS) as f64;
        let own = system.temperature(&state)? / (1.0 - H * H * mean_square / 4.0);
        temperatures.push(own);
        differences.push(squares / laplacian / own - 1.0);
        bar.inc(1);
    }
    bar.finish_and_clear();

    let g = distribution(&histogram);
    let peak = g
        .iter()
        .fold((0.0, 0.0), |a, &b| if b.1 > a.1 { b } else { a });
    let error = differences.standard_error().ok_or("too few samples")?;
    let worst = energies.iter().fold(0.0f64, |m, e| m.max(e.1.abs()));
    let ratio = energy_error(&start, H, 1)? / energy_error(&start, 0.5 * H, 2)?;
    let after = total(&state.p);
    let push = (0..3)
        .map(|k| (after[k] - before[k]).abs())
        .fold(0.0, f64::max);
    let checks = [
        Check::new("largest |ΔH / H|", worst).near(0.0, 1e-4, "order h²"),
        Check::new("rms error with h / with h/2, t up to 0.5", ratio).near(4.0, 0.6, "order h²"),
        Check::new("change of the momentum", push).near(0.0, 1e-12, "rounding"),
        Check::new("temperature", temperatures.mean())
            .reported("0.722 was set before the steps of constant energy"),
        Check::new("order of the lattice", order(&start.q, argon.system().side)).near(
            0.0,
            0.01,
            "molten: of order 1/N; 1 at the start",
        ),
        Check::new(
            "temperature of the positions / temperature − 1",
            differences.mean(),
        )
        .near(
            0.0,
            3.0 * error + 1.0 / ATOMS as f64,
            "3 standard errors, and 1/N",
        ),
        Check::new("r of the first peak of g", peak.0).near(
            1.1,
            0.05,
            "just within the minimum of u, 1.122",
        ),
        Check::new("g at its first peak", peak.1).reported("of the liquid"),
    ];
    let caption = format!(
        "{ATOMS} atoms, T = {TEMPERATURE}, density {DENSITY}, h = {H}, in units of Lennard-Jones. Left: the radial distribution, from {SAMPLES} samples. \
         Right: the range of the energy error in each fortieth of the time at constant energy; the line is its middle. Its mean is not 0, since the energy that it is compared with, at t = 0, has an error too."
    );
    report("Liquid argon", &figure(g, &energies), &caption, &checks)
}

/// Returns the radial distribution: the pairs in each shell, in parts of those of a gas.
fn distribution(histogram: &[f64; BINS]) -> Vec<(f64, f64)> {
    let samples = SAMPLES as f64;
    let width = CUT / BINS as f64;
    let bins = histogram.iter().enumerate().map(|(bin, count)| {
        let [inner, outer] = [bin, bin + 1].map(|edge| edge as f64 * width);
        let shell = 4.0 / 3.0 * PI * (outer.powi(3) - inner.powi(3));
        let of_gas = 0.5 * ATOMS as f64 * DENSITY * shell * samples;
        (0.5 * (inner + outer), count / of_gas)
    });
    bins.collect()
}

fn figure(g: Vec<(f64, f64)>, energies: &[(f64, f64)]) -> Figure {
    let left = Panel::new(
        "Radial distribution",
        Axis::new("r / σ", 0.8..CUT),
        Axis::new("g(r)", 0.0..3.5),
    )
    .with(Layer::new("", g, Pen::line(BLUE, 1.4)));
    let largest = energies.iter().fold(0.0f64, |m, e| m.max(e.1.abs()));
    let right = Panel::new(
        "Range of the energy error",
        Axis::new("time t", 0.0..energies[energies.len() - 1].0),
        Axis::new(
            "relative energy error ΔH / H",
            -1.2 * largest..1.2 * largest,
        ),
    )
    .with(range_of("", energies, 40, hues::STORMER_VERLET));
    one_row("argon", [980, 400], vec![left, right])
}

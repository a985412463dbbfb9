//! The chain of Fermi, Pasta, Ulam and Tsingou: recurrence of 31 masses, and the energy of 10⁶.
//!
//! Springs with a quadratic term in their force join masses between two walls. All energy starts in
//! the longest mode, flows into the next ones, and nearly all comes back: after 157 periods of the
//! first mode in the calculation of 1955, whose rule is that of Störmer and Verlet with h² = 1/8.
//! The example finds this number with this step, and 146.4 with small steps: the rest is the error
//! of the step. The same struct then has a million masses: the Lagrangian is a loop over a slice,
//! and the state has the length. In a heat bath, each mode has the energy of equipartition.
//! A page with the pictures is written to `target/fput`.

mod bath;

use std::error::Error;
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
use std::process::ExitCode;

use sve_examples::check::Check;
use sve_examples::figure::{Axis, Corner, Figure, Layer, Panel, Pen, Row};
use sve_examples::hues;
use sve_examples::palette::{BLACK, BLUE, GREY, ORANGE, PURPLE};
use sve_examples::report::report;
use sve_runtime::prelude::*;

/// Masses of 1 between walls, with springs of the force d + α d².
struct Chain {
    alpha: f64,
}

#[variational(stormer_verlet)]
impl Chain {
    fn spring(&self, d: f64) -> f64 {
        0.5 * d * d + self.alpha * d.powi(3) / 3.0
    }

    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = v.iter().map(|v| 0.5 * v * v).sum::<f64>();
        for i in 0..n {
            // the left spring of each mass, and the right one of the last
            if i == 0 {
                l -= self.spring(q[i]);
            } else {
                l -= self.spring(q[i] - q[i - 1]);
            }
            if i == n - 1 {
                l -= self.spring(-q[i]);
            }
        }
        l
    }
}

/// A mode of the chain of linear springs: its frequency, and its shape of norm 1.
struct Mode {
    frequency: f64,
    shape: Vec<f64>,
}

impl Mode {
    fn new(number: usize, n: usize) -> Self {
        let angle = PI * number as f64 / (n + 1) as f64;
        let shape = (1..=n).map(|i| (2.0 / (n + 1) as f64).sqrt() * (angle * i as f64).sin());
        Self {
            frequency: 2.0 * (0.5 * angle).sin(),
            shape: shape.collect(),
        }
    }

    /// Returns the part of a vector in the mode.
    fn part(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.shape).map(|(x, s)| x * s).sum()
    }

    /// Returns the energy of linear springs in the mode.
    fn energy(&self, state: &State<Vec<f64>>) -> f64 {
        0.5 * (self.part(&state.p).powi(2) + (self.frequency * self.part(&state.q)).powi(2))
    }
}

const ALPHA: f64 = 0.25;
const MASSES: usize = 31;

/// The step of 1955 (δt² = 1/8), one of small error, and half of it, each with the number of steps
/// from one saved state to the next.
const STEPS: [(f64, u64); 3] = [(0.5 * FRAC_1_SQRT_2, 1), (0.05, 10), (0.025, 20)];

/// The step of the million masses.
const H: f64 = 0.05;

/// Number of modes that are drawn.
const MODES: usize = 4;

/// Periods of the first mode.
const PERIODS: f64 = 170.0;

/// A time in periods of the first mode, and the energies of the first modes in parts of the whole.
type Energies = (f64, [f64; MODES]);

/// Returns the energies of the modes of a path with steps of length `h`, and the largest error of
/// the whole energy in parts of it.
fn recurrence((h, every): (f64, u64)) -> Result<(Vec<Energies>, f64), StepError> {
    let chain = Integrator::new(Chain { alpha: ALPHA }, StormerVerlet);
    let modes: [Mode; MODES] = std::array::from_fn(|k| Mode::new(k + 1, MASSES));
    let q = (1..=MASSES).map(|i| (PI * i as f64 / (MASSES + 1) as f64).sin());
    let start = State::new(q.collect(), vec![0.0; MASSES]);
    let whole = chain.system().hamiltonian(&start)?;
    let period = TAU / modes[0].frequency;
    let mut energies = Vec::new();
    let mut worst = 0.0f64;
    let path = chain.trajectory(start, h, NoNoise);
    for state in path.every(every).until(PERIODS * period) {
        let state = state?;
        let parts = std::array::from_fn(|k| modes[k].energy(&state) / whole);
        energies.push((state.t / period, parts));
        worst = worst.max((chain.system().hamiltonian(&state)? / whole - 1.0).abs());
    }
    Ok((energies, worst))
}

/// Returns the time at which the first mode has most energy again, and this energy.
fn recurrent(energies: &[Energies]) -> (f64, f64) {
    let late = energies.iter().filter(|e| e.0 > 100.0);
    late.fold(
        (0.0, 0.0),
        |a, e| if e.1[0] > a.1 { (e.0, e.1[0]) } else { a },
    )
}

const MANY: usize = 1_000_000;

/// Returns the relative error of the energy of 10⁶ masses against the time.
fn many() -> Result<Vec<(f64, f64)>, StepError> {
    let chain = Integrator::new(Chain { alpha: ALPHA }, StormerVerlet);
    // momenta without order, of variance 0.01
    let p = (1..=MANY).map(|i| 0.1 * 2.0f64.sqrt() * (i as f64).powi(2).sin());
    let start = State::new(vec![0.0; MANY], p.collect());
    let whole = chain.system().hamiltonian(&start)?;
    let mut path = chain.trajectory(start, H, NoNoise);
    let mut errors = vec![(0.0, 0.0)];
    for _ in 0..500 {
        let state = path.advance(2)?;
        let error = chain.system().hamiltonian(state)? / whole - 1.0;
        errors.push((state.t, error));
    }
    Ok(errors)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let chain = Integrator::new(Chain { alpha: ALPHA }, StormerVerlet);
    println!("{}\n", chain.plan());
    println!(
        "{}\n",
        chain.layout(&State::new(vec![0.0; MANY], vec![0.0; MANY]), H)?
    );
    let [first, fine, finest] = STEPS.map(recurrence);
    let (first, (fine, worst), finest) = (first?.0, fine?, finest?.0);
    let [then, back, limit] = [&first, &fine, &finest].map(|energies| recurrent(energies));
    let least = fine.iter().filter(|e| (20.0..120.0).contains(&e.0));
    let least = least.map(|e| e.1[0]).fold(f64::INFINITY, f64::min);

    let errors = many()?;
    let heats = bath::Heats::new()?;
    let largest = |part: &[(f64, f64)]| part.iter().fold(0.0f64, |m, e| m.max(e.1.abs()));
    let [early, late] = [&errors[100..300], &errors[300..]].map(largest);
    let mut checks = vec![
        Check::new("periods until it is back, h² = 1/8", then.0).near(
            157.0,
            1.0,
            "as cited for the calculation of 1955",
        ),
        Check::new("periods until it is back, h = 0.05", back.0).near(
            limit.0,
            0.3,
            "as with h = 0.025: order h²",
        ),
        Check::new("energy in the first mode then", back.1).near(
            limit.1,
            1e-3,
            "as with h = 0.025",
        ),
        Check::new("least energy in the first mode", least).near(0.0, 0.1, "it flows to others"),
        Check::new("largest |ΔH| / H", worst).near(0.0, 1e-4, "order h²"),
        Check::new("|ΔH| / H of 10⁶ masses, t from 30 to 50", late).near(
            early,
            0.2 * early,
            "no drift: as from 10 to 30",
        ),
    ];
    checks.extend(heats.checks());
    let figure = figure([&fine, &first], &errors, &heats);
    report(
        "The chain of Fermi, Pasta, Ulam and Tsingou",
        &figure,
        CAPTION,
        &checks,
    )
}

const CAPTION: &str = "A spring stretched by d has the force d + αd² + βd³ with α = 0.25, and β = 1 in the bath only. Above: the energy in the first modes of 31 masses, in parts of the whole, with h = 0.05, and in the first mode with the step of 1955; and the energy error of 10⁶ masses that start with disordered momenta. Below: the 31 modes, of frequency ω, coordinate Q and momentum P, in a heat bath with the friction ν = 0.2; bars are ± 2 standard errors of 600 paths of seed 4, and lines are exact. With linear springs the positions have the exact distribution, and ⟨P²⟩ a factor 1 − h²ω²/4. With other springs the modes are coupled: ⟨Q ∂V/∂Q⟩ is the temperature, and ω²⟨Q²⟩ is 0.473 T in each mode.";

fn figure(
    [energies, original]: [&[Energies]; 2],
    errors: &[(f64, f64)],
    heats: &bath::Heats,
) -> Figure {
    let mut left = Panel::new(
        "Energies of modes, 31 masses",
        Axis::new("periods of the first mode", 0.0..PERIODS),
        Axis::new("part of the energy", 0.0..1.05),
    )
    .legend(Corner::Below);
    let pens = [(BLUE, 1.6), (ORANGE, 1.2), (BLACK, 0.8), (PURPLE, 2.0)];
    for (k, (color, width)) in pens.into_iter().enumerate() {
        let points = energies.iter().map(|e| (e.0, e.1[k])).collect();
        left = left.with(Layer::new(
            format!("mode {}", k + 1),
            points,
            Pen::line(color, width),
        ));
    }
    let points = original.iter().map(|e| (e.0, e.1[0])).collect();
    left = left.with(Layer::new(
        "mode 1, h² = 1/8",
        points,
        Pen::dashed(GREY, 1.4, (5.0, 3.0)),
    ));
    let largest = errors.iter().fold(0.0f64, |m, e| m.max(e.1));
    let right = Panel::new(
        "Energy error, 10⁶ masses, h = 0.05",
        Axis::new("time t", 0.0..errors.last().map_or(1.0, |e| e.0)),
        Axis::new("relative energy error", 0.0..1.2 * largest),
    )
    .with(Layer::new(
        "Störmer–Verlet",
        errors.to_vec(),
        Pen::line(hues::STORMER_VERLET, 1.2),
    ));
    let rows = [vec![left, right], heats.panels()].map(|panels| Row {
        height: 400,
        panels,
    });
    Figure {
        name: "fput",
        width: 980,
        rows: rows.into(),
    }
}

//! Noise that dominates, vanishes, or makes the equations unsolvable.

use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

use super::table::{Table, Verdict};

struct Kubo {
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

/// Noise of degree four in the momentum.
struct Rotor {
    s: f64,
}

#[variational(midpoint)]
impl Rotor {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        0.25 * self.s * p.powi(4)
    }
}

/// A damped oscillator in a bath of temperature 1.
struct Bath {
    omega: f64,
    nu: f64,
}

#[variational(midpoint)]
impl Bath {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.omega.powi(2) * q * q
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        (2.0 * self.nu).sqrt() * q
    }
}

fn circle() -> Result<f64, StepError> {
    let h = 0.1_f64;
    let mut worst = 0.0_f64;
    for strength in [0.1, 1.0, 10.0] {
        let sigma = strength / h.sqrt();
        let kubo = Integrator::new(Kubo { sigma }, Midpoint);
        let path = kubo.trajectory(State::new([1.0], [0.0]), h, Wiener::new(5));
        for state in path.take(100_000) {
            let state = state?;
            worst = worst.max((state.q[0].hypot(state.p[0]) - 1.0).abs());
        }
    }
    Ok(worst)
}

const H: f64 = 0.3;

fn rotor_start() -> State<[f64; 1]> {
    State::new([0.0], [2.0])
}

/// Finds the first step without a solution.
fn without_solution() -> (Verdict, String) {
    let rotor = Integrator::new(Rotor { s: 0.3 }, Midpoint);
    let path = rotor.trajectory(rotor_start(), H, Wiener::new(1));
    match path.take(100_000).find_map(Result::err) {
        Some(StepError::BranchLost { t, dw, reached, .. }) => {
            let numbers = format!(
                "at t = {t:.1}: the solution ends at {reached:.2} of ΔW = {}",
                number(dw[0], 3)
            );
            (Verdict::Stops, numbers)
        }
        Some(error) => (Verdict::Unresolved, error.to_string()),
        None => (Verdict::Holds, String::new()),
    }
}

fn refined() -> (Verdict, String) {
    let rotor = Integrator::new(Rotor { s: 0.3 }, Midpoint);
    let mut path = rotor
        .trajectory(rotor_start(), H, Wiener::new(1))
        .refine(16);
    for _ in 0..5000 {
        if let Some(Err(error)) = path.next() {
            return (Verdict::Stops, error.to_string());
        }
    }
    let made = path.refinements();
    let numbers = format!(
        "{} of 5,000 steps in parts, the smallest halved {} times",
        made.steps, made.deepest
    );
    (Verdict::Holds, numbers)
}

/// Number of steps of each path on which truncated increments are tried.
const LONG: usize = 20_000;
/// Number of paths.
const ROTORS: u64 = 20;

/// Counts the paths that fail with plain and with truncated increments. Noise of degree four moves
/// p without bound, so a bound of ΔW does not bound p: truncation does not help here, and a smaller
/// step only delays the failure.
fn truncated() -> (Verdict, String) {
    let rotor = Integrator::new(Rotor { s: 0.3 }, Midpoint);
    let mut counts = Vec::new();
    let mut failed = 0;
    for h in [H, 0.1, 0.05, 0.02] {
        let fails = |noise: &mut dyn Noise| {
            let mut path = rotor.trajectory(rotor_start(), h, noise).take(LONG);
            u32::from(path.any(|state| state.is_err()))
        };
        let (mut plain, mut truncated) = (0, 0);
        for number in 0..ROTORS {
            let noise = || Wiener::new(1).path(number);
            plain += fails(&mut noise());
            truncated += fails(&mut Truncated::new(noise()));
        }
        failed += truncated;
        counts.push(format!("h = {h}: {plain}, {truncated}"));
    }
    let verdict = if failed == 0 {
        Verdict::Holds
    } else {
        Verdict::Stops
    };
    let counts = counts.join("; ");
    (
        verdict,
        format!("of {ROTORS} paths of 20,000 steps fail, plain and truncated: {counts}"),
    )
}

/// Checks the mean square momentum. The midpoint rule has its stationary value exactly: 1 for every
/// ωh.
fn temperature(omega: f64) -> Result<(Verdict, String), StepError> {
    const PATHS: u64 = 100;
    const STEPS: usize = 10_000;
    let bath = Integrator::new(Bath { omega, nu: 0.5 }, Midpoint);
    let mut means = Vec::new();
    for number in 0..PATHS {
        let noise = Wiener::new(11).path(number);
        let mut sum = 0.0;
        let path = bath.trajectory(State::new([0.0], [0.0]), 1.0, noise);
        for state in path.skip(1000).take(STEPS) {
            sum += state?.p[0].powi(2);
        }
        means.push(sum / STEPS as f64);
    }
    let n = PATHS as f64;
    let mean = means.iter().sum::<f64>() / n;
    let variance = means.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let error = (variance / n).sqrt();
    let holds = (mean - 1.0).abs() < 4.0 * error;
    let verdict = if holds {
        Verdict::Holds
    } else {
        Verdict::Unresolved
    };
    Ok((
        verdict,
        format!("ωh = {omega}: ⟨p²⟩ = {mean:.4} ± {error:.4}, exactly 1"),
    ))
}

/// Returns whether steps with σ → 0 equal steps without noise, bit for bit.
fn vanishing() -> Result<bool, StepError> {
    let start = State::new([1.0], [0.3]);
    let end = |s: f64, noise: &mut dyn Noise| -> Result<State<[f64; 1]>, StepError> {
        let rotor = Integrator::new(Rotor { s }, Midpoint);
        let mut end = start;
        for state in rotor.trajectory(start, 0.05, noise).take(10_000) {
            end = state?;
        }
        Ok(end)
    };
    let still = end(1.0, &mut NoNoise)?;
    let bits = |s: &State<[f64; 1]>| (s.q[0].to_bits(), s.p[0].to_bits());
    let mut same = true;
    for s in [0.0, 1e-30, 1e-300] {
        same &= bits(&end(s, &mut Wiener::new(2))?) == bits(&still);
    }
    Ok(same)
}

fn holds<T>(found: Result<T, StepError>, judge: impl Fn(T) -> (bool, String)) -> (Verdict, String) {
    match found.map(judge) {
        Ok((true, numbers)) => (Verdict::Holds, numbers),
        Ok((false, numbers)) => (Verdict::Unresolved, numbers),
        Err(error) => (Verdict::Stops, error.to_string()),
    }
}

pub(super) fn rows(table: &mut Table) {
    let row = ["Kubo", "σ√h = 0.1 … 10: turns at random", "midpoint"];
    let found = holds(circle(), |worst| {
        (
            worst < 1e-11,
            format!("radius within {} over 100,000 steps", number(worst, 2)),
        )
    });
    table.add(row, Verdict::Holds, found);
    let row = [
        "H₁ of degree 4 in p",
        "equations without a solution",
        "midpoint",
    ];
    table.add(row, Verdict::Stops, without_solution());
    let row = [
        "H₁ of degree 4 in p",
        "equations without a solution",
        "midpoint, refined",
    ];
    table.add(row, Verdict::Holds, refined());
    let row = [
        "H₁ of degree 4 in p",
        "equations without a solution",
        "midpoint, truncated",
    ];
    table.add(row, Verdict::Stops, truncated());
    for omega in [0.5, 2.0, 10.0] {
        let row = ["Langevin oscillator", "large steps", "midpoint"];
        let found = temperature(omega).unwrap_or_else(|e| (Verdict::Stops, e.to_string()));
        table.add(row, Verdict::Holds, found);
    }
    let row = ["H₁ of degree 4 in p", "σ → 0", "midpoint"];
    let found = holds(vanishing(), |same| {
        (same, "the bits of the step without noise".to_owned())
    });
    table.add(row, Verdict::Holds, found);
}

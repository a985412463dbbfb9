//! Ten million steps, and numbers of extreme size.

use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;

use super::table::{Table, Verdict};

struct Pendulum;

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
}

struct Oscillator;

#[variational(endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
}

struct Kepler;

#[variational(midpoint)]
impl Kepler {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + q[0].hypot(q[1]).recip()
    }
}

const STEPS: usize = 10_000_000;
/// Number of steps of an orbit in the plane, which takes longer.
const ORBIT: usize = 3_000_000;
/// Number of steps over which the oscillation of the energy is averaged.
const BLOCK: usize = 100_000;

/// Largest allowed block mean of a random walk, in standard deviations of the walk.
const WALK: f64 = 4.0;
/// The same bound for rounding errors of larger steps, which are not independent of the state. From
/// some starts they add up in proportion to the time, and compensated sums do not correct the
/// errors within the increments. A loop of the two lines q += h p, p −= h q behaves the same.
const BIASED: f64 = 16.0;

/// Returns the standard deviation of a random walk of rounding errors of ε/2.
fn walk(steps: usize) -> f64 {
    0.5 * f64::EPSILON * (steps as f64).sqrt()
}

/// The changes of a quantity along a run.
struct Found {
    /// The largest change in the first and in the last tenth of the run.
    tenths: [f64; 2],
    /// The largest change of its mean over a block from the mean over the first block, in units of
    /// the random walk.
    mean: f64,
    /// The change of the mean over the last block, with its sign.
    end: f64,
}

/// Returns weights with which means of quasi-periodic functions converge faster than any power
/// (Das, Saiki, Sander and Yorke, Nonlinearity 30, 2017).
fn weights() -> Vec<f64> {
    let weight = |k: usize| {
        let x = (k as f64 + 0.5) / BLOCK as f64;
        (-1.0 / (x * (1.0 - x))).exp()
    };
    let mut weights: Vec<f64> = (0..BLOCK).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    for weight in &mut weights {
        *weight /= sum;
    }
    weights
}

/// Returns the changes of a quantity along states.
fn watch<const N: usize>(
    states: impl Iterator<Item = Result<State<[f64; N]>, StepError>>,
    steps: usize,
    start: &State<[f64; N]>,
    quantity: impl Fn(&State<[f64; N]>) -> f64,
) -> Result<Found, StepError> {
    let (weights, first) = (weights(), quantity(start));
    let mut found = Found {
        tenths: [0.0; 2],
        mean: 0.0,
        end: 0.0,
    };
    let (mut first_mean, mut mean) = (None, 0.0);
    for (step, state) in (0..steps).zip(states) {
        let change = quantity(&state?) - first;
        for (tenth, inside) in [step < steps / 10, step >= steps - steps / 10]
            .into_iter()
            .enumerate()
        {
            if inside {
                found.tenths[tenth] = found.tenths[tenth].max(change.abs());
            }
        }
        mean += weights[step % BLOCK] * change;
        if step % BLOCK == BLOCK - 1 {
            found.end = (mean - *first_mean.get_or_insert(mean)) / walk(steps);
            found.mean = found.mean.max(found.end.abs());
            mean = 0.0;
        }
    }
    Ok(found)
}

fn pendulum(h: f64) -> Result<Found, StepError> {
    let midpoint = Integrator::new(Pendulum, Midpoint);
    let start = State::new([1.2], [0.0]);
    let energy = |s: &State<[f64; 1]>| 0.5 * s.p[0] * s.p[0] - s.q[0].cos();
    watch(
        midpoint.trajectory(start, h, NoNoise),
        STEPS,
        &start,
        energy,
    )
}

/// Follows a circle; the midpoint rule conserves the angular momentum exactly.
fn orbit(h: f64) -> Result<Found, StepError> {
    let midpoint = Integrator::new(Kepler, Midpoint);
    let start = State::new([1.0, 0.0], [0.0, 1.0]);
    let angular = |s: &State<[f64; 2]>| s.q[0] * s.p[1] - s.q[1] * s.p[0];
    watch(
        midpoint.trajectory(start, h, NoNoise),
        ORBIT,
        &start,
        angular,
    )
}

/// Follows q² + p² + hqp, which the endpoint rule conserves exactly.
fn oscillator(h: f64, compensated: bool) -> Result<Found, StepError> {
    let endpoint = Integrator::new(Oscillator, Endpoint);
    let start = State::new([1.2], [0.3]);
    let conserved = |s: &State<[f64; 1]>| s.q[0] * s.q[0] + s.p[0] * s.p[0] + h * s.q[0] * s.p[0];
    let path = endpoint.trajectory(start, h, NoNoise);
    let path = if compensated {
        path.compensated()
    } else {
        path
    };
    watch(path, STEPS, &start, conserved)
}

fn judge(found: Result<Found, StepError>, bound: f64, what: &str) -> (Verdict, String) {
    match found {
        Ok(Found {
            tenths: [first, last],
            mean,
            end,
        }) => {
            let verdict = if mean < bound {
                Verdict::Holds
            } else {
                Verdict::Unresolved
            };
            (
                verdict,
                format!(
                    "{what} within {} in the first tenth, {} in the last; its block means within {mean:.3} ε√n/2, the last {}",
                    number(first, 3),
                    number(last, 3),
                    number(end, 3)
                ),
            )
        }
        Err(error) => (Verdict::Stops, error.to_string()),
    }
}

/// Tries steps of sizes from 10⁻¹² to 10³ from states from the smallest to the largest numbers: the
/// result is finite, or an error.
fn sizes() -> (Verdict, String) {
    let midpoint = Integrator::new(Pendulum, Midpoint);
    let (mut made, mut refused, mut wrong) = (0, 0, 0);
    for q in [
        0.0,
        5e-324,
        1e-310,
        1e-100,
        1.0,
        1e15,
        1e100,
        1e300,
        f64::MAX,
    ] {
        for p in [0.0, -5e-324, 1e-310, 1e-160, 1.0, 1e77, 1e154, f64::MAX] {
            for h in [1e-12, 1e-6, 0.1, 1.0, 1e3] {
                let start = State::new([q], [p]);
                let mut state = start;
                match midpoint.step(&mut state, h, &[]) {
                    Ok(()) if state.q[0].is_finite() && state.p[0].is_finite() => made += 1,
                    Err(_) if state == start => refused += 1,
                    _ => wrong += 1,
                }
            }
        }
    }
    let verdict = if wrong == 0 {
        Verdict::Holds
    } else {
        Verdict::Unresolved
    };
    (
        verdict,
        format!("{made} steps, {refused} errors with the state untouched"),
    )
}

pub(super) fn rows(table: &mut Table) {
    for (h, hard, bound) in [
        (0.01, "10⁷ steps of 0.01: rounding errors", WALK),
        (0.02, "10⁷ steps of 0.02: rounding errors", WALK),
        (0.03, "10⁷ steps of 0.03: rounding errors", WALK),
        (0.1, "10⁷ steps of 0.1: rounding errors", BIASED),
    ] {
        let row = ["pendulum", hard, "midpoint"];
        table.add(row, Verdict::Holds, judge(pendulum(h), bound, "energy"));
    }
    for (h, hard) in [
        (0.01, "3·10⁶ steps of 0.01: rounding errors"),
        (0.03, "3·10⁶ steps of 0.03: rounding errors"),
    ] {
        let row = ["Kepler, circle", hard, "midpoint"];
        let found = judge(orbit(h), WALK, "angular momentum");
        table.add(row, Verdict::Holds, found);
    }
    for (h, hard, plain, compensated) in [
        (0.01, "10⁷ steps of 0.01: rounding errors", WALK, 0.1),
        (0.1, "10⁷ steps of 0.1: rounding errors", BIASED, 2.0),
    ] {
        for (method, bound) in [("endpoint", plain), ("endpoint, compensated", compensated)] {
            let row = ["linear oscillator", hard, method];
            let found = oscillator(h, method != "endpoint");
            table.add(row, Verdict::Holds, judge(found, bound, "q² + p² + hqp"));
        }
    }
    let row = ["pendulum", "numbers from 10⁻³²⁴ to 10³⁰⁸", "midpoint"];
    table.add(row, Verdict::Holds, sizes());
}

//! Ten million steps, and numbers of extreme size.

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

const H: f64 = 0.01;
const STEPS: usize = 10_000_000;
/// Steps over which the oscillation of the energy is averaged out.
const BLOCK: usize = 100_000;

/// What the midpoint rule conserves up to h⁴: H − (h²/24)(V″p² + V′²).
fn modified_energy(state: &State<1>) -> f64 {
    let (sin, cos) = state.q[0].sin_cos();
    let p2 = state.p[0] * state.p[0];
    0.5 * p2 - cos - H * H / 24.0 * (cos * p2 + sin * sin)
}

/// The largest change of the mean over a block, in units of the random walk ε√n/2.
fn pendulum() -> Result<f64, StepError> {
    let midpoint = Integrator::new(Pendulum, Midpoint);
    let start = State::new([1.2], [0.0]);
    let level = modified_energy(&start);
    let (mut first, mut worst, mut sum) = (None, 0.0_f64, 0.0);
    for (step, state) in (1..=STEPS).zip(midpoint.trajectory(start, H, NoNoise)) {
        sum += modified_energy(&state?) - level;
        if step % BLOCK == 0 {
            let mean = sum / BLOCK as f64;
            worst = worst.max((mean - *first.get_or_insert(mean)).abs());
            sum = 0.0;
        }
    }
    Ok(worst / (0.5 * f64::EPSILON * (STEPS as f64).sqrt()))
}

/// The largest change of q² + p² + hqp, which the endpoint rule conserves, in units of the random walk.
fn oscillator(compensated: bool) -> Result<f64, StepError> {
    let endpoint = Integrator::new(Oscillator, Endpoint);
    let start = State::new([1.2], [0.3]);
    let conserved = |s: &State<1>| s.q[0] * s.q[0] + s.p[0] * s.p[0] + H * s.q[0] * s.p[0];
    let path = endpoint.trajectory(start, H, NoNoise);
    let path = if compensated {
        path.compensated()
    } else {
        path
    };
    let mut worst = 0.0_f64;
    for state in path.take(STEPS) {
        worst = worst.max((conserved(&state?) - conserved(&start)).abs());
    }
    Ok(worst / (0.5 * f64::EPSILON * (STEPS as f64).sqrt()))
}

fn judge(walk: Result<f64, StepError>, bound: f64) -> (Verdict, String) {
    match walk {
        Ok(walk) => {
            let verdict = if walk < bound {
                Verdict::Holds
            } else {
                Verdict::Unresolved
            };
            (
                verdict,
                format!("largest error {walk:.3} of the random walk ε√n/2"),
            )
        }
        Err(error) => (Verdict::Stops, error.to_string()),
    }
}

/// Steps of sizes from 10⁻¹² to 10³ from states from the smallest to the largest numbers: finite, or an error.
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
    let row = ["pendulum", "10⁷ steps: rounding errors", "midpoint"];
    table.add(row, Verdict::Holds, judge(pendulum(), 4.0));
    let row = [
        "linear oscillator",
        "10⁷ steps: rounding errors",
        "endpoint",
    ];
    table.add(row, Verdict::Holds, judge(oscillator(false), 8.0));
    let row = [
        "linear oscillator",
        "10⁷ steps: rounding errors",
        "endpoint, compensated",
    ];
    table.add(row, Verdict::Holds, judge(oscillator(true), 0.1));
    let row = ["pendulum", "numbers from 10⁻³²⁴ to 10³⁰⁸", "midpoint"];
    table.add(row, Verdict::Holds, sizes());
}

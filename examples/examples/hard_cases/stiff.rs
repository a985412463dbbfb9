//! Oscillators whose period is far below the step. The step is 1, so that ω is ωh.

use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::table::{Table, Verdict};

pub(super) struct Linear {
    pub(super) omega: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Linear {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.omega.powi(2) * q * q
    }
}

/// The frequency of the largest curvature along the motion, at q = 1.
pub(super) struct Quartic {
    pub(super) omega: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Quartic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.omega.powi(2) / 12.0 * q.powi(4)
    }
}

/// Numbers of steps of a short and a long run: an energy that grows slowly exceeds its bound in the
/// long run only.
const STEPS: [usize; 2] = [5000, 100_000];

/// Returns the largest energy over a run in units of the first one; `None` if it passes a million
/// or a step fails.
pub(super) fn largest_energy<S, R>(system: S, rule: R, steps: usize) -> Option<f64>
where
    S: Variational<R> + System<Dims = Dims<1, 0>>,
{
    let integrator = Integrator::new(system, rule);
    let start = State::new([1.0], [0.0]);
    let first = integrator.system().hamiltonian(&start).ok()?;
    let mut largest = 1.0_f64;
    for state in integrator.trajectory(start, 1.0, NoNoise).take(steps) {
        let energy = integrator.system().hamiltonian(&state.ok()?).ok()?;
        largest = largest.max(energy / first);
        if largest > 1e6 {
            return None;
        }
    }
    Some(largest)
}

/// Returns the largest energy from ωh = 0.1 to 1000; or the first ωh, in steps of a thousandth, at
/// which the energy passes its bound. Islands of instability lie between stable steps, and a
/// bisection misses the first of them.
fn sweep(run: impl Fn(f64) -> Option<f64>) -> Result<f64, f64> {
    let mut largest = 1.0_f64;
    for omega in [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0] {
        match run(omega) {
            Some(energy) => largest = largest.max(energy),
            None => {
                let mut scan = (100..).map(|k| f64::from(k) / 1000.0);
                let first = scan.find(|&scanned| scanned >= omega || run(scanned).is_none());
                return Err(first.unwrap_or(omega));
            }
        }
    }
    Ok(largest)
}

/// Judges short and long runs.
fn judge(run: impl Fn(f64, usize) -> Option<f64>) -> (Verdict, String) {
    match STEPS.map(|steps| sweep(|omega| run(omega, steps))) {
        [Ok(_), Ok(largest)] => {
            let numbers =
                format!("ωh = 0.1 … 1000, 10⁵ steps: energy at most {largest:.12} of the first");
            (Verdict::Holds, numbers)
        }
        [Err(short), Err(long)] => {
            let numbers = format!("from ωh = {short:.3} within 5,000 steps, {long:.3} within 10⁵");
            (Verdict::BlowsUp, numbers)
        }
        [Ok(_), Err(long)] => (
            Verdict::BlowsUp,
            format!("from ωh = {long:.3} within 10⁵ steps"),
        ),
        [Err(short), Ok(_)] => (
            Verdict::Unresolved,
            format!("within 5,000 steps from ωh = {short:.3}, and not within more"),
        ),
    }
}

pub(super) fn rows(table: &mut Table) {
    use Verdict::{BlowsUp, Holds};
    let case = ["linear oscillator", "stiff: ωh to 1000"];
    let row = |method| [case[0], case[1], method];
    table.add(
        row("midpoint"),
        Holds,
        judge(|omega, steps| largest_energy(Linear { omega }, Midpoint, steps)),
    );
    table.add(
        row("endpoint"),
        BlowsUp,
        judge(|omega, steps| largest_energy(Linear { omega }, Endpoint, steps)),
    );
    table.add(
        row("initial point"),
        BlowsUp,
        judge(|omega, steps| largest_energy(Linear { omega }, InitialPoint, steps)),
    );
    let case = ["quartic oscillator", "stiff: ωh to 1000"];
    let row = |method| [case[0], case[1], method];
    table.add(
        row("midpoint"),
        Holds,
        judge(|omega, steps| largest_energy(Quartic { omega }, Midpoint, steps)),
    );
    table.add(
        row("endpoint"),
        BlowsUp,
        judge(|omega, steps| largest_energy(Quartic { omega }, Endpoint, steps)),
    );
    table.add(
        row("initial point"),
        BlowsUp,
        judge(|omega, steps| largest_energy(Quartic { omega }, InitialPoint, steps)),
    );
}

//! Orbits close to singular and unstable places.

use std::f64::consts::{PI, TAU};

use sve_runtime::Variational;
use sve_runtime::plot::page::number;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::table::{Table, Verdict};

struct Kepler;

#[variational(midpoint)]
impl Kepler {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + q[0].hypot(q[1]).recip()
    }

    #[symmetry]
    fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

/// The planet in the time s of dt = r ds (Poincaré), on the level −½ of its energy.
struct Regular;

#[variational(midpoint)]
impl Regular {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r = q[0].hypot(q[1]);
        0.5 * (v[0] * v[0] + v[1] * v[1]) / r + 1.0 - 0.5 * r
    }
}

struct DoublePendulum;

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + 9.8 * (2.0 * q[0].cos() + q[1].cos())
    }
}

struct HenonHeiles;

#[variational(midpoint)]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y.powi(3) / 3.0
    }
}

struct SphericalPendulum;

#[variational(midpoint)]
impl SphericalPendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + (q[0].sin() * v[1]).powi(2)) + 9.8 * q[0].cos()
    }
}

/// The largest changes of a quantity over the two halves of a run, relative to its first value.
type Halves = [f64; 2];

/// A function of the state.
type Quantity<const N: usize> = fn(&State<[f64; N]>) -> f64;

/// Returns the changes of some quantities along a run.
fn changes<S, const N: usize, const K: usize>(
    system: S,
    start: State<[f64; N]>,
    h: f64,
    steps: usize,
    quantities: [Quantity<N>; K],
) -> Result<[Halves; K], StepError>
where
    S: Variational<Midpoint> + System<Dims = Dims<N, 0>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let first = quantities.map(|quantity| quantity(&start));
    let mut worst = [[0.0_f64; 2]; K];
    for (step, state) in integrator
        .trajectory(start, h, NoNoise)
        .take(steps)
        .enumerate()
    {
        let (state, half) = (state?, usize::from(step >= steps / 2));
        for k in 0..K {
            let change = (quantities[k](&state) / first[k] - 1.0).abs();
            worst[k][half] = worst[k][half].max(change);
        }
    }
    Ok(worst)
}

/// Holds if the change is small over the whole run, and no larger in the second half than chaos
/// explains.
fn judge(changes: &Result<Halves, StepError>, bound: f64, what: &str) -> (Verdict, String) {
    match changes {
        Ok([first, second]) => {
            let largest = first.max(*second);
            let holds = largest < bound && *second < 3.0 * first;
            let verdict = if holds {
                Verdict::Holds
            } else {
                Verdict::Unresolved
            };
            (
                verdict,
                format!(
                    "{what} within {} (first half {}, second half {})",
                    number(largest, 2),
                    number(*first, 2),
                    number(*second, 2)
                ),
            )
        }
        Err(error) => (Verdict::Stops, error.to_string()),
    }
}

/// Returns one of several quantities.
fn of<const K: usize>(
    changes: &Result<[Halves; K], StepError>,
    k: usize,
) -> Result<Halves, StepError> {
    changes.clone().map(|changes| changes[k])
}

fn aphelion(e: f64) -> State<[f64; 2]> {
    State::new([1.0 + e, 0.0], [0.0, ((1.0 - e) / (1.0 + e)).sqrt()])
}

fn energy(state: &State<[f64; 2]>) -> f64 {
    let kinetic = 0.5 * (state.p[0].powi(2) + state.p[1].powi(2));
    kinetic - state.q[0].hypot(state.q[1]).recip()
}

fn angular(state: &State<[f64; 2]>) -> f64 {
    state.q[0] * state.p[1] - state.q[1] * state.p[0]
}

pub(super) fn rows(table: &mut Table) {
    table.begin("Kepler");
    kepler(table);
    table.begin("double pendulum and Hénon–Heiles");
    chaos(table);
    table.begin("spherical pendulum");
    coordinates(table);
}

/// Kepler orbits with several numbers of steps a period, which show the effect of the step size:
/// the energy error is of order h².
const LENGTHS: [(u32, &str, f64); 3] = [
    (2500, "1,000 periods of 2,500 steps", 0.04),
    (5000, "1,000 periods of 5,000 steps", 0.01),
    (10_000, "1,000 periods of 10,000 steps", 0.0025),
];

fn kepler(table: &mut Table) {
    use Verdict::{Holds, Unresolved};
    let run = |e: f64, n: u32| {
        let h = TAU / f64::from(n);
        let quantities = [energy as fn(&State<[f64; 2]>) -> f64, angular];
        changes(Kepler, aphelion(e), h, 1000 * n as usize, quantities)
    };
    for (n, hard, bound) in LENGTHS {
        let found = run(0.9, n);
        let row = ["Kepler, e = 0.9", hard, "midpoint"];
        table.add(row, Holds, judge(&of(&found, 0), bound, "energy"));
        let angular = judge(&of(&found, 1), 1e-10, "angular momentum");
        table.add(row, Holds, angular);
    }
    let row = [
        "Kepler, e = 0.99",
        "pericentre in 10⁻⁴ of a period",
        "midpoint",
    ];
    let found = run(0.99, 20_000);
    table.add(row, Unresolved, judge(&of(&found, 0), 0.01, "energy"));
    let quantities = [energy as fn(&State<[f64; 2]>) -> f64, angular];
    let found = changes(Regular, aphelion(0.99), TAU / 2000.0, 2_000_000, quantities);
    let row = [
        "Kepler, e = 0.99",
        "pericentre in 10⁻⁴ of a period",
        "midpoint, dt = r ds",
    ];
    table.add(row, Holds, judge(&of(&found, 0), 0.05, "energy"));
    let angular = judge(&of(&found, 1), 1e-10, "angular momentum");
    table.add(row, Holds, angular);
}

fn chaos(table: &mut Table) {
    let start = State::new([PI - 1e-3, PI + 1e-3], [0.0; 2]);
    let energy = |state: &State<[f64; 2]>| DoublePendulum.hamiltonian(state).unwrap_or(f64::NAN);
    let found = changes(DoublePendulum, start, 1e-3, 200_000, [energy]);
    let row = [
        "double pendulum",
        "released near upright: chaos",
        "midpoint",
    ];
    table.add(row, Verdict::Holds, judge(&of(&found, 0), 1e-3, "energy"));

    let (level, y) = (1.0 / 6.0 - 1e-3, 0.1_f64);
    let momentum = (2.0 * level - y * y + 2.0 / 3.0 * y.powi(3)).sqrt();
    let start = State::new([0.0, y], [momentum, 0.0]);
    let energy = |state: &State<[f64; 2]>| HenonHeiles.hamiltonian(state).unwrap_or(f64::NAN);
    let found = changes(HenonHeiles, start, 0.02, 500_000, [energy]);
    let row = [
        "Hénon–Heiles",
        "0.001 below the energy of escape",
        "midpoint",
    ];
    table.add(row, Verdict::Holds, judge(&of(&found, 0), 3e-3, "energy"));
}

/// Makes steps until one ends with an error, and reports where.
fn stopped<S>(system: S, start: State<[f64; 2]>, h: f64, steps: usize) -> (Verdict, String)
where
    S: Variational<Midpoint> + System<Dims = Dims<2, 0>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let mut path = integrator.trajectory(start, h, NoNoise);
    for _ in 0..steps {
        let last = *path.state();
        if let Some(Err(error)) = path.next() {
            let kind = match error {
                StepError::BranchLost { .. } => "BranchLost",
                StepError::NotConverged { .. } => "NotConverged",
                StepError::Singular { .. } => "Singular",
                StepError::SingularMass { .. } => "SingularMass",
                StepError::NonFiniteResult { .. } => "NonFiniteResult",
                other => return (Verdict::Stops, other.to_string()),
            };
            let numbers = format!("{kind} at t = {:.4}, q = {}", last.t, vector(last.q));
            return (Verdict::Stops, numbers);
        }
    }
    let end = path.state();
    let finite = end.q.iter().chain(&end.p).all(|x| x.is_finite());
    let verdict = if finite {
        Verdict::Holds
    } else {
        Verdict::Unresolved
    };
    (
        verdict,
        format!("q = {} at t = {:.2}", vector(end.q), end.t),
    )
}

fn vector(q: [f64; 2]) -> String {
    format!("[{}]", q.map(|x| number(x, 5)).join(", "))
}

fn coordinates(table: &mut Table) {
    let meridian = State::new([1.0, 0.0], [0.0, 0.0]);
    let row = [
        "spherical pendulum",
        "through the pole of its coordinates",
        "midpoint",
    ];
    table.add(
        row,
        Verdict::Holds,
        stopped(SphericalPendulum, meridian, 0.01, 2000),
    );
    let pole = State::new([0.0, 0.0], [0.0, 0.1]);
    let row = [
        "spherical pendulum",
        "at the pole, turning about it",
        "midpoint",
    ];
    table.add(
        row,
        Verdict::Stops,
        stopped(SphericalPendulum, pole, 0.01, 1),
    );
    let fall = State::new([1.0, 0.0], [0.0, 0.0]);
    let row = ["Kepler", "collision at t = 1.1107", "midpoint"];
    table.add(row, Verdict::Stops, stopped(Kepler, fall, 1e-3, 100_000));
}

//! Orbits close to singular and unstable places.

use std::f64::consts::{PI, TAU};

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

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

/// The largest change of a quantity over the two halves of a run, relative to its first value.
fn changes<S, const N: usize>(
    system: S,
    start: State<N>,
    h: f64,
    steps: usize,
    quantity: impl Fn(&State<N>) -> f64,
) -> Result<[f64; 2], StepError>
where
    S: Variational<Midpoint> + System<Dims = Dims<N, 0>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let first = quantity(&start);
    let mut worst = [0.0_f64; 2];
    for (step, state) in integrator
        .trajectory(start, h, NoNoise)
        .take(steps)
        .enumerate()
    {
        let half = usize::from(step > steps / 2);
        worst[half] = worst[half].max((quantity(&state?) / first - 1.0).abs());
    }
    Ok(worst)
}

/// Holds where the change is small, and no larger in the second half than chaos explains.
fn judge(changes: Result<[f64; 2], StepError>, bound: f64, what: &str) -> (Verdict, String) {
    match changes {
        Ok([first, second]) => {
            let holds = first < bound && second < 3.0 * first;
            let verdict = if holds {
                Verdict::Holds
            } else {
                Verdict::Unresolved
            };
            (
                verdict,
                format!("{what} within {first:.1e}, second half {second:.1e}"),
            )
        }
        Err(error) => (Verdict::Stops, error.to_string()),
    }
}

fn aphelion(e: f64) -> State<2> {
    State::new([1.0 + e, 0.0], [0.0, ((1.0 - e) / (1.0 + e)).sqrt()])
}

fn energy(state: &State<2>) -> f64 {
    let kinetic = 0.5 * (state.p[0].powi(2) + state.p[1].powi(2));
    kinetic - state.q[0].hypot(state.q[1]).recip()
}

fn angular(state: &State<2>) -> f64 {
    state.q[0] * state.p[1] - state.q[1] * state.p[0]
}

pub(super) fn rows(table: &mut Table) {
    kepler(table);
    chaos(table);
    coordinates(table);
}

fn kepler(table: &mut Table) {
    use Verdict::{Holds, Unresolved};
    let run = |e: f64, n: u32, quantity: fn(&State<2>) -> f64| {
        let h = TAU / f64::from(n);
        changes(Kepler, aphelion(e), h, 1000 * n as usize, quantity)
    };
    let row = [
        "Kepler, e = 0.9",
        "1,000 periods, 5,000 steps each",
        "midpoint",
    ];
    table.add(row, Holds, judge(run(0.9, 5000, energy), 0.01, "energy"));
    table.add(
        row,
        Holds,
        judge(run(0.9, 5000, angular), 1e-10, "angular momentum"),
    );
    let row = [
        "Kepler, e = 0.99",
        "pericentre in 10⁻⁴ of a period",
        "midpoint",
    ];
    table.add(
        row,
        Unresolved,
        judge(run(0.99, 20_000, energy), 0.01, "energy"),
    );
    let regular = |quantity: fn(&State<2>) -> f64| {
        changes(Regular, aphelion(0.99), TAU / 2000.0, 2_000_000, quantity)
    };
    let row = [
        "Kepler, e = 0.99",
        "pericentre in 10⁻⁴ of a period",
        "midpoint, dt = r ds",
    ];
    table.add(row, Holds, judge(regular(energy), 0.05, "energy"));
    table.add(
        row,
        Holds,
        judge(regular(angular), 1e-10, "angular momentum"),
    );
}

fn chaos(table: &mut Table) {
    let start = State::new([PI - 1e-3, PI + 1e-3], [0.0; 2]);
    let energy = |state: &State<2>| DoublePendulum.hamiltonian(state).unwrap_or(f64::NAN);
    let found = changes(DoublePendulum, start, 1e-3, 200_000, energy);
    let row = [
        "double pendulum",
        "released near upright: chaos",
        "midpoint",
    ];
    table.add(row, Verdict::Holds, judge(found, 1e-3, "energy"));

    let (level, y) = (1.0 / 6.0 - 1e-3, 0.1_f64);
    let momentum = (2.0 * level - y * y + 2.0 / 3.0 * y.powi(3)).sqrt();
    let start = State::new([0.0, y], [momentum, 0.0]);
    let energy = |state: &State<2>| HenonHeiles.hamiltonian(state).unwrap_or(f64::NAN);
    let found = changes(HenonHeiles, start, 0.02, 500_000, energy);
    let row = [
        "Hénon–Heiles",
        "0.001 below the energy of escape",
        "midpoint",
    ];
    table.add(row, Verdict::Holds, judge(found, 3e-3, "energy"));
}

/// A step that has to end with an error, and where.
fn stopped<S>(system: S, start: State<2>, h: f64, steps: usize) -> (Verdict, String)
where
    S: Variational<Midpoint> + System<Dims = Dims<2, 0>>,
{
    let integrator = Integrator::new(system, Midpoint);
    let mut path = integrator.trajectory(start, h, NoNoise);
    for _ in 0..steps {
        let last = *path.state();
        if let Some(Err(error)) = path.next() {
            let kind = format!("{error:?}");
            let kind = kind.split(' ').next().unwrap_or_default();
            let numbers = format!("{kind} at t = {:.4}, q = {:.4?}", last.t, last.q);
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
    (verdict, format!("q = {:.4?} at t = {:.2}", end.q, end.t))
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

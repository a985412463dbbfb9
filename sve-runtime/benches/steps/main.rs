//! Derived steps against hand-written ones: `cargo bench -p sve-runtime`.
//!
//! Each benchmark makes [`STEPS`] steps of one trajectory with given Wiener increments. After
//! criterion's report a table of ratios is printed, medians of runs that alternate between the two
//! sides, so that a noisy machine hits both alike.

mod hand;

use std::hint::black_box;
use std::time::Instant;

use criterion::Criterion;
use sve_runtime::Variational;
use sve_runtime::noise::Wiener;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

const STEPS: usize = 2000;

struct Oscillator {
    sigma: f64,
}

#[variational(endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

struct Kubo {
    a: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - 0.5 * self.a * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

#[derive(Clone, Copy)]
struct Pendulum {
    g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

#[derive(Clone, Copy)]
struct DoublePendulum {
    m: [f64; 2],
    l: [f64; 2],
    g: f64,
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let ([m1, m2], [l1, l2], g) = (self.m, self.l, self.g);
        0.5 * (m1 + m2) * l1.powi(2) * v[0].powi(2)
            + 0.5 * m2 * l2.powi(2) * v[1].powi(2)
            + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos()
            + (m1 + m2) * g * l1 * q[0].cos()
            + m2 * g * l2 * q[1].cos()
    }
}

#[derive(Clone, Copy)]
struct RigidBody {
    i: [f64; 3],
}

#[variational(midpoint)]
impl RigidBody {
    fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
        0.5 * (self.i[0] * w.x * w.x + self.i[1] * w.y * w.y + self.i[2] * w.z * w.z)
    }
}

/// The double pendulum in Cartesian coordinates, with its rods as constraints.
#[derive(Clone, Copy)]
struct Rods {
    m: [f64; 2],
    l: [f64; 2],
    g: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Rods {
    fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let [m1, m2] = self.m;
        0.5 * m1 * (v[0].powi(2) + v[1].powi(2)) + 0.5 * m2 * (v[2].powi(2) + v[3].powi(2))
            - self.g * (m1 * q[1] + m2 * q[3])
    }

    #[constraint]
    fn rods(&self, q: [f64; 4]) -> [f64; 2] {
        let [x, y] = [q[2] - q[0], q[3] - q[1]];
        [
            0.5 * (q[0].powi(2) + q[1].powi(2) - self.l[0].powi(2)),
            0.5 * (x.powi(2) + y.powi(2) - self.l[1].powi(2)),
        ]
    }
}

fn increments() -> Vec<f64> {
    let wiener = Wiener::new(1);
    (0..STEPS)
        .map(|k| wiener.increment(k as u64, 0, 0.1))
        .collect()
}

/// A side of a comparison: makes all steps from a fixed start and returns something that depends on
/// them.
type Side<'a> = (&'static str, Box<dyn Fn() -> f64 + 'a>);

struct Comparison<'a> {
    name: &'static str,
    sides: Vec<Side<'a>>,
}

/// Returns a side with a name.
fn side<'a>(name: &'static str, run: impl Fn() -> f64 + 'a) -> Side<'a> {
    (name, Box::new(run))
}

/// Makes all steps of a derived integrator, one for each entry of `dw`.
fn derived<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    h: f64,
    dw: impl Iterator<Item = [f64; M]>,
) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let mut state = black_box(start);
    let h = black_box(h);
    for dw in dw {
        integrator.step(&mut state, h, &dw).expect("a step");
    }
    state.q[0] + state.p[N - 1]
}

/// Makes the same steps by a trajectory, which keeps the values that depend on the step size alone.
fn along<S, R, const N: usize>(integrator: &Integrator<S, R>, start: State<[f64; N]>, h: f64) -> f64
where
    S: Variational<R> + System<Dims = Dims<N, 0>>,
{
    let states = integrator.trajectory(black_box(start), black_box(h), NoNoise);
    let last = states.take(STEPS).last().expect("a step").expect("a step");
    last.q[0] + last.p[N - 1]
}

/// Returns increments for a system without processes.
fn quiet() -> impl Iterator<Item = [f64; 0]> {
    std::iter::repeat_n([], STEPS)
}

fn oscillator(dw: &[f64]) -> Comparison<'_> {
    let integrator = Integrator::new(Oscillator { sigma: 1.0 }, Endpoint);
    let hand = move || {
        let mut z = black_box([1.0, 0.0]);
        let (h, sigma) = black_box((0.1, 1.0));
        for &dw in dw {
            hand::oscillator_endpoint(&mut z, h, sigma, dw);
        }
        z[0] + z[1]
    };
    let start = State::new([1.0], [0.0]);
    let sve = move || derived(&integrator, start, 0.1, dw.iter().map(|&dw| [dw]));
    Comparison {
        name: "oscillator endpoint",
        sides: vec![side("three-line loop", hand), side("sve", sve)],
    }
}

fn kubo(dw: &[f64]) -> Comparison<'_> {
    let integrator = Integrator::new(Kubo { a: 1.0, sigma: 1.0 }, Midpoint);
    let hand = move || {
        let mut z = black_box([1.0, 0.0]);
        let (h, a, sigma) = black_box((0.1, 1.0, 1.0));
        for &dw in dw {
            hand::kubo_cayley(&mut z, h, a, sigma, dw);
        }
        z[0] + z[1]
    };
    let start = State::new([1.0], [0.0]);
    let sve = move || derived(&integrator, start, 0.1, dw.iter().map(|&dw| [dw]));
    Comparison {
        name: "Kubo midpoint",
        sides: vec![side("Cayley form", hand), side("sve", sve)],
    }
}

fn pendulum() -> Comparison<'static> {
    let integrator = Integrator::new(Pendulum { g: 9.8 }, Midpoint);
    let naive = || {
        let mut z = black_box([1.0, 0.3]);
        let (h, g) = black_box((0.1, 9.8));
        for _ in 0..STEPS {
            hand::pendulum_naive(&mut z, h, g);
        }
        z[0] + z[1]
    };
    let best = || {
        let mut z = black_box([1.0, 0.3]);
        let (h, g) = black_box((0.1, 9.8));
        let mut last = 0.0;
        for _ in 0..STEPS {
            hand::pendulum_best(&mut z, &mut last, h, g);
        }
        z[0] + z[1]
    };
    let start = State::new([1.0], [0.3]);
    let sve = move || derived(&integrator, start, 0.1, quiet());
    let trajectory = move || along(&integrator, start, 0.1);
    Comparison {
        name: "pendulum midpoint",
        sides: vec![
            side("naive Newton", naive),
            side("best by hand", best),
            side("sve", sve),
            side("sve trajectory", trajectory),
        ],
    }
}

fn double_pendulum() -> Comparison<'static> {
    let (m, l, g) = ([1.0, 0.5], [1.0, 0.7], 9.8);
    let integrator = Integrator::new(DoublePendulum { m, l, g }, Midpoint);
    let naive = move || {
        let (mut q, mut p) = black_box(([1.0, 0.5], [0.3, -0.2]));
        let (h, system) = (black_box(0.01), hand::Double { m, l, g });
        for _ in 0..STEPS {
            hand::double_naive(&mut q, &mut p, h, &system);
        }
        q[0] + p[1]
    };
    let start = State::new([1.0, 0.5], [0.3, -0.2]);
    let sve = move || derived(&integrator, start, 0.01, quiet());
    let trajectory = move || along(&integrator, start, 0.01);
    Comparison {
        name: "double pendulum midpoint",
        sides: vec![
            side("naive Newton", naive),
            side("sve", sve),
            side("sve trajectory", trajectory),
        ],
    }
}

fn rigid_body() -> Comparison<'static> {
    let i = [1.0, 2.0, 3.0];
    let integrator = Integrator::new(RigidBody { i }, Midpoint);
    let hand = move || {
        let (mut q, mut p) = black_box(([1.0, 0.0, 0.0, 0.0], [0.7, 1.1, -0.4]));
        let (h, i) = black_box((0.05, i));
        for _ in 0..STEPS {
            hand::rigid_body_cayley(&mut q, &mut p, h, &i);
        }
        q[0] + p[2]
    };
    let start = State::new(UnitQuaternion::identity(), Vector3::new(0.7, 1.1, -0.4));
    let sve = move || {
        let mut state = black_box(start);
        let h = black_box(0.05);
        for _ in 0..STEPS {
            integrator.step(&mut state, h, &[]).expect("a step");
        }
        state.q.w + state.p.z
    };
    let along = move || {
        let states = integrator.trajectory(black_box(start), black_box(0.05), NoNoise);
        let last = states.take(STEPS).last().expect("a step").expect("a step");
        last.q.w + last.p.z
    };
    Comparison {
        name: "rigid body midpoint",
        sides: vec![
            side("Cayley's chart", hand),
            side("sve", sve),
            side("sve trajectory", along),
        ],
    }
}

/// Compares the double pendulum in angles and with constraints, from the same start.
fn rods() -> Comparison<'static> {
    let (m, l, g) = ([1.0, 0.5], [1.0, 0.7], 9.8);
    let angles = Integrator::new(DoublePendulum { m, l, g }, Midpoint);
    let midpoint = Integrator::new(Rods { m, l, g }, Midpoint);
    let verlet = Integrator::new(Rods { m, l, g }, StormerVerlet);
    let [a, b]: [f64; 2] = [1.0, 0.5];
    let start = State::new([a, b], [0.0, 0.0]);
    let [x, y] = [l[0] * a.sin(), -l[0] * a.cos()];
    let ends = [x, y, x + l[1] * b.sin(), y - l[1] * b.cos()];
    let cartesian = State::new(ends, [0.0; 4]);
    Comparison {
        name: "double pendulum of rods",
        sides: vec![
            side("angles, midpoint", move || {
                derived(&angles, start, 0.01, quiet())
            }),
            side("rods, midpoint", move || {
                derived(&midpoint, cartesian, 0.01, quiet())
            }),
            side("rods, Verlet", move || {
                derived(&verlet, cartesian, 0.01, quiet())
            }),
        ],
    }
}

/// Number of alternating runs of a comparison.
const ROUNDS: usize = 401;

/// Prints medians of alternating runs and their ratios to the first side.
fn ratios(comparisons: &[Comparison<'_>]) {
    println!(
        "\n{:<26}{:<18}{:>10}{:>8}",
        "step", "by", "ns a step", "ratio"
    );
    for Comparison { name, sides } in comparisons {
        let mut times = vec![Vec::with_capacity(ROUNDS); sides.len()];
        for _ in 0..ROUNDS {
            for (side, times) in sides.iter().zip(&mut times) {
                let start = Instant::now();
                black_box(side.1());
                times.push(start.elapsed().as_secs_f64() * 1e9 / STEPS as f64);
            }
        }
        let median = |times: &mut Vec<f64>| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        };
        let medians: Vec<f64> = times.iter_mut().map(median).collect();
        for (side, ns) in sides.iter().zip(&medians) {
            println!("{name:<26}{:<18}{ns:>10.2}{:>8.2}", side.0, ns / medians[0]);
        }
    }
}

fn main() {
    let dw = increments();
    let comparisons = [
        oscillator(&dw),
        kubo(&dw),
        pendulum(),
        double_pendulum(),
        rigid_body(),
        rods(),
    ];
    let mut criterion = Criterion::default().configure_from_args();
    for Comparison { name, sides } in &comparisons {
        let mut group = criterion.benchmark_group(*name);
        group.throughput(criterion::Throughput::Elements(STEPS as u64));
        for (side, run) in sides {
            group.bench_function(*side, |b| b.iter(run));
        }
        group.finish();
    }
    criterion.final_summary();
    ratios(&comparisons);
}

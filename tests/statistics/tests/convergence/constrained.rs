//! Strong orders of steps with constraints: one table of system, rule, noise and expected order, with the columns of `strong_order.rs`.
//!
//! References are exact paths, paths of the same system in angles, or paths with finer steps. The expected order lies within four standard errors
//! of the slope, and the standard error is at most 0.03. Two standard errors would leave one row in twenty off by chance.

use sve_models::models::{Curved, Ellipsoid, OnSphere, TurnedSphere, TwoRods};
use sve_runtime::prelude::*;
use sve_runtime::{Dims, StrongOrder, System, Variational, VectorCoordinates};

const BATCHES: u64 = 24;
const PATHS: u64 = 20;
const SEED: u64 = 31;

/// Numbers of steps that are measured.
const LEVELS: usize = 4;

/// Exponents of numbers of steps.
#[derive(Clone, Copy)]
struct Steps {
    /// The fewest steps that are measured; the others are twice, four and eight times as many.
    fewest: u32,
    /// The steps of the reference.
    reference: u32,
}

/// Steps with which an error of order ½ is far below its next term.
const SMALL: Steps = Steps {
    fewest: 7,
    reference: 15,
};

/// Steps with which an error of order 1 is far below its next term. The ratio to those of the reference, and so the error of the slope that the
/// reference makes, is that of the small steps.
const STEPS: Steps = if cfg!(feature = "thorough") {
    SMALL
} else {
    Steps {
        fewest: 5,
        reference: 13,
    }
};

/// For exact paths, which need no finer steps.
const EXACT: Steps = Steps {
    reference: STEPS.fewest + LEVELS as u32 - 1,
    ..STEPS
};

/// Largest standard error of an order.
const STANDARD_ERROR: f64 = 0.03;

/// A particle on the unit sphere whose time fluctuates, H₁ = s|p|²/2: the path is a great circle at the time t + sW.
#[derive(Clone)]
struct Clocked {
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Clocked {
    fn lagrangian(&self, _q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    }

    #[h1]
    fn clock(&self, _q: [f64; 3], p: [f64; 3]) -> f64 {
        0.5 * self.s * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    }

    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    }
}

/// H₁ = s f(q/|q|)|p|²/2 is not tangent off the sphere, and its correction is tangent.
#[derive(Clone)]
struct Homogeneous {
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Homogeneous {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - q[2]
    }

    #[h1]
    fn mass(&self, q: [f64; 3], p: [f64; 3]) -> f64 {
        let r = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
        0.5 * self.s * (1.0 + 0.5 * q[0] / r) * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    }

    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    }
}

/// Rotations about three axes, which do not commute.
#[derive(Clone)]
struct Tumbling {
    s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Tumbling {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) - q[2]
    }

    #[h1]
    fn turns(&self, q: [f64; 3], p: [f64; 3]) -> [f64; 3] {
        [
            self.s * (q[1] * p[2] - q[2] * p[1]),
            self.s * (q[2] * p[0] - q[0] * p[2]),
            self.s * (q[0] * p[1] - q[1] * p[0]),
        ]
    }

    #[constraint]
    fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] - 1.0)
    }
}

/// The double pendulum of two rods in angles from the downward vertical.
#[derive(Clone)]
struct Angles {
    rods: TwoRods,
}

#[variational(midpoint)]
impl Angles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = [self.rods.m[0], self.rods.m[1]];
        let [l1, l2] = [self.rods.l[0], self.rods.l[1]];
        let coupling = m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        let kinetic = 0.5 * (m1 + m2) * (l1 * v[0]).powi(2) + 0.5 * m2 * (l2 * v[1]).powi(2);
        let height = (m1 + m2) * l1 * q[0].cos() + m2 * l2 * q[1].cos();
        kinetic + coupling + self.rods.g * height
    }

    #[gamma]
    fn pulls(&self, q: [f64; 2]) -> [f64; 2] {
        let [l1, l2] = [self.rods.l[0], self.rods.l[1]];
        [
            self.rods.s * (l1 * q[0].sin() + l2 * q[1].sin()),
            -self.rods.s * l1 * q[0].cos(),
        ]
    }
}

/// Slope of the least-squares line through the logarithms of mean squares at the levels.
fn slope(squares: &[f64]) -> f64 {
    let n = LEVELS as f64;
    let x: [f64; LEVELS] = core::array::from_fn(|k| -(k as f64));
    let y: Vec<f64> = squares.iter().map(|s| 0.5 * s.log2()).collect();
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(&y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

/// Prints a line of the table from the mean squares of each batch, and checks it.
fn line(system: &str, rule: &str, noise: &str, expected: f64, batches: &[Vec<f64>]) {
    let levels = 0..LEVELS;
    let total: Vec<f64> = levels.map(|k| batches.iter().map(|b| b[k]).sum()).collect();
    let order = slope(&total);
    let slopes: Vec<f64> = batches.iter().map(|batch| slope(batch)).collect();
    let count = slopes.len() as f64;
    let mean = slopes.iter().sum::<f64>() / count;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let error = (variance / count).sqrt();
    println!("| {system} | {rule} | {noise} | {expected} | {order:.3} ± {error:.3} |");
    assert!(
        error <= STANDARD_ERROR,
        "{system} by {rule}: standard error {error}"
    );
    assert!(
        (order - expected).abs() <= 4.0 * error,
        "{system} by {rule}: order {order} ± {error}, expected {expected}"
    );
}

fn numbers<Q: VectorCoordinates<N>, const N: usize>(state: &State<Q>) -> Vec<f64> {
    [state.q.coordinates(), Q::components(&state.p)].concat()
}

fn end<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    path: &Recorded,
) -> State<Q>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    integrator
        .trajectory(start, path.h(), path)
        .last()
        .expect("a step")
        .unwrap()
}

/// A line for each rule. `exact` gives the end of a path with increments for the finest steps.
fn all_rules<S, Q, const N: usize, const M: usize>(
    system: &S,
    noise: &str,
    start: State<Q>,
    Steps { fewest, reference }: Steps,
    exact: impl Fn(State<Q>, &Recorded) -> Vec<f64>,
) where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>,
    Q: VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system, Midpoint);
    let initial_point = Integrator::new(system, InitialPoint);
    let endpoint = Integrator::new(system, Endpoint);
    let verlet = Integrator::new(system, StormerVerlet);
    let start = midpoint.consistent(start).unwrap();
    let names = ["initial_point", "midpoint", "stormer_verlet", "endpoint"];
    let mut tables = [const { Vec::new() }; 4];
    for batch in 0..BATCHES {
        let mut squares = [(); 4].map(|()| vec![0.0; LEVELS]);
        for member in 0..PATHS {
            let wiener = Wiener::new(SEED).path(batch * PATHS + member);
            let h = 0.5_f64.powi(reference as i32);
            let fine = Recorded::record(wiener, h, M, 1 << reference).unwrap();
            let exact = exact(start, &fine);
            for (k, steps) in (fewest..).take(LEVELS).enumerate() {
                let path = fine.coarsen(1 << (reference - steps)).unwrap();
                let ends = [
                    end(&initial_point, start, &path),
                    end(&midpoint, start, &path),
                    end(&verlet, start, &path),
                    end(&endpoint, start, &path),
                ];
                for (squares, end) in squares.iter_mut().zip(&ends) {
                    let pairs = numbers(end).into_iter().zip(exact.clone());
                    squares[k] += pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>();
                }
            }
        }
        for (table, squares) in tables.iter_mut().zip(squares) {
            table.push(squares);
        }
    }
    let plan = midpoint.plan();
    let expected = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::Half { .. } => 0.5,
        other => panic!("{other:?}"),
    };
    for (rule, table) in names.iter().zip(&tables) {
        line(plan.system, rule, noise, expected, table);
    }
}

/// The end by the midpoint rule with the finest steps.
fn fine<S, Q, const N: usize, const M: usize>(
    system: &S,
) -> impl Fn(State<Q>, &Recorded) -> Vec<f64>
where
    S: Clone + System<Dims = Dims<N, M, Q>> + Variational<Midpoint>,
    Q: VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system.clone(), Midpoint);
    move |start, path| numbers(&end(&midpoint, start, path))
}

fn total(path: &Recorded) -> f64 {
    path.coarsen(path.len()).unwrap().get(0).unwrap()[0]
}

const Q: [f64; 3] = [0.6, 0.0, -0.8];
const P: [f64; 3] = [0.288, 0.9, 0.216];

/// The great circle from a point with a momentum, after a time.
fn great_circle(q: Vector3<f64>, p: Vector3<f64>, time: f64) -> [Vector3<f64>; 2] {
    let speed = p.norm();
    let (sin, cos) = (speed * time).sin_cos();
    [q * cos + p / speed * sin, p * cos - q * speed * sin]
}

#[test]
fn a_rotation_has_its_exact_path() {
    let system = TurnedSphere { s: 0.7 };
    let exact = |start: State<[f64; 3]>, path: &Recorded| {
        let [q, p] = great_circle(start.q.into(), start.p.into(), 1.0);
        let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        let turn = Rotation3::new(axis * (0.7 * total(path)));
        [(turn * q).as_slice(), (turn * p).as_slice()].concat()
    };
    all_rules(
        &system,
        "rotation, exact path",
        State::new(Q, P),
        EXACT,
        exact,
    );
}

#[test]
fn a_fluctuating_time_has_its_exact_path() {
    let system = Clocked { s: 0.5 };
    let exact = |start: State<[f64; 3]>, path: &Recorded| {
        let [q, p] = great_circle(start.q.into(), start.p.into(), 1.0 + 0.5 * total(path));
        [q.as_slice(), p.as_slice()].concat()
    };
    all_rules(
        &system,
        "H₁ = s|p|²/2, exact path",
        State::new(Q, P),
        EXACT,
        exact,
    );
}

#[test]
fn position_noises_on_the_sphere() {
    let system = OnSphere { g: 1.3, s: 0.7 };
    all_rules(&system, "two γ", State::new(Q, P), STEPS, fine(&system));
}

#[test]
fn rods_against_angles() {
    let rods = TwoRods {
        m: [1.0, 0.5],
        l: [1.0, 0.7],
        g: 2.0,
        s: 0.4,
    };
    let angles = Integrator::new(Angles { rods: rods.clone() }, Midpoint);
    let [a, b] = [0.8f64, -0.3f64];
    let rates = [0.5, -0.4];
    let cartesian = |q: [f64; 2], v: [f64; 2]| -> Vec<f64> {
        let [x, y] = [q[0].sin(), -q[0].cos()];
        let [x2, y2] = [x + 0.7 * q[1].sin(), y - 0.7 * q[1].cos()];
        let [vx, vy] = [v[0] * q[0].cos(), v[0] * q[0].sin()];
        let [vx2, vy2] = [vx + 0.7 * v[1] * q[1].cos(), vy + 0.7 * v[1] * q[1].sin()];
        vec![x, y, x2, y2, vx, vy, 0.5 * vx2, 0.5 * vy2]
    };
    let first = cartesian([a, b], rates);
    let part = |z: &[f64]| -> [f64; 4] { z.try_into().unwrap() };
    let start = State::new(part(&first[..4]), part(&first[4..]));
    let from = State::new([a, b], angles.system().momentum([a, b], rates));
    let exact = |_: State<[f64; 4]>, path: &Recorded| {
        let end = end(&angles, from, path);
        cartesian(end.q, angles.system().velocity(&end).unwrap())
    };
    all_rules(&rods, "two γ, in angles", start, STEPS, exact);
}

#[test]
fn tangent_noise_on_an_ellipsoid() {
    let system = Ellipsoid {
        axes: [1.0, 2.0, 0.5],
        g: 1.0,
        s: 0.4,
    };
    let start = State::new(Vector3::from(Q), Vector3::from(P));
    all_rules(&system, "tangent H₁", start, STEPS, fine(&system));
}

#[test]
fn curved_noise_with_the_momentum_along_the_sphere() {
    let system = Curved { g: 1.0, s: 0.3 };
    let start = State::new(Vector3::from(Q), Vector3::from(P));
    all_rules(&system, "f(q)|Πp|²/2", start, STEPS, fine(&system));
}

/// The criterion by which the macro accepts a curved noise for the rules with one node at an end.
#[test]
fn curved_noise_whose_correction_is_tangent() {
    let system = Homogeneous { s: 0.3 };
    all_rules(
        &system,
        "f(q/|q|)|p|²/2",
        State::new(Q, P),
        STEPS,
        fine(&system),
    );
}

#[test]
fn rotations_that_do_not_commute() {
    let system = Tumbling { s: 0.5 };
    all_rules(
        &system,
        "three rotations",
        State::new(Q, P),
        SMALL,
        fine(&system),
    );
}

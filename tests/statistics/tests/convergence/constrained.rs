//! Strong orders of steps with constraints. References are exact paths, paths of the same system in
//! angles, or paths with finer steps.

use std::sync::LazyLock;

use sve_models::is_thorough;
use sve_models::models::{Curved, Ellipsoid, OnSphere, TurnedSphere, TwoRods};
use sve_models::orders::{Paths, Row, Tolerance, end, numbers, total};
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

/// Steps with which an error of order ½ is far below its next term. A quarter of the paths doubles
/// the standard error.
static SMALL: LazyLock<Paths> = LazyLock::new(|| Paths {
    seed: 31,
    batches: 24,
    count: if is_thorough() { 20 } else { 5 },
    coarsest: 7,
    levels: 4,
    finest: 14,
    tolerance: Tolerance {
        bias: 0.0,
        error: if is_thorough() { 0.03 } else { 0.06 },
    },
});

/// Steps with which an error of order 1 is far below its next term. The ratio to those of the
/// reference, and so the error of the slope that the reference makes, is that of the small steps.
static STEPS: LazyLock<Paths> = LazyLock::new(|| {
    if is_thorough() {
        *SMALL
    } else {
        Paths {
            coarsest: 5,
            finest: 12,
            ..*SMALL
        }
    }
});

/// For exact paths, which need no finer steps.
static EXACT: LazyLock<Paths> = LazyLock::new(|| Paths {
    finest: STEPS.coarsest + STEPS.levels - 1,
    ..*STEPS
});

/// A particle on the unit sphere whose time fluctuates, H₁ = s|p|²/2: the path is a great circle at
/// the time t + sW.
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

/// A pendulum bead whose noise force has no potential: s(1 + x) along the circle, and `$rub`.
macro_rules! bead {
    ($name:ident, [$($rule:ident),*], |$this:ident, $q:ident, $v:ident| $rub:expr) => {
        #[derive(Clone, Copy)]
        struct $name {
            s: f64,
            sigma: f64,
        }

        #[variational($($rule),*)]
        impl $name {
            fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
                0.5 * v.norm_squared() - q.y
            }

            #[force(noise)]
            fn gust(&$this, $q: Vector2<f64>, $v: Vector2<f64>) -> Vector2<f64> {
                $this.s * (1.0 + $q.x) * Vector2::new(-$q.y, $q.x) + $rub
            }

            #[constraint]
            fn circle(&self, q: Vector2<f64>) -> f64 {
                0.5 * (q.norm_squared() - 1.0)
            }
        }
    };
}

bead! { Blown, [initial_point, endpoint, midpoint, stormer_verlet], |self, q, _v| self.sigma * q }
bead! { Rubbed, [midpoint, stormer_verlet], |self, q, v| self.sigma * v }

/// The pendulum bead in its angle from the downward vertical.
#[derive(Clone, Copy)]
struct Angle {
    s: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Angle {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[force(noise)]
    fn gust(&self, q: f64, v: f64) -> f64 {
        self.s * (1.0 + q.sin()) + self.sigma * v
    }
}

/// The end of an exact path, from its start and its noise.
type ExactEnd<'a, Q> = &'a dyn Fn(&State<Q>, &Recorded) -> Vec<f64>;

/// Checks the orders of all rules from a state near a consistent one, against `exact` or the
/// midpoint rule with the finest steps.
fn check<S, Q, const N: usize, const M: usize>(
    paths: Paths,
    system: &S,
    noise: &str,
    start: State<Q>,
    exact: Option<ExactEnd<'_, Q>>,
) where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>,
    Q: VectorCoordinates<N>,
{
    let midpoint = Integrator::new(system, Midpoint);
    let start = midpoint.consistent(start).unwrap();
    let path = paths.against(M, |path| match exact {
        Some(exact) => exact(&start, path),
        None => end(&midpoint, start, path),
    });
    paths.check(noise, &Row::rules(system, start), path);
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
    let exact = |start: &State<[f64; 3]>, path: &Recorded| {
        let [q, p] = great_circle(start.q.into(), start.p.into(), 1.0);
        let axis = Vector3::new(1.0, -2.0, 2.0) / 3.0;
        let turn = Rotation3::new(axis * (0.7 * total::<1>(path)[0]));
        [(turn * q).as_slice(), (turn * p).as_slice()].concat()
    };
    let start = State::new(Q, P);
    check(*EXACT, &system, "rotation, exact path", start, Some(&exact));
}

#[test]
fn a_fluctuating_time_has_its_exact_path() {
    let system = Clocked { s: 0.5 };
    let exact = |start: &State<[f64; 3]>, path: &Recorded| {
        let time = 1.0 + 0.5 * total::<1>(path)[0];
        let [q, p] = great_circle(start.q.into(), start.p.into(), time);
        [q.as_slice(), p.as_slice()].concat()
    };
    let (noise, start) = ("H₁ = s|p|²/2, exact path", State::new(Q, P));
    check(*EXACT, &system, noise, start, Some(&exact));
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
    let exact = |_: &State<[f64; 4]>, path: &Recorded| {
        let end = angles.trajectory(from, path.h(), path).last();
        let end = end.unwrap().unwrap();
        cartesian(end.q, angles.system().velocity(&end).unwrap())
    };
    check(*STEPS, &rods, "two γ, in angles", start, Some(&exact));
}

/// Forces across the circle do no work: the constraint holds the bead against them.
#[test]
fn noise_forces_on_a_circle_against_the_angle() {
    let (sigma, from) = (0.3, State::new([0.8], [0.5]));
    let cartesian = |q: f64, p: f64| {
        let along = Vector2::new(q.cos(), q.sin());
        State::new(Vector2::new(along.y, -along.x), p * along)
    };
    let start = cartesian(0.8, 0.5);
    let path = |s: f64, sigma: f64| {
        let angle = Integrator::new(Angle { s, sigma }, Midpoint);
        STEPS.against(1, move |path| {
            let end = end(&angle, from, path);
            numbers(&cartesian(end[0], end[1]))
        })
    };
    let blown = Blown { s: 0.5, sigma };
    STEPS.check(
        "s(1 + x) along, σ across",
        &Row::rules(&blown, start),
        path(0.5, 0.0),
    );
    // Stronger noise gives most of the error to a few paths.
    let rubbed = Rubbed { s: 0.2, sigma };
    let rows = [
        Row::new(&rubbed, Midpoint, start),
        Row::new(&rubbed, StormerVerlet, start),
    ];
    STEPS.check("s(1 + x) along, σv", &rows, path(0.2, sigma));
}

#[test]
fn noises_on_the_sphere_and_on_an_ellipsoid() {
    let (q, p) = (Vector3::from(Q), Vector3::from(P));
    check(
        *STEPS,
        &OnSphere { g: 1.3, s: 0.7 },
        "two γ",
        State::new(Q, P),
        None,
    );
    let ellipsoid = Ellipsoid {
        axes: [1.0, 2.0, 0.5],
        g: 1.0,
        s: 0.4,
    };
    check(*STEPS, &ellipsoid, "tangent H₁", State::new(q, p), None);
    // the momentum along the sphere
    let curved = Curved { g: 1.0, s: 0.3 };
    check(*STEPS, &curved, "f(q)|Πp|²/2", State::new(q, p), None);
    // The macro accepts this curved noise for the rules with one node at an end, since its
    // correction is tangent.
    let homogeneous = Homogeneous { s: 0.3 };
    check(
        *STEPS,
        &homogeneous,
        "f(q/|q|)|p|²/2",
        State::new(Q, P),
        None,
    );
}

#[test]
fn rotations_that_do_not_commute() {
    let tumbling = Tumbling { s: 0.5 };
    check(*SMALL, &tumbling, "three rotations", State::new(Q, P), None);
}

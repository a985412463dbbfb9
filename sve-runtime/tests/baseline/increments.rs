//! The code that the macro writes for increments of Euler's method, against the derivatives of L:
//! masses of every structure, forces, noises, momenta at rest.

use sve_runtime::baseline::{EulerMaruyama, Heun, RungeKutta4};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use crate::random::Random;

/// A constant mass matrix that couples three coordinates, a magnetic field, time and friction.
struct Coupled {
    m: f64,
    c: f64,
    b: f64,
    nu: f64,
    sigma: f64,
}

#[variational(midpoint)]
impl Coupled {
    fn lagrangian(&self, t: f64, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * self.m * (v[0] * v[0] + 2.0 * v[1] * v[1] + v[2] * v[2])
            + self.c * (v[0] * v[1] + v[1] * v[2])
            + self.b * (q[0] * v[1] - q[1] * v[0])
            - 0.25 * q[0].powi(4)
            + q[1].cos() * q[2] * t.sin()
    }

    #[force]
    fn friction(&self, _q: [f64; 3], v: [f64; 3]) -> [f64; 3] {
        [-self.nu * v[0], 0.0, -self.nu * v[2] * v[2] * v[2]]
    }

    #[gamma]
    fn push(&self, q: [f64; 3]) -> f64 {
        self.sigma * q[0] * q[2]
    }
}

/// A mass matrix that depends on q and couples the coordinates, with noises of both kinds.
struct DoublePendulum {
    g: f64,
    sigma: [f64; 2],
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + v[0] * v[1] * (q[0] - q[1]).cos()
            + self.g * (2.0 * q[0].cos() + q[1].cos())
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma[0] * q[0] * q[1]
    }

    #[h1]
    fn shake(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.sigma[1] * (q[0].sin() * p[0] * p[0] + p[1] * q[1])
    }
}

/// A diagonal mass matrix that depends on q, without noise.
struct Polar {
    m: f64,
    k: f64,
}

#[variational(midpoint)]
impl Polar {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) - 0.5 * self.k * q[0] * q[0]
    }
}

/// A constant mass matrix of two coordinates, singular for c² = 1.
struct Pair {
    c: f64,
}

#[variational(midpoint)]
impl Pair {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.c * v[0] * v[1] - q[0] * q[0]
    }
}

fn coupled() -> Coupled {
    Coupled {
        m: 1.3,
        c: 0.4,
        b: 0.7,
        nu: 0.2,
        sigma: 0.6,
    }
}

fn double_pendulum() -> DoublePendulum {
    DoublePendulum {
        g: 9.8,
        sigma: [0.3, 0.2],
    }
}

/// Compares steps from random states with those of the first-order form.
fn compare<S, const N: usize, const M: usize>(system: &S)
where
    S: System<Dims = Dims<N, M>>,
{
    assert!(S::HAS_EULER_INCREMENT);
    let mut random = Random::new(3);
    for _ in 0..100 {
        let h = random.between(-0.2, 0.2);
        let dw: [f64; M] = core::array::from_fn(|_| 0.3 * random.normal());
        let q = core::array::from_fn(|_| random.between(0.3, 1.5));
        let p = core::array::from_fn(|_| random.between(-2.0, 2.0));
        let start = State::at(random.between(-1.0, 1.0), q, p);
        let euler = |at: &State<[f64; N]>| {
            let (f, g) = (system.drift(at).unwrap(), system.noise(at, &dw));
            let q: [f64; N] = core::array::from_fn(|i| h * f.q[i] + g.q[i]);
            let p: [f64; N] = core::array::from_fn(|i| h * f.p[i] + g.p[i]);
            [q, p]
        };
        let after = |[q, p]: [[f64; N]; 2]| {
            let mut state = start;
            state.t += h;
            for i in 0..N {
                state.q[i] += q[i];
                state.p[i] += p[i];
            }
            state
        };
        let first = euler(&start);
        let second = euler(&after(first));
        let correction = system.ito_correction(&start);
        let ito = [correction.q, correction.p];
        let rows = |a: f64, x: &[[f64; N]; 2], y: &[[f64; N]; 2], b: f64| {
            core::array::from_fn(|r| core::array::from_fn(|i| a * x[r][i] + b * y[r][i]))
        };
        let plain = EulerMaruyama::new(system).uncorrected();
        near(&plain, &start, h, &dw, &after(first));
        let corrected = after(rows(1.0, &first, &ito, h));
        near(&EulerMaruyama::new(system), &start, h, &dw, &corrected);
        near(
            &Heun::new(system),
            &start,
            h,
            &dw,
            &after(rows(0.5, &first, &second, 0.5)),
        );
    }
}

#[track_caller]
fn near<I, const N: usize, const M: usize>(
    method: &I,
    start: &State<[f64; N]>,
    h: f64,
    dw: &[f64; M],
    expected: &State<[f64; N]>,
) where
    I: Method<Increments = [f64; M]>,
    I::System: System<Dims = Dims<N, M>>,
{
    let mut state = *start;
    method.step(&mut state, h, dw).unwrap();
    assert_eq!(state.t, expected.t);
    for (x, y) in (state.q.iter().chain(&state.p)).zip(expected.q.iter().chain(&expected.p)) {
        assert!(
            (x - y).abs() <= 1e-13 * (1.0 + y.abs()),
            "{state:?}, expected {expected:?}"
        );
    }
}

#[test]
fn increments_are_those_of_the_first_order_form() {
    compare(&coupled());
    compare(&double_pendulum());
    compare(&Polar { m: 1.3, k: 0.8 });
    compare(&Pair { c: 0.4 });
}

#[test]
fn runge_kutta_is_that_of_the_drift() {
    let polar = Polar { m: 1.3, k: 0.8 };
    let (start, h) = (State::new([1.1, 0.2], [0.4, 0.9]), 0.1);
    let at = |scale: f64, k: [f64; 4]| {
        let z = [start.q[0], start.q[1], start.p[0], start.p[1]];
        let z: [f64; 4] = core::array::from_fn(|i| z[i] + scale * k[i]);
        let f = polar
            .drift(&State::new([z[0], z[1]], [z[2], z[3]]))
            .unwrap();
        [f.q[0], f.q[1], f.p[0], f.p[1]]
    };
    let k1 = at(0.0, [0.0; 4]);
    let k2 = at(0.5 * h, k1);
    let k3 = at(0.5 * h, k2);
    let k4 = at(h, k3);
    let d = |i: usize| h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
    let expected = State::at(
        h,
        [start.q[0] + d(0), start.q[1] + d(1)],
        [start.p[0] + d(2), start.p[1] + d(3)],
    );
    near(&RungeKutta4::new(polar), &start, h, &[], &expected);
}

#[track_caller]
fn failure<I, const N: usize, const M: usize>(
    method: &I,
    start: State<[f64; N]>,
    dw: [f64; M],
) -> StepError
where
    I: Method<Increments = [f64; M]>,
    I::System: System<Dims = Dims<N, M>>,
{
    let mut state = start;
    let error = method.step(&mut state, 0.1, &dw).unwrap_err();
    assert_eq!(state, start, "a failed step moved the state");
    error
}

#[test]
fn singular_masses_are_named() {
    let is_singular = |error: StepError| {
        assert!(
            matches!(error, StepError::SingularMass { t: 2.0, h: 0.1, .. }),
            "{error}"
        );
    };
    let start = State::at(2.0, [0.0, 0.3], [0.4, 0.9]);
    let polar = Polar { m: 1.3, k: 0.8 };
    is_singular(failure(&Heun::new(&polar), start, []));
    is_singular(failure(&RungeKutta4::new(&polar), start, []));
    for c in [1.0, -1.0] {
        is_singular(failure(&Heun::new(Pair { c }), start, []));
        is_singular(failure(&EulerMaruyama::new(Pair { c }), start, []));
    }
    // the determinant 2 − cos² of the double pendulum never vanishes
    let state = State::at(2.0, [0.3, 0.3], [0.4, 0.9]);
    assert!(
        Heun::new(double_pendulum())
            .step(&mut { state }, 0.1, &[0.0; 2])
            .is_ok()
    );
}

/// A force that is bounded at infinity, and a noise that is over after the start.
struct Bounded;

#[variational(midpoint)]
impl Bounded {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.atan()
    }

    #[gamma]
    fn push(&self, t: f64, q: f64) -> f64 {
        q * (-1e5 * t).exp()
    }
}

#[test]
fn a_stage_that_overflows_is_an_error() {
    // q overflows in the stage, where the noise has turned p around; the mean of both increments is
    // finite
    let start = State::new([1.79e308], [0.8e308]);
    let error = failure(&Heun::new(Bounded), start, [-1.6e308]);
    assert!(
        matches!(error, StepError::NonFiniteResult { .. }),
        "{error}"
    );
}

#[test]
fn coordinates_whose_sum_overflows_are_finite() {
    let mut state = State::new([1.5e308, 1.4e308], [0.0, 0.0]);
    EulerMaruyama::new(Pair { c: 0.0 })
        .step(&mut state, 1e-300, &[])
        .unwrap();
    assert_eq!(state.q, [1.5e308, 1.4e308]);
}

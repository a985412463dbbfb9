//! Lyapunov exponents: closed forms of the discrete map, pairs of symplectic maps, an independent
//! integration, compositions, noise.

// closures are written as users write them
#![allow(clippy::redundant_closure_for_method_calls)]

mod compositions;
mod henon_heiles;

use sve_models::models::{HenonHeiles, OnSphere};
use sve_runtime::prelude::*;

/// A saddle beside an oscillator: linear, so that the exponents are the logarithms of the
/// eigenvalues of the step.
struct Saddle {
    k: f64,
    omega: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Saddle {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 0.5 * self.k * q[0] * q[0]
            - 0.5 * (self.omega * q[1]).powi(2)
    }
}

/// The eigenvalue of the midpoint rule for q'' = k q is (1 + √k h/2)/(1 − √k h/2), that of
/// Störmer–Verlet solves λ + 1/λ = 2 + kh².
#[test]
fn of_a_saddle_are_the_logarithms_of_the_eigenvalues_of_the_step() {
    let (k, h) = (2.5_f64, 0.1);
    let saddle = || Saddle { k, omega: 1.3 };
    let x = 0.5 * h * k.sqrt();
    let midpoint = ((1.0 + x) / (1.0 - x)).ln() / h;
    let verlet = (1.0 + 0.5 * k * h * h).acosh() / h;
    let start = State::new([0.0, 0.3], [0.0, 0.2]);
    let integrator = Integrator::new(saddle(), Midpoint);
    let mut path = integrator.lyapunov(start, h, NoNoise, 4);
    path.advance(3000).unwrap();
    path.restart();
    path.advance(10_000).unwrap();
    check_saddle(&path.exponents(), midpoint);
    let integrator = Integrator::new(saddle(), StormerVerlet);
    let mut path = integrator.lyapunov(start, h, NoNoise, 4);
    path.advance(3000).unwrap();
    path.restart();
    path.advance(10_000).unwrap();
    check_saddle(&path.exponents(), verlet);
}

/// The oscillator has exponents 0, from which those of a finite path differ by the logarithm of a
/// bounded number over its time.
fn check_saddle(exponents: &[f64], largest: f64) {
    assert!((exponents[0] - largest).abs() < 1e-12, "{exponents:?}");
    assert!((exponents[3] + largest).abs() < 1e-12, "{exponents:?}");
    assert!(
        exponents[1].abs() < 1e-3 && exponents[2].abs() < 1e-3,
        "{exponents:?}"
    );
}

/// Every symplectic map has pairs λ, −λ, and so has every path of a finite length, with noise too.
#[test]
fn of_symplectic_maps_are_pairs() {
    let chaotic = Integrator::new(HenonHeiles, Midpoint);
    let start = State::new([0.0, -0.25], [0.42, 0.0]);
    let mut path = chaotic.lyapunov(start, 0.05, NoNoise, 4);
    for steps in [1, 10, 1000, 20_000] {
        path.advance(steps).unwrap();
        let [a, b, c, d] = path.exponents()[..] else {
            panic!("four exponents");
        };
        for sum in [a + d, b + c, a + b + c + d] {
            assert!(sum.abs() < 1e-12, "{steps} {sum:e}");
        }
    }
    let noisy = Integrator::new(Gusts { sigma: 0.5 }, Midpoint);
    let mut path = noisy.lyapunov(State::new([1.0], [0.0]), 0.05, Wiener::new(1), 2);
    path.advance(5000).unwrap();
    let [a, b] = path.exponents()[..] else {
        panic!("two exponents");
    };
    assert!(a > 0.01 && (a + b).abs() < 1e-12, "{a} {b}");
}

/// The determinant of the midpoint rule for q'' = −q − νq' is (1 − νh/2 + h²/4)/(1 + νh/2 + h²/4).
#[test]
fn of_friction_sum_up_to_the_loss_of_area() {
    let (nu, h) = (0.4, 0.1);
    let damped = Integrator::new(Damped { nu }, Midpoint);
    let mut path = damped.lyapunov(State::new([1.0], [0.0]), h, NoNoise, 2);
    path.advance(2000).unwrap();
    let sum: f64 = path.exponents().iter().sum();
    let area = (1.0 - 0.5 * nu * h + 0.25 * h * h) / (1.0 + 0.5 * nu * h + 0.25 * h * h);
    assert!((sum - area.ln() / h).abs() < 1e-12, "{sum}");
}

struct Damped {
    nu: f64,
}

#[variational(midpoint)]
impl Damped {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
}

struct Gusts {
    sigma: f64,
}

#[variational(midpoint)]
impl Gusts {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[gamma]
    fn gusts(&self, q: f64) -> f64 {
        self.sigma * q.cos()
    }
}

struct Windy {
    nu: f64,
    sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Windy {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
    #[gamma]
    fn gusts(&self, q: f64) -> f64 {
        self.sigma * q.cos()
    }
}

/// The start of a chaotic path of Hénon and Heiles with energy 1/8.
fn chaotic_start() -> State<[f64; 2]> {
    let y: f64 = -0.25;
    let potential = 0.5 * y * y - y.powi(3) / 3.0;
    State::new([0.0, y], [(0.25 - 2.0 * potential).sqrt(), 0.0])
}

/// A path that starts nearby and is put back to a small distance after each step grows away at the
/// same rate.
#[test]
fn is_the_rate_at_which_a_near_path_leaves() {
    let (h, steps, distance) = (0.05, 20_000, 1e-7);
    let integrator = Integrator::new(HenonHeiles, StormerVerlet);
    let mut path = integrator.lyapunov(chaotic_start(), h, NoNoise, 1);
    path.advance(1000).unwrap();
    path.restart();
    let mut near = *path.state();
    near.q[0] += distance;
    let mut growth = 0.0;
    for step in 0..steps {
        let state = path.next().unwrap().unwrap();
        integrator.step(&mut near, h, &[]).unwrap();
        let difference: Vec<f64> = (0..2)
            .flat_map(|i| [near.q[i] - state.q[i], near.p[i] - state.p[i]])
            .collect();
        let length = difference.iter().map(|x| x * x).sum::<f64>().sqrt();
        // both directions have to be those of the largest exponent first
        if step >= 2000 {
            growth += (length / distance).ln();
        } else if step == 1999 {
            path.restart();
        }
        for i in 0..2 {
            near.q[i] = state.q[i] + difference[2 * i] * distance / length;
            near.p[i] = state.p[i] + difference[2 * i + 1] * distance / length;
        }
    }
    let rate = growth / (h * f64::from(steps - 2000));
    let exponent = path.exponents()[0];
    assert!(
        (rate / exponent - 1.0).abs() < 1e-3 && exponent > 0.03,
        "{rate} {exponent}"
    );
}

/// Two rules and two paths of the noise: the exponents of a pendulum with friction in gusts, which
/// has a stationary law, agree to their errors.
#[test]
fn of_a_noisy_motion_are_those_of_other_rules_and_paths() {
    let (h, steps, start) = (0.1, 200_000, State::new([1.0], [0.0]));
    let pendulum = || Windy {
        nu: 0.3,
        sigma: 1.0,
    };
    let midpoint = Integrator::new(pendulum(), Midpoint);
    let verlet = Integrator::new(pendulum(), StormerVerlet);
    let mut first = midpoint.lyapunov(start, h, Wiener::new(1), 1);
    first.advance(steps).unwrap();
    let mut second = verlet.lyapunov(start, h, Wiener::new(2), 1);
    second.advance(steps).unwrap();
    let [a, b] = [first.exponents()[0], second.exponents()[0]];
    let [da, db] = [first.standard_errors()[0], second.standard_errors()[0]].map(Option::unwrap);
    // the rules differ by O(h²), far less than the errors
    assert!((a - b).abs() < 4.0 * da.hypot(db), "{a} ± {da}, {b} ± {db}");
    assert!(da < 0.01 && db < 0.01, "{da} {db}");
    assert_eq!(first.rates(0).unwrap().count(), steps);
}

/// Motions on a sphere have four directions; the step maps the other two to zero.
#[test]
fn across_constraints_are_minus_infinity() {
    let sphere = Integrator::new(OnSphere { g: 1.0, s: 0.3 }, StormerVerlet);
    let start = sphere
        .consistent(State::new([0.6, 0.0, -0.8], [0.1, 0.5, 0.0]))
        .unwrap();
    let mut path = sphere.lyapunov(start, 0.05, Wiener::new(2), 6);
    path.advance(2000).unwrap();
    let exponents = path.exponents();
    let sum: f64 = exponents[..4].iter().sum();
    // the area of the first step is not that of the four directions
    path.restart();
    path.advance(2000).unwrap();
    let later: f64 = path.exponents()[..4].iter().sum();
    assert!(
        sum.is_finite() && later.abs() < 1e-2,
        "{exponents:?} {later}"
    );
    assert_eq!(exponents[4..], [f64::NEG_INFINITY; 2]);
}

/// States are those of the trajectory; a recorded path ends, and a step that fails is an error.
#[test]
fn paths_are_those_of_trajectories() {
    let noisy = Integrator::new(Gusts { sigma: 0.5 }, Midpoint);
    let start = State::new([1.0], [0.0]);
    let path = noisy.lyapunov(start, 0.05, Wiener::new(1), 2).take(100);
    for (state, expected) in path.zip(noisy.trajectory(start, 0.05, Wiener::new(1))) {
        let (state, expected) = (state.unwrap(), expected.unwrap());
        assert_eq!(state.t, expected.t);
        assert!((state.q[0] - expected.q[0]).abs() < 1e-14);
    }
    let recorded = Recorded::record(Wiener::new(1), 0.05, 1, 10).unwrap();
    let mut path = noisy.lyapunov(start, 0.05, recorded, 9);
    assert_eq!(path.by_ref().count(), 10);
    assert_eq!((path.step(), path.exponents().len()), (10, 2));
    assert!(path.advance(1).is_err());
    let mut failing = noisy.lyapunov(State::new([f64::NAN], [0.0]), 0.05, Wiener::new(1), 1);
    assert!(failing.next().unwrap().is_err() && failing.next().is_none());
    assert!(failing.exponents()[0].is_nan());
}

/// Backwards in time the directions that shrank grow, so that a saddle has the same exponents.
#[test]
fn backwards_have_the_signs_of_growth() {
    let integrator = Integrator::new(Saddle { k: 2.5, omega: 1.3 }, Midpoint);
    let start = State::new([0.0, 0.3], [0.0, 0.2]);
    let largest = |h: f64| {
        let mut path = integrator.lyapunov(start, h, NoNoise, 4);
        path.advance(1000).unwrap();
        path.restart();
        path.advance(1000).unwrap();
        (path.exponents()[0], path.exponents()[3])
    };
    let (forwards, backwards) = (largest(0.1), largest(-0.1));
    assert!((backwards.0 - forwards.0).abs() < 1e-12, "{backwards:?}");
    assert!((backwards.1 - forwards.1).abs() < 1e-12, "{backwards:?}");
}

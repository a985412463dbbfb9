//! Inputs in every function of a system: its steps are those of the system with parameters instead,
//! and its gradients those of differences.

use sve_models::differences::derivative;
use sve_runtime::prelude::*;

/// Inputs in every function, with a helper and the time.
struct Driven {
    m: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Driven {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2], u: Vector2<f64>) -> f64 {
        0.5 * (self.m + u.x * u.x) * v[0] * v[0] + 0.5 * v[1] * v[1] + self.well(q, u.y) * t.cos()
    }
    fn well(&self, q: [f64; 2], u: f64) -> f64 {
        u * q[0] - self.m * (q[0] - q[1]).powi(2) - q[1].powi(4)
    }
    #[force(noise)]
    fn gust(&self, q: [f64; 2], _v: [f64; 2], u: Vector2<f64>) -> [f64; 2] {
        [-u.y * q[1], u.y * q[0]]
    }
    #[gamma]
    fn push(&self, q: [f64; 2], u: Vector2<f64>) -> f64 {
        u.x * q[0]
    }
    #[gamma]
    fn bath(&self, q: [f64; 2]) -> f64 {
        0.2 * q[1]
    }
    #[force]
    fn drag(&self, _t: f64, _q: [f64; 2], v: [f64; 2], u: Vector2<f64>) -> [f64; 2] {
        [-u.x * u.x * v[0], -0.1 * v[1]]
    }
}

/// The same with parameters.
#[derive(Clone)]
struct Plain {
    m: f64,
    x: f64,
    y: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Plain {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (self.m + self.x * self.x) * v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + self.well(q, self.y) * t.cos()
    }
    fn well(&self, q: [f64; 2], u: f64) -> f64 {
        u * q[0] - self.m * (q[0] - q[1]).powi(2) - q[1].powi(4)
    }
    #[force(noise)]
    fn gust(&self, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        [-self.y * q[1], self.y * q[0]]
    }
    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.x * q[0]
    }
    #[gamma]
    fn bath(&self, q: [f64; 2]) -> f64 {
        0.2 * q[1]
    }
    #[force]
    fn drag(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [-self.x * self.x * v[0], -0.1 * v[1]]
    }
}

fn table(k: u64) -> Vector2<f64> {
    let k = k as f64;
    Vector2::new(0.3 + 0.2 * k.sin(), 0.4 * (0.7 * k).cos())
}

fn start() -> State<[f64; 2]> {
    State::at(0.3, [0.4, -0.2], [0.5, 0.3])
}

/// To rounding the steps of parameters that are changed between them.
#[test]
fn held_inputs_are_parameters_of_a_step() {
    let (h, n) = (0.1, 12_u64);
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let driven = Integrator::new(Driven { m: 1.2 }, $rule);
            let path = driven.trajectory(start(), h, Wiener::new(5)).inputs(|k, _| table(k));
            let mut plain = Integrator::new(Plain { m: 1.2, x: 0.0, y: 0.0 }, $rule);
            let mut state = start();
            for (k, found) in path.take(n as usize).enumerate() {
                let u = table(k as u64);
                (plain.system_mut().x, plain.system_mut().y) = (u.x, u.y);
                let dw = [0, 1, 2].map(|a| Wiener::new(5).increment(k as u64, a, h));
                plain.step(&mut state, h, &dw).unwrap();
                state.t = f64::mul_add(k as f64 + 1.0, h, 0.3);
                let (found, expected) = (found.unwrap(), state);
                assert_eq!(found.t, expected.t);
                for i in 0..2 {
                    // the terms may stand in another order
                    assert!((found.q[i] - expected.q[i]).abs() < 1e-14, "{found:?} {expected:?}");
                    assert!((found.p[i] - expected.p[i]).abs() < 1e-14, "{found:?} {expected:?}");
                }
            }
        )*};
    }
    check!(
        InitialPoint,
        Endpoint,
        Midpoint,
        StormerVerlet,
        Gauss::<2>,
        Gauss::<4>
    );
    check!(Composed::new(StormerVerlet, KahanLi8));
}

/// A step of `Driven`.
type Step<'a> = &'a dyn Fn(&Driven, &mut State<[f64; 2]>, &[f64; 3], Vector2<f64>);

/// The sum of a function of the places and momenta of a path.
fn loss(step: Step<'_>, change: impl Fn(u64) -> Vector2<f64>, m: f64, q: f64) -> f64 {
    let driven = Driven { m };
    let mut sum = 0.0;
    let mut state = start();
    state.q[0] = q;
    for k in 0..8 {
        let dw = [0, 1, 2].map(|a| Wiener::new(5).increment(k, a, 0.1));
        step(&driven, &mut state, &dw, change(k));
        state.t = f64::mul_add(k as f64 + 1.0, 0.1, 0.3);
        sum += state.q[0] * state.p[1];
    }
    sum
}

#[test]
fn gradients_are_derivatives_by_each_input() {
    macro_rules! check {
        ($($rule:expr),*) => {$(
            let step: Step<'_> = &|driven, state, dw, u| {
                Integrator::new(driven, $rule).step_with(state, 0.1, dw, &u).unwrap();
            };
            let driven = Integrator::new(Driven { m: 1.2 }, $rule);
            let path = driven.trajectory(start(), 0.1, Wiener::new(5)).inputs(|k, _| table(k));
            let found = path
                .gradient(8, |k, state| (k > 0).then(|| state.q[0] * state.p[1]))
                .unwrap();
            assert!((found.loss() - loss(step, table, 1.2, 0.4)).abs() < 1e-13);
            for (k, by_input) in found.inputs().enumerate() {
                for (i, found) in by_input.iter().enumerate() {
                    let expected = derivative(|d| {
                        let change = |step| {
                            let mut u = table(step);
                            if step == k as u64 {
                                u[i] += d;
                            }
                            u
                        };
                        loss(step, change, 1.2, 0.4)
                    });
                    assert!((found - expected).abs() < 1e-9, "{k} {i}: {found} {expected}");
                }
            }
            let by_mass = derivative(|d| loss(step, table, 1.2 + d, 0.4));
            assert!((found.get("m").unwrap() - by_mass).abs() < 1e-9);
            let by_start = derivative(|d| loss(step, table, 1.2, 0.4 + d));
            assert!((found.start().q[0] - by_start).abs() < 1e-9);
            // a parameter is the input with all values equal
            let constant = |_| table(3);
            let path = driven.trajectory(start(), 0.1, Wiener::new(5)).inputs(|k, _| constant(k));
            let found = path
                .gradient(8, |k, state| (k > 0).then(|| state.q[0] * state.p[1]))
                .unwrap();
            let sum: f64 = found.inputs().map(|by_input| by_input[1]).sum();
            let expected = derivative(|d| {
                loss(step, |k| constant(k) + Vector2::new(0.0, d), 1.2, 0.4)
            });
            assert!((sum - expected).abs() < 1e-9, "{sum} {expected}");
        )*};
    }
    check!(
        InitialPoint,
        Endpoint,
        Midpoint,
        StormerVerlet,
        Gauss::<2>,
        Gauss::<4>
    );
}

//! Noises that move positions, `#[h1]`, in steps of the midpoint rule.

use sve_runtime::plan::BlockKind;
use sve_runtime::prelude::*;

use crate::common::{assert_same, spread};

/// Kubo oscillators without springs: H₁ = σ (p² + q²)/2.
struct Kubo {
    sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        (0..q.len())
            .map(|i| 0.5 * v[i] * v[i] - 0.5 * q[i] * q[i])
            .sum()
    }
    #[h1]
    fn phase(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| 0.5 * self.sigma * (p[i] * p[i] + q[i] * q[i]))
            .collect()
    }
}

/// A site turns by 2 atan(x) with x = (h + σΔW)/2, and the bound of the ratio of errors is |h| +
/// σ|ΔW| over 2, the exact one of a sweep that computes both from the old values.
#[test]
fn the_bound_of_an_oscillator_is_exact() {
    let kubo = Integrator::new(Kubo { sigma: 0.5 }, Midpoint);
    let start = State::new(vec![1.0, -0.3], vec![0.2, 0.7]);
    for h in [0.3, -0.3] {
        let mut state = start.clone();
        let dw = [0.4, -0.9];
        kubo.step(&mut state, h, &dw).expect("a step");
        for i in 0..2 {
            let (sin, cos) = (2.0 * (0.5 * (h + 0.5 * dw[i])).atan()).sin_cos();
            let q = cos * start.q[i] + sin * start.p[i];
            let p = cos * start.p[i] - sin * start.q[i];
            assert!((state.q[i] - q).abs() < 4e-16, "{} {q}", state.q[i]);
            assert!((state.p[i] - p).abs() < 4e-16, "{} {p}", state.p[i]);
        }
        let mut state = start.clone();
        let error = kubo
            .step(&mut state, h, &[0.4, -5.0])
            .expect_err("a large increment");
        assert_eq!(state, start);
        let StepError::Contraction { ratio, wanted, .. } = error else {
            panic!("{error}");
        };
        assert!((ratio - 1.4).abs() < 1e-14, "{ratio}");
        // increments are in proportion to the square root of the step size
        let scale = (wanted / 0.3).sqrt();
        kubo.step(&mut state, wanted.copysign(h), &[0.4 * scale, -5.0 * scale])
            .expect("a shorter step");
    }
    let error = kubo
        .step(&mut start.clone(), 0.1, &[f64::NAN, 0.0])
        .expect_err("no number");
    assert!(matches!(error, StepError::NonFiniteInput { .. }), "{error}");
}

/// H₁ = σ q p multiplies places by (1 + s)/(1 − s) and momenta by its inverse, s = σΔW/2; the bound
/// of the ratio is s and the least part of the velocities.
#[test]
fn the_bound_of_a_stretch_is_the_increment() {
    struct Stretch {
        sigma: f64,
        friction: f64,
    }
    #[variational(midpoint)]
    impl Stretch {
        fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
            v.iter().map(|v| v * v).sum()
        }
        #[h1]
        fn stretch(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
            q.iter().zip(p).map(|(q, p)| self.sigma * q * p).collect()
        }
        #[force]
        fn drag(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
            v.iter().map(|v| -self.friction * v).collect()
        }
    }
    for (friction, large) in [(0.0, 1.05), (2.0, 1.05), (-2.0, 1.0 / 0.95)] {
        let stretch = Stretch {
            sigma: 0.5,
            friction,
        };
        let stretch = Integrator::new(stretch, Midpoint);
        let mut state = State::new(vec![1.0, 2.0], vec![0.0, 0.0]);
        let h = 0.1;
        stretch.step(&mut state, h, &[0.2, -1.2]).expect("a step");
        for (q, [start, s]) in state.q.iter().zip([[1.0, 0.05], [2.0, -0.3]]) {
            let exact = start * (1.0 + s) / (1.0 - s);
            assert!((q - exact).abs() < 4e-16 * exact, "{q} {exact}");
        }
        let error = stretch
            .step(&mut state, h, &[0.2, -4.0])
            .expect_err("a large increment");
        let StepError::Contraction { ratio, .. } = error else {
            panic!("{error}");
        };
        assert!((ratio - large).abs() < 1e-14, "{ratio} {friction}");
    }
}

/// Small steps keep the digits of displacements and momenta, also far from the origin.
#[test]
fn small_steps_keep_their_digits() {
    let kubo = Integrator::new(Kubo { sigma: 0.5 }, Midpoint);
    let (q, p) = (1000.0, 0.7);
    for h in [1e-2, 1e-6, 1e-9] {
        let mut state = State::new(vec![q], vec![p]);
        kubo.step(&mut state, h, &[0.3 * h]).expect("a step");
        let x = 0.5 * (h + 0.5 * 0.3 * h);
        // p₁ − p₀ = −2x (q + x p)/(1 + x²)
        let exact = p - 2.0 * x * (q + x * p) / (1.0 + x * x);
        let error = (state.p[0] - exact).abs();
        assert!(error < 4e-16 * (2.0 * x * q).max(p), "{h}: {error}");
    }
}

#[test]
fn the_plan_has_the_noises() {
    let plan = Integrator::new(Kubo { sigma: 0.5 }, Midpoint).plan();
    assert_eq!(plan.kind(), BlockKind::FixedPoint);
    let text = plan.to_string();
    for line in [
        "S_d = h L(t̄, q̄, v) + ⟨p, q₁ − q₀ − h v⟩ − Σ H₁(t̄, q̄, p) ΔW,  q̄ = (q₀ + q₁)/2",
        "solve: M v = p₀ + (I(q̄) + K(q̄, M v))/2, q̄ = q₀ + (h v + X(q̄, M v))/2, by fixed-point sweeps",
        "end: q₁ = q₀ + h v + X, p₁ = p₀ + I + K",
    ] {
        assert!(text.contains(line), "{text}");
    }
}

mod wild {
    use sve_runtime::prelude::*;
    both! {
        @rules (midpoint)
        struct { k: f64, sigma: f64 }
        [f64] 3
        |self, q, v| {
            let mut l = 0.0;
            for i in 0..q.len() {
                l += 0.5 * v[i] * v[i] + self.k * q[i].cos();
            }
            for i in 1..q.len() {
                l -= 0.5 * (q[i] - q[i - 1]).powi(2);
            }
            l
        }
        #[h1]
        each kick(&self, q, p) -> f64 |i| {
            self.sigma * (q[i] * p[i].sin() + 0.3 * (p[i] - q[i]).cos())
        }
    }
}

/// A step is never another solution than the one that is connected with short steps, up to the step
/// sizes from which on the bounds refuse.
#[test]
fn no_step_is_another_solution() {
    let (k, sigma) = (3.0, 0.8);
    let scene = Integrator::new(wild::scene::System { k, sigma }, Midpoint);
    let unrolled = Integrator::new(wild::unrolled::System { k, sigma }, Midpoint);
    let numbers = |seed| -> [f64; 3] { spread(3, seed).try_into().expect("three") };
    let (mut made, mut refused) = (0, 0);
    for seed in 0..400 {
        let h = 0.05 * 1.01_f64.powi(seed as i32);
        let (q, p) = (
            numbers(3 * seed).map(|x| 3.0 * x),
            numbers(3 * seed + 1).map(|x| 3.0 * x),
        );
        let dw = numbers(3 * seed + 2).map(|x| 1.7 * h.sqrt() * x);
        let mut state = State::new(q.to_vec(), p.to_vec());
        match scene.step(&mut state, h, &dw) {
            Ok(()) => {
                made += 1;
                let mut expected = State::new(q, p);
                unrolled
                    .step(&mut expected, h, &dw)
                    .expect("the step of the fixed size");
                assert_same(&state, &expected.q, &expected.p, "midpoint");
            }
            Err(StepError::Contraction { .. } | StepError::Stiff { .. }) => refused += 1,
            Err(error) => panic!("{error}"),
        }
    }
    assert!(made > 100 && refused > 100, "{made} {refused}");
}

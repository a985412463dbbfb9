//! Exponents of compositions and splittings: those of the motion to their order, and exact pairs.

use sve_runtime::prelude::*;

/// A saddle beside an oscillator.
struct Saddle {
    k: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Saddle {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 0.5 * self.k * q[0] * q[0] - 0.8 * q[1] * q[1]
    }
}

/// A pendulum that is pushed at random.
struct Gusts {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Gusts {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }
    #[gamma]
    fn gusts(&self, q: f64) -> f64 {
        self.sigma * q.cos()
    }
}

/// The exponents of the saddle by a rule.
macro_rules! of_saddle {
    ($rule:expr) => {{
        let saddle = Integrator::new(Saddle { k: 2.5 }, $rule);
        let start = State::new([0.0, 0.3], [0.0, 0.2]);
        let mut path = saddle.lyapunov(start, 0.1, NoNoise, 4);
        path.advance(3000).unwrap();
        path.restart();
        path.advance(3000).unwrap();
        path.exponents()
    }};
}

/// The exponents of the motion are ±√k. The errors of the rules are at most (√k h)ᵖ/10.
#[test]
fn of_a_saddle_have_the_order_of_the_composition() {
    let root = 2.5_f64.sqrt();
    let plain = of_saddle!(Midpoint)[0] - root;
    assert!(plain > 1e-3, "{plain:e}");
    let x: f64 = 0.1 * root;
    for (order, exponents) in [
        (8, of_saddle!(Composed::new(Midpoint, KahanLi8))),
        (8, of_saddle!(Composed::new(StormerVerlet, KahanLi8))),
        (4, of_saddle!(Split::new(BlanesMoan4))),
        (6, of_saddle!(Split::new(BlanesMoanRkn6))),
    ] {
        let largest = 0.1 * x.powi(order) + 1e-12;
        let error = (exponents[0] - root).abs();
        assert!(error < largest, "{order} {error:e} {largest:e}");
        for sum in [exponents[0] + exponents[3], exponents[1] + exponents[2]] {
            assert!(sum.abs() < 1e-11, "{sum:e}");
        }
    }
}

/// Substeps with parts of the increments are symplectic, and so is their sequence.
#[test]
fn with_noise_are_pairs() {
    let noisy = Integrator::new(Gusts { sigma: 0.5 }, Composed::new(StormerVerlet, KahanLi8));
    let start = State::new([1.0], [0.0]);
    let mut path = noisy.lyapunov(start, 0.05, Wiener::new(1), 2);
    let split = Integrator::new(Gusts { sigma: 0.5 }, Split::new(BlanesMoan4));
    let mut other = split.lyapunov(start, 0.05, Wiener::new(1), 2);
    for steps in [1, 10, 2000] {
        path.advance(steps).unwrap();
        other.advance(steps).unwrap();
        for exponents in [path.exponents(), other.exponents()] {
            let sum = exponents[0] + exponents[1];
            assert!(sum.abs() < 1e-11, "{steps} {exponents:?}");
        }
    }
    for chaotic in [path.exponents(), other.exponents()] {
        assert!(chaotic[0] > 0.05, "{chaotic:?}");
    }
}

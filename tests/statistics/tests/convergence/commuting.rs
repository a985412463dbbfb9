//! Noises that commute with one another and with H: a Gauss rule with S stages has the strong order S.

use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

use super::strong_order::{Path, line, measure, record, rotated, run, total};

/// H = I with H₁ = (σ₁I, σ₂I²), I = (q² + p²)/2.
#[derive(Clone, Debug)]
struct Actions {
    sigma: [f64; 2],
}

#[variational(gauss(2), gauss(3))]
impl Actions {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> [f64; 2] {
        let action = 0.5 * (q * q + p * p);
        [self.sigma[0] * action, self.sigma[1] * action * action]
    }
}

/// A particle in a central potential of the plane, which noise turns: H₁ is the angular momentum times σ.
#[derive(Clone, Debug)]
struct Central {
    sigma: f64,
}

#[variational(gauss(2), gauss(3))]
impl Central {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * square - 0.25 * square * square
    }

    #[h1]
    fn turn(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.sigma * (q[0] * p[1] - q[1] * p[0])
    }
}

/// Prints and checks the orders of the rules with two and three stages.
fn has_order_of_stages<S, const N: usize, const M: usize>(
    system: &S,
    noise: &str,
    start: State<[f64; N]>,
    path: impl Fn(u64) -> Path<N>,
) where
    S: Variational<Gauss<2>> + Variational<Gauss<3>> + System<Dims = Dims<N, M>>,
{
    let (two, three) = (
        Integrator::new(system, Gauss::<2>),
        Integrator::new(system, Gauss::<3>),
    );
    let name = two.plan().system;
    let order = measure(&path, |path| run(&two, start, path));
    line(name, "gauss(2)", noise, 2.0, order);
    let order = measure(&path, |path| run(&three, start, path));
    line(name, "gauss(3)", noise, 3.0, order);
}

#[test]
fn functions_of_the_action() {
    let sigma = [0.5, 0.2];
    let start = State::new([0.8], [0.3]);
    let action = 0.5 * (0.8_f64.powi(2) + 0.3_f64.powi(2));
    let path = |path| {
        let fine = record(path, 2, 10);
        let [w1, w2] = total(&fine);
        let angle = 1.0 + sigma[0] * w1 + 2.0 * sigma[1] * action * w2;
        let end = rotated(start, angle);
        Path { fine, end }
    };
    has_order_of_stages(&Actions { sigma }, "H₁ = (σ₁I, σ₂I²)", start, path);
}

#[test]
fn angular_momentum_in_a_central_potential() {
    let system = Central { sigma: 0.7 };
    let start = State::new([0.8, -0.2], [0.3, 0.9]);
    // The flows of H and of the noise commute: first that of H, then a rotation.
    let quiet = Integrator::new(Central { sigma: 0.0 }, Gauss::<3>);
    let mut path = quiet.trajectory(start, 0.5_f64.powi(10), NoNoise);
    let end = path.nth((1 << 10) - 1).unwrap().unwrap();
    let path = |path| {
        let fine = record(path, 1, 10);
        let [w] = total(&fine);
        let (s, c) = (system.sigma * w).sin_cos();
        let turned = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
        let end = State::at(1.0, turned(end.q), turned(end.p));
        Path { fine, end }
    };
    has_order_of_stages(&system, "H₁ = σ(q₀p₁ − q₁p₀)", start, path);
}

//! Noises that commute with one another and with H: a Gauss rule with S stages has the strong order
//! S.

use std::sync::LazyLock;

use sve_models::orders::{Paths, Row, end, total};
use sve_runtime::Variational;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::strong_order::{self, rotated};

/// With fewer paths the standard errors of order 3 would be above the tolerance.
static EXACT: LazyLock<Paths> = LazyLock::new(|| Paths {
    count: 20,
    ..*strong_order::EXACT
});

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

/// A particle in a central potential of the plane, which noise turns: H₁ is the angular momentum
/// times σ.
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

/// The rules with two and three stages.
fn rows<S, const N: usize, const M: usize>(system: &S, start: State<[f64; N]>) -> [Row<'_>; 2]
where
    S: Variational<Gauss<2>> + Variational<Gauss<3>> + System<Dims = Dims<N, M>>,
{
    [
        Row::new(system, Gauss::<2>, start).of_order(2.0),
        Row::new(system, Gauss::<3>, start).of_order(3.0),
    ]
}

#[test]
fn functions_of_the_action() {
    let sigma = [0.5, 0.2];
    let start = State::new([0.8], [0.3]);
    let action = 0.5 * (0.8_f64.powi(2) + 0.3_f64.powi(2));
    let path = EXACT.against(2, |path| {
        let [w1, w2] = total(path);
        rotated(&start, 1.0 + sigma[0] * w1 + 2.0 * sigma[1] * action * w2)
    });
    EXACT.check("H₁ = (σ₁I, σ₂I²)", &rows(&Actions { sigma }, start), path);
}

#[test]
fn angular_momentum_in_a_central_potential() {
    let system = Central { sigma: 0.7 };
    let start = State::new([0.8, -0.2], [0.3, 0.9]);
    // The flows of H and of the noise commute: first that of H, then a rotation.
    let quiet = Integrator::new(Central { sigma: 0.0 }, Gauss::<3>);
    let still = Recorded::new(0.5_f64.powi(10), vec![[0.0]; 1 << 10]).unwrap();
    let quiet = end(&quiet, start, &still);
    let path = EXACT.against(1, |path| {
        let (s, c) = (system.sigma * total::<1>(path)[0]).sin_cos();
        let turned = |z: &[f64]| [c * z[0] - s * z[1], s * z[0] + c * z[1]];
        quiet.chunks(2).flat_map(turned).collect()
    });
    EXACT.check("H₁ = σ(q₀p₁ − q₁p₀)", &rows(&system, start), path);
}

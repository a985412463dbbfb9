//! The problems with noise: strong and weak errors on common Brownian paths.

use sve_runtime::Variational;
use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::prelude::*;
use sve_runtime::study::{Study, StudyError};
use sve_runtime::system::{Dims, System};

use crate::problem::{Problem, powers};
use crate::systems::{HenonHeiles, Kubo, Langevin, Oscillator, Synchrotron};
use crate::uncorrected::{QuadratureNode, Uncorrected};

const SEED: u64 = 42;

/// The methods that are run on every problem with noise.
struct Methods<S: System> {
    initial_point: Integrator<S, InitialPoint>,
    endpoint: Integrator<S, Endpoint>,
    midpoint: Integrator<S, Midpoint>,
    verlet: Integrator<S, StormerVerlet>,
    gauss_2: Integrator<S, Gauss<2>>,
    heun: Heun<S>,
    euler: EulerMaruyama<S>,
    backward: BackwardEulerMaruyama<S>,
}

impl<S, const N: usize, const M: usize> Methods<S>
where
    S: System<Dims = Dims<N, M>>
        + Copy
        + Sync
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>
        + Variational<Gauss<2>>,
{
    fn new(system: S) -> Self {
        Self {
            initial_point: Integrator::new(system, InitialPoint),
            endpoint: Integrator::new(system, Endpoint),
            midpoint: Integrator::new(system, Midpoint),
            verlet: Integrator::new(system, StormerVerlet),
            gauss_2: Integrator::new(system, Gauss::<2>),
            heun: Heun::new(system),
            euler: EulerMaruyama::new(system),
            backward: BackwardEulerMaruyama::new(system),
        }
    }

    /// Returns a study of all these methods.
    fn study<'a>(&'a self, name: &'static str) -> Study<'a, S> {
        Study::new(name)
            .seed(SEED)
            .method("Störmer–Verlet", &self.verlet)
            .method("midpoint", &self.midpoint)
            .method("Gauss 2", &self.gauss_2)
            .method("endpoint", &self.endpoint)
            .method("initial point", &self.initial_point)
            .method("Heun", &self.heun)
            .method("Euler–Maruyama", &self.euler)
            .method("backward Euler–Maruyama", &self.backward)
    }
}

/// Runs L = v²/2 − q²/2, γ = σq, from (1, 0).
pub(crate) fn oscillator() -> Result<Problem, StudyError> {
    let system = Oscillator { sigma: 1.0 };
    let (start, horizon) = (State::new([1.0], [0.0]), 10.0);
    let report = Methods::new(system)
        .study("linear_oscillator")
        .start(start)
        .horizon(horizon)
        .step_counts(powers(5..=10))
        .paths(1000)
        .exact_paths(|path, steps| exact_oscillator(system.sigma, start, horizon, path, steps))
        .observe("energy", Mechanics::hamiltonian)
        .run()?;
    Ok(Problem {
        title: "Linear oscillator, additive noise",
        setting: "L = v²/2 − q²/2, γ = σq, σ = 1, from (1, 0) to t = 10. Errors against the exact solution on each of 1000 paths.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: None,
        report,
    })
}

/// Returns increments, and the exact solution. Over a step it is the rotation by h plus σ ∫
/// (sin(h−s), cos(h−s)) dW, a pair that is drawn jointly with ΔW by the Cholesky factor of the
/// covariance of all three.
fn exact_oscillator(
    sigma: f64,
    start: State<[f64; 1]>,
    horizon: f64,
    path: u64,
    steps: usize,
) -> (Recorded, State<[f64; 1]>) {
    let normals = Wiener::new(SEED).path(path);
    let h = horizon / steps as f64;
    let (sin, cos) = h.sin_cos();
    let w = h.sqrt();
    // 1 − cos h = 2 sin²(h/2), since the difference would cancel.
    let (xw, yw) = (2.0 * (h / 2.0).sin().powi(2) / w, sin / w);
    let x = (0.5 * (h - sin * cos) - xw * xw).sqrt();
    let yx = (0.5 * sin * sin - xw * yw) / x;
    // The remaining variance has the size of h⁵, and rounding may make it negative.
    let y = (0.5 * (h + sin * cos) - yw * yw - yx * yx).max(0.0).sqrt();
    let mut end = start;
    let increments: Vec<[f64; 1]> = (0..steps as u64)
        .map(|step| {
            let [z0, z1, z2] = [0, 1, 2].map(|process| normals.increment(step, process, 1.0));
            let ([q], [p]) = (end.q, end.p);
            end.q = [cos * q + sin * p + sigma * (xw * z0 + x * z1)];
            end.p = [cos * p - sin * q + sigma * (yw * z0 + yx * z1 + y * z2)];
            [w * z0]
        })
        .collect();
    let recorded = Recorded::new(h, increments);
    // Normals are finite, and so is h.
    (recorded.expect("finite increments"), end)
}

/// Runs L = v²/2a − aq²/2, H₁ = σ(q² + p²)/2, from (1, 0), and rules without the correction.
pub(crate) fn kubo() -> Result<Problem, StudyError> {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let horizon = 4.0;
    let methods = Methods::new(system);
    let without = |node| Uncorrected { kubo: system, node };
    let (initial_point, endpoint) = (
        without(QuadratureNode::InitialPoint),
        without(QuadratureNode::Endpoint),
    );
    let report = methods
        .study("kubo")
        .method("endpoint, uncorrected", &endpoint)
        .method("initial point, uncorrected", &initial_point)
        .start(State::new([1.0], [0.0]))
        .horizon(horizon)
        .step_counts(powers(4..=11))
        .paths(1000)
        .exact(|path| {
            let dw = (0..path.len()).filter_map(|step| path.get(step));
            let w: f64 = dw.map(|dw| dw[0]).sum();
            let (sin, cos) = (system.a * horizon + system.sigma * w).sin_cos();
            State::at(horizon, [cos], [-sin])
        })
        .observe("q", |_, state| state.q[0])
        .invariant(|_, state| state.q[0].powi(2) + state.p[0].powi(2))
        .run()?;
    Ok(Problem {
        title: "Kubo oscillator, noise in q and p",
        setting: "L = v²/2a − aq²/2, H₁ = σ(q² + p²)/2, a = 1, σ = ½, from (1, 0) to t = 4. Errors against the exact rotation on each of \
                  1000 paths. “Uncorrected” rules lack the Stratonovich term of the discrete action; the macro never leaves it out.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: Some("q² + p²"),
        report,
    })
}

/// Runs L = v²/2 + ω² cos q, γ = (−σ₁ cos q, −σ₂ sin q).
pub(crate) fn synchrotron() -> Result<Problem, StudyError> {
    let system = Synchrotron {
        omega: 1.0,
        sigma: [0.1, 0.1],
    };
    let methods = Methods::new(system);
    let weak2 = Integrator::new(system, Weak2(StormerVerlet));
    let report = methods
        .study("synchrotron")
        .method("Störmer–Verlet, weak2", &weak2)
        .start(State::new([0.5], [0.0]))
        .horizon(8.0)
        .step_counts(powers(4..=10))
        .paths(600)
        .fine(&methods.verlet, 16)
        .observe("energy", Mechanics::hamiltonian)
        .run()?;
    Ok(Problem {
        title: "Synchrotron, two noises in q",
        setting: "L = v²/2 + ω² cos q, γ = (−σ₁ cos q, −σ₂ sin q), ω = 1, σ₁ = σ₂ = 0.1, from q = 0.5 at rest to t = 8. Errors against the rule \
                  of Störmer and Verlet with 16 times shorter steps on each of 600 paths.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: None,
        report,
    })
}

/// Runs Hénon–Heiles with γ = (σx, σy).
pub(crate) fn henon_heiles() -> Result<Problem, StudyError> {
    let system = HenonHeiles { sigma: 0.02 };
    let methods = Methods::new(system);
    let report = methods
        .study("henon_heiles")
        .start(State::new([0.0, 0.1], [0.35, 0.1]))
        .horizon(16.0)
        .step_counts(powers(6..=11))
        .paths(200)
        .fine(&methods.verlet, 16)
        .observe("energy", Mechanics::hamiltonian)
        .run()?;
    Ok(Problem {
        title: "Hénon–Heiles, additive noise",
        setting: "L = (v² − q²)/2 − x²y + y³/3, γ = (σx, σy), σ = 0.02, from q = (0, 0.1), p = (0.35, 0.1) to t = 16. Errors against the rule \
                  of Störmer and Verlet with 16 times shorter steps on each of 200 paths.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: None,
        report,
    })
}

/// Runs L = v²/2 − a(q² − 1)², F = −νv, γ = √(2νkT) q.
pub(crate) fn langevin() -> Result<Problem, StudyError> {
    let system = Langevin {
        a: 1.0,
        nu: 1.0,
        kt: 0.4,
    };
    let methods = Methods::new(system);
    let report = methods
        .study("langevin")
        .start(State::new([-1.0], [0.0]))
        .horizon(2.0)
        .step_counts(powers(3..=9))
        .paths(2000)
        .fine(&methods.verlet, 16)
        .observe("q²", |_, state| state.q[0].powi(2))
        .run()?;
    Ok(Problem {
        title: "Langevin dynamics in a double well, friction and additive noise",
        setting: "L = v²/2 − a(q² − 1)², F = −νv, γ = √(2νkT) q, a = ν = 1, kT = 0.4, from q = −1 at rest to t = 2. Errors against the rule of Störmer and Verlet with \
                  16 times shorter steps on each of 2000 paths.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: None,
        report,
    })
}

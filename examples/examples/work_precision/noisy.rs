//! The problems with noise: strong and weak errors on common Brownian paths.

use std::array;
use std::f64::consts::FRAC_PI_2;
use std::ops::RangeInclusive;

use sve_runtime::baseline::{BackwardEulerMaruyama, EulerMaruyama, Heun};
use sve_runtime::prelude::*;
use sve_runtime::study::{Study, StudyError};
use sve_runtime::system::{Dims, System};
use sve_runtime::{Rule, Variational};

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

/// The Gauss rules with an increment for each stage, for additive noise.
struct StageRules<S: System> {
    two: Integrator<S, StageNoise<Gauss<2>>>,
    three: Integrator<S, StageNoise<Gauss<3>>>,
    four: Integrator<S, StageNoise<Gauss<4>>>,
}

/// The constants `MK` are the numbers of increments of a step with `K` stages.
impl<S, const N: usize, const M: usize, const M2: usize, const M3: usize, const M4: usize>
    StageRules<S>
where
    S: System<Dims = Dims<N, M>> + Copy + Sync,
    StageNoise<Gauss<2>>: Rule<S::Itself, Increments = [f64; M2]>,
    StageNoise<Gauss<3>>: Rule<S::Itself, Increments = [f64; M3]>,
    StageNoise<Gauss<4>>: Rule<S::Itself, Increments = [f64; M4]>,
{
    fn new(system: S) -> Self {
        Self {
            two: Integrator::new(system, StageNoise(Gauss::<2>)),
            three: Integrator::new(system, StageNoise(Gauss::<3>)),
            four: Integrator::new(system, StageNoise(Gauss::<4>)),
        }
    }

    /// Adds the rules to a study. They reach errors of interest with fewer steps than rules of
    /// order 1, so each rule has its own range of exponents of 2.
    fn add_to<'a>(
        &'a self,
        study: Study<'a, S>,
        [two, three, four]: [RangeInclusive<u32>; 3],
    ) -> Study<'a, S> {
        study
            .method_with_step_counts("Gauss 2, stage noise", &self.two, powers(two))
            .method_with_step_counts("Gauss 3, stage noise", &self.three, powers(three))
            .method_with_step_counts("Gauss 4, stage noise", &self.four, powers(four))
    }
}

/// Runs L = v²/2 − q²/2, γ = σq, from (1, 0).
pub(crate) fn oscillator() -> Result<Problem, StudyError> {
    let system = Oscillator { sigma: 1.0 };
    let (start, horizon) = (State::new([1.0], [0.0]), 10.0);
    let (methods, stage_rules) = (Methods::new(system), StageRules::new(system));
    let report = stage_rules
        .add_to(methods.study("linear_oscillator"), [4..=10, 3..=10, 3..=9])
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

/// Number of coefficients of the noise in Legendre polynomials. The first one that is left out
/// changes an impulse by less than 10⁻¹⁵ of the noise of a step.
const COEFFICIENTS: usize = 5;

/// Returns increments at the four stages of `gauss(4)`, and the exact solution.
///
/// Over a step the solution is the rotation by h plus σ ∫ (sin(h−s), cos(h−s)) dW. The noise is
/// drawn by its coefficients `ξ_k = √(2k+1) ∫ P_k(2s/h − 1) dW / √h`, which are independent
/// normals. With a = h/2 and the spherical Bessel functions j, the expansion of a plane wave in
/// Legendre polynomials gives `∫ exp(i(h−s)) dW = √h Σ √(2k+1) exp(i(a − kπ/2)) j_k(a) ξ_k`.
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
    let impulses: [(f64, f64); COEFFICIENTS] = array::from_fn(|k| {
        let (sine, cosine) = (0.5 * h - k as f64 * FRAC_PI_2).sin_cos();
        let size = sigma * (h * (2 * k + 1) as f64).sqrt() * spherical_bessel(k, 0.5 * h);
        (size * sine, size * cosine)
    });
    let mut end = start;
    let increments: Vec<[f64; 4]> = (0..steps as u64)
        .map(|step| {
            let xi: [f64; COEFFICIENTS] = array::from_fn(|k| normals.increment(step, k, 1.0));
            let ([q], [p]) = (end.q, end.p);
            let sum = |part: fn(&(f64, f64)) -> f64| -> f64 {
                impulses
                    .iter()
                    .zip(xi)
                    .map(|(both, xi)| part(both) * xi)
                    .sum()
            };
            end.q = [cos * q + sin * p + sum(|both| both.0)];
            end.p = [cos * p - sin * q + sum(|both| both.1)];
            at_stages(xi).map(|part| h.sqrt() * part)
        })
        .collect();
    let recorded = Recorded::new(h, increments).and_then(|path| path.with_stages(4));
    // Normals are finite, and so is h.
    (recorded.expect("finite increments"), end)
}

/// Returns the spherical Bessel function `j_k` at a small argument, by its power series.
fn spherical_bessel(k: usize, x: f64) -> f64 {
    const TERMS: usize = 6;
    let mut term: f64 = (0..k).map(|i| x / (2 * i + 3) as f64).product();
    let mut sum = term;
    for m in 1..TERMS {
        term *= -0.5 * x * x / (m * (2 * (k + m) + 1)) as f64;
        sum += term;
    }
    sum
}

/// Returns the increments at the stages of `gauss(4)` over a step of length 1 from the coefficients
/// of the noise: `b_i Σ √(2k+1) P_k(2c_i − 1) ξ_k`, where k has the values 0 to 3.
fn at_stages(xi: [f64; COEFFICIENTS]) -> [f64; 4] {
    let (middle, width, weight) = (3.0 / 7.0, 2.0 / 7.0 * 1.2_f64.sqrt(), 30.0_f64.sqrt());
    let (inner, outer) = ((middle - width).sqrt(), (middle + width).sqrt());
    [
        (-outer, -weight),
        (-inner, weight),
        (inner, weight),
        (outer, -weight),
    ]
    .map(|(y, weight)| {
        let second = 0.5 * (3.0 * y * y - 1.0);
        let third = 0.5 * (5.0 * y * y - 3.0) * y;
        let odd = 3.0_f64.sqrt() * y * xi[1] + 7.0_f64.sqrt() * third * xi[3];
        (18.0 + weight) / 72.0 * (xi[0] + odd + 5.0_f64.sqrt() * second * xi[2])
    })
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
    let (methods, stage_rules) = (Methods::new(system), StageRules::new(system));
    let report = stage_rules
        .add_to(methods.study("henon_heiles"), [5..=11, 5..=10, 4..=9])
        .start(State::new([0.0, 0.1], [0.35, 0.1]))
        .horizon(16.0)
        .step_counts(powers(6..=11))
        .paths(200)
        .fine(&stage_rules.four, 2)
        .observe("energy", Mechanics::hamiltonian)
        .run()?;
    Ok(Problem {
        title: "Hénon–Heiles, additive noise",
        setting: "L = (v² − q²)/2 − x²y + y³/3, γ = (σx, σy), σ = 0.02, from q = (0, 0.1), p = (0.35, 0.1) to t = 16. Errors against gauss(4, stage_noise) \
                  with 2 times shorter steps on each of 200 paths.",
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
    let (methods, stage_rules) = (Methods::new(system), StageRules::new(system));
    let report = stage_rules
        .add_to(methods.study("langevin"), [3..=9, 3..=9, 2..=8])
        .start(State::new([-1.0], [0.0]))
        .horizon(2.0)
        .step_counts(powers(3..=9))
        .paths(2000)
        .fine(&stage_rules.four, 4)
        .observe("q²", |_, state| state.q[0].powi(2))
        .run()?;
    Ok(Problem {
        title: "Langevin dynamics in a double well, friction and additive noise",
        setting: "L = v²/2 − a(q² − 1)², F = −νv, γ = √(2νkT) q, a = ν = 1, kT = 0.4, from q = −1 at rest to t = 2. Errors against gauss(4, stage_noise) with \
                  4 times shorter steps on each of 2000 paths.",
        norm: "root mean square distance of (q, p) at the end",
        invariant: None,
        report,
    })
}

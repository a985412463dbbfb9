//! Strong orders of systems in rows of coordinates, and orders without noise.
//!
//! References are exact paths, or the midpoint rule with steps of 2⁻¹⁴ on the same path: its error
//! has the same order, so that it is smaller by 2⁻⁴ (order 1) or 2⁻² (order ½, 3 % of the mean
//! square) than that of the finest step measured.

use std::sync::LazyLock;

use sve_models::exact::OscillatorStep;
use sve_models::is_thorough;
use sve_models::models::{Actions, Clashing, Kubo, Oscillator};
use sve_models::oracle::{
    double_pendulum, mixed, pendulum, planar_double_pendulum, relativistic, spherical_pendulum,
    synchrotron,
};
use sve_models::orders::{Order, Path, Paths, Row, Tolerance, distance2, end, numbers, total};
use sve_runtime::baseline::RungeKutta4;
use sve_runtime::plan::StrongOrder;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Rule, Variational};

/// Against exact paths: steps 2⁻⁶ … 2⁻¹⁰. Half of the paths give 1.4 times the standard error.
pub(crate) static EXACT: LazyLock<Paths> = LazyLock::new(|| Paths {
    seed: 2024,
    batches: 12,
    count: if is_thorough() { 20 } else { 10 },
    coarsest: 6,
    levels: 5,
    finest: 10,
    tolerance: Tolerance {
        bias: 0.06,
        error: 0.06,
    },
});

/// Against fine steps on the same path.
pub(crate) static FINE: LazyLock<Paths> = LazyLock::new(|| Paths {
    finest: 14,
    ..*EXACT
});

pub(crate) fn rotated(start: &State<[f64; 1]>, angle: f64) -> Vec<f64> {
    let ([q], [p]) = (start.q, start.p);
    let (s, c) = angle.sin_cos();
    vec![q * c + p * s, p * c - q * s]
}

/// Checks the orders of all rules against the midpoint rule with fine steps.
pub(crate) fn check_against_fine_steps<S, const N: usize, const M: usize>(
    system: &S,
    noise: &str,
    order: StrongOrder,
    start: State<[f64; N]>,
) where
    S: System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>
        + Variational<Endpoint>,
{
    let midpoint = Integrator::new(system, Midpoint);
    assert_eq!(midpoint.plan().strong_order, order);
    let path = FINE.against(M, |fine| end(&midpoint, start, fine));
    FINE.check(noise, &Row::rules(system, start), path);
}

#[test]
fn commuting_momentum_noises() {
    let system = Actions {
        a: 1.0,
        sigma: [0.5, 0.2],
    };
    let start = State::new([0.8], [0.3]);
    let action = 0.5 * (0.8_f64.powi(2) + 0.3_f64.powi(2));
    let path = EXACT.against(2, |path| {
        let [w1, w2] = total(path);
        rotated(&start, 1.0 + 0.5 * w1 + 2.0 * 0.2 * action * w2)
    });
    EXACT.check("H₁ = (σ₁I, σ₂I²)", &Row::rules(&system, start), path);
}

/// The endpoint rule on Kubo as it is without the Stratonovich correction: `q₁ = q₀ + x p₀`,
/// `p₁ = p₀ − x q₁`.
fn uncorrected(path: &Recorded) -> Vec<f64> {
    let (mut q, mut p) = (1.0, 0.0);
    for step in 0..path.len() {
        let x = path.h() + 0.5 * path.get(step).unwrap()[0];
        q += x * p;
        p -= x * q;
    }
    vec![q, p]
}

#[test]
fn kubo_with_the_correction_and_without() {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let start = State::new([1.0], [0.0]);
    let mut rows = Row::rules(&system, start);
    rows.push(Row {
        system: "Kubo".to_owned(),
        rule: "endpoint, uncorrected".to_owned(),
        order: 0.0,
        end: Box::new(uncorrected),
    });
    let path = EXACT.against(1, |path| rotated(&start, 1.0 + 0.5 * total::<1>(path)[0]));
    EXACT.check("H₁ = σI", &rows, path);
}

/// Path by path.
#[test]
fn linear_oscillator_against_the_exact_path() {
    let system = Oscillator { sigma: 0.7 };
    let start = State::new([1.0], [0.0]);
    let steps = 1_usize << EXACT.finest;
    let step = OscillatorStep::new(1.0 / steps as f64);
    let path = |path| {
        let noise = Wiener::new(EXACT.seed).path(path);
        let (fine, end) = step.path(system.sigma, start, &noise, steps);
        let end = Some(numbers(&end));
        Path { fine, end }
    };
    EXACT.check("γ = σq, exact path", &Row::rules(&system, start), path);
}

#[test]
fn commuting_position_noises() {
    let start = State::new([0.5], [0.8]);
    let noise = "γ = (σ₁ sin q, σ₂ cos q)";
    check_against_fine_steps(&synchrotron(), noise, StrongOrder::One, start);

    let start = State::new([0.8, -0.3], [0.2, 0.4]);
    let noise = "γ = (s sin q₀, s cos q₁)";
    check_against_fine_steps(&double_pendulum(), noise, StrongOrder::One, start);
}

#[test]
fn noises_that_do_not_commute() {
    let order = |first, second| StrongOrder::Half {
        pair: (first, second),
    };
    let system = Clashing { sigma: [1.0, 0.6] };
    let start = State::new([0.5], [0.5]);
    let noise = "γ = σ₁ sin q, H₁ = σ₂qp";
    check_against_fine_steps(&system, noise, order("push", "stretch"), start);

    let start = State::new([0.4, -0.3], [0.2, 0.5]);
    let noise = "two H₁(q, p) and a γ";
    check_against_fine_steps(&mixed(), noise, order("drag[0]", "drag[1]"), start);
}

/// Without noise: slopes between 2⁻⁷ and 2⁻¹¹ at T = 1, against an exact end.
fn check_without_noise<S, R, const N: usize>(
    system: &S,
    rule: R,
    order: u32,
    start: State<[f64; N]>,
    exact: &[f64],
) where
    S: System<Dims = Dims<N, 0>>,
    R: Rule<S::Itself>,
{
    let integrator = Integrator::new(system, rule);
    let plan = integrator.plan();
    assert_eq!(plan.strong_order, StrongOrder::Deterministic);
    assert_eq!(plan.deterministic_order, order);
    let errors = [7, 8, 9, 10, 11].map(|level| {
        let steps = 1_usize << level;
        let mut path = integrator.trajectory(start, 1.0 / steps as f64, NoNoise);
        let end = path.nth(steps - 1).unwrap().unwrap();
        distance2(&numbers(&end), exact).sqrt()
    });
    // the next term of the error is 2⁻⁷ times a constant of the order of 1 to 3
    let tolerance = Tolerance {
        bias: 0.03,
        error: 0.0,
    };
    let names = [plan.system, plan.rule, "none"];
    Order::of(&errors).check(names, f64::from(order), tolerance);
}

/// The reference is Runge–Kutta with 2¹³ steps, whose error is 1e-14.
fn check_rules_without_noise<S, const N: usize>(system: &S, start: State<[f64; N]>)
where
    S: System<Dims = Dims<N, 0>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<Taylor2>,
{
    let steps = 1_u32 << 13;
    let reference = RungeKutta4::new(system);
    let mut path = reference.trajectory(start, 1.0 / f64::from(steps), NoNoise);
    let exact = numbers(&path.nth(steps as usize - 1).unwrap().unwrap());
    check_without_noise(system, InitialPoint, 1, start, &exact);
    check_without_noise(system, Endpoint, 1, start, &exact);
    check_without_noise(system, Midpoint, 2, start, &exact);
    check_without_noise(system, Taylor2, 2, start, &exact);
}

#[test]
fn without_noise() {
    let start = State::new([0.8, -0.3], [0.2, 0.4]);
    check_rules_without_noise(&planar_double_pendulum(), start);
    check_rules_without_noise(&pendulum(), State::new([1.0], [0.4]));
    check_rules_without_noise(&spherical_pendulum(), State::new([1.2, 0.3], [0.3, 0.6]));
    check_rules_without_noise(&relativistic(), State::new([0.6, -0.3], [0.3, 0.6]));
}

//! Measured orders of convergence: one table of system, rule, noise and expected order.
//!
//! The strong error is the root mean square over paths of the distance from the exact end point at T = 1, for steps
//! 2⁻⁶ … 2⁻¹⁰ on the same paths. The order is the slope of the logarithms; the standard error of the slope comes from the
//! scatter between batches of paths.

use sve_models::exact::OscillatorStep;
use sve_models::models::{Actions, Clashing, Kubo, Oscillator};
use sve_models::oracle::{
    Rule, double_pendulum, mixed, pendulum, planar_double_pendulum, relativistic,
    spherical_pendulum, synchrotron,
};
use sve_runtime::baseline::RungeKutta4;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, StrongOrder, System, Variational};

const BATCHES: usize = 12;
const PATHS: usize = 20;
const SEED: u64 = 2024;

/// Exponents of the step sizes 2⁻ᵏ.
const LEVELS: [u32; 5] = [6, 7, 8, 9, 10];

/// What a slope may be off beside its statistical error: at the larger steps the next term of the error still counts.
const BIAS: f64 = 0.06;

/// Standard errors that are accepted; with fixed seeds the test never changes its mind.
const SIGMAS: f64 = 4.0;

/// A path: increments for the finest steps, and the exact end point.
pub(crate) struct Path<const N: usize> {
    pub(crate) fine: Recorded,
    pub(crate) end: State<[f64; N]>,
}

/// Slope of the least-squares line.
pub(crate) fn slope(x: &[f64], y: &[f64]) -> f64 {
    let n = x.len() as f64;
    let (mx, my) = (x.iter().sum::<f64>() / n, y.iter().sum::<f64>() / n);
    let covariance: f64 = x.iter().zip(y).map(|(x, y)| (x - mx) * (y - my)).sum();
    covariance / x.iter().map(|x| (x - mx).powi(2)).sum::<f64>()
}

pub(crate) fn distance2<const N: usize>(a: &State<[f64; N]>, b: &State<[f64; N]>) -> f64 {
    (0..N)
        .map(|i| (a.q[i] - b.q[i]).powi(2) + (a.p[i] - b.p[i]).powi(2))
        .sum()
}

/// Measures the order of `end(path, k)`, the end points with 2ᵏ steps, and returns it with its standard error.
pub(crate) fn measure<const N: usize>(
    path: impl Fn(u64) -> Path<N>,
    end: impl Fn(&Recorded) -> State<[f64; N]>,
) -> (f64, f64) {
    let x: Vec<f64> = LEVELS.iter().map(|&k| -f64::from(k)).collect();
    let mut total = vec![0.0; LEVELS.len()];
    let mut slopes = Vec::new();
    for batch in 0..BATCHES {
        let mut squares = vec![0.0; LEVELS.len()];
        for member in 0..PATHS {
            let path = path((batch * PATHS + member) as u64);
            for (square, &level) in squares.iter_mut().zip(&LEVELS) {
                let steps = 1_usize << level;
                let coarse = path.fine.coarsen(path.fine.len() / steps).unwrap();
                *square += distance2(&end(&coarse), &path.end);
            }
        }
        for (sum, square) in total.iter_mut().zip(&squares) {
            *sum += square;
        }
        let y: Vec<f64> = squares.iter().map(|s| 0.5 * s.log2()).collect();
        slopes.push(slope(&x, &y));
    }
    let y: Vec<f64> = total.iter().map(|s| 0.5 * s.log2()).collect();
    let mean = slopes.iter().sum::<f64>() / BATCHES as f64;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (BATCHES - 1) as f64;
    (slope(&x, &y), (variance / BATCHES as f64).sqrt())
}

/// Prints a line of the table and checks it.
pub(crate) fn line(
    system: &str,
    rule: &str,
    noise: &str,
    expected: f64,
    (order, error): (f64, f64),
) {
    println!("| {system} | {rule} | {noise} | {expected} | {order:.3} ± {error:.3} |");
    assert!(
        (order - expected).abs() < BIAS + SIGMAS * error,
        "{system} by {rule}: order {order} ± {error}, expected {expected}"
    );
}

/// The end point on a recorded path.
pub(crate) fn run<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    path: &Recorded,
) -> State<[f64; N]>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let end = integrator.trajectory(start, path.h(), path).last();
    end.expect("a step at least").unwrap()
}

/// One line for a rule, after checking that the plan expects the same.
fn stochastic<S, R, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    noise: &str,
    start: State<[f64; N]>,
    path: impl Fn(u64) -> Path<N>,
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
    R: Rule,
{
    let plan = integrator.plan();
    let expected = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::Half { .. } => 0.5,
        other => panic!("{other:?}"),
    };
    let measured = measure(path, |path| run(integrator, start, path));
    line(plan.system, R::NAME, noise, expected, measured);
}

fn all_rules<S, const N: usize, const M: usize>(
    system: &S,
    noise: &str,
    order: StrongOrder,
    start: State<[f64; N]>,
    path: impl Fn(u64) -> Path<N>,
) where
    S: Clone
        + System<Dims = Dims<N, M>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<StormerVerlet>,
{
    let midpoint = Integrator::new(system.clone(), Midpoint);
    assert_eq!(midpoint.plan().strong_order, order);
    stochastic(
        &Integrator::new(system.clone(), InitialPoint),
        noise,
        start,
        &path,
    );
    stochastic(&midpoint, noise, start, &path);
    stochastic(
        &Integrator::new(system.clone(), StormerVerlet),
        noise,
        start,
        &path,
    );
    stochastic(
        &Integrator::new(system.clone(), Endpoint),
        noise,
        start,
        &path,
    );
}

pub(crate) fn record(path: u64, processes: usize, level: u32) -> Recorded {
    let h = 0.5_f64.powi(level as i32);
    Recorded::record(Wiener::new(SEED).path(path), h, processes, 1 << level).unwrap()
}

/// The sum of all increments.
pub(crate) fn total<const M: usize>(path: &Recorded) -> [f64; M] {
    let whole = path.coarsen(path.len()).unwrap();
    whole.get(0).unwrap().try_into().unwrap()
}

pub(crate) fn rotated(start: State<[f64; 1]>, angle: f64) -> State<[f64; 1]> {
    let ([q], [p]) = (start.q, start.p);
    let (s, c) = angle.sin_cos();
    State::at(1.0, [q * c + p * s], [p * c - q * s])
}

/// The reference is the midpoint rule with steps of 2⁻¹⁴ on the same path: its error has the same order, so that it is
/// smaller by 2⁻⁴ (order 1) or 2⁻² (order ½, 3 % of the mean square) than that of the finest step measured.
pub(crate) fn with_fine_reference<S, const N: usize, const M: usize>(
    system: &S,
    start: State<[f64; N]>,
) -> impl Fn(u64) -> Path<N>
where
    S: Clone + System<Dims = Dims<N, M>> + Variational<Midpoint>,
{
    let midpoint = Integrator::new(system.clone(), Midpoint);
    move |path| {
        let fine = record(path, M, 14);
        let end = run(&midpoint, start, &fine);
        Path { fine, end }
    }
}

#[test]
fn commuting_momentum_noises() {
    let system = Actions {
        a: 1.0,
        sigma: [0.5, 0.2],
    };
    let start = State::new([0.8], [0.3]);
    let action = 0.5 * (0.8_f64.powi(2) + 0.3_f64.powi(2));
    all_rules(
        &system,
        "H₁ = (σ₁I, σ₂I²)",
        StrongOrder::One,
        start,
        |path| {
            let fine = record(path, 2, 10);
            let [w1, w2] = total(&fine);
            let end = rotated(start, 1.0 + 0.5 * w1 + 2.0 * 0.2 * action * w2);
            Path { fine, end }
        },
    );
}

fn kubo_path(path: u64) -> Path<1> {
    let fine = record(path, 1, 10);
    let [w] = total(&fine);
    let end = rotated(State::new([1.0], [0.0]), 1.0 + 0.5 * w);
    Path { fine, end }
}

#[test]
fn kubo() {
    let system = Kubo { a: 1.0, sigma: 0.5 };
    let start = State::new([1.0], [0.0]);
    all_rules(&system, "H₁ = σI", StrongOrder::One, start, kubo_path);
}

/// The endpoint rule on Kubo as it is without the Stratonovich correction: `q₁ = q₀ + x p₀`, `p₁ = p₀ − x q₁`.
#[test]
fn kubo_without_the_correction() {
    let end = |path: &Recorded| {
        let (mut q, mut p) = (1.0, 0.0);
        for step in 0..path.len() {
            let x = path.h() + 0.5 * path.get(step).unwrap()[0];
            q += x * p;
            p -= x * q;
        }
        State::new([q], [p])
    };
    let measured = measure(kubo_path, end);
    line("Kubo", "endpoint, uncorrected", "H₁ = σI", 0.0, measured);
}

/// Path by path.
#[test]
fn linear_oscillator_against_the_exact_path() {
    let sigma = 0.7;
    let start = State::new([1.0], [0.0]);
    let steps = 1_usize << 10;
    let step = OscillatorStep::new(1.0 / steps as f64);
    let exact = |path: u64| {
        let (fine, end) = step.path(sigma, start, &Wiener::new(SEED).path(path), steps);
        Path { fine, end }
    };
    all_rules(
        &Oscillator { sigma },
        "γ = σq, exact path",
        StrongOrder::One,
        start,
        exact,
    );
}

#[test]
fn commuting_position_noises() {
    let system = synchrotron();
    let start = State::new([0.5], [0.8]);
    let path = with_fine_reference(&system, start);
    all_rules(
        &system,
        "γ = (σ₁ sin q, σ₂ cos q)",
        StrongOrder::One,
        start,
        path,
    );

    let system = double_pendulum();
    let start = State::new([0.8, -0.3], [0.2, 0.4]);
    let path = with_fine_reference(&system, start);
    all_rules(
        &system,
        "γ = (s sin q₀, s cos q₁)",
        StrongOrder::One,
        start,
        path,
    );
}

#[test]
fn noises_that_do_not_commute() {
    let system = Clashing { sigma: [1.0, 0.6] };
    let start = State::new([0.5], [0.5]);
    let path = with_fine_reference(&system, start);
    let order = StrongOrder::Half {
        pair: ("push", "stretch"),
    };
    all_rules(&system, "γ = σ₁ sin q, H₁ = σ₂qp", order, start, path);

    let system = mixed();
    let start = State::new([0.4, -0.3], [0.2, 0.5]);
    let path = with_fine_reference(&system, start);
    let order = StrongOrder::Half {
        pair: ("drag[0]", "drag[1]"),
    };
    all_rules(&system, "two H₁(q, p) and a γ", order, start, path);
}

/// Without noise: slopes between 2⁻⁷ and 2⁻¹¹ at T = 1, against Runge–Kutta with 2¹³ steps, whose error is 1e-14.
fn deterministic<S, R, const N: usize>(system: &S, rule: R, start: State<[f64; N]>)
where
    S: Clone + Variational<R> + System<Dims = Dims<N, 0>>,
    R: Rule,
{
    let steps = 1_u32 << 13;
    let reference = RungeKutta4::new(system.clone());
    let exact = reference
        .trajectory(start, 1.0 / f64::from(steps), NoNoise)
        .nth(steps as usize - 1)
        .unwrap()
        .unwrap();
    let integrator = Integrator::new(system.clone(), rule);
    let plan = integrator.plan();
    let (x, y): (Vec<_>, Vec<_>) = (7..=11)
        .map(|level| {
            let steps = 1_u32 << level;
            let mut path = integrator.trajectory(start, 1.0 / f64::from(steps), NoNoise);
            let end = path.nth(steps as usize - 1).unwrap().unwrap();
            (-f64::from(level), 0.5 * distance2(&end, &exact).log2())
        })
        .unzip();
    let order = slope(&x, &y);
    let expected = f64::from(plan.deterministic_order);
    println!(
        "| {} | {} | none | {expected} | {order:.4} |",
        plan.system,
        R::NAME
    );
    assert_eq!(plan.strong_order, StrongOrder::Deterministic);
    // the next term of the error is 2⁻⁷ times a constant of the order of 1 to 3
    assert!(
        (order - expected).abs() < 0.03,
        "{} by {}: {order}",
        plan.system,
        R::NAME
    );
}

fn four_rules<S, const N: usize>(system: &S, start: State<[f64; N]>)
where
    S: Clone
        + System<Dims = Dims<N, 0>>
        + Variational<InitialPoint>
        + Variational<Endpoint>
        + Variational<Midpoint>
        + Variational<Taylor2>,
{
    deterministic(system, InitialPoint, start);
    deterministic(system, Endpoint, start);
    deterministic(system, Midpoint, start);
    deterministic(system, Taylor2, start);
    let orders = [
        Integrator::new(system.clone(), InitialPoint).plan(),
        Integrator::new(system.clone(), Endpoint).plan(),
        Integrator::new(system.clone(), Midpoint).plan(),
        Integrator::new(system.clone(), Taylor2).plan(),
    ]
    .map(|plan| plan.deterministic_order);
    assert_eq!(orders, [1, 1, 2, 2]);
}

#[test]
fn without_noise() {
    four_rules(&pendulum(), State::new([1.0], [0.4]));
    four_rules(
        &planar_double_pendulum(),
        State::new([0.8, -0.3], [0.2, 0.4]),
    );
    four_rules(&spherical_pendulum(), State::new([1.2, 0.3], [0.3, 0.6]));
    four_rules(&relativistic(), State::new([0.6, -0.3], [0.3, 0.6]));
}

//! Strong orders of degenerate systems, as rows of the table of `strong_order.rs`. The expected order is within two standard errors of the fit, and the
//! standard error at most 0.03. Wrong steps fail the same test.

use sve_models::degenerate::wrong::{self, Plain};
use sve_models::degenerate::{
    InternalLotkaVolterra, Joint, Kubo, MassWithPair, Spin, StormyLotkaVolterra, VortexPair,
};
use sve_models::oracle::Rule;
use sve_runtime::prelude::*;
use sve_runtime::{Coordinates, Dims, StrongOrder, System, Variational};

use super::strong_order::{record, slope, total};

/// Batches of paths, from whose scatter the standard error comes.
const BATCHES: u64 = 24;

/// Exponents of the step sizes 2⁻ᵏ, and of the reference.
const LEVELS: [u32; 5] = [6, 7, 8, 9, 10];
const REFERENCE: u32 = 14;

/// The slope of the logarithms of the errors of configurations, with its standard error. `paths` are those of a batch.
fn measure<const N: usize>(
    paths: u64,
    level: u32,
    processes: usize,
    exact: impl Fn(&Recorded) -> [f64; N],
    end: impl Fn(&Recorded) -> [f64; N],
) -> [f64; 2] {
    let x: Vec<f64> = LEVELS.iter().map(|&k| -f64::from(k)).collect();
    let mut total = [0.0; LEVELS.len()];
    let mut slopes = Vec::new();
    for batch in 0..BATCHES {
        let mut squares = [0.0; LEVELS.len()];
        for member in 0..paths {
            let fine = record(batch * paths + member, processes, level);
            let target = exact(&fine);
            for (square, &level) in squares.iter_mut().zip(&LEVELS) {
                let coarse = fine.coarsen(fine.len() >> level).unwrap();
                let found = end(&coarse);
                *square += (0..N).map(|i| (found[i] - target[i]).powi(2)).sum::<f64>();
            }
        }
        for (sum, square) in total.iter_mut().zip(&squares) {
            *sum += square;
        }
        let y: Vec<f64> = squares.iter().map(|s| 0.5 * s.log2()).collect();
        slopes.push(slope(&x, &y));
    }
    let y: Vec<f64> = total.iter().map(|s| 0.5 * s.log2()).collect();
    let count = BATCHES as f64;
    let mean = slopes.iter().sum::<f64>() / count;
    let variance = slopes.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (count - 1.0);
    [slope(&x, &y), (variance / count).sqrt()]
}

/// The configuration at the end of a recorded path.
fn end<S, R, Q, const N: usize, const M: usize>(
    integrator: &Integrator<S, R>,
    start: State<Q>,
    path: &Recorded,
) -> [f64; N]
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let end = integrator.trajectory(start, path.h(), path).last();
    end.expect("a step at least").unwrap().q.coordinates()
}

/// Prints a row of the table and checks it.
fn row(system: &str, rule: &str, noise: &str, expected: f64, [order, error]: [f64; 2]) {
    println!("| {system} | {rule} | {noise} | {expected} | {order:.3} ± {error:.3} |");
    assert!(error <= 0.03, "{system} by {rule}: {order} ± {error}");
    assert!(
        (order - expected).abs() <= 2.0 * error,
        "{system} by {rule}: {order} ± {error}, expected {expected}"
    );
}

/// A row of a rule, against an exact end or the midpoint rule with small steps.
fn stochastic<S, R, Q, const N: usize, const M: usize>(
    (system, rule): (S, R),
    noise: &str,
    start: State<Q>,
    paths: u64,
    exact: Option<&dyn Fn([f64; M]) -> [f64; N]>,
) where
    S: Variational<R> + Variational<Midpoint> + System<Dims = Dims<N, M, Q>> + Copy,
    R: Rule,
    Q: Coordinates<N>,
{
    let integrator = Integrator::new(system, rule);
    let reference = Integrator::new(system, Midpoint);
    let plan = integrator.plan();
    let expected = match plan.strong_order {
        StrongOrder::One => 1.0,
        StrongOrder::Half { .. } => 0.5,
        other => panic!("{other:?}"),
    };
    let measured = match exact {
        Some(exact) => measure(
            paths,
            LEVELS[4],
            M,
            |fine| exact(total(fine)),
            |path| end(&integrator, start, path),
        ),
        None => measure(
            paths,
            REFERENCE,
            M,
            |fine| end(&reference, start, fine),
            |path| end(&integrator, start, path),
        ),
    };
    row(plan.system, R::NAME, noise, expected, measured);
}

#[test]
fn a_rotation_against_its_exact_path() {
    let start = State::from_configuration(&Kubo, [1.0, 0.5]).unwrap();
    let exact = |[w]: [f64; 1]| {
        let (s, c) = (1.0 + 0.5 * w).sin_cos();
        [c - 0.5 * s, s + 0.5 * c]
    };
    let noise = "γ = −H/2, exact path";
    stochastic((Kubo, InitialPoint), noise, start, 200, Some(&exact));
    stochastic((Kubo, Midpoint), noise, start, 200, Some(&exact));
    stochastic((Kubo, Endpoint), noise, start, 200, Some(&exact));
}

/// The spin of a stereographic point, turned about (0.6, 0, 0.8) by an angle, and its stereographic point.
fn turned([u, v]: [f64; 2], angle: f64) -> [f64; 2] {
    let square = u * u + v * v;
    let spin = [2.0 * u, 2.0 * v, 1.0 - square].map(|x| x / (1.0 + square));
    let axis = [0.6, 0.0, 0.8];
    let along: f64 = (0..3).map(|i| axis[i] * spin[i]).sum();
    let (s, c) = angle.sin_cos();
    let cross = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        axis[j] * spin[k] - axis[k] * spin[j]
    };
    let end: [f64; 3] =
        core::array::from_fn(|i| c * spin[i] + s * cross(i) + (1.0 - c) * along * axis[i]);
    [end[0] / (1.0 + end[2]), end[1] / (1.0 + end[2])]
}

const SPIN: [f64; 2] = [0.3125, 0.40625];

fn spin_exact([w]: [f64; 1]) -> [f64; 2] {
    turned(SPIN, -(1.0 + 0.5 * w))
}

#[test]
fn a_spin_against_its_exact_path() {
    let start = State::from_configuration(&Spin, SPIN).unwrap();
    let noise = "γ = −H/2, exact path";
    stochastic((Spin, Midpoint), noise, start, 200, Some(&spin_exact));
}

#[test]
fn two_vortices_against_their_exact_path() {
    let pair = VortexPair {
        strength: [1.0, 2.0],
        sigma: 0.3,
    };
    let start = State::from_configuration(&pair, [[1.0, 0.0], [-0.5, 0.0]]).unwrap();
    let exact = |[w]: [f64; 1]| {
        let (s, c) = (3.0 / 2.25 * (1.0 + 0.3 * w)).sin_cos();
        [c, s, -0.5 * c, -0.5 * s]
    };
    let noise = "γ = −σH, exact path";
    stochastic((pair, Midpoint), noise, start, 200, Some(&exact));
}

#[test]
fn lotka_volterra_with_one_noise() {
    let system = InternalLotkaVolterra;
    let start = State::from_configuration(&system, [1.5, 0.8]).unwrap();
    let noise = "one γ";
    stochastic((system, InitialPoint), noise, start, 30, None);
    stochastic((system, Midpoint), noise, start, 30, None);
    stochastic((system, Endpoint), noise, start, 30, None);
}

#[test]
fn noises_of_positions_that_do_not_commute() {
    let system = StormyLotkaVolterra;
    let start = State::from_configuration(&system, [1.5, 0.8]).unwrap();
    let noise = "γ = (ln x, y)/2";
    stochastic((system, InitialPoint), noise, start, 30, None);
    stochastic((system, Midpoint), noise, start, 30, None);
    stochastic((system, Endpoint), noise, start, 30, None);
    let mass = MassWithPair { mass: 1.5 };
    let start = State::from_configuration(&mass, [0.5, 0.3, -0.4]).unwrap();
    stochastic((mass, Midpoint), "γ = (xa, b)/10", start, 30, None);
}

#[test]
fn a_joint_without_mass() {
    let joint = Joint { k: 2.0 };
    let start = State::from_configuration(&joint, [0.8, 0.4]).unwrap();
    let noise = "γ = 0.3 sin x, H₁ = 0.2 p";
    stochastic((joint, InitialPoint), noise, start, 30, None);
    stochastic((joint, Midpoint), noise, start, 30, None);
    stochastic((joint, Endpoint), noise, start, 30, None);
}

/// The plain discrete equations lose their order, and projecting after each step converges to another equation.
#[test]
fn wrong_steps_have_no_order() {
    for what in [Plain::Free, Plain::Projected] {
        let end = |path: &Recorded| {
            let start = State::from_configuration(&Spin, SPIN).unwrap();
            let (mut q, mut p) = (start.q, start.p);
            for step in 0..path.len() {
                let dw = [path.get(step).unwrap()[0]];
                (q, p) = wrong::step(&Spin, what, (q, p), path.h(), &dw);
            }
            q
        };
        let exact = |fine: &Recorded| spin_exact(total(fine));
        let [order, error] = measure(4, LEVELS[4], 1, exact, end);
        println!("| Spin | midpoint, {what:?} | γ = −H/2 | none | {order:.3} ± {error:.3} |");
        assert!(order < 0.8, "{what:?}: {order} ± {error}");
    }
}

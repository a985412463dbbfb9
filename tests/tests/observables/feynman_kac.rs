//! Weights of paths: the formula of Feynman and Kac, its weak orders without sampling, and its
//! results from ensembles.
//!
//! The expectation over an increment is taken exactly. A linear step with a quadratic exponent maps
//! exp(−½zᵀAz − c) to a function of the same form; for the Kubo oscillator the mean of the step's
//! matrix is a quadrature; for other systems the quadrature follows all nodes of all steps.

use sve_runtime::Variational;
use sve_runtime::baseline::EulerMaruyama;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};

use super::systems::{Kubo, Langevin, Stiffness};

/// `u_t = p u_q − q u_p + ½σ²u_pp − ½κq²u` with u(0) = 1, σ = 0.8, κ = 1.3, at t = 2 and (q, p) =
/// (0.7, −0.4).
const QUADRATIC: f64 = 0.627_173_387_859;
const SIGMA: f64 = 0.8;
const KAPPA: f64 = 1.3;
const TIME: f64 = 2.0;
const POINT: [f64; 2] = [0.7, -0.4];

fn oscillator() -> Langevin {
    Langevin {
        nu: 0.0,
        sigma: SIGMA,
    }
}

/// E exp(−½κ∫q² dt) by a linear rule, exactly: backwards from the end, step by step.
fn quadratic<I>(method: &I, steps: u32, weights: [f64; 2]) -> f64
where
    I: Method<System = Langevin>,
{
    let h = TIME / f64::from(steps);
    let image = |q: f64, p: f64, dw: f64| {
        let mut state = State::new([q], [p]);
        method.step(&mut state, h, &[dw]).unwrap();
        [state.q[0], state.p[0]]
    };
    let columns = [image(1.0, 0.0, 0.0), image(0.0, 1.0, 0.0)];
    let b = image(0.0, 0.0, 1.0);
    // exp(−½zᵀAz − c), where the end of the last step counts first
    let mut a = [KAPPA * h * weights[1], 0.0, 0.0];
    let mut c = 0.0;
    for step in (0..steps).rev() {
        let form = |x: [f64; 2], y: [f64; 2]| {
            a[0] * x[0] * y[0] + a[1] * (x[0] * y[1] + x[1] * y[0]) + a[2] * x[1] * y[1]
        };
        let variance = 1.0 + h * form(b, b);
        let entry = |i: usize, j: usize| {
            let along = form(columns[i], b) * form(columns[j], b);
            form(columns[i], columns[j]) - h * along / variance
        };
        let next = [entry(0, 0), entry(0, 1), entry(1, 1)];
        c += 0.5 * variance.ln();
        let weight = if step == 0 {
            weights[0]
        } else {
            weights[0] + weights[1]
        };
        a = [next[0] + KAPPA * h * weight, next[1], next[2]];
    }
    let [q, p] = POINT;
    (-0.5 * (a[0] * q * q + 2.0 * a[1] * q * p + a[2] * p * p) - c).exp()
}

const TRAPEZOID: [f64; 2] = [0.5, 0.5];

fn order(name: &str, expected: f64, errors: [f64; 3]) {
    let order = (errors[0] / errors[2]).log2() / 2.0;
    println!("| {name} | {expected} | {order:.3} | {:.1e} |", errors[2]);
    // the next term of the error still counts
    let bias = 0.06 * expected.max(2.0);
    assert!(
        (order - expected).abs() < bias,
        "{name}: {order} {errors:?}"
    );
}

#[test]
fn weak_orders_of_the_quadratic_problem() {
    let errors = |found: &dyn Fn(u32) -> f64| [32, 64, 128].map(|n| (found(n) - QUADRATIC).abs());
    let system = oscillator();
    let initial = Integrator::new(system, InitialPoint);
    let endpoint = Integrator::new(system, Endpoint);
    let midpoint = Integrator::new(system, Midpoint);
    let verlet = Integrator::new(system, StormerVerlet);
    order(
        "initial point",
        1.0,
        errors(&|n| quadratic(&initial, n, TRAPEZOID)),
    );
    order(
        "endpoint",
        1.0,
        errors(&|n| quadratic(&endpoint, n, TRAPEZOID)),
    );
    let found = errors(&|n| quadratic(&midpoint, n, TRAPEZOID));
    order("midpoint", 2.0, found);
    assert!(found[2] < 4e-6, "{found:?}");
    let found = errors(&|n| quadratic(&verlet, n, TRAPEZOID));
    order("Verlet", 2.0, found);
    assert!(found[2] < 2e-5, "{found:?}");
    let euler = EulerMaruyama::new(system);
    order(
        "Euler–Maruyama",
        1.0,
        errors(&|n| quadratic(&euler, n, TRAPEZOID)),
    );
    // the left ends of the steps in place of the trapezoid
    order(
        "midpoint, left",
        1.0,
        errors(&|n| quadratic(&midpoint, n, [1.0, 0.0])),
    );
}

/// Nodes and weights for the mean over a normal variable.
fn normal_nodes() -> Vec<(f64, f64)> {
    // the trapezoidal rule for a normal density is exact to rounding with this spacing
    let spacing = 0.25;
    let density = |x: f64| (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    (-34..=34)
        .map(|k| spacing * f64::from(k))
        .map(|x| (x, spacing * density(x)))
        .collect()
}

/// `u_t = a Du + ½σ²D²u − κIu` with u(0) = q: u = exp(−κIt − σ²t/2) (q cos at + p sin at). Where a
/// rule keeps I, the weight is a number, and u the mean of q.
fn kubo<R>(integrator: &Integrator<Kubo, R>, steps: u32) -> f64
where
    Kubo: Variational<R> + System<Dims = Dims<1, 1>>,
{
    let h = 1.0 / f64::from(steps);
    let nodes = normal_nodes();
    let mean = |z: [f64; 2]| {
        let mut sum = [0.0; 2];
        for (x, weight) in &nodes {
            let mut state = State::new([z[0]], [z[1]]);
            integrator.step(&mut state, h, &[x * h.sqrt()]).unwrap();
            sum[0] += weight * state.q[0];
            sum[1] += weight * state.p[0];
        }
        sum
    };
    let mut z = [1.0, 0.5];
    for _ in 0..steps {
        z = mean(z);
    }
    (-0.6_f64 * 0.625).exp() * z[0]
}

#[test]
fn weak_orders_of_the_kubo_problem() {
    let system = Kubo { sigma: 0.5 };
    let (sin, cos) = 1.0_f64.sin_cos();
    let exact = (-0.6_f64 * 0.625 - 0.125).exp() * (cos + 0.5 * sin);
    let errors = |found: &dyn Fn(u32) -> f64| [4, 8, 16].map(|n| (found(n) - exact).abs());
    let midpoint = Integrator::new(system, Midpoint);
    order("Kubo, midpoint", 1.0, errors(&|n| kubo(&midpoint, 4 * n)));
    let gauss = Integrator::new(system, Gauss::<2>);
    order("Kubo, Gauss 2", 2.0, errors(&|n| kubo(&gauss, 8 * n)));
    let gauss = Integrator::new(system, Gauss::<3>);
    order("Kubo, Gauss 3", 3.0, errors(&|n| kubo(&gauss, 4 * n)));
    let initial = Integrator::new(system, InitialPoint);
    order(
        "Kubo, initial point",
        1.0,
        errors(&|n| kubo(&initial, 8 * n)),
    );
    let endpoint = Integrator::new(system, Endpoint);
    order("Kubo, endpoint", 1.0, errors(&|n| kubo(&endpoint, 8 * n)));
}

/// E exp(−∫q² dt) at T = ½ by following five nodes of each step.
fn followed<R>(integrator: &Integrator<Stiffness, R>, steps: u32) -> f64
where
    Stiffness: Variational<R> + System<Dims = Dims<1, 1>>,
{
    // Gauss–Hermite of 5 nodes
    let (a, b) = (10.0_f64.sqrt() - 5.0, -10.0_f64.sqrt() - 5.0);
    let (x1, x2) = ((-a).sqrt(), (-b).sqrt());
    let w = |x: f64| 24.0 * 5.0 / (25.0 * hermite4(x).powi(2));
    let nodes = [
        (-x2, w(x2)),
        (-x1, w(x1)),
        (0.0, w(0.0)),
        (x1, w(x1)),
        (x2, w(x2)),
    ];
    let total: f64 = nodes.iter().map(|(_, w)| w).sum();
    assert!((total - 1.0).abs() < 1e-14, "{total}");
    let h = 0.5 / f64::from(steps);
    descend(integrator, State::new([1.2], [0.4]), (steps, h), &nodes)
}

fn hermite4(x: f64) -> f64 {
    x.powi(4) - 6.0 * x * x + 3.0
}

fn descend<R>(
    integrator: &Integrator<Stiffness, R>,
    state: State<[f64; 1]>,
    (left, h): (u32, f64),
    nodes: &[(f64, f64); 5],
) -> f64
where
    Stiffness: Variational<R> + System<Dims = Dims<1, 1>>,
{
    if left == 0 {
        return 1.0;
    }
    let mut sum = 0.0;
    for (x, weight) in nodes {
        let mut next = state;
        integrator.step(&mut next, h, &[x * h.sqrt()]).unwrap();
        let both = state.q[0].powi(2) + next.q[0].powi(2);
        sum += weight * (-0.5 * h * both).exp() * descend(integrator, next, (left - 1, h), nodes);
    }
    sum
}

/// Noise whose strength depends on q: the option `weak2` makes the weak order 2 with the weight
/// too.
#[test]
fn weak_order_two_with_the_option() {
    let system = Stiffness { sigma: 1.5 };
    let values = [
        (
            "Verlet",
            [1, 2, 4, 8].map(|n| followed(&Integrator::new(system, Weak2(StormerVerlet)), n)),
        ),
        (
            "midpoint",
            [1, 2, 4, 8].map(|n| followed(&Integrator::new(system, Weak2(Midpoint)), n)),
        ),
    ];
    let mut limits = [0.0; 2];
    for ((name, values), limit) in values.iter().zip(&mut limits) {
        // the exact value is not known: differences between steps and steps of half the size
        let differences = [0, 1, 2].map(|k| values[k] - values[k + 1]);
        let order = (differences[1] / differences[2]).log2();
        println!("| {name} with `weak2` | 2 | {order:.2} |");
        assert!(
            (order - 2.0).abs() < 0.15,
            "{name}: {order} {differences:?}"
        );
        *limit = values[3] - differences[2] / 3.0;
    }
    assert!((limits[0] - limits[1]).abs() < 1e-4, "{limits:?}");
}

fn ensemble<I: Method<System = Langevin>>(method: &I, paths: u64) -> Ensemble<'_, I> {
    Ensemble::new(method)
        .paths(paths)
        .seed(3)
        .steps(0.125, 16)
        .every(8)
        .start(State::new([POINT[0]], [POINT[1]]))
        .weight(|_, state| 0.5 * KAPPA * state.q[0].powi(2))
        .terminal("u", |_, _| 1.0)
        .terminal("qu", |_, state| state.q[0])
        .observe("q", |_, state| state.q[0])
}

/// The weight of a path is the exponential of the trapezoidal sum along it.
#[test]
fn weights_are_exponentials_of_trapezoidal_sums() {
    let motion = Integrator::new(oscillator(), Midpoint);
    let ensemble = ensemble(&motion, 100);
    let summary = ensemble.run().unwrap();
    let mut means = [[0.0; 3]; 3];
    for path in 0..100 {
        let states: Vec<_> = std::iter::once(State::new([POINT[0]], [POINT[1]]))
            .chain(ensemble.replay(path).unwrap().map(Result::unwrap))
            .collect();
        for (record, means) in means.iter_mut().enumerate() {
            let exponent: f64 = states[..=8 * record]
                .windows(2)
                .map(|pair| 0.0625 * 0.5 * KAPPA * (pair[0].q[0].powi(2) + pair[1].q[0].powi(2)))
                .sum();
            let (weight, q) = ((-exponent).exp(), states[8 * record].q[0]);
            for (mean, value) in means.iter_mut().zip([weight, weight * q, q]) {
                *mean += value / 100.0;
            }
        }
    }
    for (k, name) in ["u", "qu", "q"].into_iter().enumerate() {
        for (record, mean) in summary[name].mean().iter().enumerate() {
            assert!((mean - means[record][k]).abs() < 1e-14, "{name} {record}");
        }
    }
}

/// A baseline, whose steps are not made in lanes, has the same weights.
#[test]
fn baselines_have_weights() {
    let euler = EulerMaruyama::new(oscillator());
    let summary = ensemble(&euler, 20_000).run().unwrap();
    let (u, error) = (summary["u"].mean()[2], summary["u"].standard_error()[2]);
    let exact = quadratic(&euler, 16, TRAPEZOID);
    assert!((u - exact).abs() < 4.0 * error, "{u} {exact} {error}");
    assert!((exact - QUADRATIC).abs() > 8.0 * error);
}

#[test]
fn weights_keep_their_bits() {
    let motion = Integrator::new(oscillator(), Midpoint);
    let whole = ensemble(&motion, 300).threads(1).run().unwrap();
    assert_eq!(whole, ensemble(&motion, 300).threads(2).run().unwrap());
    let shard = |k| ensemble(&motion, 300).shard(k, 2).run().unwrap();
    let mut merged = shard(1);
    merged.merge(shard(0)).unwrap();
    assert_eq!(merged, whole);
    // another potential is another run
    let other = ensemble(&motion, 300).weight(|_, state| state.q[0].powi(2));
    assert!(shard(0).merge(other.shard(1, 2).run().unwrap()).is_err());
}

/// The sampling errors at near points are nearly the same with the same paths, and differ with
/// paths of their own.
#[test]
fn several_points() {
    let motion = Integrator::new(oscillator(), Midpoint);
    let points = [[0.7, -0.4], [0.7001, -0.4]].map(|[q, p]| State::new([q], [p]));
    let run = |k: usize, first_path: u64| {
        let ensemble = ensemble(&motion, 200).noise(Wiener::new(3).path(first_path));
        let summary = ensemble.start(points[k]).run().unwrap();
        (summary["u"].mean()[2], summary["u"].standard_error()[2])
    };
    let (first, error) = run(0, 0);
    assert!((first - run(1, 0).0).abs() < 1e-3 * error.sqrt());
    assert!((first - run(1, 200).0).abs() > 0.1 * error);
    // a seed alone is the noise that begins at path 0
    let seeded = ensemble(&motion, 200).start(points[0]).run().unwrap();
    assert_eq!(seeded["u"].mean()[2], first);
}

/// The closed form, with a tolerance of the sampling error and the known bias of the rule.
#[test]
fn the_closed_form() {
    let motion = Integrator::new(oscillator(), Midpoint);
    let summary = ensemble(&motion, 40_000).run().unwrap();
    let (u, error) = (summary["u"].mean()[2], summary["u"].standard_error()[2]);
    let bias = quadratic(&motion, 16, TRAPEZOID) - QUADRATIC;
    assert!((u - QUADRATIC - bias).abs() < 4.0 * error, "{u} {error}");
    assert!(
        (error * 200.0 / 0.043_548_f64.sqrt() - 1.0).abs() < 0.03,
        "{error}"
    );
}

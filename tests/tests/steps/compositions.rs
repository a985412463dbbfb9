//! Compositions of rules: orders, symmetry, symplecticity, momenta, lanes, and what happens when a substep fails.

use sve_models::steps::{check_sensitivity, check_tangent};
use sve_runtime::prelude::*;
use sve_runtime::{Dims, LANES, OneStepMethod, StateLanes, System, Variational};

/// A pendulum on a spring: separable, with a quadratic kinetic energy.
#[derive(Clone, Debug)]
struct Henon {
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Henon {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
            - 0.5 * (q[0] * q[0] + q[1] * q[1])
            - (q[0] * q[0] * q[1] - q[1].powi(3) / 3.0)
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0] * q[1]
    }
}

/// A relativistic particle in a driven well: T is not quadratic, and V depends on time.
struct Driven;

#[variational(initial_point, endpoint)]
impl Driven {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        -(1.0 - v * v).sqrt() - 0.5 * q * q * (1.0 + 0.3 * t.sin())
    }
}

/// A mass that depends on its place, with friction.
struct Curved {
    nu: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Curved {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (1.0 + 0.25 * q * q) * v * v - 0.5 * q * q
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
}

/// Two bodies whose total momentum is conserved.
struct Pair;

#[variational(initial_point, endpoint, midpoint)]
impl Pair {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] + v[1] * v[1] - (q[1] - q[0]).cosh()
    }

    #[gamma]
    fn pull(&self, q: [f64; 2]) -> f64 {
        (q[1] - q[0]).sin()
    }

    #[symmetry]
    fn shift(&self, _q: [f64; 2]) -> [f64; 2] {
        [1.0, 1.0]
    }
}

/// The state after `steps` steps to time 1.
fn at_one<S, R, const N: usize, const M: usize>(
    method: &Integrator<S, R>,
    start: &State<[f64; N]>,
    steps: u32,
) -> Vec<f64>
where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let mut state = *start;
    let h = 1.0 / f64::from(steps);
    for _ in 0..steps {
        method.step(&mut state, h, &[0.0; M]).unwrap();
    }
    state.q.into_iter().chain(state.p).collect()
}

/// Checks the order by the errors of the given numbers of steps, against four times as many of the last.
fn has_order<S, R, const N: usize, const M: usize>(
    method: &Integrator<S, R>,
    start: &State<[f64; N]>,
    [coarse, fine]: [u32; 2],
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let exact = at_one(method, start, 4 * fine);
    let error = |steps| {
        let end = at_one(method, start, steps);
        let errors = end.iter().zip(&exact).map(|(x, y)| (x - y).abs());
        errors.fold(0.0, f64::max)
    };
    let (first, last) = (error(coarse), error(fine));
    let slope = (first / last).ln() / (f64::from(fine) / f64::from(coarse)).ln();
    let expected = f64::from(method.plan().deterministic_order);
    // At step sizes whose errors are above rounding, the next term of the error changes the slope by a few per cent.
    assert!(
        (slope - expected).abs() < 0.06 * expected,
        "{}: order {slope} for {expected}, errors {first:e} and {last:e}",
        method.plan().structure()
    );
}

const START: State<[f64; 2]> = State {
    t: 0.0,
    q: [0.12, 0.52],
    p: [0.37, -0.1],
};

#[test]
fn compositions_have_their_orders() {
    let still = Henon { sigma: 0.0 };
    has_order(
        &Integrator::new(&still, Composed::new(StormerVerlet, KahanLi8)),
        &START,
        [2, 4],
    );
    has_order(
        &Integrator::new(&still, Composed::new(Midpoint, KahanLi8)),
        &START,
        [2, 4],
    );
    has_order(
        &Integrator::new(&still, Split::new(BlanesMoan4)),
        &START,
        [8, 16],
    );
    has_order(
        &Integrator::new(&still, Split::new(BlanesMoanRkn6)),
        &START,
        [4, 8],
    );
    let start = State::new([0.8], [0.6]);
    has_order(
        &Integrator::new(Driven, Split::new(BlanesMoan4)),
        &start,
        [4, 8],
    );
    // configuration-dependent masses and friction
    let curved = Curved { nu: 0.3 };
    has_order(
        &Integrator::new(&curved, Composed::new(Midpoint, KahanLi8)),
        &start,
        [2, 4],
    );
}

/// A free particle with friction.
struct Damped {
    nu: f64,
}

#[variational(midpoint)]
impl Damped {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
}

#[test]
fn steps_of_a_composition_have_to_resolve_friction() {
    let error = |nu: f64| {
        let method = Integrator::new(Damped { nu }, Composed::new(Midpoint, KahanLi8));
        let mut state = State::new([0.0], [1.0]);
        method.step(&mut state, 1.0, &[]).unwrap();
        (state.p[0] * nu.exp() - 1.0).abs()
    };
    assert!(error(0.5) < 1e-9, "{}", error(0.5));
    assert!(error(1.0) < 5e-7, "{}", error(1.0));
    assert!((0.05..0.2).contains(&error(3.0)), "{}", error(3.0));
}

/// A step and its reverse, with noise.
fn returns<R>(rule: R)
where
    Henon: Variational<R>,
{
    let method = Integrator::new(Henon { sigma: 0.4 }, rule);
    let mut state = START;
    method.step(&mut state, 0.2, &[0.3]).unwrap();
    assert_eq!(state.t, 0.2);
    assert!((state.q[0] - START.q[0]).abs() > 0.01);
    method.step(&mut state, -0.2, &[-0.3]).unwrap();
    for (x, y) in state
        .q
        .iter()
        .chain(&state.p)
        .zip(START.q.iter().chain(&START.p))
    {
        // 22 substeps back and forth, each with some roundings of numbers below 1
        assert!((x - y).abs() < 40.0 * f64::EPSILON, "{x} {y}");
    }
}

#[test]
fn a_step_back_returns_to_the_start() {
    returns(Composed::new(StormerVerlet, KahanLi8));
    returns(Composed::new(Midpoint, KahanLi8));
    returns(Split::new(BlanesMoan4));
    returns(Split::new(BlanesMoanRkn6));
}

/// The tangent map is symplectic, and the derivative of the step; sensitivities are its derivatives in the parameter.
fn is_differentiated<R: Copy>(rule: R)
where
    Henon: Variational<R>,
{
    let (h, dw) = (0.3, [0.5]);
    let system = |_: &str, by: f64| Henon { sigma: 0.4 + by };
    let method = Integrator::new(system("", 0.0), rule);
    check_tangent(&method, &START, h, &dw, Some(1e-14));
    check_sensitivity(system, rule, &["sigma"], &START, (h, &dw));
}

#[test]
fn compositions_are_symplectic_with_noise_and_differentiated_by_the_chain_rule() {
    is_differentiated(Composed::new(StormerVerlet, KahanLi8));
    is_differentiated(Composed::new(Midpoint, KahanLi8));
    is_differentiated(Split::new(BlanesMoan4));
    is_differentiated(Split::new(BlanesMoanRkn6));
}

fn conserves<R>(rule: R)
where
    Pair: Variational<R>,
{
    let method = Integrator::new(Pair, rule);
    let mut state = State::new([0.2, -0.7], [0.3, 1.0]);
    for step in 0..100 {
        method
            .step(&mut state, 0.1, &[0.2 * f64::from(step % 7 - 3)])
            .unwrap();
    }
    assert!((Pair.shift_momentum(&state) - 1.3).abs() < 1e-13);
    assert_eq!(method.plan().conserved, ["shift_momentum"]);
}

#[test]
fn compositions_conserve_what_their_rules_conserve() {
    conserves(Composed::new(Midpoint, KahanLi8));
    conserves(Split::new(BlanesMoan4));
}

/// Lanes that are solved have the state of the single step, at the times of the lanes.
fn agrees_with_lanes<S, R>(method: &Integrator<S, R>, dw: f64)
where
    S: Variational<R> + System<Dims = Dims<2, 1>>,
{
    let h = 0.1;
    let mut lanes = StateLanes::splat(&START);
    for lane in 0..LANES {
        lanes.q[0][lane] += 0.01 * lane as f64;
    }
    let prepared = method.prepare(h).unwrap();
    let mut next = lanes;
    let unsolved = method.step_lanes(&prepared, &lanes, &mut next, h, &[[dw; LANES]]);
    assert_eq!(unsolved, 0);
    for lane in 0..LANES {
        let mut state = lanes.get(lane);
        method.step(&mut state, h, &[dw]).unwrap();
        let found = next.get(lane);
        for (x, y) in found
            .q
            .iter()
            .chain(&found.p)
            .zip(state.q.iter().chain(&state.p))
        {
            assert!((x - y).abs() < 40.0 * f64::EPSILON, "{x} {y}");
        }
    }
}

#[test]
fn compositions_step_in_lanes() {
    let system = Henon { sigma: 0.4 };
    agrees_with_lanes(
        &Integrator::new(&system, Composed::new(StormerVerlet, KahanLi8)),
        0.2,
    );
    agrees_with_lanes(
        &Integrator::new(&system, Composed::new(Midpoint, KahanLi8)),
        0.2,
    );
    agrees_with_lanes(&Integrator::new(&system, Split::new(BlanesMoanRkn6)), 0.2);
}

#[test]
fn a_failing_substep_leaves_the_state_unchanged() {
    // an unbounded potential: the momentum overflows within the step
    let method = Integrator::new(Henon { sigma: 0.0 }, Composed::new(StormerVerlet, KahanLi8));
    let start = State::new([1e100, -1e100], [0.0, 0.0]);
    let mut state = start;
    let error = method.step(&mut state, 1e30, &[0.0]).unwrap_err();
    assert!(
        matches!(error, StepError::NonFiniteResult { .. }),
        "{error}"
    );
    assert_eq!(state, start);
    let mut path = method.trajectory(start, 1e30, NoNoise);
    assert!(path.next().unwrap().is_err());
    assert_eq!(*path.state(), start);
}

#[test]
fn plans_count_the_substeps() {
    let system = Henon { sigma: 0.0 };
    let base = Integrator::new(&system, StormerVerlet).plan();
    let plan = Integrator::new(&system, Composed::new(StormerVerlet, KahanLi8)).plan();
    assert_eq!(
        plan.operations(0).arithmetic,
        17 * base.operations(0).arithmetic
    );
    assert_eq!(plan.rule, "stormer_verlet");
    let text = plan.to_string();
    assert!(
        text.contains("17 substeps of the composition Kahan–Li 8"),
        "{text}"
    );
    assert!(text.contains("deterministic order 8"), "{text}");
    let split = Integrator::new(&system, Split::new(BlanesMoanRkn6)).plan();
    assert_eq!(split.substeps.unwrap().count, 22);
    assert_eq!(split.rule, "initial_point, endpoint");
}

#[test]
fn compensated_sums_work_through_substeps() {
    let still = Henon { sigma: 0.0 };
    let method = Integrator::new(&still, Composed::new(StormerVerlet, KahanLi8));
    let energy = |state: &State<[f64; 2]>| still.hamiltonian(state).unwrap();
    let change = |end: State<[f64; 2]>| (energy(&end) - energy(&START)).abs();
    let (h, steps) = (0.05, 20_000);
    let plain = method.trajectory(START, h, NoNoise).take(steps).last();
    let path = method.trajectory(START, h, NoNoise).compensated();
    let compensated = path.take(steps).last();
    let (plain, compensated) = (
        change(plain.unwrap().unwrap()),
        change(compensated.unwrap().unwrap()),
    );
    assert!(compensated < 0.3 * plain, "{compensated:e} and {plain:e}");
}

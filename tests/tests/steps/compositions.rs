//! Compositions of rules: a step is a walk over substeps, which may be compositions themselves.
//! Orders, all modes of a step, momenta, and what happens when a substep fails.

use sve_models::assert_matches;
use sve_models::checks::{assert_relative, assert_says, assert_states_close, failure};

use sve_models::models::{Bath, HenonHeiles};
use sve_models::orders::numbers;
use sve_models::stepper::Stepper;
use sve_models::steps::{check_return, check_sensitivity, check_tangent};
use sve_runtime::__private::{Composition, LANES, StateLanes, Symmetric};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{OneStepMethod, Rule, Variational};

/// A pendulum whose pivot swings, so that the times of substeps matter, with a bead on a spring.
#[derive(Clone, Copy, Debug)]
struct Driven {
    g: f64,
    sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Driven {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let swing = self.g * (1.0 + 0.3 * (2.0 * t).sin());
        0.5 * (v[0] * v[0] + v[1] * v[1]) + swing * q[0].cos() - 0.25 * (q[1] - q[0]).powi(4)
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0].sin() * q[1]
    }
}

/// A relativistic particle in a driven well: T is not quadratic, and V depends on time.
struct Well;

#[variational(initial_point, endpoint)]
impl Well {
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

/// Checks the order by the errors of the given numbers of steps, against four times as many of the
/// last.
fn has_order<S, R, const N: usize, const M: usize>(
    method: &Integrator<S, R>,
    start: &State<[f64; N]>,
    [coarse, fine]: [u32; 2],
) where
    S: Variational<R> + System<Dims = Dims<N, M>>,
{
    let at_one = |steps: u32| method.after(*start, 1.0 / f64::from(steps), &[0.0; M], steps);
    let exact = numbers(&at_one(4 * fine));
    let error = |steps| {
        let end = numbers(&at_one(steps));
        let errors = end.iter().zip(&exact).map(|(x, y)| (x - y).abs());
        errors.fold(0.0, f64::max)
    };
    let (first, last) = (error(coarse), error(fine));
    let slope = (first / last).ln() / (f64::from(fine) / f64::from(coarse)).ln();
    let expected = f64::from(method.plan().deterministic_order);
    // At step sizes whose errors are above rounding, the next term of the error changes the slope
    // by a few per cent.
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
    macro_rules! orders {
        ($($system:expr, $rule:expr, $start:expr, $steps:expr;)*) => {$(
            has_order(&Integrator::new($system, $rule), &$start, $steps);
        )*};
    }
    let start = State::new([0.8], [0.6]);
    orders! {
        HenonHeiles, Composed::new(StormerVerlet, KahanLi8), START, [2, 4];
        HenonHeiles, Composed::new(Midpoint, KahanLi8), START, [2, 4];
        HenonHeiles, Split::new(BlanesMoan4), START, [8, 16];
        HenonHeiles, Split::new(BlanesMoanRkn6), START, [4, 8];
        Well, Split::new(BlanesMoan4), start, [4, 8];
        // configuration-dependent masses and friction
        Curved { nu: 0.3 }, Composed::new(Midpoint, KahanLi8), start, [2, 4];
    }
}

#[test]
fn steps_of_a_composition_have_to_resolve_friction() {
    let error = |nu: f64| {
        let damped = Bath {
            omega: 0.0,
            nu,
            sigma: 0.0,
        };
        let method = Integrator::new(damped, Composed::new(Midpoint, KahanLi8));
        let end = method.after(State::new([0.0], [1.0]), 1.0, &[0.0], 1);
        (end.p[0] * nu.exp() - 1.0).abs()
    };
    assert!(error(0.5) < 1e-9, "{}", error(0.5));
    assert!(error(1.0) < 5e-7, "{}", error(1.0));
    assert!((0.05..0.2).contains(&error(3.0)), "{}", error(3.0));
}

const H: f64 = 0.2;
const DW: [f64; 1] = [0.3];

fn driven() -> Driven {
    Driven { g: 1.7, sigma: 0.4 }
}

fn start() -> State<[f64; 2]> {
    State::at(0.4, [0.8, 0.5], [-0.3, 0.2])
}

/// Steps with noise by a rule: there and back, their derivatives forwards and backwards, and in
/// lanes. `bound` is the rounding of the substeps, `defect` that of the symplectic form.
fn has_all_modes<R: Copy>(rule: R, bound: f64, defect: f64)
where
    Driven: Variational<R>,
{
    let method = Integrator::new(driven(), rule);
    let end = method.after(start(), H, &DW, 1);
    assert_eq!(end.t, 0.4 + H);
    assert!((end.q[0] - start().q[0]).abs() > 0.01);
    check_return(&method, &start(), H, [&DW, &[-0.3]], bound);

    check_tangent(&method, &start(), H, &DW, Some(defect));
    let with = |name: &str, by: f64| match name {
        "g" => Driven {
            g: 1.7 + by,
            sigma: 0.4,
        },
        _ => Driven {
            g: 1.7,
            sigma: 0.4 + by,
        },
    };
    check_sensitivity(with, rule, &["g", "sigma"], &start(), (H, &DW));
    goes_back(&method);
    steps_in_lanes(&method, bound);
}

/// The walk back through the substeps gives the row of the tangent map and the sensitivities that
/// the walk forward gives.
fn goes_back<R>(method: &Integrator<Driven, R>)
where
    Driven: Variational<R>,
{
    let path = Recorded::new(H, [DW]).unwrap();
    let derivatives = method.step_with_derivatives(&mut start(), H, &DW);
    let (tangent, sensitivity) = derivatives.unwrap();
    let gradient = method
        .trajectory(start(), H, &path)
        .gradient(1, |step, state| (step == 1).then(|| state.q[0]))
        .unwrap();
    let [g, sigma] = ["g", "sigma"];
    let forward = [g, sigma].map(|name| sensitivity.get(name).unwrap().q[0]);
    let backward = [g, sigma].map(|name| gradient.get(name).unwrap());
    assert_relative(&forward, &backward, 1e-12, "by parameters");
    let backward = [gradient.start().q, gradient.start().p].concat();
    assert_relative(&tangent[0], &backward, 1e-12, "by the start");
}

/// Lanes that are solved have the state of the single step.
fn steps_in_lanes<R>(method: &Integrator<Driven, R>, bound: f64)
where
    Driven: Variational<R>,
{
    let mut lanes = StateLanes::splat(&start());
    for lane in 0..LANES {
        lanes.q[0][lane] += 0.01 * lane as f64;
    }
    let (prepared, mut next) = (method.prepare(H).unwrap(), lanes);
    let unsolved = method.step_lanes(&prepared, &lanes, &mut next, H, &[[DW[0]; LANES]]);
    assert_eq!(unsolved, 0);
    for lane in 0..LANES {
        let expected = method.after(lanes.get(lane), H, &DW, 1);
        assert_states_close(&next.get(lane), &expected, bound, method.name());
    }
}

/// A composition of a composition, which has 289 substeps.
type Nested<R> = Composed<Composed<R, KahanLi8>, KahanLi8>;

fn nested<R: Symmetric>(rule: R) -> Nested<R>
where
    Composed<R, KahanLi8>: Symmetric,
{
    Composed::new(Composed::new(rule, KahanLi8), KahanLi8)
}

#[test]
fn compositions_have_all_modes_of_a_step() {
    // some 20 substeps, each with some roundings of numbers below 1
    let bound = 40.0 * f64::EPSILON;
    has_all_modes(Composed::new(StormerVerlet, KahanLi8), bound, 1e-14);
    has_all_modes(Composed::new(Midpoint, KahanLi8), bound, 1e-14);
    has_all_modes(Split::new(BlanesMoan4), bound, 1e-14);
    has_all_modes(Split::new(BlanesMoanRkn6), bound, 1e-14);
    has_all_modes(nested(StormerVerlet), 1e-13, 1e-12);
}

/// The outer step is 17 steps by the inner composition, bit for bit.
fn is_made_of_its_parts<R: Copy + Symmetric>(rule: R)
where
    Composed<R, KahanLi8>: Symmetric,
    Driven: Variational<Composed<R, KahanLi8>> + Variational<Nested<R>>,
{
    let whole = Integrator::new(driven(), nested(rule));
    let part = Integrator::new(driven(), Composed::new(rule, KahanLi8));
    let state = whole.after(start(), H, &DW, 1);
    let mut expected = start();
    for &fraction in KahanLi8::FRACTIONS {
        let dw = [fraction * DW[0]];
        part.step(&mut expected, fraction * H, &dw).unwrap();
    }
    assert_eq!((state.q, state.p), (expected.q, expected.p));
}

#[test]
fn a_composition_of_a_composition_is_made_of_its_parts() {
    is_made_of_its_parts(StormerVerlet);
    is_made_of_its_parts(Midpoint);
}

fn conserves<R>(rule: R)
where
    Pair: Variational<R>,
{
    let method = Integrator::new(Pair, rule);
    let mut state = State::new([0.2, -0.7], [0.3, 1.0]);
    for step in 0..100 {
        let dw = [0.2 * f64::from(step % 7 - 3)];
        method.step(&mut state, 0.1, &dw).unwrap();
    }
    assert!((Pair.shift_momentum(&state) - 1.3).abs() < 1e-13);
    assert_eq!(method.plan().conserved, ["shift_momentum"]);
}

#[test]
fn compositions_conserve_what_their_rules_conserve() {
    conserves(Composed::new(Midpoint, KahanLi8));
    conserves(Split::new(BlanesMoan4));
}

#[test]
fn a_failing_substep_leaves_the_state_unchanged() {
    // an unbounded potential: the momentum overflows within the step
    let method = Integrator::new(HenonHeiles, Composed::new(StormerVerlet, KahanLi8));
    let start = State::new([1e100, -1e100], [0.0, 0.0]);
    let error = failure(&method, &start, 1e30, &[]);
    assert_matches!(error, StepError::NonFiniteResult { .. });
    let mut path = method.trajectory(start, 1e30, NoNoise);
    assert!(path.next().unwrap().is_err());
    assert_eq!(*path.state(), start);
}

#[test]
fn plans_count_the_substeps() {
    let base = Integrator::new(HenonHeiles, StormerVerlet).plan();
    let plan = Integrator::new(HenonHeiles, Composed::new(StormerVerlet, KahanLi8)).plan();
    let [whole, part] = [plan, base].map(|plan| plan.operations(0).arithmetic);
    assert_eq!(whole, 17 * part);
    assert_eq!(plan.rule, "stormer_verlet");
    let substeps = "17 substeps of the composition Kahan–Li 8";
    assert_says(plan, &[substeps, "deterministic order 8"]);
    let split = Integrator::new(HenonHeiles, Split::new(BlanesMoanRkn6)).plan();
    assert_eq!(split.substeps.unwrap().count, 22);
    assert_eq!(split.rule, "initial_point, endpoint");
}

#[test]
fn compensated_sums_work_through_substeps() {
    let method = Integrator::new(HenonHeiles, Composed::new(StormerVerlet, KahanLi8));
    let energy = |state: &State<[f64; 2]>| HenonHeiles.hamiltonian(state).unwrap();
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

/// One bound is enough for code over the rules of a system, and a bound of the system holds for
/// references to it.
#[test]
fn one_bound_is_enough() {
    fn by_rule<R: Rule<Driven, Increments = [f64; 1]>>(system: Driven, rule: R) -> f64 {
        let mut state = start();
        let method = Integrator::new(system, rule);
        method.step(&mut state, H, &DW).unwrap();
        state.q[0]
    }
    fn by_system<S, R, const N: usize, const M: usize>(
        method: &Integrator<S, R>,
        start: &State<[f64; N]>,
    ) -> State<[f64; N]>
    where
        S: Variational<R, Prepared: Sync, Memory: Sync> + System<Dims = Dims<N, M>> + Sync,
        R: Sync,
    {
        let mut state = *start;
        method.step(&mut state, H, &[DW[0]; M]).unwrap();
        let ensemble = Ensemble::new(method).paths(2).seed(1).steps(H, 1);
        assert!(ensemble.start(*start).run().unwrap().failures().is_empty());
        state
    }
    /// The same by the system, by a reference to it, and by a reference to that.
    fn by_references<S, R, const N: usize, const M: usize>(system: S, rule: R)
    where
        S: Variational<R, Prepared: Sync, Memory: Sync> + System<Dims = Dims<N, M>> + Sync,
        R: Copy + Sync,
    {
        let start = State::new([0.1; N], [0.2; N]);
        let once = by_system(&Integrator::new(&system, rule), &start);
        let twice = by_system(&Integrator::new(&&system, rule), &start);
        let owned = by_system(&Integrator::new(system, rule), &start);
        assert_ne!(owned, start);
        assert_eq!([once, twice], [owned, owned]);
    }
    let composed = Composed::new(StormerVerlet, KahanLi8);
    assert!(by_rule(driven(), StormerVerlet) != by_rule(driven(), composed));
    by_references(driven(), Midpoint);
    by_references(driven(), composed);
    by_references(driven(), Split::new(BlanesMoan4));
}

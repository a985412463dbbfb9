//! Steps of constrained systems in lanes against steps of single states. The last digits may differ: pivots have another order, and quotients share a division.

use sve_models::models::{OnSphere, Thermal, TurnedSphere};
use sve_models::random::Random;
use sve_runtime::ensemble::{Cause, Failure};
use sve_runtime::prelude::*;
use sve_runtime::{
    ConstraintImpulses, Dimensions, Dims, LANES, Lane, Mask, OneStepMethod, StateLanesOf, StateOf,
    System, Variational, VectorCoordinates,
};

use super::errors::FourBars;
use super::systems::{Check, all};

/// States and increments of all lanes.
struct Block<Q: VectorCoordinates<N>, const N: usize, const M: usize> {
    states: Vec<State<Q>>,
    dw: [Lane; M],
}

impl<Q: VectorCoordinates<N>, const N: usize, const M: usize> Block<Q, N, M> {
    /// Consistent states around a start, and increments up to `noise`.
    fn random<S, R>(
        integrator: &Integrator<S, R>,
        around: State<Q>,
        noise: f64,
        random: &mut Random,
    ) -> Self
    where
        S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    {
        let mut states = Vec::new();
        while states.len() < LANES {
            let (q, p) = (around.q.coordinates(), Q::components(&around.p));
            let moved: [f64; N] = core::array::from_fn(|i| q[i] + random.uniform(-0.3, 0.3));
            let pushed: [f64; N] = core::array::from_fn(|i| p[i] + random.uniform(-1.0, 1.0));
            let (q, p) = (Q::from_coordinates(&moved), Q::from_components(&pushed));
            states.extend(integrator.consistent(State::at(around.t, q, p)));
        }
        let lane = |_| core::array::from_fn(|_| random.uniform(-noise, noise));
        let dw = core::array::from_fn(lane);
        Self { states, dw }
    }

    fn step<S, R>(&self, integrator: &Integrator<S, R>, h: f64) -> (Vec<State<Q>>, Mask)
    where
        S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    {
        let mut states = <Dims<N, M, Q> as Dimensions>::splat(&self.states[0]);
        for (lane, state) in self.states.iter().enumerate() {
            <Dims<N, M, Q> as Dimensions>::set(&mut states, lane, state);
        }
        let mut next: StateLanesOf<S> = states;
        let prepared = OneStepMethod::prepare(integrator, h).unwrap();
        let left =
            OneStepMethod::step_lanes(integrator, &prepared, &states, &mut next, h, &self.dw);
        let states = (0..LANES).map(|lane| <Dims<N, M, Q> as Dimensions>::get(&next, lane));
        (states.collect(), left)
    }

    fn increments(&self, lane: usize) -> [f64; M] {
        self.dw.map(|row| row[lane])
    }
}

/// Allowed difference in units of rounding of the largest number, which is at least 1. Both iterations end within a few units of the root, in the velocity; the
/// solves that follow multiply this by the condition of the constraints.
const UNITS: f64 = 16.0;

fn entries<Q: VectorCoordinates<N>, const N: usize>(state: &State<Q>) -> Vec<f64> {
    [state.q.coordinates(), Q::components(&state.p)].concat()
}

/// Steps of more than 3000 instructions: the correction of a noise that is curved in the momentum, along the constraint.
const ONE_BY_ONE: [&str; 2] = ["curved initial_point", "curved endpoint"];

/// Compares lanes with single states at several step sizes.
struct Compared {
    random: Random,
    /// Largest difference, and lanes that were solved and not.
    worst: f64,
    solved: u32,
    left: u32,
}

impl Check for Compared {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let in_lanes = integrator.plan().in_lanes;
        assert_eq!(in_lanes, !ONE_BY_ONE.contains(&name), "{name}");
        let (mut solved, mut count) = (0, 0);
        // of the last steps, many have no root
        for (h, deviations) in [(1e-3, 1.0), (0.03, 1.0), (0.1_f64, 1.0), (0.4, 3.0)] {
            for _ in 0..6 {
                let noise = deviations * h.sqrt();
                let block = Block::random(integrator, start, noise, &mut self.random);
                let (states, left) = block.step(integrator, h);
                if deviations == 1.0 {
                    solved += left.count_zeros();
                    count += LANES as u32;
                }
                for lane in 0..LANES {
                    let before = &block.states[lane];
                    if left >> lane & 1 == 1 {
                        assert_eq!(&states[lane], before, "{name}");
                        continue;
                    }
                    let mut single = *before;
                    let dw = block.increments(lane);
                    let result = integrator.step(&mut single, h, &dw);
                    assert!(result.is_ok(), "{name}: {result:?} from {before:?}");
                    let (got, expected) = (entries(&states[lane]), entries(&single));
                    let size = expected.iter().fold(1.0, |m: f64, x| m.max(x.abs()));
                    for (a, b) in got.iter().zip(&expected) {
                        let units = (a - b).abs() / (f64::EPSILON * size);
                        self.worst = self.worst.max(units);
                        assert!(
                            units <= UNITS,
                            "{name}, h = {h}: {got:?} in a lane, {expected:?} alone"
                        );
                    }
                }
            }
        }
        self.solved += solved;
        self.left += count - solved;
        assert!(in_lanes || solved == 0, "{name}: {solved}");
        assert!(
            !in_lanes || 10 * solved >= 9 * count,
            "{name}: {solved} of {count}"
        );
    }
}

#[test]
fn lanes_agree_with_single_states() {
    let mut compared = Compared {
        random: Random::new(21),
        worst: 0.0,
        solved: 0,
        left: 0,
    };
    all(&mut compared);
    let Compared {
        worst,
        solved,
        left,
        ..
    } = compared;
    println!("{solved} lanes solved, {left} left, at most {worst} units of rounding apart");
}

/// Steps each lane beside other neighbours: one that cannot be stepped, one that is far away.
struct Neighbours {
    random: Random,
}

impl Check for Neighbours {
    fn run<S, R, Q, const N: usize, const M: usize>(
        &mut self,
        name: &str,
        integrator: &Integrator<S, R>,
        start: State<Q>,
    ) where
        S: Variational<R> + ConstraintImpulses<R> + System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let h = 0.03;
        let block = Block::random(integrator, start, 0.2, &mut self.random);
        let (together, left) = block.step(integrator, h);
        for lane in (0..LANES).filter(|lane| left >> lane & 1 == 0).step_by(5) {
            let mut alone = Block {
                states: vec![block.states[lane]; LANES],
                dw: block.increments(lane).map(|dw| [dw; LANES]),
            };
            let (bad, far) = ((lane + 1) % LANES, (lane + 2) % LANES);
            let mut q = start.q.coordinates();
            q[0] = f64::NAN;
            alone.states[bad].q = Q::from_coordinates(&q);
            let p = Q::components(&block.states[lane].p).map(|p| 1e6 * p);
            alone.states[far].p = Q::from_components(&p);
            let (states, left) = alone.step(integrator, h);
            assert_eq!(left >> bad & 1, 1, "{name}: NaN");
            for other in [lane, (lane + 5) % LANES] {
                assert_eq!(left >> other & 1, 0, "{name}");
                assert_eq!(states[other], together[lane], "{name}");
            }
        }
    }
}

#[test]
fn a_lane_does_not_feel_its_neighbours() {
    all(&mut Neighbours {
        random: Random::new(22),
    });
}

/// A method whose ensembles step one path after the other.
struct OneByOne<I>(I);

impl<I: OneStepMethod> OneStepMethod for OneByOne<I> {
    type System = I::System;
    type Increments = I::Increments;
    type Prepared = I::Prepared;

    fn system(&self) -> &Self::System {
        self.0.system()
    }

    fn prepare(&self, h: f64) -> Result<Self::Prepared, StepError> {
        self.0.prepare(h)
    }

    fn step_prepared(
        &self,
        prepared: &Self::Prepared,
        state: &mut StateOf<Self::System>,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), StepError> {
        self.0.step_prepared(prepared, state, h, dw)
    }
}

/// The failures of the paths of an ensemble.
fn failures<I, Q, const N: usize, const M: usize>(
    method: &I,
    h: f64,
    steps: u64,
    start: impl Fn(u64) -> State<Q> + Sync,
) -> Vec<Failure>
where
    I: OneStepMethod<Increments = [f64; M], Prepared: Sync> + Sync,
    I::System: System<Dims = Dims<N, M, Q>> + Sync,
    Q: VectorCoordinates<N> + Sync,
{
    let summary = Ensemble::new(method)
        .paths(100)
        .seed(7)
        .steps(h, steps)
        .start_with(|path, _| start(path))
        .observe("q", |_, state: &State<Q>| state.q.coordinates()[0])
        .run();
    summary.unwrap().failures().to_vec()
}

fn is_lost(failure: &Failure) -> bool {
    matches!(failure.cause, Cause::Step(StepError::ConstraintLost { .. }))
}

/// Errors of the first step are the same to the last digit. Later ones happen to the same paths at the same steps.
#[test]
fn failures_are_those_of_single_paths() {
    // ever faster around the equator, until no point of the sphere lies on the normal
    let sphere = || Integrator::new(OnSphere { g: 1.0, s: 0.5 }, StormerVerlet);
    let fast = |path: u64| State::new([0.0, 0.0, -1.0], [0.05 * path as f64, 0.0, 0.0]);
    let expected = failures(&OneByOne(sphere()), 0.5, 1, fast);
    let found = failures(&sphere(), 0.5, 1, fast);
    assert!(expected.len() > 30 && expected.iter().all(is_lost));
    assert_eq!(found, expected);
    let midpoint = || Integrator::new(OnSphere { g: 1.0, s: 1.5 }, Midpoint);
    let later = |failures: Vec<Failure>| -> Vec<(u64, u64, bool)> {
        let of = |failure: &Failure| (failure.path, failure.step, is_lost(failure));
        failures.iter().map(of).collect()
    };
    let slow = |path: u64| State::new([0.0, 0.0, -1.0], [0.01 * path as f64, 0.0, 0.0]);
    let expected = later(failures(&OneByOne(midpoint()), 0.5, 20, slow));
    assert!(expected.len() > 10, "{}", expected.len());
    assert_eq!(later(failures(&midpoint(), 0.5, 20, slow)), expected);
    // every third start is beside the sphere
    let beside = |path: u64| {
        let radius = if path.is_multiple_of(3) { 1.001 } else { 1.0 };
        State::new([0.0, 0.0, -radius], [0.3, 0.0, 0.0])
    };
    let expected = failures(&OneByOne(sphere()), 0.01, 5, beside);
    assert_eq!(expected.len(), 34);
    for failure in &expected {
        let is_inconsistent = matches!(
            failure.cause,
            Cause::Step(StepError::InconsistentStart { .. })
        );
        assert!(is_inconsistent && failure.step == 0, "{failure}");
    }
    assert_eq!(failures(&sphere(), 0.01, 5, beside), expected);
}

/// Folded linkages among others, exactly and to rounding.
#[test]
fn folded_linkages_are_errors_in_lanes() {
    fn check<R: Copy + Sync>(rule: R)
    where
        FourBars: Variational<R, Increments = [f64; 0], Prepared: Sync, Memory: Sync>,
    {
        let start = |path: u64| {
            let angle = [0.0, std::f64::consts::PI, 1.0, 2.0][path as usize % 4];
            let arm = Vector2::new(f64::cos(angle), f64::sin(angle));
            let across = Vector2::new(-angle.sin(), angle.cos());
            let speed = if path % 8 < 4 { 0.0 } else { 1.0 };
            State::new([arm, arm + Vector2::new(2.0, 0.0)], [across * speed; 2])
        };
        let integrator = Integrator::new(FourBars, rule);
        assert!(integrator.plan().in_lanes);
        let expected = failures(&OneByOne(Integrator::new(FourBars, rule)), 0.01, 10, start);
        assert_eq!(expected.len(), 50);
        for failure in &expected {
            let is_rank = matches!(failure.cause, Cause::Step(StepError::ConstraintRank { .. }));
            assert!(is_rank && failure.step == 0, "{failure}");
        }
        assert_eq!(failures(&integrator, 0.01, 10, start), expected);
    }
    check(Midpoint);
    check(StormerVerlet);
}

/// Linkages that are nearly folded: where the scalar step refuses a pivot of few digits, the lane does too.
#[test]
fn pivots_of_few_digits_are_judged_by_the_scalar_step() {
    fn check<R: Copy + Sync>(rule: R)
    where
        FourBars: Variational<R, Increments = [f64; 0], Prepared: Sync, Memory: Sync>,
    {
        let start = |path: u64| {
            let folded = std::f64::consts::PI * (path % 2) as f64;
            let angle: f64 = folded + 10.0_f64.powf(-0.36 * (path / 2) as f64);
            let arm = Vector2::new(angle.cos(), angle.sin());
            State::new([arm, arm + Vector2::new(2.0, 0.0)], [Vector2::zeros(); 2])
        };
        let of = |failure: &Failure| (failure.path, failure.step);
        let expected = failures(&OneByOne(Integrator::new(FourBars, rule)), 0.01, 1, start);
        let found = failures(&Integrator::new(FourBars, rule), 0.01, 1, start);
        println!("{} refused", expected.len());
        assert!((10..90).contains(&expected.len()), "{}", expected.len());
        assert_eq!(
            found.iter().map(of).collect::<Vec<_>>(),
            expected.iter().map(of).collect::<Vec<_>>()
        );
    }
    check(Midpoint);
    check(StormerVerlet);
}

/// A particle at rest that is turned at random: each step of the midpoint rule turns it by 2 arctan(s ΔW/2) about the axis, so the mean of the part across the
/// axis is multiplied by `E (1 − x²/4)/(1 + x²/4)`, x = s ΔW, in each step.
#[test]
fn the_mean_of_random_rotations_is_exact() {
    const STEPS: u64 = 40;
    let (s, h) = (1.0, 0.05_f64);
    let integrator = Integrator::new(TurnedSphere { s }, Midpoint);
    assert!(integrator.plan().in_lanes);
    let (axis, q) = (
        Vector3::new(1.0, -2.0, 2.0) / 3.0,
        Vector3::new(0.6, 0.0, -0.8),
    );
    let summary = Ensemble::new(&integrator)
        .paths(4000)
        .seed(3)
        .steps(h, STEPS)
        .start(State::new(q.into(), [0.0; 3]))
        .observe("x", |_, state: &State<[f64; 3]>| state.q[0])
        .observe("y", |_, state: &State<[f64; 3]>| state.q[1])
        .observe("along the axis", |_, state: &State<[f64; 3]>| {
            (state.q[0] - 2.0 * state.q[1] + 2.0 * state.q[2]) / 3.0
        })
        .run()
        .unwrap();
    let failures = summary.failures();
    assert!(failures.is_empty(), "{}", failures[0]);
    // the mean over a normal distribution, by the trapezoidal rule
    let (mut factor, mut weight) = (0.0, 0.0);
    for k in -4000..=4000 {
        let z = f64::from(k) * 2e-3;
        let (x, w) = (s * h.sqrt() * z, (-0.5 * z * z).exp());
        factor += w * (1.0 - 0.25 * x * x) / (1.0 + 0.25 * x * x);
        weight += w;
    }
    let factor = (factor / weight).powi(STEPS as i32);
    let along = axis * axis.dot(&q);
    let expected = along + (q - along) * factor;
    for (k, expected) in [expected.x, expected.y].into_iter().enumerate() {
        let statistics = &summary.statistics()[k];
        let (mean, variance) = (statistics.mean(), statistics.variance());
        let last = mean.len() - 1;
        let error = (variance[last] / 4000.0).sqrt();
        let distance = (mean[last] - expected).abs();
        assert!(error > 1e-3 && distance < 4.5 * error, "{distance} {error}");
    }
    let statistics = &summary.statistics()[2];
    let (min, max) = (statistics.min(), statistics.max());
    for x in min.iter().chain(max) {
        assert!((x - axis.dot(&q)).abs() < 1e-14, "{x}");
    }
}

/// A heat bath: E z = 1 − coth 1 and the temperature 1 at g = T = 1. The rule changes both by less than 0.013 at this step size.
#[test]
fn a_heat_bath_has_its_temperature() {
    const PATHS: u32 = 1500;
    let thermal = Thermal {
        g: 1.0,
        nu: 1.0,
        temperature: 1.0,
    };
    let integrator = Integrator::new(thermal, Midpoint);
    assert!(integrator.plan().in_lanes);
    let summary = Ensemble::new(&integrator)
        .paths(u64::from(PATHS))
        .seed(11)
        .steps(0.1, 120)
        .record_every(120)
        .start(State::new(Vector3::new(1.0, 0.0, 0.0), Vector3::zeros()))
        .observe("height", |_, state: &State<Vector3<f64>>| state.q.z)
        .observe(
            "temperature",
            |thermal: &Thermal, state: &State<Vector3<f64>>| thermal.temperature(state),
        )
        .run()
        .unwrap();
    assert!(summary.failures().is_empty());
    let exact = [1.0 - 1.0 / 1.0_f64.tanh(), 1.0];
    for (statistics, exact) in summary.statistics().iter().zip(exact) {
        let (mean, variance) = (statistics.mean(), statistics.variance());
        let last = mean.len() - 1;
        let error = (variance[last] / f64::from(PATHS)).sqrt();
        let distance = (mean[last] - exact).abs();
        println!("{} ± {error}, exact {exact}", mean[last]);
        assert!(distance < 0.013 + 4.0 * error, "{distance} {error}");
    }
}

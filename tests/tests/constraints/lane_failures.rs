//! Failures of constrained systems in lanes: those of single paths.

use sve_models::models::OnSphere;
use sve_runtime::__private::VectorCoordinates;
use sve_runtime::ensemble::{Cause, Failure};
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, StateOf, System};
use sve_runtime::{OneStepMethod, Variational};

use super::errors::FourBars;

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
        .start(Starts::each(|path, _| start(path)))
        .observe("q", |_, state: &State<Q>| state.q.coordinates()[0])
        .run();
    summary.unwrap().failures().to_vec()
}

fn is_lost(failure: &Failure) -> bool {
    matches!(failure.cause, Cause::Step(StepError::ConstraintLost { .. }))
}

/// Errors of the first step are the same to the last digit. Later ones happen to the same paths at
/// the same steps.
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
        FourBars: Variational<R, Prepared: Sync, Memory: Sync>,
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

/// Linkages that are nearly folded: where the scalar step refuses a pivot of few digits, the lane
/// does too.
#[test]
fn pivots_of_few_digits_are_judged_by_the_scalar_step() {
    fn check<R: Copy + Sync>(rule: R)
    where
        FourBars: Variational<R, Prepared: Sync, Memory: Sync>,
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

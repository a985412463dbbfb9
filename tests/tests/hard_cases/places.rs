//! Places where coordinates or forces are singular. A step there is an error that names the place,
//! or finite, but never NaN.

use sve_models::assert_matches;
use sve_models::checks::assert_says;
use sve_models::models::{Kepler, SphericalPendulum};
use sve_models::stepper::{Stepper, one_node, with_taylor2};
use sve_runtime::prelude::*;

/// Steps until an error or the end and checks that every state is finite. Returns the error with
/// the state before it.
fn run<const N: usize, const M: usize>(
    rule: &dyn Stepper<[f64; N], [f64; M]>,
    start: State<[f64; N]>,
    h: f64,
    steps: usize,
) -> Option<(StepError, State<[f64; N]>)> {
    let mut state = start;
    for _ in 0..steps {
        let last = state;
        if let Err(error) = rule.step(&mut state, h, &[0.0; M]) {
            assert_eq!(state, last);
            return Some((error, last));
        }
        let mut numbers = state.q.iter().chain(&state.p);
        assert!(numbers.all(|x| x.is_finite()), "{}: {state:?}", rule.name());
    }
    None
}

/// Returns the numbers in an error that names a place.
fn place(error: &StepError) -> (f64, f64) {
    match *error {
        StepError::Singular { t, h, .. }
        | StepError::SingularMass { t, h, .. }
        | StepError::NonFiniteResult { t, h, .. }
        | StepError::NotConverged { t, h, .. }
        | StepError::BranchLost { t, h, .. } => (t, h),
        ref other => panic!("{other}"),
    }
}

/// Swinging through the lowest point, where the azimuth is not defined: with no momentum about the
/// axis the motion along the meridian has a mass of its own and passes; with a little of it the
/// orbit turns around the pole in less time than a step.
#[test]
fn spherical_pendulum_through_the_pole() {
    let (m, l, g) = (1.0, 1.0, 9.8);
    for rule in with_taylor2(&SphericalPendulum { m, l, g }) {
        for momentum in [0.0, 1e-12, 1e-6, 1e-3] {
            let start = State::new([1.0, 0.0], [0.0, momentum]);
            let failed = run(&*rule, start, 0.01, 2000);
            assert!(
                failed.is_none(),
                "{}, {momentum:e}: {failed:?}",
                rule.name()
            );
        }
        // at the pole itself no velocity has a momentum about the axis
        let at_pole = State::new([0.0, 0.0], [1.0, 0.1]);
        let error = rule.failure(&at_pole, 0.01, &[0.0; 0]);
        assert_matches!(
            error,
            StepError::SingularMass {
                t: 0.0,
                h: 0.01,
                ..
            }
        );
    }
}

/// Straight into the sun: the fall ends at t = π/√8 from rest at distance 1. What a step across
/// makes of it is wrong in any case; it is finite, or an error that says where.
#[test]
fn kepler_collision() {
    let kepler = Kepler { k: 1.0, sigma: 0.0 };
    let collision = core::f64::consts::PI / 8.0_f64.sqrt();
    let mut errors = 0;
    for h in [1e-1, 1e-2, 1e-3] {
        let start = State::new([1.0, 0.0], [0.0, 0.0]);
        let rules = one_node(&kepler);
        let ends = rules.iter().map(|rule| run(&**rule, start, h, 100_000));
        for (error, last) in ends.flatten() {
            assert_eq!(place(&error), (last.t, h));
            assert!(last.t > 0.5 * collision, "{error}");
            errors += 1;
        }
        // in the sun there is no step
        let start = State::new([0.0, 0.0], [0.1, 0.0]);
        let error = Integrator::new(&kepler, InitialPoint).failure(&start, h, &[0.0]);
        assert_matches!(error, StepError::NonFiniteResult { .. });
        assert_says(error, &["q = [0.0, 0.0]"]);
    }
    // the implicit rule finds no solution across the singularity
    assert!(errors > 0);
}

//! Places where coordinates or forces are singular. A step there is an error that names the place,
//! or finite, but never NaN.

use sve_models::models::SphericalPendulum;
use sve_runtime::prelude::*;
use sve_runtime::{Dims, System, Variational};

use sve_models::models::Kepler;

/// Steps until an error or the end and checks that every state is finite. Returns the error with
/// the state before it.
fn run<S, R, const N: usize>(
    integrator: &Integrator<S, R>,
    start: State<[f64; N]>,
    h: f64,
    steps: usize,
) -> Option<(StepError, State<[f64; N]>)>
where
    S: Variational<R> + System<Dims = Dims<N, 0>>,
{
    finite(integrator.trajectory(start, h, NoNoise), steps)
}

fn finite<I, W, const N: usize, const M: usize>(
    mut path: sve_runtime::Trajectory<'_, I, W>,
    steps: usize,
) -> Option<(StepError, State<[f64; N]>)>
where
    I: Method,
    I::System: System<Dims = Dims<N, M>>,
    W: Noise,
{
    for _ in 0..steps {
        let last = *path.state();
        match path.next()? {
            Ok(state) => {
                assert!(
                    state.q.iter().chain(&state.p).all(|x| x.is_finite()),
                    "{state:?}"
                );
            }
            Err(error) => {
                assert_eq!(path.state(), &last);
                return Some((error, last));
            }
        }
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
    fn check<R>(rule: R)
    where
        SphericalPendulum: Variational<R>,
    {
        let (m, l, g) = (1.0, 1.0, 9.8);
        let pendulum = Integrator::new(SphericalPendulum { m, l, g }, rule);
        for momentum in [0.0, 1e-12, 1e-6, 1e-3] {
            let start = State::new([1.0, 0.0], [0.0, momentum]);
            if let Some((error, last)) = run(&pendulum, start, 0.01, 2000) {
                let (t, h) = place(&error);
                assert_eq!((t, h), (last.t, 0.01));
                // near the pole, and nowhere else
                let from_pole = last.q[0].sin().abs();
                assert!(from_pole < 0.1, "{momentum:e}: {error} at {last:?}");
            }
        }
        // at the pole itself with momentum about it there is no such motion; a rule that does not
        // look there may go on
        if let Some((error, last)) = run(&pendulum, State::new([0.0, 0.0], [1.0, 0.1]), 0.01, 10) {
            assert_eq!(place(&error), (last.t, 0.01));
        }
    }
    check(InitialPoint);
    check(Endpoint);
    check(Midpoint);
    check(Taylor2);
}

/// Straight into the sun: the fall ends at t = π/√8 from rest at distance 1. What a step across
/// makes of it is wrong in any case; it is finite, or an error that says where.
#[test]
fn kepler_collision() {
    fn check<R>(rule: R, h: f64) -> Option<(StepError, State<[f64; 2]>)>
    where
        Kepler: Variational<R>,
    {
        let kepler = Integrator::new(Kepler { k: 1.0, sigma: 0.0 }, rule);
        let start = State::new([1.0, 0.0], [0.0, 0.0]);
        finite(kepler.trajectory(start, h, NoNoise), 100_000)
    }
    let collision = core::f64::consts::PI / 8.0_f64.sqrt();
    let mut errors = 0;
    for h in [1e-1, 1e-2, 1e-3] {
        let ends = [
            check(InitialPoint, h),
            check(Endpoint, h),
            check(Midpoint, h),
        ];
        for (error, last) in ends.into_iter().flatten() {
            assert_eq!(place(&error), (last.t, h));
            assert!(last.t > 0.5 * collision, "{error}");
            errors += 1;
        }
        // in the sun there is no step
        let start = State::new([0.0, 0.0], [0.1, 0.0]);
        let kepler = Integrator::new(Kepler { k: 1.0, sigma: 0.0 }, InitialPoint);
        let error = kepler.step(&mut start.clone(), h, &[0.0]).unwrap_err();
        assert!(
            matches!(error, StepError::NonFiniteResult { .. }),
            "{error}"
        );
        assert!(error.to_string().contains("q = [0.0, 0.0]"), "{error}");
    }
    // the implicit rule finds no solution across the singularity
    assert!(errors > 0);
}

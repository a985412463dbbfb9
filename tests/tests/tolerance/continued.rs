//! A path with a tolerance that is stored and continued has the bits of one that was not
//! interrupted.

use sve_runtime::prelude::*;

use super::systems::{DoublePendulum, Kepler, Pendulum, perihelion};

/// Stores a path as text after each of its steps, and continues it. Returns after how many of them
/// attempts had been rejected.
macro_rules! check_continued {
    ($integrator:expr, $start:expr, $tolerance:expr, $steps:expr) => {{
        let integrator = &$integrator;
        let path = || {
            integrator
                .trajectory($start, 0.01, NoNoise)
                .tolerance($tolerance)
        };
        let whole: Vec<_> = path().take($steps).map(Result::unwrap).collect();
        let mut first = path();
        let mut rejected_before = 0;
        for stop in 0..$steps - 1 {
            let text = serde_json::to_string(&first.snapshot()).unwrap();
            let snapshot = serde_json::from_str(&text).unwrap();
            let rest = integrator.resume(snapshot, NoNoise).unwrap();
            let mut rest = rest.tolerance($tolerance);
            assert_eq!(
                (rest.step(), rest.rejections()),
                (stop as u64, first.rejections())
            );
            for state in whole[stop..].iter().take(4) {
                assert_eq!(&rest.next().unwrap().unwrap(), state, "after {stop}");
            }
            let rejections = first.rejections();
            first.next().unwrap().unwrap();
            rejected_before += usize::from(first.rejections() > rejections);
        }
        rejected_before
    }};
}

#[test]
fn a_stored_path_is_continued_with_the_same_bits() {
    let kepler = Integrator::new(Kepler, Gauss::<8>);
    // also right after steps that were tried more than once
    let rejected = check_continued!(kepler, perihelion(0.9), 1e-9, 80);
    assert!(rejected >= 2, "{rejected}");
    let double = Integrator::new(DoublePendulum, Gauss::<6>);
    check_continued!(double, State::new([1.0, 1.5], [0.0, 0.0]), 1e-6, 30);
}

#[test]
fn a_snapshot_needs_its_tolerance_and_its_system() {
    let mut pendulum = Integrator::new(Pendulum { g: 1.0 }, Gauss::<8>);
    let start = State::new([1.0], [0.0]);
    let mut path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
    path.next().unwrap().unwrap();
    let (snapshot, t) = (path.snapshot(), path.state().t);
    let mut plain = pendulum.resume(snapshot.clone(), NoNoise).unwrap();
    assert_eq!(plain.next(), Some(Err(StepError::ToleranceMissing { t })));
    let plain = pendulum.resume(snapshot.clone(), NoNoise).unwrap();
    let loss = plain.gradient(10, |_, end| Some(end.q[0]));
    assert_eq!(loss.err(), Some(StepError::ToleranceMissing { t }));
    // the present time has the present state
    for steps in 1..30 {
        let path = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
        let mut path = path.skip(steps - 1);
        let state = path.next().unwrap().unwrap();
        let stored = pendulum.trajectory(start, 0.1, NoNoise).tolerance(1e-8);
        let mut stored = stored;
        for _ in 0..steps {
            stored.next().unwrap().unwrap();
        }
        let resumed = pendulum.resume(stored.snapshot(), NoNoise).unwrap();
        let again = resumed.tolerance(1e-8).at([state.t]).next();
        assert_eq!(again, Some(Ok(state)));
    }
    // stored again, it is the same
    let again = pendulum
        .resume(snapshot.clone(), NoNoise)
        .unwrap()
        .snapshot();
    assert_eq!(again, snapshot);
    let other = Integrator::new(Pendulum { g: 1.0 }, Gauss::<6>);
    let error = other.resume(snapshot.clone(), NoNoise).err();
    assert!(
        matches!(error, Some(StepError::OtherSteps { .. })),
        "{error:?}"
    );
    pendulum.system_mut().g = 2.0;
    let error = pendulum.resume(snapshot, NoNoise).err();
    assert!(
        matches!(error, Some(StepError::OtherSteps { .. })),
        "{error:?}"
    );
}

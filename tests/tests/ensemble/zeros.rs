//! Zeros within steps: their order, and jumps, which are none.

use sve_models::models::Kicked;
use sve_runtime::ensemble::{Cause, Failure};
use sve_runtime::prelude::*;

use crate::runs::free;

/// Two functions have their zeros within one step: a path stops at the first one in time, whatever
/// their order.
#[test]
fn the_first_zero_within_a_step_stops() {
    let method = free();
    let summary = Ensemble::new(&method)
        .paths(100)
        .steps(0.5, 8)
        .start(Starts::each(|path, _| {
            State::new([0.0], [if path % 2 == 0 { 1.0 } else { -1.0 }])
        }))
        .stop_at("outer", |_, state| state.q[0].abs() - 1.25)
        .stop_at("inner", |_, state| state.q[0].abs() - 1.125)
        .first_passage("between", |_, state| state.q[0].abs() - 1.1875)
        .first_passage("before", |_, state| state.q[0] - 1.0625)
        .keep_final_states(true)
        .run()
        .unwrap();
    let ends = |name| {
        let passage = summary.passage(name).unwrap();
        (passage.passed()[1], passage.censored()[1])
    };
    assert_eq!((ends("inner"), ends("outer")), ((100, 0), (0, 100)));
    assert_eq!((ends("between"), ends("before")), ((0, 100), (50, 50)));
    for (path, state) in summary.final_states() {
        assert!((state.t - 1.125).abs() < 1e-12, "{path}: {}", state.t);
    }
}

/// A pole is no zero, and neither is a jump; a rough function has a zero.
#[test]
fn jumps_are_no_passages() {
    let method = Integrator::new(Kicked { sigma: 1.0 }, Midpoint);
    let ensemble = || {
        Ensemble::new(&method)
            .paths(256)
            .steps(0.05, 20)
            .start(Starts::each(|path, _| {
                State::new([0.0], [0.25 + 1.75 * (path % 256) as f64 / 256.0])
            }))
    };
    let crossing = ensemble()
        .crossings("x", |_, s| s.q[0] - 0.2)
        .run()
        .unwrap();
    let crossing = crossing["x"].mean()[1] * 256.0;
    assert!(crossing > 200.0);
    for failing in [
        ensemble().stop_at("pole", |_, s| 1.0 / (s.q[0] - 0.2)),
        ensemble().stop_at("jump", |_, s| if s.q[0] < 0.2 { -0.5 } else { 1.0 }),
    ] {
        let summary = failing.run().unwrap();
        let passed = summary.passages()[0].passed()[1];
        let failed = summary.failed();
        assert!(passed == 0 && failed > 150, "{passed} {failed}");
        let jumps = |failure: &Failure| matches!(failure.cause, Cause::Step(StepError::EventJump { before, after, .. }) if before < 0.0 && after > 0.0);
        assert!(summary.failures().iter().all(jumps));
    }
    let summary = ensemble()
        .paths(4096)
        .first_passage("rough", |_, s| s.p[0] - 1.0);
    let summary = summary.run().unwrap();
    assert_eq!(summary.failed(), 0);
    assert!(summary.passage("rough").unwrap().passed()[1] > 1000);
}

#[test]
fn a_function_that_is_not_finite_fails_the_path() {
    let method = free();
    let summary = Ensemble::new(&method)
        .paths(2)
        .steps(0.125, 8)
        .start(Starts::each(|path, _| {
            State::new([0.0], [1.0 - 2.0 * path as f64])
        }))
        .stop_at("root", |_, state| 1.0 - (state.q[0] + 0.5).sqrt())
        .run()
        .unwrap();
    assert_eq!((summary.failed(), summary.failures()[0].path), (1, 1));
    let root = summary.passage("root").unwrap();
    assert_eq!((root.passed()[1], root.censored()[1]), (1, 1));
    assert!(summary.failures()[0].to_string().contains("`root`"));
}

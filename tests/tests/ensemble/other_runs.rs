//! Settings that make another run: shards with another one do not merge, and a checkpoint with
//! another one is not continued.

use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use sve_models::models::Pushed;
use sve_runtime::ensemble::{By, Difference};
use sve_runtime::prelude::*;

use crate::runs::scratch;

type Method = Integrator<Pushed, Midpoint>;
type Change = fn(Ensemble<'_, Method>) -> Ensemble<'_, Method>;

/// Settings, changes to one of them, and the difference that the error names.
const CASES: [(Change, Change, Difference); 14] = [
    (|e| e, |e| e.refine(4), Difference::Settings),
    (|e| e.refine(3), |e| e.refine(4), Difference::Settings),
    (
        |e| e.first_passage("far", |_, s| s.q[0] - 0.5),
        |e| e.stop_at("far", |_, s| s.q[0] - 0.5),
        Difference::Settings,
    ),
    (
        |e| e.first_passage("far", |_, s| s.q[0] - 0.5),
        |e| e.first_passage("far", |_, s| s.q[0] - 0.500_001),
        Difference::Values,
    ),
    (
        |e| e.first_passage("far", |_, s| s.q[0] - 0.5),
        |e| e.first_passage("near", |_, s| s.q[0] - 0.5),
        Difference::Observables,
    ),
    (
        |e| e.maximum("x", |_, s| s.q[0]),
        |e| e.integral("x", |_, s| s.q[0]),
        Difference::Settings,
    ),
    (
        |e| e.average("x", |_, s| s.q[0]).settle(5),
        |e| e.average("x", |_, s| s.q[0]).settle(6),
        Difference::Settings,
    ),
    (
        |e| e.gradient("x", ["g"], |s| s.q[0]),
        |e| e.gradient("x", [By::during("g", 0..10)], |s| s.q[0]),
        Difference::Observables,
    ),
    (
        |e| e.gradient("x", [By::during("g", 0..10)], |s| s.q[0]),
        |e| e.gradient("x", [By::during("g", 0..11)], |s| s.q[0]),
        Difference::Observables,
    ),
    (
        |e| e.noise(Wiener::new(3)),
        |e| e.noise(Wiener::new(3).path(1)),
        Difference::Noise,
    ),
    (
        |e| e.noise(Wiener::new(3).refine(1).unwrap()),
        |e| e.noise(Wiener::new(3).refine(2).unwrap()),
        Difference::Noise,
    ),
    (|e| e, |e| e.antithetic(true), Difference::Noise),
    (
        |e| e.covariance("q", "q"),
        |e| e.two_time("q", "q"),
        Difference::Statistic("covariances"),
    ),
    (
        |e| e.quantiles("q", 10),
        |e| e.quantiles("q", 11),
        Difference::Statistic("quantiles"),
    ),
];

fn method() -> Method {
    Integrator::new(Pushed { g: 1.0, s: 0.3 }, Midpoint)
}

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(64 * 4)
        .seed(3)
        .steps(0.05, 20)
        .start(State::new([0.1], [0.0]))
        .observe("q", |_, state| state.q[0])
}

#[test]
fn shards_with_another_setting_do_not_merge() {
    let method = method();
    let mut wrong = Vec::new();
    for (number, (setting, change, expected)) in CASES.into_iter().enumerate() {
        let shard = |setting: Change, index| setting(ensemble(&method)).shard(index, 2).run();
        let mut merged = shard(setting, 0).unwrap();
        let refused = merged.merge(shard(change, 1).unwrap());
        if !matches!(refused, Err(EnsembleError::OtherRun { what }) if what == expected) {
            wrong.push((number, refused));
            continue;
        }
        merged.merge(shard(setting, 1).unwrap()).unwrap();
        assert!(merged.is_complete());
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn a_checkpoint_is_not_continued_with_another_setting() {
    let method = method();
    let mut wrong = Vec::new();
    for (number, (setting, change, expected)) in CASES.into_iter().enumerate() {
        let path = scratch("other_runs.sve");
        let blocks = AtomicU32::new(0);
        let begun = setting(ensemble(&method))
            .threads(1)
            .checkpoint(&path, Duration::ZERO)
            .stop_when(|| blocks.fetch_add(1, Ordering::Relaxed) >= 1);
        assert!(!begun.run().unwrap().is_complete());
        let resumed = |setting: Change| {
            let ensemble = setting(ensemble(&method)).checkpoint(&path, Duration::ZERO);
            ensemble.resume(true).run()
        };
        let refused = resumed(change);
        if !matches!(&refused, Err(EnsembleError::OtherCheckpoint { what, .. }) if *what == expected)
        {
            wrong.push((number, refused));
            continue;
        }
        let whole = setting(ensemble(&method)).run().unwrap();
        assert_eq!(resumed(setting).unwrap(), whole, "case {number}");
    }
    let _ = scratch("other_runs.sve");
    assert!(wrong.is_empty(), "{wrong:?}");
}

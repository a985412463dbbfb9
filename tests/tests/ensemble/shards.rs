//! Shards merge into the bits of the whole, in any order.

use sve_runtime::prelude::*;
use sve_tests::models::Kubo;

type Method = Integrator<Kubo, Midpoint>;

fn kubo() -> Method {
    Integrator::new(Kubo { a: 1.0, sigma: 0.5 }, Midpoint)
}

/// Eleven blocks, the last a partial one.
const PATHS: u64 = 64 * 10 + 7;

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .record_every(10)
        .start_with(|_, rng| State::new([rng.normal()], [rng.uniform()]))
        .observe("q", |_, state| {
            if state.q[0] > 2.5 {
                f64::NAN
            } else {
                state.q[0]
            }
        })
        .observe("energy", |system, state| system.hamiltonian(state))
        .histogram("q", -2.0..2.0, 10)
        .final_histogram("energy", 0.0..2.0, 7)
        .keep_final_states(true)
}

fn shards(method: &Method, of: u64) -> Vec<Summary> {
    let shard = |k| ensemble(method).shard(k, of).run().unwrap();
    (0..of).map(shard).collect()
}

fn orders(n: usize) -> Vec<Vec<usize>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let insert = |order: Vec<usize>| {
        (0..n).map(move |at| {
            let mut order = order.clone();
            order.insert(at, n - 1);
            order
        })
    };
    orders(n - 1).into_iter().flat_map(insert).collect()
}

#[test]
fn merge_in_any_order() {
    let method = kubo();
    let whole = ensemble(&method).run().unwrap();
    assert!(whole.is_complete() && whole.failed() > 0);
    for of in [2, 3, 4, 5] {
        let shards = shards(&method, of);
        for order in orders(of as usize) {
            let mut merged = shards[order[0]].clone();
            for &k in &order[1..] {
                assert!(!merged.is_complete());
                merged.merge(shards[k].clone()).unwrap();
            }
            assert_eq!(merged, whole, "{order:?}");
            let bits = |s: &Summary| {
                s["energy"]
                    .mean()
                    .iter()
                    .map(|x| x.to_bits())
                    .collect::<Vec<_>>()
            };
            assert_eq!(bits(&merged), bits(&whole));
            assert_eq!(merged.failures(), whole.failures());
        }
    }
}

#[test]
fn may_be_empty_and_many() {
    let method = kubo();
    let mut shards = shards(&method, 16).into_iter();
    let mut merged = shards.next().unwrap();
    assert_eq!(merged.paths(), 0);
    assert!(merged["q"].mean()[0].is_nan());
    for shard in shards {
        assert!(shard.paths() <= 64);
        merged.merge(shard).unwrap();
    }
    assert_eq!(merged, ensemble(&method).run().unwrap());
}

#[test]
fn are_of_use_alone() {
    let method = kubo();
    let whole = ensemble(&method).run().unwrap();
    let shards = shards(&method, 3);
    let paths: Vec<_> = shards.iter().map(Summary::paths).collect();
    // blocks 0 – 2, 3 – 6, 7 – 10
    assert_eq!(paths, [3 * 64, 4 * 64, 3 * 64 + 7]);
    let ends = shards.iter().flat_map(Summary::final_states::<1>);
    assert!(ends.eq(whole.final_states()));
    let mean = shards
        .iter()
        .map(|s| s["energy"].mean()[4] * s.counts()[4] as f64);
    let mean = mean.sum::<f64>() / whole.counts()[4] as f64;
    assert!((mean / whole["energy"].mean()[4] - 1.0).abs() < 1e-13);
}

#[test]
fn of_other_runs_do_not_merge() {
    let method = kubo();
    let part = ensemble(&method).shard(0, 2).run().unwrap();
    let other = |change: fn(Ensemble<'_, Method>) -> Ensemble<'_, Method>, what: &str| {
        let mut merged = part.clone();
        let other = change(ensemble(&method).shard(1, 2)).run().unwrap();
        let error = merged.merge(other).unwrap_err();
        assert!(error.to_string().contains(what), "{error}");
        assert_eq!(merged, part);
    };
    other(|e| e.paths(PATHS + 64), "number of paths");
    other(|e| e.steps(0.06, 40), "recorded times");
    other(|e| e.record_every(20), "recorded times");
    other(|e| e.observe("p", |_, s| s.p[0]), "observables");
    other(|e| e.histogram("q", 0.0..1.0, 3), "histograms");
    other(|e| e.seed(4), "seed");
    other(|e| e.truncated(1.0), "seed");
    other(|e| e.start(State::new([1.0], [0.0])), "seed");
    other(|e| e.keep_final_states(false), "seed");
    let stiff = Integrator::new(Kubo { a: 1.1, sigma: 0.5 }, Midpoint);
    let mut merged = part.clone();
    let error = merged.merge(ensemble(&stiff).shard(1, 2).run().unwrap());
    assert!(matches!(error, Err(EnsembleError::OtherRun { .. })));
}

#[test]
fn do_not_merge_twice() {
    let method = kubo();
    let mut part = ensemble(&method).shard(1, 3).run().unwrap();
    let copy = part.clone();
    match part.merge(ensemble(&method).shard(1, 2).run().unwrap()) {
        // blocks 3 – 6 and 5 – 10
        Err(EnsembleError::Overlap { first, last }) => assert_eq!((first, last), (320, 383)),
        other => panic!("{other:?}"),
    }
    assert_eq!(part, copy);
}

//! Shards merge into the bits of the whole, in any order.

use sve_models::assert_matches;
use sve_models::checks::assert_says;
use sve_runtime::baseline::{EulerMaruyama, Heun};
use sve_runtime::ensemble::Difference;
use sve_runtime::prelude::*;
use sve_runtime::system::Dims;

use crate::runs::{KuboMethod, kubo, run_in_parts};

/// Eleven blocks, the last a partial one.
const PATHS: u64 = 64 * 10 + 7;

fn ensemble(method: &KuboMethod) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(3)
        .steps(0.05, 40)
        .every(10)
        .start(Starts::each(|_, rng| {
            State::new([rng.normal()], [rng.uniform()])
        }))
        .observe("q", |_, s| if s.q[0] > 2.5 { f64::NAN } else { s.q[0] })
        .observe("energy", |system, state| system.hamiltonian(state))
        .histogram("q", -2.0..2.0, 10)
        .histogram("energy", 0.0..2.0, Bins::at_end(7))
        .keep_final_states(true)
}

fn shards(method: &KuboMethod, of: u64) -> Vec<Summary> {
    let shard = |k| ensemble(method).shard(k, of).run().unwrap();
    (0..of).map(shard).collect()
}

/// All orders of so many shards.
fn orders(n: u64) -> Vec<Vec<u64>> {
    if n == 0 {
        return vec![Vec::new()];
    }
    let insert = |order: Vec<u64>| {
        (0..n as usize).map(move |at| {
            let mut order = order.clone();
            order.insert(at, n - 1);
            order
        })
    };
    orders(n - 1).into_iter().flat_map(insert).collect()
}

#[test]
fn threads_and_shards_in_any_order_have_the_same_bits() {
    let method = kubo();
    let orders: Vec<_> = (2..=5).flat_map(orders).collect();
    let orders: Vec<&[u64]> = orders.iter().map(Vec::as_slice).collect();
    let whole = run_in_parts(|| ensemble(&method), &[2, 3, 16], &orders);
    assert!(whole.failed() > 0 && whole["energy"].variance()[4] > 0.01);
}

#[test]
fn may_be_many_and_none_is_empty() {
    let method = kubo();
    let all = shards(&method, 11);
    assert!(all.iter().all(|shard| (1..=64).contains(&shard.paths())));
    let each: Vec<u64> = (0..11).collect();
    run_in_parts(|| ensemble(&method), &[], &[&each]);
    let error = ensemble(&method).shard(0, 16).run().unwrap_err();
    assert_says(error, &["647 paths are 11 blocks", "at most 11 shards"]);
    let none = ensemble(&method).stop_when(|| true).run();
    assert_matches!(none, Err(EnsembleError::NothingRun));
}

#[test]
fn are_of_use_alone() {
    let method = kubo();
    let whole = ensemble(&method).run().unwrap();
    let shards = shards(&method, 3);
    let paths: Vec<_> = shards.iter().map(Summary::paths).collect();
    // blocks 0 – 2, 3 – 6, 7 – 10
    assert_eq!(paths, [3 * 64, 4 * 64, 3 * 64 + 7]);
    let ends = shards.iter().flat_map(Summary::final_states);
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
    let other = |change: fn(Ensemble<'_, KuboMethod>) -> Ensemble<'_, KuboMethod>, what: &str| {
        let mut merged = part.clone();
        let other = change(ensemble(&method).shard(1, 2)).run().unwrap();
        assert_says(merged.merge(other).unwrap_err(), &[what]);
        assert_eq!(merged, part);
    };
    other(|e| e.paths(PATHS + 64), "number of paths");
    other(|e| e.steps(0.06, 40), "recorded times");
    other(|e| e.every(20), "recorded times");
    other(|e| e.observe("p", |_, s| s.p[0]), "observables");
    other(|e| e.histogram("q", 0.0..1.0, 3), "histograms");
    other(|e| e.seed(4), "a seed");
    other(
        |e| e.noise(Truncated::new(Wiener::new(3)).deviations(1.0).unwrap()),
        "law of the noise",
    );
    other(|e| e.noise(ThreePoint::new(3)), "law of the noise");
    other(|e| e.noise(NoNoise), "law of the noise");
    other(|e| e.start(State::new([1.0], [0.0])), "starts");
    other(|e| e.keep_final_states(false), "settings");
    other(|e| e.bound("q", ..1e9), "settings");
    // all recorded times are equal, and the step is not
    other(|e| e.steps(0.025, 80).every(20), "settings");
}

#[test]
fn of_statistics_in_another_order_merge() {
    let method = kubo();
    let shard = |index| ensemble(&method).shard(index, 2);
    let histogram_last = shard(0)
        .two_time("energy", "q")
        .quantiles("q", 100)
        .histogram("q", 0.0..1.0, 3);
    let histogram_first = shard(1)
        .histogram("q", 0.0..1.0, 3)
        .two_time("energy", "q")
        .quantiles("q", 100);
    let mut merged = histogram_last.run().unwrap();
    merged.merge(histogram_first.run().unwrap()).unwrap();
    assert_eq!(merged, histogram_first.shard(0, 1).run().unwrap());
    // two requests of one kind have the order in which they were made
    let [a, b] = [0.0..1.0, 0.0..2.0];
    let first = (shard(0).histogram("q", a.clone(), 3)).histogram("q", b.clone(), 3);
    let second = (shard(1).histogram("q", b, 3)).histogram("q", a, 3);
    let error = first.run().unwrap().merge(second.run().unwrap());
    assert_says(error.unwrap_err(), &["histograms"]);
}

/// Merges shard 0 of one ensemble with shard 1 of another. Returns the difference that the error
/// names.
fn refused<I, J>(first: &Ensemble<'_, I>, second: &Ensemble<'_, J>) -> Difference
where
    I: sve_runtime::Method<System: sve_runtime::system::System<Dims = Dims<1, 1>>> + Sync,
    J: sve_runtime::Method<System: sve_runtime::system::System<Dims = Dims<1, 1>>> + Sync,
{
    let mut merged = first.run().unwrap();
    match merged.merge(second.run().unwrap()) {
        Err(EnsembleError::OtherRun { what }) => what,
        other => panic!("{other:?}"),
    }
}

/// An oscillator with a spring of sixth degree, whose first steps from rest do not show the spring.
struct Sixth {
    f: f64,
    sigma: f64,
}

#[variational(endpoint, midpoint)]
impl Sixth {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q - self.f * q.powi(6) / 6.0
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// An oscillator with a pulse at t = 5.
struct Pulse {
    f: f64,
    sigma: f64,
}

#[variational(endpoint)]
impl Pulse {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        let pulse = (-1e3 * (t - 5.0).powi(2)).exp();
        0.5 * v * v - 0.5 * q * q - self.f * q.powi(6) / 6.0 + pulse * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// 2,000 steps from rest.
fn from_rest<I>(method: &I, shard: u64) -> Ensemble<'_, I>
where
    I: sve_runtime::Method<System: sve_runtime::system::System<Dims = Dims<1, 1>>>,
{
    Ensemble::new(method)
        .paths(256)
        .steps(0.01, 2000)
        .every(100)
        .start(State::new([0.0], [0.0]))
        .observe("q²", |_, state| state.q[0].powi(2))
        .shard(shard, 2)
}

#[test]
fn of_systems_and_methods_that_differ_little_do_not_merge() {
    let sixth = |f, sigma| Integrator::new(Sixth { f, sigma }, Endpoint);
    let [plain, stiff, noisier] = [sixth(0.0, 0.3), sixth(10.0, 0.3), sixth(0.0, 0.3 + 1e-9)];
    let first = from_rest(&plain, 0);
    let pulsed = Integrator::new(Pulse { f: 0.0, sigma: 0.3 }, Endpoint);
    let quiet = || Sixth { f: 0.0, sigma: 0.3 };
    let midpoint = Integrator::new(quiet(), Midpoint);
    let newton = Newton {
        max_iterations: 49,
        ..Newton::default()
    };
    let other_newton = Integrator::new(quiet(), Midpoint).with_newton(newton);
    let (heun, euler) = (Heun::new(quiet()), EulerMaruyama::new(quiet()));
    let uncorrected = EulerMaruyama::new(quiet()).uncorrected();
    let of_newton = refused(&from_rest(&midpoint, 0), &from_rest(&other_newton, 1));
    let of_heun = refused(&from_rest(&heun, 0), &from_rest(&euler, 1));
    let of_correction = refused(&from_rest(&euler, 0), &from_rest(&uncorrected, 1));
    for (found, expected) in [
        (
            refused(&first, &from_rest(&stiff, 1)),
            Difference::Parameters,
        ),
        (
            refused(&first, &from_rest(&noisier, 1)),
            Difference::Parameters,
        ),
        (
            refused(&first, &from_rest(&pulsed, 1)),
            Difference::Formulas,
        ),
        (
            refused(&first, &from_rest(&midpoint, 1)),
            Difference::Method,
        ),
        (of_newton, Difference::Method),
        (of_heun, Difference::Method),
        (of_correction, Difference::Method),
    ] {
        assert_eq!(found, expected);
    }
    // an equal one, made anew, is the same run
    let mut whole = first.run().unwrap();
    whole
        .merge(from_rest(&sixth(0.0, 0.3), 1).run().unwrap())
        .unwrap();
    assert!(whole.is_complete());
}

#[test]
fn of_starts_and_observables_that_differ_little_do_not_merge() {
    let method = Integrator::new(Sixth { f: 0.0, sigma: 0.3 }, Endpoint);
    let first = from_rest(&method, 0);
    let moved = from_rest(&method, 1).start(State::new([1e-9], [0.0]));
    assert_eq!(refused(&first, &moved), Difference::Starts);
    let others = from_rest(&method, 1).start(Starts::each(|k, _| {
        State::new([if k == 0 { 0.0 } else { 1e-12 }], [0.0])
    }));
    assert_eq!(refused(&first, &others), Difference::Starts);
    let late = |from: f64| {
        Ensemble::new(&method)
            .paths(256)
            .steps(0.01, 2000)
            .every(100)
            .start(State::new([0.0], [0.0]))
            .observe("q²", move |_, state| {
                state.q[0].powi(2) + if state.t > from { 1e-12 } else { 0.0 }
            })
    };
    let what = refused(&late(f64::INFINITY).shard(0, 2), &late(4.0).shard(1, 2));
    assert_eq!(what, Difference::Values);
    let folded = |factor: f64, offset: f64, shard| {
        from_rest(&method, shard).fold(
            "x",
            |_, state| state.q[0],
            move |x, _, state| *x += factor * state.q[0].abs(),
            move |x| x + if *x == 0.0 { 0.0 } else { offset },
        )
    };
    for (factor, offset) in [(1.0 + 1e-12, 0.0), (1.0, 1e-12)] {
        let what = refused(&folded(1.0, 0.0, 0), &folded(factor, offset, 1));
        assert_eq!(what, Difference::Values);
    }
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

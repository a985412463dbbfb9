//! Invalid settings are errors that say what to write. Histograms and names.

use sve_models::checks::assert_says;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, drawn, kubo};

type Change = fn(Ensemble<'_, KuboMethod>) -> Ensemble<'_, KuboMethod>;

fn sound(method: &KuboMethod) -> Ensemble<'_, KuboMethod> {
    Ensemble::new(method)
        .paths(10)
        .steps(0.1, 10)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, state| state.q[0])
}

#[test]
fn errors() {
    let method = kubo();
    let cases: [(Change, &str); 30] = [
        (|e| e.paths(0), "`paths` was given 0"),
        (|e| e.steps(0.1, 0), "`steps` was given 0"),
        (|e| e.steps(0.0, 10), "h = 0 must be finite and not zero"),
        (
            |e| e.steps(f64::NAN, 10),
            "h = NaN must be finite and not zero",
        ),
        (
            |e| e.steps(1e308, 10),
            "not finite; take fewer or shorter steps",
        ),
        (
            |e| e.start(State::at(f64::NAN, [1.0], [0.0])),
            "not finite; take fewer or shorter steps",
        ),
        (|e| e.every(0), "write 1 to record each step"),
        (
            |e| e.steps(0.1, 10).settle(10).average("x", |_, s| s.q[0]),
            "`settle(10)` leaves nothing to average: a path makes 10 steps",
        ),
        (|e| e.resume(true), "`.checkpoint("),
        (
            |e| e.antithetic(true).paths(2).stop_at("x", |_, s| s.q[0]),
            "`antithetic` and `stop_at` do not go together",
        ),
        (|e| e.threads(0), "leave it out to use every core"),
        (
            |e| e.observe("q", |_, _| 1.0),
            "two observables are called `q`",
        ),
        (
            |e| e.histogram("p", 0.0..1.0, 3),
            "add `.observe(\"p\", …)`",
        ),
        (|e| e.histogram("q", 0.0..1.0, 0), "with 0 bins"),
        (
            |e| e.histogram("q", 1.0..1.0, 3),
            "the lower below the upper",
        ),
        (|e| e.histogram("q", f64::NAN..1.0, 3), "finite bounds"),
        (
            |e| e.histogram("q", 0.0..f64::INFINITY, Bins::at_end(3)),
            "finite bounds",
        ),
        (|e| e.shard(2, 2), "of 2 shards the numbers are 0 to 2 − 1"),
        (|e| e.shard(0, 0), "of 0 shards"),
        (
            |e| e.noise(Truncated::new(Wiener::new(0)).exponent(2.0, 1e-3).unwrap()),
            "`noise`: increments truncated at √(2k ln(τ/h)) standard deviations need h < τ",
        ),
        (|e| e.bound("p", ..1.0), "add `.observe(\"p\", …)`"),
        (|e| e.bound("q", 1.0..0.0), "leaves no value"),
        (|e| e.bound("q", f64::NAN..), "leaves no value"),
        (
            |e| e.start(State::at(1e16, [1.0], [0.0])),
            "at t = 10000000000000000 a step does not change the time, whose next number is 2 away",
        ),
        (
            |e| e.histogram("q", 0.0..1.0, usize::MAX),
            "with 18446744073709551615 bins",
        ),
        (
            |e| e.histogram("q", 0.0..1.0, 1 << 45),
            "with 35184372088832 bins at 2 recorded times take 11",
        ),
        (
            |e| e.steps(1e-9, 1 << 50).every(1),
            "1125899906842625 recorded times",
        ),
        (
            |e| e.steps(1e-9, u64::MAX).every(1),
            "18446744073709551615 steps of 1e-9 from t = 0: at t = 18446744073",
        ),
        (
            |e| e.paths(u64::MAX).keep_final_states(true),
            "the final states of 18446744073709551615 paths",
        ),
        (
            |e| e.stop_on_failure(true).observe("bad", |_, _| f64::NAN),
            "path 0 failed after 0 steps",
        ),
    ];
    for (change, says) in cases {
        assert_says(change(sound(&method)).run().unwrap_err(), &[says]);
    }
    assert!(sound(&method).run().is_ok());
}

#[test]
fn what_is_missing_is_named() {
    let method = kubo();
    let start = State::new([1.0], [0.0]);
    let of = || Ensemble::new(&method);
    for (ensemble, says) in [
        (of().steps(0.1, 1).start(start), "`.paths(1000)`"),
        (of().paths(1).start(start), "`.steps(0.01, 1000)`"),
        (
            of().paths(1).steps(0.1, 1),
            "`.start(State::new([1.0], [0.0]))`",
        ),
    ] {
        assert_says(ensemble.run().unwrap_err(), &[says]);
    }
}

#[test]
fn replays_of_no_path() {
    let method = kubo();
    let error = sound(&method).replay(10).err().unwrap();
    assert_says(error, &["numbered from 0 to 10 − 1"]);
}

#[test]
#[should_panic(expected = "there is no observable `p`; there are [\"q\"]")]
fn a_name_that_is_not_there_panics() {
    let _ = &sound(&kubo()).run().unwrap()["p"];
}

/// The number of coordinates is written nowhere.
#[test]
fn final_states_are_read_as_states() {
    let method = kubo();
    let ensemble = sound(&method).keep_final_states(true);
    let summary = ensemble.run().unwrap();
    for (path, state) in summary.final_states() {
        let again = ensemble.replay(path).unwrap().last().unwrap().unwrap();
        assert_eq!(state, again);
        assert_eq!(state.state(), Some(again));
        assert_eq!(state.state::<[f64; 2]>(), None);
    }
    assert_eq!(summary.final_states().count(), 10);
}

/// The last of 2⁶⁴ − 1 paths, whose block is not full.
#[test]
fn the_largest_number_of_paths_is_counted_right() {
    let method = kubo();
    let of = 1 << 58;
    let ensemble = |shard| sound(&method).paths(u64::MAX).shard(shard, of);
    let last = ensemble(of - 1).run().unwrap();
    assert_eq!((last.paths(), last.counts()), (63, &[63, 63][..]));
    assert!(!last.is_complete());
    let mut both = ensemble(of - 2).run().unwrap();
    assert_eq!(both.paths(), 64);
    both.merge(last.clone()).unwrap();
    assert_eq!((both.paths(), both.counts()), (127, &[127, 127][..]));
    match both.merge(last) {
        Err(EnsembleError::Overlap { first, last }) => {
            assert_eq!((first, last), (u64::MAX - 63, u64::MAX - 1));
        }
        other => panic!("{other:?}"),
    }
    let first = ensemble(0);
    let last = first.replay(u64::MAX - 1);
    assert!(last.unwrap().all(|state| state.is_ok()));
}

#[test]
fn a_name_may_be_asked_for() {
    let summary = sound(&kubo()).run().unwrap();
    assert_eq!(summary.get("q"), Some(&summary["q"]));
    assert_eq!(summary.get("p"), None);
    assert!(summary.histogram("q").is_none());
    assert_eq!(summary.final_states().count(), 0);
    let text = summary.to_string();
    assert!(text.starts_with("10 paths, at t = 1\n  q  "), "{text}");
}

#[test]
fn histograms_count_every_path_in_its_bin() {
    let method = kubo();
    // multiples of 1/8, and of 1/10, whose borders are rounded
    for (low, high, bins) in [(-1.0, 1.0, 16), (-0.3, 0.7, 10)] {
        let draw = |path: u64, rng: &mut StartRng| {
            let edge = low + (high - low) * (path % 40) as f64 / bins as f64 - 0.1;
            let drawn = 0.5 * rng.normal();
            if path.is_multiple_of(2) { edge } else { drawn }
        };
        let summary = Ensemble::new(&method)
            .paths(500)
            .seed(6)
            .steps(0.1, 2)
            .every(1)
            .start(Starts::each(|path, rng| {
                State::new([draw(path, rng)], [0.0])
            }))
            .observe("q", |_, state| state.q[0])
            .histogram("q", low..high, bins)
            .histogram("q", low..high, Bins::at_end(bins))
            .run()
            .unwrap();
        let [each, end] = summary.histograms() else {
            panic!()
        };
        assert_eq!((each.rows(), end.rows()), (3, 1));
        assert_eq!(
            (each.counts(), each.counts_at(2)),
            (end.counts(), end.counts())
        );
        let edges = each.edges();
        assert_eq!((edges[0], edges[bins], edges.len()), (low, high, bins + 1));
        for row in 0..3 {
            // the states at that time, from an ensemble that ends there
            let all = each.counts_at(row).iter().sum::<u64>();
            assert_eq!(all + each.below_at(row) + each.above_at(row), 500);
        }
        let mut counts = vec![0; bins + 2];
        for q in drawn(500, 6, draw) {
            let bin = edges.iter().filter(|&&edge| q >= edge).count();
            counts[bin] += 1;
        }
        assert_eq!(each.below_at(0), counts[0]);
        assert_eq!(each.counts_at(0), &counts[1..=bins]);
        assert_eq!(each.above_at(0), counts[bins + 1]);
    }
}

#[test]
fn start_generators_differ_and_repeat() {
    let draw = |seed| {
        drawn(20_000, seed, |_, rng| {
            [rng.uniform(), rng.normal(), rng.normal(), rng.uniform()]
        })
    };
    let (first, again, other) = (draw(1), draw(1), draw(2));
    assert_eq!(first, again);
    assert!(first.iter().zip(&other).all(|(a, b)| a[0] != b[0]));
    let n = 20_000.0_f64;
    let mean = |f: &dyn Fn(&[f64; 4]) -> f64| first.iter().map(f).sum::<f64>() / n;
    // four standard errors each
    assert!((mean(&|x| x[0]) - 0.5).abs() < 4.0 * (1.0 / (12.0 * n)).sqrt());
    assert!((mean(&|x| (x[0] - 0.5) * (x[3] - 0.5))).abs() < 4.0 / 12.0 / n.sqrt());
    assert!(mean(&|x| x[1]).abs() < 4.0 / n.sqrt());
    assert!((mean(&|x| x[1] * x[1]) - 1.0).abs() < 4.0 * (2.0 / n).sqrt());
    assert!(mean(&|x| x[1] * x[2]).abs() < 4.0 / n.sqrt());
    // not those of the path's increments
    let dw = |path| Wiener::new(1).path(path).increment(0, 0, 1.0);
    let together = (0..).zip(&first).map(|(path, x)| dw(path) * x[1]);
    let together = together.sum::<f64>() / n;
    assert!(together.abs() < 4.0 / n.sqrt());
}

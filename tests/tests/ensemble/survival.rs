//! Survival with censoring: Kaplan and Meier's estimate from single events, exact laws of competing
//! ends, what is unknown, shards.

use sve_models::checks::{assert_close, assert_says, assert_within};
use sve_runtime::ensemble::Passages;
use sve_runtime::prelude::*;

use crate::runs::{drawn, run_in_parts};

/// Two free particles.
struct Pair;

#[variational(midpoint)]
impl Pair {
    fn lagrangian(&self, _q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1])
    }
}

type Method = Integrator<Pair, Midpoint>;

fn pair() -> Method {
    Integrator::new(Pair, Midpoint)
}

/// Pairs that start at 0 with velocities 1/a and 1/b arrive at 1 at the times a and b. The earlier
/// one stops the pair.
fn race<'a>(
    method: &'a Method,
    (paths, seed): (u64, u64),
    (h, steps): (f64, u64),
    times: impl Fn([f64; 2]) -> [f64; 2] + Sync + 'a,
) -> Ensemble<'a, Method> {
    Ensemble::new(method)
        .paths(paths)
        .seed(seed)
        .steps(h, steps)
        .start(Starts::each(move |_, rng| {
            let [a, b] = times([rng.uniform(), rng.uniform()].map(|u| -(1.0 - u).ln()));
            State::new([0.0; 2], [1.0 / a, 1.0 / b])
        }))
        .stop_at("event", |_, state| state.q[0] - 1.0)
        .stop_at("other end", |_, state| state.q[1] - 1.0)
}

fn last(passages: &Passages) -> (f64, f64) {
    let error = passages.survival_error();
    let last = |values: Vec<Option<f64>>| values.last().unwrap().unwrap();
    (last(passages.survival()), last(error))
}

/// Kaplan and Meier's estimate from single events, and Greenwood's error: `(time, has passed)`, in
/// the order of time, passages first.
fn kaplan_meier(ends: &[(f64, bool)], t: f64) -> (f64, f64) {
    let mut ends = ends.to_vec();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    let (mut survival, mut sum, mut n) = (1.0, 0.0, ends.len() as f64);
    for (time, has_passed) in ends {
        if time > t {
            break;
        }
        if has_passed {
            survival *= 1.0 - 1.0 / n;
            sum += 1.0 / (n * (n - 1.0));
        }
        n -= 1.0;
    }
    (survival, survival * f64::sqrt(sum))
}

/// Event of rate 1, other end of rate 1.5.
fn exponential([a, b]: [f64; 2]) -> [f64; 2] {
    [a, b / 1.5]
}

/// P(τ > 2) of exponential times, however long steps and recording intervals are.
#[test]
fn competing_exponential_times_have_their_survival() {
    let method = pair();
    let exact = f64::exp(-2.0);
    for (steps, every) in [(1, 1), (20, 20), (20, 4)] {
        let runs = 10;
        let mut squares = 0.0;
        for seed in 0..runs {
            let step = (2.0 / steps as f64, steps);
            let ensemble = race(&method, (10_000, seed), step, exponential);
            let summary = ensemble.every(every).run().unwrap();
            let (survival, error) = last(summary.passage("event").unwrap());
            // 10,000 e⁻⁵ paths are left, and Greenwood's sum is ∫ λ e^(2.5 t) dt/n
            let expected = exact * ((5.0_f64.exp() - 1.0) / 2.5 / 10_000.0).sqrt();
            assert!((error / expected - 1.0).abs() < 0.25, "{error} {expected}");
            let row = format!("{steps} {every} {seed}");
            assert_within(survival, exact, expected, 4.5, row);
            squares += ((survival - exact) / expected).powi(2);
        }
        // a sum of 10 squares: above 29.6 once in a thousand times
        assert!((1.0..29.6).contains(&squares), "{steps} {every}: {squares}");
    }
}

/// The rates have no constant ratio: events of rate 2t, P(τ > t) = e^(−t²), and other ends that
/// come early.
#[test]
fn rates_may_vary_against_one_another() {
    let method = pair();
    let times = |[a, b]: [f64; 2]| [a.sqrt(), 0.8 * b * b];
    for (steps, every) in [(1, 1), (12, 12), (9000, 9000)] {
        let paths = if steps > 1000 { 1000 } else { 20_000 };
        let ensemble = race(&method, (paths, 3), (1.2 / steps as f64, steps), times);
        let summary = ensemble.every(every).run().unwrap();
        let (survival, error) = last(summary.passage("event").unwrap());
        assert_within(survival, f64::exp(-1.44), error, 4.0, steps);
    }
}

/// The exact times of the ends are known: the estimate is that of the single events, up to ends
/// within 1/4096 of the run, and the same bits for any recorded times.
#[test]
fn the_estimate_is_that_of_single_events() {
    let method = pair();
    let run = |every| race(&method, (300, 5), (0.1, 20), exponential).every(every);
    let ends = drawn(300, 5, |_, rng| {
        let [a, b] = exponential([rng.uniform(), rng.uniform()].map(|u: f64| -(1.0 - u).ln()));
        (a.min(b), a < b)
    });
    let summary = run(1).run().unwrap();
    let event = summary.passage("event").unwrap();
    let (survival, errors) = (event.survival(), event.survival_error());
    for (record, &t) in summary.times().iter().enumerate() {
        let (exact, exact_error) = kaplan_meier(&ends, t);
        let (survival, error) = (survival[record].unwrap(), errors[record].unwrap());
        // an event and another end of n paths in one bin: 1/n² of the survival, for a few of them
        assert_close(&[survival], &[exact], 3e-4 * exact, t);
        assert_close(&[error], &[exact_error], 3e-3 * exact_error, t);
    }
    for every in [2, 5, 20] {
        let summary = run(every).run().unwrap();
        let other = summary.passage("event").unwrap();
        for (record, step) in (0..=20).step_by(every as usize).enumerate() {
            let found = (other.survival()[record], other.survival_error()[record]);
            assert_eq!(found, (survival[step], errors[step]), "{every} {step}");
        }
    }
}

/// Over many runs the estimate scatters as Greenwood's error says.
#[test]
fn estimates_scatter_as_their_errors_say() {
    let method = pair();
    let (runs, exact) = (300, f64::exp(-0.8));
    let (mut sum, mut squares, mut variances) = (0.0, 0.0, 0.0);
    for seed in 0..runs {
        let ensemble = race(&method, (192, 1000 + seed), (0.4, 2), exponential).threads(1);
        let summary = ensemble.run().unwrap();
        let (survival, error) = last(summary.passage("event").unwrap());
        sum += survival - exact;
        squares += (survival - exact).powi(2);
        variances += error * error;
    }
    let runs = runs as f64;
    let error = (variances / runs / runs).sqrt();
    assert_within(sum / runs, 0.0, error, 4.0, "survival");
    // a variance of 300 values has a relative error of √(2/300)
    let ratio = squares / variances;
    assert_within(ratio, 1.0, (2.0 / runs).sqrt(), 4.0, "variance");
}

/// Failures are at recorded times, or where a path stops. Those at recorded times come after the
/// passages until then.
#[test]
fn paths_that_fail_are_at_risk_until_then() {
    let method = pair();
    let paths = 200;
    let velocity = |path: u64| 0.25 + 1.75 * ((path * 37) % 1000) as f64 / 1000.0;
    #[allow(clippy::cast_sign_loss)] // values from 0.25 on
    let number = |v: f64| ((v - 0.25) / 1.75 * 1000.0).round() as u64;
    let summary = Ensemble::new(&method)
        .paths(paths)
        .steps(0.125, 24)
        .every(4)
        .start(Starts::each(|path, _| {
            State::new([0.0; 2], [velocity(path), 0.0])
        }))
        // every third path fails where its age is above 1.2
        .observe("age", |_, state| {
            if number(state.p[0]) % 3 == 0 {
                state.t
            } else {
                0.0
            }
        })
        .bound("age", ..=1.2)
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .run()
        .unwrap();
    let ends = (0..paths).map(|path| {
        let time = 1.0 / velocity(path);
        let fails = number(velocity(path)) % 3 == 0 && time > 1.2;
        (if fails { time.min(1.5) } else { time }, !fails)
    });
    let ends: Vec<(f64, bool)> = ends.collect();
    let wall = summary.passage("wall").unwrap();
    let is_between = |end: &&(f64, bool)| !end.1 && end.0 > 1.2 && end.0 < 1.5;
    assert!(ends.iter().filter(is_between).count() > 2 && wall.censored()[6] > 20);
    for (record, &t) in summary.times().iter().enumerate() {
        let (survival, error) = kaplan_meier(&ends, t);
        let found = [wall.survival(), wall.survival_error()].map(|x| x[record].unwrap());
        assert_close(&found, &[survival, error], 1e-14, record);
    }
    // passages and time at risk from t = 1 on, with the time of the censored paths
    let late = ends.iter().filter(|end| end.0 > 1.0);
    let (events, exposure) = late.fold((0, 0.0), |sum, end| {
        let has_passed = u64::from(end.1 && end.0 <= 3.0);
        (sum.0 + has_passed, sum.1 + end.0.min(3.0) - 1.0)
    });
    let rate = wall.rate(2);
    assert_eq!(rate.events, events);
    assert_close(&[rate.exposure], &[exposure], 1e-10, "time at risk");
}

/// Pairs of which the first particle never arrives, and the observable of some is not finite from a
/// time on.
fn lost(method: &Method, from: f64, speed: f64) -> Summary {
    Ensemble::new(method)
        .paths(100)
        .steps(0.25, 12)
        .every(4)
        .start(Starts::each(move |path, _| {
            State::new([0.0; 2], [if path < 50 { speed } else { 0.0 }, 1.0])
        }))
        .observe(
            "x",
            move |_, state| if state.t >= from { f64::NAN } else { 0.0 },
        )
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .run()
        .unwrap()
}

#[test]
fn survival_is_unknown_after_the_last_path_is_censored() {
    let method = pair();
    // at the start; at t = 1, which is recorded; after 50 paths have passed at t = 0.8
    let summaries = [
        lost(&method, 0.0, 0.0),
        lost(&method, 1.0, 0.0),
        lost(&method, 1.0, 1.25),
    ];
    let known = [vec![1.0], vec![1.0, 1.0], vec![1.0, 0.5]];
    for (summary, known) in summaries.iter().zip(known) {
        let wall = summary.passage("wall").unwrap();
        let mut expected: Vec<_> = known.iter().copied().map(Some).collect();
        expected.resize(4, None);
        assert_eq!(wall.survival(), expected);
        let has_error: Vec<_> = wall.survival_error().iter().map(Option::is_some).collect();
        let is_known: Vec<_> = expected.iter().map(Option::is_some).collect();
        assert_eq!(has_error, is_known);
        assert_eq!(wall.at_risk()[3], 0);
        let mut bytes = Vec::new();
        wall.write_csv(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        assert!(text.ends_with(",0,,\n") && !text.contains("NaN"), "{text}");
        let from = format!("survival unknown from t = {} on", known.len());
        assert_says(wall, &[&from]);
        assert_says(summary, &[&from]);
    }
    // another end stops the others within an interval, at t = 1.25
    let ensemble = Ensemble::new(&method)
        .paths(100)
        .steps(0.5, 6)
        .every(2)
        .start(Starts::each(|path, _| {
            State::new([0.0; 2], [if path < 50 { 1.25 } else { 0.0 }, 0.8])
        }))
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .stop_at("other end", |_, state| state.q[1] - 1.0);
    let summary = ensemble.run().unwrap();
    let wall = summary.passage("wall").unwrap();
    assert_eq!(wall.survival(), [Some(1.0), Some(0.5), None, None]);
    // where all pass, none survives, and that is known
    let summary = Ensemble::new(&method)
        .paths(100)
        .steps(0.5, 4)
        .every(2)
        .start(State::new([0.0; 2], [0.8, 0.0]))
        .stop_at("wall", |_, state| state.q[0] - 1.0)
        .run()
        .unwrap();
    let wall = summary.passage("wall").unwrap();
    assert_eq!(wall.survival(), [Some(1.0), Some(1.0), Some(0.0)]);
    assert_eq!(wall.survival_error(), [Some(0.0), Some(0.0), None]);
    assert!(!wall.to_string().contains("unknown"), "{wall}");
}

#[test]
fn threads_shards_and_stored_forms_have_the_same_bits() {
    let method = pair();
    let ensemble = || race(&method, (1000, 9), (0.1, 20), exponential).every(4);
    let whole = run_in_parts(ensemble, &[3], &[&[2, 0, 1]]);
    let text = serde_json::to_string(&whole).unwrap();
    let read: Summary = serde_json::from_str(&text).unwrap();
    assert_eq!(read.passages(), whole.passages());
    // another format, none, a bin beyond the run, and more ends than paths
    let other = text.replacen("\"format\":6", "\"format\":5", 1);
    let error = serde_json::from_str::<Summary>(&other).unwrap_err();
    let formats = "has format 5, and this version of sve reads format 6";
    assert_says(error, &[formats]);
    let old = text.replacen("\"format\":6,\"settings\"", "\"run\"", 1);
    let old = old.replacen("\"results\"", "\"nodes\"", 1);
    let error = serde_json::from_str::<Summary>(&old).unwrap_err();
    assert_says(error, &["missing field `format`"]);
    for (from, to) in [
        ("\"bins\":{\"", "\"bins\":{\"9999"),
        ("\"passed\":", "\"passed\":1"),
    ] {
        let damaged = text.replacen(from, to, 1);
        assert_ne!(damaged, text);
        assert!(serde_json::from_str::<Summary>(&damaged).is_err(), "{to}");
    }
}

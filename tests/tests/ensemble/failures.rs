//! Paths that fail are counted, described, left out of the statistics, and replayed. They do not
//! change the bits of other paths.

use sve_runtime::ensemble::{Cause, FAILURES_KEPT};
use sve_runtime::prelude::*;

use crate::runs::drawn;

/// A hard spring, whose explicit step overflows if the amplitude is too large.
#[derive(Clone, Debug)]
struct Spring {
    k: f64,
}

#[variational(endpoint)]
impl Spring {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.k * q.powi(4)
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.1 * q
    }
}

const PATHS: u64 = 500;
const H: f64 = 0.3;
const STEPS: u64 = 60;

fn start(rng: &mut StartRng) -> State<[f64; 1]> {
    State::new([rng.normal()], [rng.normal()])
}

fn spring() -> Integrator<Spring, Endpoint> {
    Integrator::new(Spring { k: 0.5 }, Endpoint)
}

fn ensemble(method: &Integrator<Spring, Endpoint>) -> Ensemble<'_, Integrator<Spring, Endpoint>> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(5)
        .steps(H, STEPS)
        .every(10)
        .start(Starts::each(|_, rng| start(rng)))
        .keep_final_states(true)
}

#[test]
fn are_counted_described_and_left_out() {
    let method = spring();
    let summary = ensemble(&method)
        .observe("q", |_, state| state.q[0])
        .run()
        .unwrap();
    let failed = summary.failed();
    assert!((20..PATHS - 20).contains(&failed), "{failed}");
    assert_eq!(summary.paths(), PATHS);
    assert_eq!(summary.failures().len() as u64, failed);
    assert_eq!(summary.final_states().count() as u64, PATHS - failed);

    // each path by itself, by the scalar step
    let starts = drawn(PATHS, 5, |_, rng| start(rng));
    let mut q = vec![Vec::new(); 7];
    let mut failures = summary.failures().iter();
    let mut ends = summary
        .final_states()
        .map(|(path, end)| (path, end.state().unwrap()));
    for path in 0..PATHS {
        let mut generator = starts[path as usize];
        let mut steps = 0;
        q[0].push(generator.q[0]);
        let trajectory = method.trajectory(generator, H, Wiener::new(5).path(path));
        let mut error = None;
        for next in trajectory.take(STEPS as usize) {
            match next {
                Ok(next) => {
                    steps += 1;
                    generator = next;
                    if steps % 10 == 0 {
                        q[steps as usize / 10].push(next.q[0]);
                    }
                }
                Err(e) => error = Some(e),
            }
        }
        match error {
            None => assert_eq!(ends.next(), Some((path, generator))),
            Some(error) => {
                let failure = failures.next().unwrap();
                assert_eq!((failure.path, failure.step), (path, steps));
                assert_eq!(failure.t, generator.t);
                assert_eq!(failure.cause, Cause::Step(error));
            }
        }
    }
    assert_eq!((failures.next(), ends.next()), (None, None));
    for (record, values) in q.iter().enumerate() {
        let count = values.len() as f64;
        let mean = values.iter().sum::<f64>() / count;
        assert_eq!(summary.counts()[record], values.len() as u64);
        let shown = summary["q"].mean()[record];
        let size = values.iter().map(|x| x.abs()).sum::<f64>() / count;
        assert!((shown - mean).abs() <= 1e-13 * size, "{shown} {mean}");
    }
}

#[test]
fn are_replayed() {
    let method = spring();
    let ensemble = ensemble(&method).observe("q", |_, state| state.q[0]);
    let summary = ensemble.run().unwrap();
    for failure in summary.failures().iter().take(20) {
        let items: Vec<_> = ensemble.replay(failure.path).unwrap().collect();
        assert_eq!(items.len() as u64, failure.step + 1);
        let (last, states) = items.split_last().unwrap();
        assert_eq!(last, &Err(failure.clone()));
        for (k, state) in (1..).zip(states) {
            assert_eq!(state.as_ref().unwrap().t, f64::from(k) * H);
        }
    }
    for (path, end) in summary.final_states().take(20) {
        let states: Vec<_> = ensemble.replay(path).unwrap().collect();
        assert_eq!(states.len() as u64, STEPS);
        assert_eq!(states.last(), Some(&Ok(end.state().unwrap())));
    }
}

#[test]
fn change_nothing_for_the_others() {
    let method = spring();
    let failing = |limit: f64| {
        ensemble(&method)
            .observe(
                "q",
                move |_, s| if s.q[0] > limit { f64::NAN } else { s.q[0] },
            )
            .run()
            .unwrap()
    };
    let (all, fewer) = (failing(f64::INFINITY), failing(1.0));
    assert!(fewer.failed() > all.failed());
    let mut all = all.final_states();
    for (path, end) in fewer.final_states() {
        assert_eq!(all.find(|(k, _)| *k == path), Some((path, end)));
    }
}

#[test]
fn of_observables_name_them() {
    let method = spring();
    let error = StepError::StepSize { h: 7.0 };
    let (given, starts) = (error.clone(), drawn(250, 5, |_, rng| start(rng)));
    // few enough that all failures are described
    let paths = 250;
    let summary = ensemble(&method)
        .paths(paths)
        .observe("fine", |_, _| 1.0)
        .observe("number", |_, s| {
            if s.t > 2.9 && s.q[0] > 0.0 {
                f64::INFINITY
            } else {
                0.0
            }
        })
        .observe("result", move |_, s| {
            if s.t == 0.0 && s.q[0] > 1.0 {
                Err(given.clone())
            } else {
                Ok(0.0)
            }
        })
        .run()
        .unwrap();
    let mut found = [0; 2];
    for failure in summary.failures() {
        match &failure.cause {
            Cause::Observable { name, error: e } => {
                assert_eq!((name.as_str(), e), ("result", &error));
                assert_eq!((failure.step, failure.t), (0, 0.0));
                assert!(starts[failure.path as usize].q[0] > 1.0);
                found[0] += 1;
            }
            Cause::NotFinite { name, value } => {
                assert_eq!((name.as_str(), *value), ("number", f64::INFINITY));
                assert!(failure.step >= 10 && failure.step % 10 == 0);
                found[1] += 1;
            }
            _ => {}
        }
    }
    assert!(found.iter().all(|&n| n > 20), "{found:?}");
    // left out of the statistics of all observables at once
    assert_eq!(summary["fine"].counts(), summary["result"].counts());
    assert_eq!(summary.counts()[0], paths - found[0]);
    assert_eq!(summary["fine"].variance()[0], 0.0);
}

#[test]
fn of_starts() {
    let method = spring();
    let summary = Ensemble::new(&method)
        .paths(200)
        .steps(H, 5)
        .start(Starts::each(|path, _| match path {
            0 | 64 => State::new([f64::NAN], [0.0]),
            17 => State::at(1.0, [0.0], [0.0]),
            130 => State::new([0.0], [f64::INFINITY]),
            _ => State::new([0.1], [0.0]),
        }))
        .observe("q", |_, state| state.q[0])
        .run()
        .unwrap();
    let of: Vec<_> = summary
        .failures()
        .iter()
        .map(|f| (f.path, f.step))
        .collect();
    assert_eq!(of, [(0, 0), (17, 0), (64, 0), (130, 0)]);
    assert_eq!(summary.counts(), [196, 196]);
    let what = |k: usize| summary.failures()[k].to_string();
    assert!(what(0).contains("q[0] is NaN"), "{}", what(0));
    assert!(what(1).contains("starts at t = 1"), "{}", what(1));
    assert!(what(3).contains("p[0] is inf"), "{}", what(3));
}

#[test]
fn of_all_paths_leave_statistics_of_none() {
    let method = spring();
    let summary = ensemble(&method)
        .observe("bad", |_, _| f64::NAN)
        .run()
        .unwrap();
    assert_eq!(summary.failed(), PATHS);
    assert_eq!(summary.failures().len(), FAILURES_KEPT);
    let of: Vec<_> = summary.failures().iter().map(|f| f.path).collect();
    assert!(of.iter().enumerate().all(|(k, &path)| path == k as u64));
    assert_eq!(summary.counts(), [0; 7]);
    assert!(summary["bad"].mean().iter().all(|x| x.is_nan()));
}

#[test]
fn end_the_run_where_that_is_wanted() {
    let method = spring();
    let first = ensemble(&method).run().unwrap().failures()[0].clone();
    for threads in [1, 2, 16] {
        let error = ensemble(&method)
            .stop_on_failure(true)
            .threads(threads)
            .run()
            .unwrap_err();
        match error {
            EnsembleError::Failed(failure) => assert_eq!(*failure, first),
            other => panic!("{other}"),
        }
    }
    let fine = ensemble(&method)
        .start(State::new([0.1], [0.0]))
        .stop_on_failure(true);
    assert_eq!(fine.run().unwrap().failed(), 0);
}

#[test]
fn that_end_a_run_are_the_lowest_even_if_a_later_one_is_first() {
    use std::sync::atomic::{AtomicBool, Ordering};
    let method = spring();
    let begun = AtomicBool::new(false);
    let ensemble = ensemble(&method)
        .start(Starts::each(|path, _| {
            match path {
                // another thread has the block of path 130; let it fail meanwhile
                70 => {
                    for _ in 0..100 {
                        std::thread::sleep(std::time::Duration::from_millis(5));
                        if begun.load(Ordering::Relaxed) {
                            break;
                        }
                    }
                    std::thread::sleep(std::time::Duration::from_millis(50));
                }
                130 => begun.store(true, Ordering::Relaxed),
                _ => return State::new([0.1], [0.0]),
            }
            State::new([f64::NAN], [0.0])
        }))
        .stop_on_failure(true)
        .threads(2);
    match ensemble.run() {
        Err(EnsembleError::Failed(failure)) => assert_eq!(failure.path, 70),
        other => panic!("{other:?}"),
    }
}

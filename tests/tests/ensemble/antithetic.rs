//! Antithetic pairs: the noise of their paths, the mean of linear observables, errors of even ones,
//! failures, shards.

use sve_models::assert_matches;
use sve_models::checks::assert_says;
use sve_runtime::noise::ThreePoint;
use sve_runtime::prelude::*;

use crate::runs::{KuboMethod, kubo, oscillator, run_in_parts};

const PATHS: u64 = 64 * 6 + 10;

/// Paths 2k and 2k + 1 have the increments of path k of the source, the second one with the other
/// sign.
#[test]
fn paths_have_opposite_increments() {
    let kubo = kubo();
    let (h, steps, first) = (0.05, 37, 5);
    let ensemble = |noise: &dyn Fn(Ensemble<'static, _>) -> Ensemble<'static, _>| {
        let kubo: &'static _ = Box::leak(Box::new(kubo.clone()));
        let ensemble = Ensemble::new(kubo)
            .paths(PATHS)
            .steps(h, steps)
            .start(State::new([1.0], [0.0]))
            .keep_final_states(true);
        noise(ensemble.antithetic(true))
    };
    let check = |ensemble: Ensemble<'_, KuboMethod>, dw: &dyn Fn(u64, u64) -> f64| {
        let summary = ensemble.run().unwrap();
        assert_eq!(summary.final_states().count() as u64, PATHS);
        for (path, end) in summary.final_states() {
            let sign = if path % 2 == 0 { 1.0 } else { -1.0 };
            let mut state = State::new([1.0], [0.0]);
            for step in 0..steps {
                kubo.step(&mut state, h, &[sign * dw(path / 2, step)])
                    .unwrap();
            }
            let off = (state.q[0] - end.q[0]).hypot(state.p[0] - end.p[0]);
            assert!(off < 1e-13, "{path} {off}");
        }
        let (path, end) = summary.final_states().nth(101).unwrap();
        let again = ensemble.replay(path).unwrap().last().unwrap().unwrap();
        assert_eq!((again.q[0], again.p[0]), (end.q[0], end.p[0]));
    };
    let wiener = |path: u64| Wiener::new(9).path(first + path);
    check(ensemble(&|e| e.noise(wiener(0))), &|path, step| {
        wiener(path).increment(step, 0, h)
    });
    let three = |path: u64| ThreePoint::new(9).path(path);
    check(ensemble(&|e| e.noise(three(0))), &|path, step| {
        three(path).increment(step, 0, h)
    });
    let largest = 2.0 * h.sqrt();
    let truncated = || Truncated::new(Wiener::new(9)).deviations(2.0).unwrap();
    check(ensemble(&|e| e.noise(truncated())), &|path, step| {
        let dw = Wiener::new(9).path(path).increment(step, 0, h);
        dw.clamp(-largest, largest)
    });
}

/// The position is linear in the noise: the mean of each pair is the motion without noise. Its
/// square, from a start at rest, is even: both paths of a pair have the same.
#[test]
fn odd_observables_have_no_error_and_even_ones_a_larger_one() {
    let method = oscillator(Midpoint);
    let ensemble = |start: f64| {
        Ensemble::new(&method)
            .paths(20_000)
            .seed(4)
            .steps(0.05, 40)
            .every(20)
            .start(State::new([start], [0.0]))
            .observe("q", |_, s| s.q[0])
            .observe("q²", |_, s| s.q[0] * s.q[0])
    };
    let mut exact = State::new([1.0], [0.0]);
    for _ in 0..40 {
        method.step(&mut exact, 0.05, &[0.0]).unwrap();
    }
    let pairs = ensemble(1.0).antithetic(true).run().unwrap();
    let (mean, error) = (pairs["q"].mean()[2], pairs["q"].standard_error()[2]);
    assert!(
        (mean - exact.q[0]).abs() < 1e-14 && error < 1e-16,
        "{mean} {error:e}"
    );
    // the variance is that between paths
    let plain = ensemble(1.0).run().unwrap();
    assert!((pairs["q"].variance()[2] / plain["q"].variance()[2] - 1.0).abs() < 0.1);
    let error = |antithetic| {
        let summary = ensemble(0.0).antithetic(antithetic).run().unwrap();
        summary["q²"].standard_error()[2]
    };
    // each error is known to 1.6 %: √(56/4n) for the fourth moments of a squared normal number, n =
    // 10⁴
    let ratio = error(true) / error(false);
    assert!((ratio / 2.0_f64.sqrt() - 1.0).abs() < 0.15, "{ratio}");
}

/// Starts of a pair have the same generator, and can be mirrored.
#[test]
fn starts_of_a_pair_have_the_same_numbers() {
    let method = oscillator(Midpoint);
    let summary = Ensemble::new(&method)
        .paths(1000)
        .seed(4)
        .steps(0.05, 40)
        .start(Starts::each(|path, rng| {
            let sign = if path % 2 == 0 { 1.0 } else { -1.0 };
            State::new([sign * rng.normal()], [sign * rng.normal()])
        }))
        .antithetic(true)
        .observe("q", |_, s| s.q[0])
        .run()
        .unwrap();
    for record in 0..2 {
        assert!(summary["q"].mean()[record].abs() < 1e-15);
        assert!(summary["q"].standard_error()[record] < 1e-16);
        assert!(summary["q"].variance()[record] > 0.5);
    }
}

/// A pair of which a path has failed does not count. Shards and threads have the bits of the whole.
#[test]
fn failures_and_shards() {
    let method = oscillator(Midpoint);
    let ensemble = || {
        Ensemble::new(&method)
            .paths(PATHS)
            .seed(4)
            .steps(0.05, 40)
            .start(State::new([1.0], [0.0]))
            .observe("q", |_, s| if s.q[0] > 1.5 { f64::NAN } else { s.q[0] })
            .antithetic(true)
    };
    let whole = run_in_parts(ensemble, &[], &[&[1, 2, 0]]);
    assert!(whole.failed() > 10);
    let left = Ensemble::new(&method)
        .paths(PATHS)
        .seed(4)
        .steps(0.05, 40)
        .start(State::new([1.0], [0.0]))
        .antithetic(true)
        .keep_final_states(true)
        .run()
        .unwrap();
    let ends: Vec<f64> = left.final_states().map(|(_, s)| s.q[0]).collect();
    let means: Vec<f64> = (ends.chunks(2))
        .filter(|pair| pair.iter().all(|&q| q <= 1.5))
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect();
    let n = means.len() as f64;
    let mean = means.iter().sum::<f64>() / n;
    let squares: f64 = means.iter().map(|x| (x - mean).powi(2)).sum();
    let error = (squares / (n - 1.0) / n).sqrt();
    assert!(
        (whole["q"].standard_error()[1] - error).abs() < 1e-15,
        "{error:e}"
    );
    let mut plain = ensemble().antithetic(false).shard(0, 3).run().unwrap();
    assert!(plain.merge(ensemble().shard(1, 3).run().unwrap()).is_err());
}

#[test]
fn what_supposes_independent_paths_is_refused() {
    let method = oscillator(Midpoint);
    let ensemble = |paths| {
        let ensemble = Ensemble::new(&method).paths(paths).steps(0.1, 2);
        let ensemble = ensemble.start(State::new([1.0], [0.0])).antithetic(true);
        ensemble.observe("q", |_, s| s.q[0])
    };
    assert_says(ensemble(9).run().unwrap_err(), &["9 paths are not pairs"]);
    for refused in [
        ensemble(10).covariance("q", "q"),
        ensemble(10).quantiles("q", 10),
    ] {
        assert_matches!(refused.run(), Err(EnsembleError::AntitheticPairs));
    }
}

/// Within a step the source knows the path of one increment, and not that of its mirror image.
#[test]
fn what_divides_steps_is_refused() {
    let method = oscillator(Midpoint);
    let ensemble = || {
        let ensemble = Ensemble::new(&method).paths(10).steps(0.1, 2);
        ensemble.start(State::new([1.0], [0.0])).antithetic(true)
    };
    for refused in [
        ensemble().stop_at("zero", |_, s| s.q[0]),
        ensemble().first_passage("zero", |_, s| s.q[0]),
        ensemble().refine(3),
    ] {
        assert_matches!(refused.run(), Err(EnsembleError::NotTogether { .. }));
    }
}

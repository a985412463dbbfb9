//! The multilevel method: its noise path by path, exact moments of its levels, bias, bits.

use std::collections::BTreeSet;
use std::sync::Mutex;
use std::time::Duration;

use sve_models::assert_matches;
use sve_models::checks::{assert_says, assert_within};
use sve_models::models::Oscillator;
use sve_runtime::ensemble::By;
use sve_runtime::noise::{Recorded, ThreePoint};
use sve_runtime::prelude::*;

use crate::exact::scheme;
use crate::runs::oscillator;

/// Without noise: every path is the same.
struct Swing {
    g: f64,
}

#[variational(endpoint)]
impl Swing {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

const H: f64 = 0.5;
const STEPS: u64 = 4;

type Method = Integrator<Oscillator, Endpoint>;

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(200)
        .seed(8)
        .steps(H, STEPS)
        .start(State::new([1.0], [0.0]))
        .observe("p", |_, s| s.p[0])
        .observe("q²", |_, s| s.q[0] * s.q[0])
}

/// Level l has the paths from l 2⁴⁸ on. Its coarse steps have the sums of the increments of its
/// fine steps.
#[test]
fn levels_are_differences_along_common_paths() {
    let method = oscillator(Endpoint);
    let estimate = ensemble(&method).multilevel("q²").run(0.3).unwrap();
    let levels = estimate.levels();
    assert_eq!(levels[0].paths % 64, 0);
    for (level, found) in (0_u32..).zip(levels) {
        let (h, steps) = (H / f64::from(1 << level), STEPS << level);
        assert_eq!((found.h, found.failed), (h, 0));
        let value = |noise: &Recorded, h| {
            let states = method.trajectory(State::new([1.0], [0.0]), h, noise.clone());
            states.last().unwrap().unwrap().q[0].powi(2)
        };
        let values: Vec<f64> = (0..found.paths)
            .map(|path| {
                let path = Wiener::new(8).path((u64::from(level) << 48) + path);
                let fine = Recorded::record(path, h, 1, steps as usize).unwrap();
                let coarse = if level > 0 {
                    value(&fine.coarsen(2).unwrap(), 2.0 * h)
                } else {
                    0.0
                };
                value(&fine, h) - coarse
            })
            .collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        assert!(
            (found.mean - mean).abs() < 1e-12,
            "{level} {} {mean}",
            found.mean
        );
        assert!((found.variance / variance - 1.0).abs() < 1e-10, "{level}");
        let made = if level == 0 { steps } else { steps + steps / 2 };
        assert_eq!(found.steps, made);
    }
    let mean: f64 = levels.iter().map(|level| level.mean).sum();
    assert_eq!(estimate.mean(), mean);
    assert_eq!(
        estimate.steps(),
        levels.iter().map(|l| l.steps * l.paths).sum::<u64>()
    );
}

/// The endpoint rule has weak order 1 here, so there is a bias to estimate. E q² = cos²t + σ²(t −
/// sin t cos t)/2.
#[test]
fn means_are_exact_to_their_errors() {
    let method = oscillator(Endpoint);
    let t = H * STEPS as f64;
    let exact = t.cos().powi(2) + 0.5 * (t - t.sin() * t.cos());
    for error in [0.1, 0.03, 0.01] {
        let estimate = ensemble(&method).multilevel("q²").run(error).unwrap();
        let mut before = 0.0;
        for (level, found) in (0_u32..).zip(estimate.levels()) {
            let steps = (STEPS << level) as usize;
            let law = scheme(&method, found.h).after([1.0, 0.0], steps);
            let mean = law.mean[0] * law.mean[0] + law.covariance[0][0];
            let row = format!("level {level}");
            assert_within(found.mean, mean - before, found.standard_error, 4.5, row);
            before = mean;
        }
        let bias = (before - exact).abs();
        assert!(
            bias < 1.5 * estimate.bias() && estimate.bias() < error,
            "{bias} {}",
            estimate.bias()
        );
        assert!((estimate.mean() - exact).abs() < bias + 4.5 * estimate.standard_error());
        // the variance is at its half of the squared error, up to blocks and the tolerance of 1 %
        assert!(estimate.standard_error() < 1.02 * error / 2.0_f64.sqrt());
        assert!(estimate.error() < 1.02 * error);
        // numbers of paths are in the ratio of √(variance/steps), where they are more than the
        // first ones
        let grown: Vec<_> = estimate
            .levels()
            .iter()
            .filter(|l| l.paths > 2000)
            .collect();
        for pair in grown.windows(2) {
            let wanted = |l: &sve_runtime::ensemble::Level| (l.variance / l.steps as f64).sqrt();
            let ratio = pair[0].paths as f64 / pair[1].paths as f64;
            assert!(
                (ratio / (wanted(pair[0]) / wanted(pair[1])) - 1.0).abs() < 0.1,
                "{ratio}"
            );
        }
    }
}

/// The variance of a difference falls like h² at strong order 1: a factor of 4 a level.
#[test]
fn variances_of_levels_fall_with_the_square_of_the_step() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method).paths(20_000);
    let estimate = ensemble.multilevel("q²").run(0.01).unwrap();
    for pair in estimate.levels()[2..].windows(2) {
        let ratio = pair[0].variance / pair[1].variance;
        assert!((3.3..4.7).contains(&ratio), "{ratio}");
    }
}

#[test]
fn threads_have_the_same_bits() {
    let method = oscillator(Endpoint);
    let run = |threads| {
        ensemble(&method)
            .threads(threads)
            .multilevel("q²")
            .run(0.03)
            .unwrap()
    };
    let estimate = run(1);
    assert_eq!(run(3), estimate);
    let text = estimate.to_string();
    assert!(
        text.starts_with("q²: ") && text.contains("level 2: h = 1.25e-1"),
        "{text}"
    );
}

/// The momentum is linear in the noise, so that pairs leave no variance on any level.
#[test]
fn antithetic_levels_have_the_variance_of_pairs() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method).antithetic(true);
    let estimate = ensemble.multilevel("p").run(0.01).unwrap();
    assert!(estimate.standard_error() < 1e-15);
    assert!(estimate.levels().iter().all(|level| level.paths == 256));
    let exact = -(H * STEPS as f64).sin();
    assert!((estimate.mean() - exact).abs() < 2.0 * estimate.bias() && estimate.bias() < 0.01);
}

#[test]
fn impossible_estimates_are_errors() {
    let method = oscillator(Endpoint);
    let of = || ensemble(&method);
    let deepest = |deepest, wanted| {
        let ensemble = of();
        ensemble.multilevel("q²").deepest(deepest).run(wanted)
    };
    assert_matches!(deepest(2, 0.03), Err(EnsembleError::Bias { level: 2, .. }));
    // a bias that no number of paths removes is seen before the 10⁹ paths for such an error are
    // made
    assert_matches!(deepest(2, 1e-5), Err(EnsembleError::Bias { level: 2, .. }));
    let few = deepest(1, 0.1);
    assert_matches!(few, Err(EnsembleError::TooFewLevels { deepest: 1 }));
    let error = |ensemble: Ensemble<'_, Method>, name: &str, wanted: f64| {
        ensemble.multilevel(name).run(wanted).unwrap_err()
    };
    let no_sums = error(of().noise(ThreePoint::new(1)), "q²", 0.1);
    assert_matches!(no_sums, EnsembleError::NoSums);
    let refined = Wiener::new(1).refine(2).unwrap();
    for (ensemble, setting) in [
        (of().noise(refined), "refined noise"),
        (of().refine(3), "refine"),
        (of().stop_at("x", |_, s| s.q[0]), "stop_at"),
        (of().first_passage("x", |_, s| s.q[0]), "first_passage"),
        (of().keep_final_states(true), "keep_final_states"),
    ] {
        let found = error(ensemble, "q²", 0.1).to_string();
        let expected = format!("`multilevel` and `{setting}` do not");
        assert!(found.starts_with(&expected), "{found}");
    }
    for part in [of().shard(0, 2), of().checkpoint("x.sve", Duration::ZERO)] {
        let found = error(part, "q²", 0.1);
        assert_matches!(found, EnsembleError::MultilevelInParts);
    }
    assert_says(error(of(), "q²", -1.0), &["the error -1e0"]);
    assert_says(error(of(), "x", 0.1), &["`x` to take the mean of"]);
    let none = of().observe("none", |_, s| if s.t > 0.0 { f64::NAN } else { 0.0 });
    assert_says(error(none, "none", 0.1), &["256 of 256", "level 0"]);
}

/// An average over [1, 4] has the same interval on all levels, and so has a derivative by a
/// parameter during some steps.
#[test]
fn steps_in_settings_are_those_of_the_coarsest_level() {
    let method = oscillator(Endpoint);
    let estimate = ensemble(&method)
        .noise(NoNoise)
        .steps(H, 8)
        .settle(2)
        .average("t", |_, s| s.t)
        .multilevel("t")
        .run(0.1)
        .unwrap();
    assert!((estimate.mean() - 2.5).abs() < 1e-14, "{estimate}");
    assert!(estimate.bias() < 1e-14, "{estimate}");

    // the sum of the levels is the mean of the last one where all paths are the same
    let method = Integrator::new(Swing { g: 2.0 }, Endpoint);
    let of = |level: u32| {
        Ensemble::new(&method)
            .paths(64)
            .steps(H / f64::from(1 << level), STEPS << level)
            .start(State::new([0.5], [0.0]))
            .gradient("x", [By::during("g", 1 << level..3 << level)], |s| s.q[0])
    };
    let estimate = of(0).multilevel("∂x/∂g in 1..3").run(0.05).unwrap();
    let last = estimate.levels().len() as u32 - 1;
    let expected = of(last).run().unwrap();
    let steps = 1 << last..3 << last;
    let expected = expected.derivative("x", By::during("g", steps)).unwrap();
    let difference = estimate.mean() - expected.mean()[1];
    assert!(difference.abs() < 1e-14, "{estimate} {difference}");
}

/// Each level has starts of its own, common to its two runs.
#[test]
fn levels_have_independent_random_starts() {
    let method = oscillator(Endpoint);
    let starts = Mutex::new(BTreeSet::new());
    let estimate = ensemble(&method)
        .start(Starts::each(|_, rng| {
            let q = rng.normal();
            starts.lock().unwrap().insert(q.to_bits());
            State::new([q], [0.0])
        }))
        .multilevel("q²")
        .run(0.3)
        .unwrap();
    let paths: u64 = estimate.levels().iter().map(|level| level.paths).sum();
    assert_eq!(starts.into_inner().unwrap().len() as u64, paths);
}

/// Where three of four paths fail, four times as many are run.
#[test]
fn paths_that_fail_do_not_count() {
    let method = oscillator(Endpoint);
    let wanted = 0.1;
    let estimate = ensemble(&method)
        .start(Starts::each(|path, _| {
            let q = if path % 4 == 0 { 1.0 } else { f64::NAN };
            State::new([q], [0.0])
        }))
        .multilevel("q²")
        .run(wanted)
        .unwrap();
    let level = &estimate.levels()[0];
    assert!(level.paths > 1000 && 4 * level.failed == 3 * level.paths);
    assert!(estimate.standard_error() < 1.02 * wanted / 2.0_f64.sqrt());
}

/// The largest of the last three differences, each scaled to the last level, over 2ʷ − 1.
#[test]
fn the_bias_follows_the_weak_order() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method);
    for order in [1.0, 1.5, 2.0] {
        let estimate = ensemble.multilevel("q²").weak_order(order).run(0.1);
        let estimate = estimate.unwrap();
        let factor = order.exp2();
        let differences = estimate.levels()[1..].iter().rev().take(3).zip(0..);
        let scaled = differences.map(|(level, k)| level.mean.abs() / factor.powi(k));
        let expected = scaled.fold(0.0, f64::max) / (factor - 1.0);
        let off = estimate.bias() / expected - 1.0;
        assert!(off.abs() < 1e-14, "{order}: {off:e}");
    }
}

//! The multilevel method where few paths have the mean: rare events against their exact
//! probabilities, values that do not differ, tails without a variance, means without a limit.

use std::f64::consts::PI;

use sve_models::assert_matches;
use sve_models::checks::assert_says;
use sve_models::models::Oscillator;
use sve_runtime::prelude::*;

use crate::exact::scheme;
use crate::runs::oscillator;

const H: f64 = 0.25;
const STEPS: u64 = 8;

type Method = Integrator<Oscillator, Endpoint>;

fn ensemble(method: &Method, seed: u64) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(1024)
        .seed(seed)
        .steps(H, STEPS)
        .start(State::new([0.0], [0.0]))
}

/// P(q > far) at the end of `steps` steps of length `h`: q is normal with a variance that the
/// recursion of the covariance gives.
fn probability(method: &Method, far: f64, h: f64, steps: u64) -> f64 {
    let end = scheme(method, h).after([0.0; 2], steps as usize);
    let variance = end.covariance[0][0];
    let x = far / (2.0 * variance).sqrt();
    // the continued fraction of erfc
    let fraction = (1..200)
        .rev()
        .fold(x, |below, k| x + 0.5 * f64::from(k) / below);
    0.5 * (-x * x).exp() / (PI.sqrt() * fraction)
}

/// P(q > 3.23) is 0.15 %: 1024 paths have one or two such ends, or none, and fewer that differ
/// between levels.
#[test]
fn probabilities_of_rare_events_are_within_their_errors() {
    let method = oscillator(Endpoint);
    let far = 3.23;
    let (mut squares, mut estimates) = (0.0, 0);
    for seed in 0..12 {
        // small errors of a few seeds: they take most of the time
        for wanted in [1e-3, 4e-4].into_iter().take(1 + usize::from(seed < 3)) {
            let ensemble =
                ensemble(&method, seed).observe("is far", move |_, s| f64::from(s.q[0] > far));
            let estimate = match ensemble.multilevel("is far").run(wanted) {
                Ok(estimate) => estimate,
                // no end of that kind on any level
                Err(EnsembleError::OneValue { value, paths, .. }) => {
                    assert_eq!((value, paths), (0.0, 1024));
                    continue;
                }
                Err(other) => panic!("{other}"),
            };
            let last = estimate.levels().len() as u32 - 1;
            let exact = probability(
                &method,
                far,
                estimate.levels()[last as usize].h,
                STEPS << last,
            );
            assert!((1.3e-3..1.8e-3).contains(&exact), "{exact}");
            assert!(estimate.error() < 1.05 * wanted, "{estimate}");
            let z = (estimate.mean() - exact) / estimate.standard_error();
            assert!(z.abs() < 4.5, "seed {seed}, {wanted}: {z}\n{estimate}");
            squares += z * z;
            estimates += 1;
        }
    }
    // the mean of about 12 squares, of which some belong to few events
    assert!(estimates >= 10, "{estimates}");
    let mean = squares / f64::from(estimates);
    assert!((0.2..2.5).contains(&mean), "{mean}");
}

#[test]
fn values_that_do_not_differ_are_no_estimate() {
    let method = oscillator(Endpoint);
    let never = ensemble(&method, 1).observe("never", |_, s| f64::from(s.q[0] > 30.0));
    let found = never.multilevel("never").run(1e-3).unwrap_err();
    let one = "all of the first 1024 paths of each level have one value of `never`, 0e0";
    assert_says(found, &[one, "fewer than one path in 341"]);
    let constant = || ensemble(&method, 1).observe("t", |_, s| s.t);
    let found = constant().multilevel("t").run(1e-3);
    assert_matches!(found, Err(EnsembleError::OneValue { .. }));
    // without noise every path is the same, and one is enough
    let found = constant().noise(NoNoise).multilevel("t").run(1e-3).unwrap();
    assert_eq!((found.mean(), found.error()), (H * STEPS as f64, 0.0));
    // random starts are noise
    let drawn = constant()
        .noise(NoNoise)
        .start(Starts::each(|_, rng| State::new([rng.normal()], [0.0])));
    let found = drawn.multilevel("t").run(1e-3);
    assert_matches!(found, Err(EnsembleError::OneValue { .. }));
}

/// Values that are the same on both levels of each path, and differ between paths: their levels are
/// run until a difference on 8 paths would change the mean by less than its error.
#[test]
fn levels_without_a_difference_have_enough_paths() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method, 2)
        .paths(64)
        .start(Starts::each(|_, rng| State::new([0.0], [rng.uniform()])))
        .fold(
            "start",
            |_, s| f64::from(s.p[0] < 0.3),
            |_, _, _| (),
            |x| *x,
        );
    let wanted = 0.02;
    let estimate = ensemble.multilevel("start").run(wanted).unwrap();
    assert!(
        (estimate.mean() - 0.3).abs() < 4.5 * estimate.standard_error(),
        "{estimate}"
    );
    for level in &estimate.levels()[1..] {
        assert_eq!((level.mean, level.variance), (0.0, 0.0));
        let least = 8.0 / (wanted / 2.0_f64.sqrt());
        assert!(level.paths as f64 > 0.98 * least, "{estimate}");
    }
}

/// Cauchy's distribution has no variance.
#[test]
fn tails_without_a_variance_are_an_error() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method, 3)
        .paths(64)
        .steps(1.0, 1)
        .start(Starts::each(|_, rng| {
            State::new([(PI * (rng.uniform() - 0.5)).tan()], [0.0])
        }))
        .observe("q", |_, s| s.q[0]);
    let found = ensemble.multilevel("q").run(0.01);
    assert_matches!(found, Err(EnsembleError::HeavyTails { carriers, .. }) if *carriers < 8.0);
    assert_says(found.unwrap_err(), &["tails are too heavy for a variance"]);
}

/// Sums over steps double with each level, with and without noise in them; a mean that grows by the
/// same amount each time has no limit either.
#[test]
fn means_without_a_limit_are_an_error() {
    let method = oscillator(Endpoint);
    let ensemble = ensemble(&method, 4)
        .fold("steps", |_, _| 0.0, |n, _, _| *n += 1.0, |n| *n)
        .fold(
            "work",
            |_, _| 0.0,
            |sum, _, s| *sum += s.p[0] * s.p[0],
            |sum| *sum,
        )
        .fold(
            "logarithm",
            |_, _| 0.0_f64,
            |n, _, _| *n += 1.0,
            |n| n.max(1.0).log2(),
        );
    for (name, ratio) in [("steps", 2.0), ("work", 2.0), ("logarithm", 1.0)] {
        let found = ensemble.multilevel(name).run(0.01);
        let Err(EnsembleError::NoLimit {
            level: 3, changes, ..
        }) = &found
        else {
            panic!("{name}: {found:?}");
        };
        for pair in changes.windows(2) {
            assert!(
                (pair[1] / pair[0] - ratio).abs() < 0.15,
                "{name}: {changes:?}"
            );
        }
        assert_says(found.unwrap_err(), &["the changes do not fall"]);
    }
    // the integral has a limit
    let integral = ensemble.integral("∫p²", |_, s| s.p[0] * s.p[0]);
    assert!(integral.multilevel("∫p²").run(0.1).is_ok());
}

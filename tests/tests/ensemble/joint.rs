//! Covariances, two-time covariances and quantiles against exact moments of the discrete motion,
//! and against all values.

use sve_models::assert_matches;
use sve_models::checks::{assert_says, assert_within};
use sve_models::gaussian::{Matrix, Scheme, product, transpose};
use sve_models::models::{Bath, Oscillator};
use sve_models::stepper::Stepper;
use sve_runtime::ensemble::Difference;
use sve_runtime::prelude::*;

use crate::exact::scheme;
use crate::runs::{kubo, oscillator, run_in_parts};

const PATHS: u64 = 20_000;
const START: [f64; 2] = [1.0, 0.0];

type Method = Integrator<Oscillator, Midpoint>;

fn ensemble(method: &Method) -> Ensemble<'_, Method> {
    Ensemble::new(method)
        .paths(PATHS)
        .seed(5)
        .steps(0.1, 60)
        .every(10)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, s| s.q[0])
        .observe("p", |_, s| s.p[0])
}

/// C₁ = A C₀ Aᵀ + h b bᵀ for equal times; C(s, t) = C(s) (A^(t−s))ᵀ for two times.
#[test]
fn covariances_are_those_of_the_recursion() {
    let method = oscillator(Midpoint);
    let summary = ensemble(&method)
        .covariance("q", "p")
        .covariance("q", "q")
        .two_time("q", "p")
        .two_time("p", "p")
        .run()
        .unwrap();
    let steps = scheme(&method, 0.1);
    let [qp, qq] = ["p", "q"].map(|of| summary.covariance("q", of).unwrap());
    for record in 1..=6 {
        let c = steps.after(START, 10 * record).covariance;
        for (found, exact) in [(&qp, c[0][1]), (&qq, c[0][0])] {
            let (covariance, error) = (found.covariance(), found.standard_error());
            assert_within(covariance[record], exact, error[record], 4.5, record);
        }
        // var(s₁₂) = (c₁₁ c₂₂ + c₁₂²)/(n − 1) for a Gaussian
        let exact = (c[0][0] * c[1][1] + c[0][1] * c[0][1]).sqrt() / (PATHS as f64 - 1.0).sqrt();
        assert!((qp.standard_error()[record] / exact - 1.0).abs() < 0.1);
        let variance = summary["q"].variance()[record];
        assert!((qq.covariance()[record] / variance - 1.0).abs() < 1e-12);
        assert!((qq.correlation()[record] - 1.0).abs() < 1e-12);
        let rho = c[0][1] / (c[0][0] * c[1][1]).sqrt();
        assert!((qp.correlation()[record] - rho).abs() < 5.0 / (PATHS as f64).sqrt());
    }
    assert_eq!((qp.covariance()[0], qp.standard_error()[0]), (0.0, 0.0));
    assert!(qp.correlation()[0].is_nan());
    let [two, momentum] = ["q", "p"].map(|of| summary.two_time(of, "p").unwrap());
    for s in 0..=6 {
        for t in 0..=6 {
            let exact = exact_two_time(&steps, 10 * s, 10 * t);
            if s * t > 0 {
                let variances = [s, t].map(|k| steps.after(START, 10 * k).covariance);
                // var(s₁₂) = (c₁₁ c₂₂ + c₁₂²)/(n − 1) for a Gaussian, of which fourth moments are
                // known to 3 %
                for (found, [first, second], exact) in [
                    (&two, [0, 1], exact[0][1]),
                    (&momentum, [1, 1], exact[1][1]),
                ] {
                    let (covariance, error) = (found.covariance(s, t), found.standard_error(s, t));
                    assert_within(covariance, exact, error, 4.5, format!("{s} {t}"));
                    let [a, b] = [variances[0][first][first], variances[1][second][second]];
                    let error = ((a * b + exact * exact) / (PATHS as f64 - 1.0)).sqrt();
                    let ratio = found.standard_error(s, t) / error;
                    assert!((ratio - 1.0).abs() < 0.1, "{s} {t} {ratio}");
                    let rho = exact / (a * b).sqrt();
                    let off = found.correlation(s, t) - rho;
                    assert!(off.abs() < 5.0 / (PATHS as f64).sqrt(), "{s} {t} {off}");
                }
            }
            let pair = [momentum.covariance(s, t), momentum.covariance(t, s)];
            assert_eq!(pair[0].to_bits(), pair[1].to_bits());
        }
        assert_eq!(two.covariance(s, s).to_bits(), qp.covariance()[s].to_bits());
    }
}

/// Covariances of the state at step `s` with that at step `t`.
fn exact_two_time(scheme: &Scheme<2>, s: usize, t: usize) -> Matrix<2> {
    let mut c = scheme.after(START, s.min(t)).covariance;
    for _ in 0..s.abs_diff(t) {
        c = product(&c, &transpose(&scheme.a));
    }
    if s <= t { c } else { transpose(&c) }
}

/// The midpoint rule keeps q and p independent with variance kT = σ²/2ν, so C(t) = kT Aᵗ.
#[test]
fn autocorrelations_of_a_bath_are_stationary() {
    let (omega, nu, sigma) = (1.0, 1.0, 2.0);
    let bath = Integrator::new(Bath { omega, nu, sigma }, Midpoint);
    let h = 0.2;
    let image = |q, p| {
        let end = bath.after(State::new([q], [p]), h, &[0.0], 1);
        [end.q[0], end.p[0]]
    };
    let (x, y) = (image(1.0, 0.0), image(0.0, 1.0));
    let summary = Ensemble::new(&bath)
        .paths(20_000)
        .seed(3)
        .steps(h, 12)
        .every(2)
        .start(Starts::each(|_, rng| {
            let s = 2.0_f64.sqrt();
            State::new([s * rng.normal()], [s * rng.normal()])
        }))
        .observe("q", |_, s| s.q[0])
        .two_time("q", "q")
        .run()
        .unwrap();
    let both = summary.two_time("q", "q").unwrap();
    assert_eq!(both.names(), ["q", "q"]);
    let mut power = [1.0, 0.0];
    for lag in 0..=6 {
        for s in 0..=6 - lag {
            let (found, error) = (both.covariance(s, s + lag), both.standard_error(s, s + lag));
            assert_within(found, 2.0 * power[0], error, 4.5, format!("{s} {lag}"));
            assert!(error < 0.04);
        }
        for _ in 0..2 {
            // the first row of the power of A, times A
            power = [
                power[0] * x[0] + power[1] * x[1],
                power[0] * y[0] + power[1] * y[1],
            ];
        }
    }
}

/// Fewer paths than values are exact; more are within the bound of the ranks.
#[test]
fn quantiles_are_those_of_all_values() {
    let method = oscillator(Midpoint);
    let summary = ensemble(&method)
        .quantiles("q", PATHS as usize)
        .quantiles("p", 300)
        .keep_final_states(true)
        .run()
        .unwrap();
    let sorted = |of: fn(&[f64], &[f64]) -> f64| {
        let mut values: Vec<f64> = summary.final_states().map(|(_, s)| of(s.q, s.p)).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (q, p) = (sorted(|q, _| q[0]), sorted(|_, p| p[0]));
    let (exact, sketch) = (
        summary.quantiles("q").unwrap(),
        summary.quantiles("p").unwrap(),
    );
    assert_eq!(exact.rank_error()[6], 0.0);
    let bound = sketch.rank_error()[6];
    assert!(
        bound > 0.0 && bound <= (PATHS as f64 / 300.0).log2().ceil() / 300.0,
        "{bound}"
    );
    for k in 0..=100_usize {
        let part = k as f64 / 100.0;
        #[allow(clippy::cast_sign_loss)] // a part of a number of paths
        let rank = ((part * PATHS as f64).ceil() as usize).max(1);
        assert_eq!(exact.quantile(part)[6], q[rank - 1]);
        let found = sketch.quantile(part)[6];
        let place = p.partition_point(|&x| x <= found) as f64;
        // a value that the sketch keeps has a weight of 128 at most
        let off = (place - rank as f64).abs() / PATHS as f64;
        assert!(off <= bound + 128.0 / PATHS as f64, "{part} {off} {bound}");
    }
    let [low, high] = sketch.interval(0.5, 3.0)[6];
    let middle = sketch.quantile(0.5)[6];
    assert!(low < middle && middle < high);
    assert_eq!(sketch.interval(0.0, 3.0)[6][0], f64::NEG_INFINITY);
    // all paths start at the same momentum
    assert_eq!(sketch.quantile(0.3)[0], 0.0);
}

/// A pair of times has the paths that have not failed until the later one, in several blocks.
#[test]
fn pairs_of_times_leave_out_paths_that_have_failed() {
    let (method, h, paths) = (oscillator(Midpoint), 0.1, 300);
    let bound = 1.2;
    let summary = Ensemble::new(&method)
        .paths(paths)
        .seed(5)
        .steps(h, 30)
        .every(10)
        .start(State::new([1.0], [0.0]))
        .observe("q", |_, s| if s.q[0] > bound { f64::NAN } else { s.q[0] })
        .observe("p", |_, s| s.p[0])
        .two_time("q", "p")
        .run()
        .unwrap();
    // positions and momenta at the recorded times, up to that of a failure
    let records: Vec<Vec<[f64; 2]>> = (0..paths)
        .map(|path| {
            let noise = Wiener::new(5).path(path);
            let states = method.trajectory(State::new([1.0], [0.0]), h, noise);
            let states = states.take(30).map(Result::unwrap).skip(9).step_by(10);
            let all = [[1.0, 0.0]]
                .into_iter()
                .chain(states.map(|s| [s.q[0], s.p[0]]));
            all.take_while(|[q, _]| *q <= bound).collect()
        })
        .collect();
    let two = summary.two_time("q", "p").unwrap();
    for s in 0..4 {
        for t in 0..4 {
            let alive = records.iter().filter(|path| path.len() > s.max(t));
            let pairs: Vec<_> = alive.map(|path| (path[s][0], path[t][1])).collect();
            let n = pairs.len() as f64;
            assert!(s.max(t) == 0 || (50.0..300.0).contains(&n), "{n}");
            let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / n;
            let (a, b) = (mean(|v| v.0), mean(|v| v.1));
            let sum: f64 = pairs.iter().map(|(x, y)| (x - a) * (y - b)).sum();
            let off = two.covariance(s, t) - sum / (n - 1.0);
            assert!(off.abs() < 1e-13, "{s} {t} {off:e}");
        }
    }
}

/// Shards and threads have the bits of the whole, with paths that fail.
#[test]
fn shards_merge_into_the_bits_of_the_whole() {
    let kubo = kubo();
    let ensemble = || {
        Ensemble::new(&kubo)
            .paths(64 * 10 + 7)
            .seed(3)
            .steps(0.05, 40)
            .every(10)
            .start(Starts::each(|_, rng| {
                State::new([rng.normal()], [rng.uniform()])
            }))
            .observe("q", |_, s| if s.q[0] > 2.0 { f64::NAN } else { s.q[0] })
            .observe("p", |_, s| s.p[0])
            .covariance("q", "p")
            .two_time("p", "q")
            .quantiles("p", 100)
    };
    let whole = run_in_parts(ensemble, &[2], &[&[1, 0], &[4, 0, 1, 2, 3]]);
    assert!(whole.failed() > 0);
    let other = |ensemble: Ensemble<'_, _>| {
        let shard = ensemble.shard(0, 2).run().unwrap();
        whole.clone().merge(shard).unwrap_err()
    };
    for (ensemble, statistic) in [
        (ensemble().covariance("q", "q"), "covariances"),
        (ensemble().quantiles("q", 100), "quantiles"),
    ] {
        assert_matches!(other(ensemble), EnsembleError::OtherRun { what: Difference::Statistic(name) } if *name == statistic);
    }
}

#[test]
fn names_and_sizes_are_checked() {
    let method = oscillator(Midpoint);
    let of = || ensemble(&method);
    let many = of().steps(1e-9, 1 << 21).every(1);
    for (refused, says) in [
        (of().covariance("q", "x"), "`x` to take a covariance of"),
        (of().quantiles("x", 10), "`x` to take quantiles of"),
        (of().quantiles("q", 1), "at least 2"),
        (many.two_time("q", "q"), "covariances of `q` and `q`"),
    ] {
        assert_says(refused.run().unwrap_err(), &[says]);
    }
}

//! Quantiles: the errors of their ranks over many seeds, extremes, threads and shards; intervals:
//! their ranks, and how often they contain the quantile of the distribution.

use sve_models::models::Kicked;
use sve_runtime::prelude::*;

use crate::runs::{free, run_in_parts};

/// Particles that stay where they start.
type Free = Integrator<Kicked, Midpoint>;

/// Values 1 to n: the value of a rank is the rank. The ends are beyond the ranks np ∓ z√(np(1 − p))
/// by less than 2.
#[test]
fn ends_have_the_ranks_of_so_many_deviations() {
    let (method, paths) = (free(), 1000_u16);
    let summary = Ensemble::new(&method)
        .paths(u64::from(paths))
        .steps(0.1, 1)
        .start(Starts::each(|path, _| {
            State::new([((path * 77) % 1000 + 1) as f64], [0.0])
        }))
        .observe("q", |_, state| state.q[0])
        .quantiles("q", 1000)
        .run()
        .unwrap();
    let quantiles = summary.quantiles("q").unwrap();
    assert_eq!(quantiles.rank_error(), [0.0, 0.0]);
    let n = f64::from(paths);
    for p in [0.05, 0.3, 0.5, 0.9] {
        assert_eq!(quantiles.quantile(p)[1], (n * p).ceil());
        for deviations in [0.0, 1.0, 3.0] {
            let half = deviations * (n * p * (1.0 - p)).sqrt();
            let [low, high] = quantiles.interval(p, deviations)[1];
            let (below, above) = (n * p - half - low, high - n * p - half);
            assert!((0.0..2.0).contains(&below), "{p} {deviations}: {low}");
            assert!((0.0..2.0).contains(&above), "{p} {deviations}: {high}");
        }
    }
    // 2 of 1000 values are not enough to tell 1/500 from 0
    assert_eq!(quantiles.interval(0.002, 2.0)[1][0], f64::NEG_INFINITY);
    assert_eq!(quantiles.interval(0.998, 2.0)[1][1], f64::INFINITY);
}

fn normals(method: &Free, size: usize, seed: u64) -> Ensemble<'_, Free> {
    Ensemble::new(method)
        .paths(6000)
        .seed(seed)
        .steps(0.1, 1)
        .start(Starts::each(|_, rng| State::new([rng.normal()], [0.0])))
        .observe("q", |_, state| state.q[0])
        .quantiles("q", size)
}

/// Ranks of quantiles of normal numbers, from many seeds: no part of the bound is a bias. The
/// deviation is below √2/size, the bound holds, the extremes are exact.
#[test]
fn ranks_are_right_in_the_mean_over_seeds() {
    const SIZES: [usize; 7] = [16, 33, 45, 100, 128, 250, 1000];
    const PARTS: [f64; 5] = [0.01, 0.1, 0.5, 0.9, 0.99];
    let method = free();
    let (paths, seeds) = (6000_u32, 60_u32);
    let mut sums = [[[0.0; 2]; PARTS.len()]; SIZES.len()];
    for seed in 0..seeds {
        let mut ensemble = normals(&method, 2, u64::from(seed)).keep_final_states(true);
        for size in SIZES {
            let name = size.to_string();
            ensemble = ensemble
                .observe(name.clone(), |_, state| state.q[0])
                .quantiles(name, size);
        }
        let summary = ensemble.run().unwrap();
        let mut sorted: Vec<f64> = summary.final_states().map(|(_, end)| end.q[0]).collect();
        sorted.sort_by(f64::total_cmp);
        for (size, sums) in SIZES.into_iter().zip(&mut sums) {
            let sketch = summary.quantiles(&size.to_string()).unwrap();
            assert_eq!(sketch.quantile(0.0)[1], sorted[0]);
            assert_eq!(sketch.quantile(1.0)[1], sorted[5999]);
            let bound = sketch.rank_error()[1];
            for (p, sums) in PARTS.into_iter().zip(sums) {
                let value = sketch.quantile(p)[1];
                let rank = sorted.partition_point(|&x| x <= value);
                let error = rank as f64 / f64::from(paths) - p;
                assert!(error.abs() < bound + 2e-4, "{size} {p}: {error} {bound}");
                sums[0] += error;
                sums[1] += error * error;
            }
        }
    }
    let n = f64::from(seeds);
    for (size, sums) in SIZES.into_iter().zip(sums) {
        for (p, [sum, squares]) in PARTS.into_iter().zip(sums) {
            let deviation = (squares / n).sqrt();
            assert!(deviation < 1.42 / size as f64, "{size} {p}: {deviation}");
            // nearer to the end than a few values of the sketch, an error has no room to both sides
            if p.min(1.0 - p) * size as f64 > 4.0 {
                let z = sum / n / (deviation / n.sqrt());
                assert!(z.abs() < 4.5, "{size} {p}: {z}");
            }
        }
    }
}

/// A rule that depended on the order of merges would differ here.
#[test]
fn threads_and_shards_have_the_same_quantiles() {
    let method = free();
    for size in [2, 33, 64, 200] {
        run_in_parts(|| normals(&method, size, 4), &[3], &[&[3, 0, 4, 2, 1]]);
    }
}

/// With two deviations 95 % of the intervals contain the quantile, and a few more, since the ends
/// are whole ranks.
#[test]
fn intervals_contain_the_quantile_as_often_as_they_say() {
    let method = free();
    let (runs, p) = (1000_u32, 0.3);
    let found = |seed: u32| {
        let summary = Ensemble::new(&method)
            .paths(192)
            .seed(u64::from(seed))
            .steps(0.1, 1)
            .start(Starts::each(|_, rng| State::new([rng.uniform()], [0.0])))
            .observe("q", |_, state| state.q[0])
            .quantiles("q", 192)
            .threads(1)
            .run()
            .unwrap();
        let [low, high] = summary.quantiles("q").unwrap().interval(p, 2.0)[1];
        low <= p && p <= high
    };
    let part =
        f64::from((0..runs).map(|seed| u32::from(found(seed))).sum::<u32>()) / f64::from(runs);
    // four standard errors of 0.0066 below 95.4 %; the widest interval that two more ranks on each
    // side allow contains 98.5 %
    assert!((0.928..0.998).contains(&part), "{part}");
}

#[test]
#[should_panic(expected = "0 or more")]
fn an_interval_of_no_width_is_a_mistake() {
    let method = free();
    let ensemble = Ensemble::new(&method).paths(4).steps(0.1, 1);
    let ensemble = ensemble.start(State::new([1.0], [0.0]));
    let summary = ensemble
        .observe("q", |_, s| s.q[0])
        .quantiles("q", 4)
        .run()
        .unwrap();
    let _ = summary.quantiles("q").unwrap().interval(0.5, f64::NAN);
}

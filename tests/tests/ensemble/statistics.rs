//! Statistics for which a simple formula would fail: constants, tiny and huge deviations, rounded
//! edges of histograms.

use sve_runtime::prelude::*;

use crate::runs::kubo;

fn summary(observable: impl Fn(f64) -> f64 + Sync) -> Summary {
    let method = kubo();
    // 300 paths are four blocks and a part of a fifth, with a part of a tile
    let ensemble = Ensemble::new(&method)
        .paths(300)
        .steps(0.1, 1)
        .start(Starts::each(|path, _| State::new([path as f64], [0.0])))
        .observe("x", |_, state| {
            observable(if state.t == 0.0 { state.q[0] } else { 0.0 })
        });
    ensemble.run().unwrap()
}

#[test]
fn a_constant_is_its_mean_and_has_no_variance() {
    for c in [0.1, -0.1, 1.0 / 3.0, 1e300, -1e-300, 5e-324, f64::MAX, 0.0] {
        let summary = summary(|_| c);
        let x = &summary["x"];
        assert_eq!((x.mean()[0], x.min()[0], x.max()[0]), (c, c, c));
        assert_eq!(x.variance()[0], 0.0, "{c}");
        assert_eq!(x.standard_error()[0], 0.0, "{c}");
    }
}

#[test]
fn a_mean_is_between_the_least_and_the_greatest_value() {
    for c in [0.1_f64, 0.7, 1e-310, -0.3] {
        // one value among many that are next to it
        for one in [0.0, 17.0, 64.0, 299.0] {
            let summary = summary(|path| if path == one { c.next_up() } else { c });
            let x = &summary["x"];
            let (mean, min, max) = (x.mean()[0], x.min()[0], x.max()[0]);
            assert!(min <= mean && mean <= max, "{min} {mean} {max}");
        }
    }
}

/// Deviations of any size, by two passes over the numbers of size 1.
#[test]
fn deviations_of_any_size_survive() {
    let unit = |path: f64| (path * 37.0) % 101.0 - 50.0;
    let values: Vec<f64> = (0..300).map(|path| unit(f64::from(path))).collect();
    let mean = values.iter().sum::<f64>() / 300.0;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    let deviation = (squares / 299.0).sqrt();
    for scale in [
        1e-320, 1e-300, 1e-200, 1e-160, 1e-130, 1.0, 1e130, 1e160, 1e200, 1e300,
    ] {
        let summary = summary(|path| unit(path) * scale);
        let x = &summary["x"];
        // the values themselves are rounded to units of 5e-324
        let allowed = 1e-13 + 5e-324 / scale;
        let close = |a: f64, b: f64| (a / b - 1.0).abs() <= allowed;
        let found = [x.standard_deviation()[0], x.standard_error()[0]].map(|x| x / scale);
        assert!(close(found[0], deviation), "{scale:e}");
        assert!(close(found[1], deviation / 300.0_f64.sqrt()), "{scale:e}");
        let off = (x.mean()[0] / scale - mean).abs();
        assert!(off <= 1e-13 * 50.0 + allowed * 50.0, "{scale:e}");
        let variance = deviation * scale * deviation * scale;
        if (1e-300..1e300).contains(&variance) {
            assert!(close(x.variance()[0], variance), "{scale:e}");
        }
    }
    // blocks of all three sizes in one column
    let size = |path: f64| match path {
        ..64.0 => 1e-250,
        64.0..128.0 => 1.0,
        _ => 1e250,
    };
    let summary = summary(|path| unit(path) * size(path));
    let large: Vec<f64> = (128..300).map(|path| unit(f64::from(path))).collect();
    let mean = large.iter().sum::<f64>() / 300.0;
    let squares = large.iter().map(|x| (x - mean).powi(2)).sum::<f64>() + 128.0 * mean * mean;
    let deviation = (squares / 299.0).sqrt();
    let found = summary["x"].standard_deviation()[0] / 1e250;
    assert!(
        (found / deviation - 1.0).abs() < 1e-13,
        "{found} {deviation}"
    );
}

#[test]
fn edges_of_histograms_are_the_nearest_numbers() {
    let method = kubo();
    let ensemble = Ensemble::new(&method)
        .paths(3)
        .steps(0.1, 1)
        .start(Starts::each(|path, _| {
            let starts = [-0.5_f64, (-0.5_f64).next_down(), 2.5];
            State::new([starts[path as usize]], [0.0])
        }))
        .observe("q", |_, state| state.q[0])
        .histogram("q", -3.0..3.0, 12);
    let summary = ensemble.run().unwrap();
    let histogram = summary.histogram("q").unwrap();
    let halves: Vec<f64> = (-6..=6).map(|k| 0.5 * f64::from(k)).collect();
    assert_eq!(histogram.edges(), halves);
    let mut expected = [0; 12];
    (expected[4], expected[5], expected[11]) = (1, 1, 1);
    assert_eq!(histogram.counts_at(0), expected);
}

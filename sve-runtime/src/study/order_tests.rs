//! Orders of errors that are known.

use super::{Convergence, ErrorOf, Level, fit};
use crate::study::Estimate;

/// Returns a level of 2ᵏ steps of 2⁻ᵏ with one error.
fn level(k: i32, error: f64) -> Level {
    Level {
        ln_h: f64::from(-k) * 2.0_f64.ln(),
        steps: 1 << k,
        of_paths: vec![error * error],
    }
}

/// Errors as a function of the step size, without noise.
fn of(error: impl Fn(f64) -> f64, exponents: impl IntoIterator<Item = i32>) -> Convergence {
    let levels = exponents
        .into_iter()
        .map(|k| level(k, error(0.5_f64.powi(k))));
    fit(levels.collect(), ErrorOf::Squares, 1.0, false)
}

fn order(convergence: Convergence) -> (Estimate, usize) {
    match convergence {
        Convergence::Asymptotic(order, points) => (order, points),
        Convergence::Unsettled(slopes) => panic!("not asymptotic: {slopes:?}"),
    }
}

fn slopes(convergence: Convergence) -> Vec<f64> {
    match convergence {
        Convergence::Asymptotic(order, points) => panic!("{order:?} from {points}"),
        Convergence::Unsettled(slopes) => slopes.iter().map(|slope| slope.value).collect(),
    }
}

#[test]
fn a_power_has_its_order() {
    // in any order of the step sizes; the first is saturated, the last is rounding
    let (order, points) = order(of(|h| h.powf(1.5), [5, 1, 6, 4, 28]));
    assert_eq!(points, 3);
    assert!((order.value - 1.5).abs() < 1e-14 && order.standard_error < 1e-13);
}

/// For every mixture of two powers an order that is reported is right within its error; at fine
/// steps it is reported, where the powers change places it is not.
#[test]
fn an_order_is_right_within_its_error_or_not_reported() {
    let (mut reported, mut changing) = (0, 0);
    for (p, r) in [(0.5, 0.5), (0.5, 1.0), (1.0, 1.0), (2.0, 2.0), (4.0, 1.0)] {
        for b in [-0.5_f64, 0.0, 0.1, 1.0, 10.0, 100.0] {
            for finest in 4..12 {
                let error = |h: f64| 1e-3 * h.powf(p) * (1.0 + b * h.powf(r)).abs();
                let second = b.abs() * 0.5_f64.powf(r * f64::from(finest));
                match of(error, finest - 4..=finest) {
                    // So far from the change of the powers, the errors do not show it; errors below
                    // rounding are left out.
                    _ if second > 8.0 || error(0.5_f64.powi(finest)) < 1e-11 => {}
                    Convergence::Asymptotic(order, _) => {
                        let case = format!("h^{p} (1 + {b} h^{r}), 2^{finest} steps: {order:?}");
                        let off = (order.value - p).abs();
                        assert!(off <= order.standard_error + 1e-12, "{case}");
                        assert!(order.standard_error <= 0.25);
                        reported += 1;
                    }
                    Convergence::Unsettled(_) => {
                        assert!(second > 0.005, "h^{p} (1 + {b} h^{r}), 2^{finest} steps");
                        changing += 1;
                    }
                }
            }
        }
    }
    println!("{reported} orders, {changing} without");
    assert!(reported > 120 && changing > 20);
}

#[test]
fn slopes_that_have_not_settled_are_no_order() {
    // two powers that change places
    let changing = slopes(of(|h| h.powi(4) + 1e-4 * h, 2..=6));
    println!("{changing:?}");
    assert!(changing.len() == 4 && changing[0] > 3.5 && changing[3] < 2.0);
    // an error that changes its sign on the way
    let crossing = slopes(of(|h| (h - 0.03).abs() * h, 3..=7));
    assert_eq!(crossing.len(), 4);
    // Two step sizes have one slope; fewer step sizes have no slope.
    assert_eq!(slopes(of(|h| h, [5, 6])).len(), 1);
    assert!(slopes(of(|h| h, [5])).is_empty());
    assert!(slopes(of(|_| 1.0, 1..=9)).is_empty());
}

/// Checks that a single path gives no standard error.
#[test]
fn one_random_path_has_no_order() {
    let levels = (4..8).map(|k| level(k, 0.5_f64.powi(k)));
    assert!(matches!(
        fit(levels.collect(), ErrorOf::Squares, 1.0, true),
        Convergence::Unsettled(slopes) if slopes.len() == 3
    ));
}

/// Errors in proportion to h on each path: all slopes are 1. Errors that are shared between step
/// sizes do not blur the slope, others do.
#[test]
fn the_scatter_between_paths_is_in_the_error() {
    let shared = |path: usize| 1e-3 * (1.0 + (path % 7) as f64);
    let level = |k: i32, tilt: f64| Level {
        ln_h: f64::from(-k) * 2.0_f64.ln(),
        steps: 1 << k,
        of_paths: (0..100)
            .map(|path| 0.25_f64.powi(k) * shared(path) * (1.0 + tilt * (path % 3) as f64))
            .collect(),
    };
    let (same, _) = order(fit(
        [4, 3, 2].map(|k| level(k, 0.0)).into(),
        ErrorOf::Squares,
        1.0,
        true,
    ));
    assert!((same.value - 1.0).abs() < 1e-13 && same.standard_error < 1e-13);
    let levels = vec![level(3, 0.0), level(2, 1.0)];
    let Convergence::Unsettled(slopes) = fit(levels, ErrorOf::Squares, 1.0, true) else {
        panic!("two step sizes");
    };
    // of squares u and w u: the variance of Σwu/Σu − w̄ is Σ(w − w̄)²u²/(Σu)², and the slope is its
    // logarithm over 2 ln 2
    let (mut s, mut sw) = (0.0, 0.0);
    for path in 0..100 {
        s += shared(path);
        sw += shared(path) * (1.0 + (path % 3) as f64);
    }
    let w = sw / s;
    let variance: f64 = (0..100)
        .map(|path| ((1.0 + (path % 3) as f64 - w) * shared(path) / s).powi(2))
        .sum();
    let expected = variance.sqrt() / w / (2.0 * 2.0_f64.ln());
    let slope = slopes[0];
    assert!((slope.value - 1.0 - w.ln() / (2.0 * 2.0_f64.ln())).abs() < 1e-13);
    // ten batches of such regular paths know it to a factor, not to a digit
    assert!(slope.standard_error < 2.0 * expected && slope.standard_error > 0.1 * expected);
}

/// Weak errors, the means of differences: of either sign, with scatter that is the same at all step
/// sizes or grows with them, and dropped where they are scatter or have another sign.
#[test]
fn weak_errors_have_orders_where_they_are_no_scatter() {
    let level = |k: i32, error: f64, scatter: f64| Level {
        ln_h: f64::from(-k) * 2.0_f64.ln(),
        steps: 1 << k,
        // deviations with the mean 0
        of_paths: (0..99)
            .map(|path| error + scatter * (f64::from(path % 3) - 1.0))
            .collect(),
    };
    let weak = |levels: Vec<Level>| fit(levels, ErrorOf::Differences, 1.0, true);
    let h = |k: i32| 0.5_f64.powi(k);
    let levels = |exponents: core::ops::RangeInclusive<i32>, scatter: f64| {
        let level = |k| level(k, -h(k).powi(2), scatter);
        exponents.map(level).collect::<Vec<_>>()
    };
    let (exact, points) = order(weak(levels(2..=6, 0.0)));
    assert!((exact.value - 2.0).abs() < 1e-12 && points == 5);
    // a mean of 99 numbers with deviations 0 and ± s has the standard error s √(2/3/98)
    let (blurred, points) = order(weak(levels(2..=4, 1e-3)));
    assert!(points == 3 && blurred.standard_error > 1e-3);
    assert!((blurred.value - 2.0).abs() <= 2.0 * blurred.standard_error);
    let known = slopes(weak(levels(4..=9, 1e-3)));
    assert_eq!(known.len(), 1); // 4 h² against 8.2e-5: h = 1/16 and 1/32 are above four of these
    // a change of sign between step sizes is no slope
    let crossing = |k: i32| level(k, h(k) * (h(k) - 0.02), 0.0);
    let found = weak((3..=9).map(crossing).collect());
    assert!(slopes(found).len() == 3, "those of h < 0.02");
}

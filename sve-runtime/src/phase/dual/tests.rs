//! Functions of dual numbers against differences.

use super::Dual;

/// Checks a function against differences of the fourth order.
fn check(name: &str, function: impl Fn(Dual) -> Dual, plain: impl Fn(f64) -> f64, x: f64) {
    let dual = function(Dual {
        value: x,
        slope: 1.0,
        is_constant: false,
    });
    assert!(
        (dual.value - plain(x)).abs() <= 2e-15 * plain(x).abs(),
        "{name}"
    );
    let d = 1e-3;
    let difference = |d: f64| (plain(x + d) - plain(x - d)) / (2.0 * d);
    let expected = (4.0 * difference(d) - difference(2.0 * d)) / 3.0;
    let error = (dual.slope - expected).abs();
    assert!(
        error < 1e-8 * (1.0 + expected.abs()),
        "{name}: {} {expected}",
        dual.slope
    );
}

macro_rules! all {
    ($($name:ident at $x:expr),*) => {$( check(stringify!($name), Dual::$name, f64::$name, $x); )*};
}

#[test]
fn derivatives_of_functions() {
    all! {
        sqrt at 1.7, cbrt at -1.3, exp at 0.4, exp2 at -0.7, exp_m1 at 0.3, ln at 1.9, ln_1p at 0.4, log2 at 2.1, log10 at 1.4,
        sin at 0.9, cos at -0.6, tan at 0.7, asin at 0.3, acos at -0.4, atan at 1.2, sinh at 0.8, cosh at -0.5, tanh at 0.6,
        asinh at -0.9, acosh at 1.8, atanh at 0.35, recip at -1.6
    }
    check("powi", |x| x.powi(-3), |x| x.powi(-3), 1.3);
    check("powi 0", |x| x.powi(0) + x.powi(1), |x| 1.0 + x, 0.0);
    check("powf", |x| x.powf(1.7), |x| x.powf(1.7), 0.8);
    check("hypot", |x| x.hypot(2.0), |x| x.hypot(2.0), -1.1);
    check(
        "atan2",
        |x| x.atan2(x * x - 2.0),
        |x| x.atan2(x * x - 2.0),
        0.9,
    );
}

#[test]
fn derivatives_of_operators() {
    let plain = |x: f64| (2.0 - x) * x / (x * x + 0.5) - 3.0 * x + (1.0 / x).mul_add(x, x);
    let dual = |x: Dual| (2.0 - x) * x / (x * x + 0.5) - 3.0 * x + (1.0 / x).mul_add(x, x);
    check("quotient", dual, plain, 0.7);
    let sum = |x: Dual| {
        let mut y = x;
        y += x * x;
        y -= 0.5;
        y *= x;
        y /= 1.0 + x;
        [y, -x, x.sin_cos().0].into_iter().sum()
    };
    let plain = |x: f64| (x + x * x - 0.5) * x / (1.0 + x) - x + x.sin();
    check("sum", sum, plain, 0.4);
}

//! Derivatives, as emitted code computes them, at points where a plain formula is 0/0, 0·∞ or
//! overflows; and points without a derivative, where the result must not be finite.

use super::formula::Formula;
use super::stable::{computed, units};
use crate::algebra::elementary::{Double, of};
use crate::algebra::{Arena, Purpose, Symbol};

/// Differentiates a formula in the listed variables, and evaluates the derivative at a point.
fn derivative(formula: &str, by: &[u32], at: [f64; 2]) -> f64 {
    let mut arena = Arena::new();
    let mut expr = Formula::new(formula).build(&mut arena);
    for &i in by {
        expr = arena.diff(expr, Symbol(i));
    }
    arena.stabilise(Purpose::Values, vec![&mut expr]);
    computed(&arena, expr, &[at[0], at[1], 0.0, 0.0])
}

/// Checks a derivative to four roundings.
#[track_caller]
fn check(formula: &str, by: &[u32], at: [f64; 2], expected: f64) {
    let found = derivative(formula, by, at);
    assert!(
        (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs(),
        "{formula} by {by:?} at {at:?}: {found} for {expected}"
    );
}

#[test]
fn constant_powers_at_zero() {
    const INFINITE: f64 = f64::INFINITY;
    // exponent, and its first three derivatives at 0
    for (k, expected) in [
        ("0.0", [0.0, 0.0, 0.0]),
        ("1.0", [1.0, 0.0, 0.0]),
        ("2.0", [0.0, 2.0, 0.0]),
        ("3.0", [0.0, 0.0, 6.0]),
        ("0.5", [INFINITE, -INFINITE, INFINITE]),
        ("1.5", [0.0, INFINITE, -INFINITE]),
        ("2.5", [0.0, 0.0, INFINITE]),
        ("3.5", [0.0, 0.0, 0.0]),
        ("0.3", [INFINITE, -INFINITE, INFINITE]),
        ("1.3", [0.0, INFINITE, -INFINITE]),
        ("2.3", [0.0, 0.0, INFINITE]),
        ("70.0", [0.0, 0.0, 0.0]),
    ] {
        for (order, expected) in (1..).zip(expected) {
            let power = format!("x.powf({k})");
            let found = derivative(&power, &vec![0; order], [0.0, 0.0]);
            assert_eq!(found, expected, "derivative {order} of {power}");
        }
    }
    // and away from 0
    check("x.powf(1.5)", &[0], [4.0, 0.0], 3.0);
    check("x.powf(2.5)", &[0, 0], [4.0, 0.0], 7.5);
    check("x.powf(-0.5)", &[0], [4.0, 0.0], -1.0 / 16.0);
}

#[test]
fn roots_beside_their_radicands() {
    // 3 |x| x y^(3/2) is smooth enough at 0 once
    let whole = "(x.powi(2) * y).powf(1.5)";
    check(whole, &[0], [0.0, 2.0], 0.0);
    check(whole, &[1], [0.0, 2.0], 0.0);
    check(whole, &[0], [-2.0, 4.0], -96.0);
    // the radicand is a sum
    check("(1.0 - x).powf(1.5)", &[0], [1.0, 0.0], 0.0);
    check("(1.0 - x).powf(1.5)", &[0], [-3.0, 0.0], -3.0);
    // |x| x has the derivative 2 |x|, and |x| has none at 0
    for (x, expected) in [(0.0, 0.0), (-3.0, 6.0), (3.0, 6.0)] {
        let found = derivative("x * x.powi(2).sqrt()", &[0], [x, 0.0]);
        assert_eq!(found, expected);
    }
    let modulus = |x| derivative("x.powi(2).sqrt()", &[0], [x, 0.0]);
    assert!(modulus(0.0).is_nan());
    assert_eq!(modulus(-3.0), -1.0);
}

#[test]
fn variable_powers() {
    let power = "x.powf(y)";
    for zero in [0.0, -0.0] {
        for by in [
            &[0][..],
            &[1],
            &[1, 1],
            &[0, 1],
            &[1, 0],
            &[0, 0],
            &[1, 1, 1],
        ] {
            assert_eq!(derivative(power, by, [zero, 2.5]), 0.0, "{by:?}");
        }
        assert_eq!(derivative(power, &[0], [zero, 1.0]), 1.0);
        assert_eq!(derivative(power, &[1], [zero, 0.5]), 0.0);
        // x^y has no derivatives there
        assert!(!derivative(power, &[0], [zero, 0.5]).is_finite());
        assert!(!derivative(power, &[1], [zero, 0.0]).is_finite());
        assert!(!derivative(power, &[0, 1], [zero, 1.0]).is_finite());
    }
    assert!(derivative(power, &[1], [-2.0, 2.0]).is_nan());
    let ln = std::f64::consts::LN_2;
    for (by, expected) in [
        (&[1][..], 8.0 * ln),
        (&[1, 1], 8.0 * ln * ln),
        (&[0], 12.0),
        (&[0, 0], 12.0),
        (&[0, 1], 4.0 + 12.0 * ln),
        (&[1, 0], 4.0 + 12.0 * ln),
        (&[0, 1, 1], 8.0 * ln + 12.0 * ln * ln),
    ] {
        check(power, by, [2.0, 3.0], expected);
    }
    // a constant base keeps its logarithm as a constant
    check("2.0.powf(y)", &[1, 1], [0.0, 3.0], 8.0 * ln * ln);
}

#[test]
fn zero_times_anything_is_zero() {
    for k in [-3, -1, 0, 1, 2] {
        let none = format!("0.0 * x.powi({k})");
        assert_eq!(derivative(&none, &[], [0.0, 0.0]), 0.0);
        assert_eq!(derivative(&none, &[0], [0.0, 0.0]), 0.0);
    }
}

/// Returns points in all quadrants and on the axes, of all sizes whose reciprocals exist.
fn around() -> Vec<[f64; 2]> {
    let corners = [
        [3.0, 4.0],
        [-3.0, 4.0],
        [3.0, -4.0],
        [-3.0, -4.0],
        [5.0, 0.0],
        [-5.0, 0.0],
        [0.0, 5.0],
        [0.0, -5.0],
        [4.0, 3.0],
    ];
    let sizes = [1.0, 1e-200, 1e-100, 1e100, 1e200];
    let scaled = |size: f64| corners.map(|c| c.map(|x| x * size));
    sizes.into_iter().flat_map(scaled).collect()
}

#[test]
fn hypot_and_atan2_everywhere_but_the_origin() {
    let (hypot, angle) = ("x.hypot(y)", "y.atan2(x)");
    for [x, y] in around() {
        // computed from numbers of the size of 1, and the size
        let r = x.hypot(y);
        let (u, w) = (x / r, y / r);
        let second = 1.0 / r;
        let inverse = second * second;
        let table: [(&str, &[u32], f64); 10] = [
            (hypot, &[0], u),
            (hypot, &[1], w),
            (hypot, &[0, 0], w * w * second),
            (hypot, &[0, 1], -u * w * second),
            (hypot, &[1, 1], u * u * second),
            (angle, &[0], -w * second),
            (angle, &[1], u * second),
            (angle, &[0, 0], 2.0 * u * w * inverse),
            (angle, &[1, 1], -2.0 * u * w * inverse),
            (angle, &[0, 1], (w * w - u * u) * inverse),
        ];
        for (formula, by, expected) in table {
            let found = derivative(formula, by, [x, y]);
            if !expected.is_finite() {
                // an infinite derivative may show as any number that is not finite
                assert!(
                    !found.is_finite(),
                    "{formula} by {by:?}: {found} at {x}, {y}"
                );
                continue;
            }
            assert!(
                (found - expected).abs() <= 8.0 * f64::EPSILON * expected.abs(),
                "{formula} by {by:?}: {found} for {expected} at {x}, {y}"
            );
        }
        assert_eq!(derivative(angle, &[], [x, y]), y.atan2(x));
    }
    for by in [&[0][..], &[1]] {
        assert!(derivative(hypot, by, [0.0, 0.0]).is_nan());
        assert!(derivative(angle, by, [0.0, 0.0]).is_nan());
    }
}

/// `1/√((1 − x)(1 + x))` and similar forms keep their digits next to ±1.
#[test]
fn inverse_functions_next_to_one() {
    // the function, the side of 1 on which it is defined, its slope s, and k and n of its second
    // derivative k x sⁿ
    for (name, side, slope, factor, power) in [
        ("asin", -1.0, "1.0 / ((1.0 - x) * (1.0 + x)).sqrt()", 1.0, 3),
        (
            "acos",
            -1.0,
            "-1.0 / ((1.0 - x) * (1.0 + x)).sqrt()",
            1.0,
            3,
        ),
        ("atanh", -1.0, "1.0 / ((1.0 - x) * (1.0 + x))", 2.0, 2),
        (
            "acosh",
            1.0,
            "1.0 / ((x - 1.0) * (x + 1.0)).sqrt()",
            -1.0,
            3,
        ),
    ] {
        let slope = Formula::new(slope);
        // a product, since 1 − x² itself has a stable form anyway
        let whole = format!("(x * y).{name}()");
        for k in 1..53 {
            for sign in [1.0, -1.0] {
                let x = sign * (1.0 + side * 0.5f64.powi(k));
                if name == "acosh" && sign < 0.0 {
                    continue;
                }
                let first: Double = slope.evaluate([of(x); 3]);
                // x/√(1 − x²)³ and similar forms
                let second = of(factor * x) * first.power(power);
                for (by, expected, bound) in [(&[0][..], first, 2.0), (&[0, 0], second, 6.0)] {
                    let error = units(derivative(&whole, by, [x, 1.0]), expected);
                    assert!(error <= bound, "{name} by {by:?} at {x}: {error} units");
                }
            }
        }
    }
}

#[test]
fn no_derivative_shows() {
    for (function, x) in [
        ("sqrt", 0.0),
        ("cbrt", 0.0),
        ("ln", 0.0),
        ("asin", 1.0),
        ("acosh", 1.0),
        ("atanh", -1.0),
        ("sqrt", -1.0),
        ("asin", 1.5),
    ] {
        let found = derivative(&format!("x.{function}()"), &[0], [x, 0.0]);
        assert!(!found.is_finite(), "{function} at {x}: {found}");
    }
    check("x.cbrt()", &[0], [-8.0, 0.0], 1.0 / 12.0);
}

/// `ln cosh x` and its derivatives at points where cosh overflows.
#[test]
fn hyperbolic_quotients_do_not_overflow() {
    let potential = "x.cosh().ln()";
    for x in [1e3, -1e3] {
        assert_eq!(derivative(potential, &[0], [x, 0.0]), x.signum());
        assert_eq!(derivative(potential, &[0, 0], [x, 0.0]), 0.0);
    }
    check(potential, &[0, 0], [20.0, 0.0], 4.0 * (-40.0f64).exp());
}

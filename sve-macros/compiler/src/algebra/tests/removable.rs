//! Derivatives, as emitted code computes them, at points where a plain formula is 0/0, 0·∞ or
//! overflows; and points without a derivative, where the result must not be finite.

use super::stable::{computed, units};
use crate::algebra::elementary::{self as exact, Double, of};
use crate::algebra::{Arena, Binary, Expr, Function, Purpose, Symbol};

/// An expression of two variables.
type Formula<'a> = &'a dyn Fn(&mut Arena, Expr, Expr) -> Expr;

/// Builds an expression of two variables, differentiates it in the listed ones, and evaluates the
/// derivative at a point.
fn derivative(make: Formula<'_>, by: &[u32], at: [f64; 2]) -> f64 {
    let mut arena = Arena::new();
    let [x, y] = [0, 1].map(|i| arena.symbol(Symbol(i)));
    let mut expr = make(&mut arena, x, y);
    for &i in by {
        expr = arena.diff(expr, Symbol(i));
    }
    arena.stabilise(Purpose::Values, vec![&mut expr]);
    computed(&arena, expr, &[at[0], at[1], 0.0, 0.0])
}

fn close(found: f64, expected: f64) -> bool {
    // four roundings
    (found - expected).abs() <= 4.0 * f64::EPSILON * expected.abs()
}

/// Returns a function that builds `x^k` as `powf` does.
fn power(k: f64) -> impl Fn(&mut Arena, Expr, Expr) -> Expr {
    move |a, x, _| {
        let k = a.constant(k);
        a.call2(Binary::Pow, x, k)
    }
}

#[test]
fn constant_powers_at_zero() {
    const INFINITE: f64 = f64::INFINITY;
    // exponent, and its first three derivatives at 0
    for (k, expected) in [
        (0.0, [0.0, 0.0, 0.0]),
        (1.0, [1.0, 0.0, 0.0]),
        (2.0, [0.0, 2.0, 0.0]),
        (3.0, [0.0, 0.0, 6.0]),
        (0.5, [INFINITE, -INFINITE, INFINITE]),
        (1.5, [0.0, INFINITE, -INFINITE]),
        (2.5, [0.0, 0.0, INFINITE]),
        (3.5, [0.0, 0.0, 0.0]),
        (0.3, [INFINITE, -INFINITE, INFINITE]),
        (1.3, [0.0, INFINITE, -INFINITE]),
        (2.3, [0.0, 0.0, INFINITE]),
        (70.0, [0.0, 0.0, 0.0]),
    ] {
        for (order, expected) in (1..).zip(expected) {
            let found = derivative(&power(k), &vec![0; order], [0.0, 0.0]);
            assert_eq!(found, expected, "derivative {order} of x^{k}");
        }
    }
    // and away from 0
    assert!(close(derivative(&power(1.5), &[0], [4.0, 0.0]), 3.0));
    assert!(close(derivative(&power(2.5), &[0, 0], [4.0, 0.0]), 7.5));
    assert!(close(
        derivative(&power(-0.5), &[0], [4.0, 0.0]),
        -1.0 / 16.0
    ));
}

#[test]
fn roots_beside_their_radicands() {
    // (x² y)^(3/2), 3 |x| x y^(3/2), is smooth enough at 0 once
    let whole = |a: &mut Arena, x: Expr, y: Expr| {
        let product = a.product(&[(x, 2), (y, 1)]);
        let k = a.constant(1.5);
        a.call2(Binary::Pow, product, k)
    };
    assert_eq!(derivative(&whole, &[0], [0.0, 2.0]), 0.0);
    assert_eq!(derivative(&whole, &[1], [0.0, 2.0]), 0.0);
    assert!(close(derivative(&whole, &[0], [-2.0, 4.0]), -96.0));
    // (1 − x)^(3/2), where the radicand is a sum
    let falling = |a: &mut Arena, x: Expr, _: Expr| {
        let rest = a.sum(1.0, &[(-1.0, x)]);
        let k = a.constant(1.5);
        a.call2(Binary::Pow, rest, k)
    };
    assert_eq!(derivative(&falling, &[0], [1.0, 0.0]), 0.0);
    assert!(close(derivative(&falling, &[0], [-3.0, 0.0]), -3.0));
    // |x| x has the derivative 2 |x|, and |x| has none at 0
    let modulus = |a: &mut Arena, x: Expr| {
        let square = a.pow(x, 2);
        a.call(Function::Sqrt, square)
    };
    let signed = |a: &mut Arena, x: Expr, _: Expr| {
        let modulus = modulus(a, x);
        a.mul(x, modulus)
    };
    for (x, expected) in [(0.0, 0.0), (-3.0, 6.0), (3.0, 6.0)] {
        assert_eq!(derivative(&signed, &[0], [x, 0.0]), expected);
    }
    let modulus = |a: &mut Arena, x: Expr, _: Expr| modulus(a, x);
    assert!(derivative(&modulus, &[0], [0.0, 0.0]).is_nan());
    assert_eq!(derivative(&modulus, &[0], [-3.0, 0.0]), -1.0);
}

#[test]
fn variable_powers() {
    let power = |a: &mut Arena, x: Expr, y: Expr| a.call2(Binary::Pow, x, y);
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
            assert_eq!(derivative(&power, by, [zero, 2.5]), 0.0, "{by:?}");
        }
        assert_eq!(derivative(&power, &[0], [zero, 1.0]), 1.0);
        assert_eq!(derivative(&power, &[1], [zero, 0.5]), 0.0);
        // x^y has no derivatives there
        assert!(!derivative(&power, &[0], [zero, 0.5]).is_finite());
        assert!(!derivative(&power, &[1], [zero, 0.0]).is_finite());
        assert!(!derivative(&power, &[0, 1], [zero, 1.0]).is_finite());
    }
    assert!(derivative(&power, &[1], [-2.0, 2.0]).is_nan());
    let (x, y, ln) = (2.0f64, 3.0, std::f64::consts::LN_2);
    for (by, expected) in [
        (&[1][..], 8.0 * ln),
        (&[1, 1], 8.0 * ln * ln),
        (&[0], 12.0),
        (&[0, 0], 12.0),
        (&[0, 1], 4.0 + 12.0 * ln),
        (&[1, 0], 4.0 + 12.0 * ln),
        (&[0, 1, 1], 8.0 * ln + 12.0 * ln * ln),
    ] {
        let found = derivative(&power, by, [x, y]);
        assert!(close(found, expected), "{by:?}: {found} {expected}");
    }
    // a constant base keeps its logarithm as a constant
    let exponential = |a: &mut Arena, _: Expr, y: Expr| {
        let two = a.constant(2.0);
        a.call2(Binary::Pow, two, y)
    };
    assert!(close(
        derivative(&exponential, &[1, 1], [0.0, 3.0]),
        8.0 * ln * ln
    ));
}

#[test]
fn zero_times_anything_is_zero() {
    for k in [-3, -1, 0, 1, 2] {
        let none = |a: &mut Arena, x: Expr, _: Expr| {
            let power = a.pow(x, k);
            a.scale(0.0, power)
        };
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
    let hypot = |a: &mut Arena, x: Expr, y: Expr| a.call2(Binary::Hypot, x, y);
    let angle = |a: &mut Arena, x: Expr, y: Expr| a.call2(Binary::Atan2, y, x);
    for [x, y] in around() {
        // computed from numbers of the size of 1, and the size
        let r = x.hypot(y);
        let (u, w) = (x / r, y / r);
        let second = 1.0 / r;
        let inverse = second * second;
        let table: [(Formula<'_>, &[u32], f64); 10] = [
            (&hypot, &[0], u),
            (&hypot, &[1], w),
            (&hypot, &[0, 0], w * w * second),
            (&hypot, &[0, 1], -u * w * second),
            (&hypot, &[1, 1], u * u * second),
            (&angle, &[0], -w * second),
            (&angle, &[1], u * second),
            (&angle, &[0, 0], 2.0 * u * w * inverse),
            (&angle, &[1, 1], -2.0 * u * w * inverse),
            (&angle, &[0, 1], (w * w - u * u) * inverse),
        ];
        for (at, (make, by, expected)) in table.into_iter().enumerate() {
            let found = derivative(make, by, [x, y]);
            if !expected.is_finite() {
                // an infinite derivative may show as any number that is not finite
                assert!(!found.is_finite(), "{at}: {found} at {x}, {y}");
                continue;
            }
            assert!(
                (found - expected).abs() <= 8.0 * f64::EPSILON * expected.abs(),
                "{at}: {found} for {expected} at {x}, {y}"
            );
        }
        assert_eq!(derivative(&angle, &[], [x, y]), y.atan2(x));
    }
    for by in [&[0][..], &[1]] {
        assert!(derivative(&hypot, by, [0.0, 0.0]).is_nan());
        assert!(derivative(&angle, by, [0.0, 0.0]).is_nan());
    }
}

/// `1/√((1 − x)(1 + x))` and similar forms keep their digits next to ±1.
#[test]
fn inverse_functions_next_to_one() {
    type Slope = fn(Double) -> Double;
    let table: [(Function, f64, Slope); 4] = [
        (Function::Asin, -1.0, |x| {
            Double::ONE / exact::sqrt((Double::ONE - x) * (Double::ONE + x))
        }),
        (Function::Acos, -1.0, |x| {
            -Double::ONE / exact::sqrt((Double::ONE - x) * (Double::ONE + x))
        }),
        (Function::Atanh, -1.0, |x| {
            Double::ONE / ((Double::ONE - x) * (Double::ONE + x))
        }),
        (Function::Acosh, 1.0, |x| {
            Double::ONE / exact::sqrt((x - Double::ONE) * (x + Double::ONE))
        }),
    ];
    for (function, side, slope) in table {
        for k in 1..53 {
            for sign in [1.0, -1.0] {
                let x = sign * (1.0 + side * 0.5f64.powi(k));
                if function == Function::Acosh && sign < 0.0 {
                    continue;
                }
                // a product, since 1 − x² itself has a stable form anyway
                let whole = |a: &mut Arena, x: Expr, y: Expr| {
                    let product = a.mul(x, y);
                    a.call(function, product)
                };
                let found = derivative(&whole, &[0], [x, 1.0]);
                let error = units(found, slope(of(x)));
                assert!(error <= 2.0, "{function:?} at {x}: {error} units");
                // differentiated once more: x/√(1 − x²)³ and similar forms
                let again = derivative(&whole, &[0, 0], [x, 1.0]);
                let inner = slope(of(x));
                let expected = match function {
                    Function::Atanh => of(2.0 * x) * inner * inner,
                    Function::Acosh => -of(x) * inner * inner * inner,
                    _ => of(x) * inner * inner * inner,
                };
                let error = units(again, expected);
                assert!(error <= 6.0, "{function:?} twice at {x}: {error} units");
            }
        }
    }
}

#[test]
fn no_derivative_shows() {
    for (function, x) in [
        (Function::Sqrt, 0.0),
        (Function::Cbrt, 0.0),
        (Function::Ln, 0.0),
        (Function::Asin, 1.0),
        (Function::Acosh, 1.0),
        (Function::Atanh, -1.0),
        (Function::Sqrt, -1.0),
        (Function::Asin, 1.5),
    ] {
        let found = derivative(&|a, x, _| a.call(function, x), &[0], [x, 0.0]);
        assert!(!found.is_finite(), "{function:?} at {x}: {found}");
    }
    let cbrt = |a: &mut Arena, x: Expr, _: Expr| a.call(Function::Cbrt, x);
    assert!(close(derivative(&cbrt, &[0], [-8.0, 0.0]), 1.0 / 12.0));
}

/// `ln cosh x` and its derivatives at points where cosh overflows.
#[test]
fn hyperbolic_quotients_do_not_overflow() {
    let potential = |a: &mut Arena, x: Expr, _: Expr| {
        let cosh = a.call(Function::Cosh, x);
        a.call(Function::Ln, cosh)
    };
    for x in [1e3, -1e3] {
        assert_eq!(derivative(&potential, &[0], [x, 0.0]), x.signum());
        assert_eq!(derivative(&potential, &[0, 0], [x, 0.0]), 0.0);
    }
    let found = derivative(&potential, &[0, 0], [20.0, 0.0]);
    assert!(close(found, 4.0 * (-40.0f64).exp()), "{found}");
}

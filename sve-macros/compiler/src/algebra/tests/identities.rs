//! Identities that vanish, similar expressions that do not, and equal expressions that have equal
//! names.

use super::formula::Formula;
use crate::algebra::{Arena, Binary, Symbol};

#[test]
fn known_identities_are_zero() {
    for zero in [
        "x.sin().powi(2) + x.cos().powi(2) - 1.0",
        "x.cosh().powi(2) - x.sinh().powi(2) - 1.0",
        "(x + y).powi(2) - x.powi(2) - 2.0 * (x * y) - y.powi(2)",
        "(x + y).exp() - x.exp() * y.exp()",
        "(2.0 * x).sin() - 2.0 * (x.sin() * x.cos())",
        "x.powi(2).sqrt().powi(2) - x.powi(2)",
    ] {
        let mut arena = Arena::new();
        let expr = Formula::new(zero).build(&mut arena);
        assert!(arena.is_zero(expr), "{zero}");
    }
}

#[test]
fn near_identities_are_not_zero() {
    for formula in [
        "x.sin() - x",
        "1e-9 * x",
        "1e-300 * x",
        "x.powi(2).sqrt() - x",
        "x.sin().powi(2) + x.cos().powi(2) - 1.0 + 1e-12",
        "(x - y).powi(12)",
        "x.ln()",
    ] {
        let mut arena = Arena::new();
        let expr = Formula::new(formula).build(&mut arena);
        assert!(!arena.is_zero(expr), "{formula}");
    }
}

#[test]
fn equal_expressions_have_equal_names() {
    for (one, other) in [
        ("x + y", "y + x"),
        ("x * y", "y * x"),
        ("(x - y).powi(2)", "(y - x).powi(2)"),
        ("(x - y).cos()", "(y - x).cos()"),
        ("x - x", "0.0"),
        ("x / x", "1.0"),
        ("-0.0", "0.0"),
        ("x * 0.0", "0.0"),
        ("x * 1.0", "x"),
        ("x.powi(0)", "1.0"),
    ] {
        let mut arena = Arena::new();
        let [one_expr, other_expr] = [one, other].map(|text| Formula::new(text).build(&mut arena));
        assert_eq!(one_expr, other_expr, "{one} and {other}");
    }
}

#[test]
fn exponents_do_not_overflow() {
    let mut arena = Arena::new();
    let mut power = arena.symbol(Symbol(0));
    for _ in 0..8 {
        power = arena.pow(power, 1000);
        power = arena.mul(power, power);
    }
    assert_eq!(arena.evaluate(power, |_| 1.0), 1.0);
    let derivative = arena.diff(power, Symbol(0));
    assert!(arena.evaluate(derivative, |_| 1.0) > 1e20);
}

/// A power of the literal zero has a derivative in its exponent, which is zero.
#[test]
fn powers_of_zero() {
    let mut arena = Arena::new();
    let (zero, x) = (arena.constant(0.0), arena.symbol(Symbol(0)));
    let power = arena.call2(Binary::Pow, zero, x);
    let derivative = arena.diff(power, Symbol(0));
    assert_eq!(arena.evaluate(power, |_| 1.5), 0.0);
    assert_eq!(arena.evaluate(derivative, |_| 1.5), 0.0);
}

//! The identities and properties in the entries of functions.

use crate::algebra::expr::Node;
use crate::algebra::functions::Form;
use crate::algebra::{Arena, Binary, Function, Symbol};

/// Asserts that a form has the value of a difference, up to the rounding of the difference.
fn assert_form(function: Function, form: Form, x: f64, expected: f64, size: f64) {
    let value = form.scale * form.function.evaluate(form.factor * x).powi(form.power);
    assert!(
        (value - expected).abs() <= 8.0 * f64::EPSILON * size,
        "{function:?} at {x}: {value} for {expected}"
    );
}

/// The identities in the entries of functions of one argument hold.
#[test]
fn identities_of_entries_hold() {
    let mut count = 0;
    for &function in Function::METHODS {
        let stable = &function.entry().stable;
        for x in [-1.7, -0.6, -0.1, 0.2, 0.9, 2.3] {
            let value = function.evaluate(x);
            if let Some(form) = stable.less_one {
                assert_form(function, form, x, value - 1.0, 1.0 + value.abs());
                count += 1;
            }
            if let Some(form) = stable.square_less_one {
                assert_form(function, form, x, value * value - 1.0, 1.0 + value * value);
                count += 1;
            }
            if let Some(shifted) = stable.of_one_plus
                && x > -1.0
            {
                let distance = function.evaluate(1.0 + x) - shifted.evaluate(x);
                assert!(distance.abs() < 1e-15, "{function:?} at 1 + {x}");
                count += 1;
            }
            if let Some((divisor, quotient)) = stable.quotient {
                let ratio = value / divisor.evaluate(x);
                assert!((ratio - quotient.evaluate(x)).abs() < 1e-15, "{function:?}");
                count += 1;
            }
            assert!(!stable.is_at_least_one || value >= 1.0, "{function:?}");
            if stable.power_scales_argument {
                let power = value.powi(2);
                assert!((power - function.evaluate(2.0 * x)).abs() < 4e-15 * power);
                count += 1;
            }
        }
    }
    // 3 differences, 4 of squares, a shift that is defined at 5 points, a quotient, a power
    assert_eq!(count, 6 * 9 + 5);
}

/// The functions of two arguments that are marked as norms are norms, and their conditions and
/// constant forms agree with their values.
#[test]
fn properties_of_functions_of_two_arguments_hold() {
    let functions = Binary::METHODS.iter().copied().chain([Binary::PowLog(2)]);
    for function in functions {
        let entry = function.entry();
        let (x, y) = (1.3, -0.7);
        let square = function.evaluate(x, y).powi(2);
        let is_norm = (square - (x * x + y * y)).abs() < 1e-14;
        assert_eq!(entry.is_norm, is_norm, "{function:?}");
        if entry.needs_nonnegative {
            assert!(function.evaluate(-x, y).is_nan(), "{function:?}");
        }
        let mut arena = Arena::new();
        let symbol = arena.symbol(Symbol(0));
        let constant = arena.constant(y);
        let call = arena.call2(function, symbol, constant);
        let is_call = *arena.node(call) == Node::Call2(function, symbol, constant);
        assert_eq!(entry.with_constant.is_none(), is_call, "{function:?}");
    }
}

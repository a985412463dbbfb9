//! Functions of 106 bits against values of 40 digits, computed with mpmath. Each line of
//! `elementary.csv` has a function, its arguments, the nearest `f64` of the value, and the nearest
//! `f64` of the remainder.

use crate::algebra::elementary::{ARGUMENT, Double, ROUNDING, of};
use crate::algebra::expr::Bits;
use crate::algebra::{Binary, Function};

use super::recipe::FUNCTIONS;

const VALUES: &str = include_str!("elementary.csv");

/// Returns the value of a function, and the magnitude of the sum of its derivatives times their
/// arguments, computed by differences.
fn value(name: &str, arguments: &[f64]) -> (Double, f64) {
    let wiggle = |f: &dyn Fn(f64) -> f64, x: f64| {
        let dx = 1e-9 * x.abs();
        ((f(x + dx) - f(x - dx)) / 2e-9).abs()
    };
    let &[x, y] = arguments else {
        let function = FUNCTIONS
            .iter()
            .copied()
            .chain([
                Function::Powf(Bits::new(1.7)),
                Function::Powf(Bits::new(-0.3)),
            ])
            .find(|f| format!("{f:?}") == name || powf_name(*f) == name)
            .unwrap_or_else(|| panic!("{name}"));
        let x = arguments[0];
        let mut change = wiggle(&|x| function.evaluate(x), x);
        if let Function::Powf(k) = function {
            // the exponent is an argument too
            change += (k.get() * x.ln() * function.evaluate(x)).abs();
        }
        return (function.evaluate_double(of(x)), change);
    };
    let function = match name {
        "Atan2" => Binary::Atan2,
        "Hypot" => Binary::Hypot,
        "Pow" => Binary::Pow,
        _ => Binary::PowLog(2),
    };
    let change = wiggle(&|x| function.evaluate(x, y), x) + wiggle(&|y| function.evaluate(x, y), y);
    (function.evaluate_double(of(x), of(y)), change)
}

fn powf_name(function: Function) -> String {
    match function {
        Function::Powf(k) => format!("Powf({})", k.get()),
        _ => String::new(),
    }
}

#[test]
fn functions_are_good_to_their_bounds() {
    let mut seen = std::collections::BTreeSet::new();
    let mut worst = 0.0f64;
    for line in VALUES.lines() {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let numbers: Vec<f64> = fields[1..].iter().map(|text| number(text)).collect();
        let (arguments, expected) = numbers.split_at(numbers.len() - 2);
        let expected = Double::new(expected[0], expected[1]);
        let (found, change) = value(fields[0], arguments);
        let bound = ROUNDING * expected.nearest().abs() + ARGUMENT * change;
        let error = (found - expected).nearest().abs();
        assert!(error <= bound, "{line}: off by {error:e}, bound {bound:e}");
        if expected.nearest() != 0.0 {
            worst = worst.max(error / bound);
        }
        seen.insert(fields[0]);
    }
    assert!(worst > 1e-4, "the bound says nothing: {worst:e}");
    // each function of the table; powers with one constant exponent or more
    for &function in FUNCTIONS {
        assert!(
            seen.contains(format!("{function:?}").as_str()),
            "{function:?}"
        );
    }
    for name in ["Atan2", "Hypot", "Pow", "PowLog(2)", "Powf(1.7)"] {
        assert!(seen.contains(name), "{name}");
    }
}

#[test]
fn undefined_values_show() {
    for (function, x) in [
        (Function::Sqrt, -1.0),
        (Function::Ln, -1.0),
        (Function::Ln, 0.0),
        (Function::Ln1p, -2.0),
        (Function::Asin, 1.5),
        (Function::Acos, -1.5),
        (Function::Acosh, 0.5),
        (Function::Atanh, 1.5),
        (Function::Exp, 1e4),
        (Function::Sin, f64::INFINITY),
        (Function::Powf(Bits::new(0.3)), -1.0),
    ] {
        let value = function.evaluate_double(of(x)).nearest();
        assert!(!value.is_finite(), "{function:?} {x}: {value}");
    }
    assert_eq!(Function::Exp.evaluate_double(of(-1e4)).nearest(), 0.0);
}

//! Numbers as a physicist writes them: 1/3 below the line, 2·π, 1.38·10⁻²³.
//!
//! Invariant: numerator over denominator equals the number, up to the rounding of the power of ten.

use std::f64::consts::PI;

/// A positive number as a fraction; empty stands for 1.
#[derive(Default)]
pub(super) struct Fraction {
    pub(super) above: String,
    pub(super) below: String,
}

/// Characters of a decimal that is easier to read than a fraction.
const DIGITS: usize = 7;

/// Largest denominator that is tried.
const DENOMINATORS: u32 = 64;

/// Largest numerator of a fraction; beyond it, a decimal is easier to read.
const NUMERATOR: f64 = 999.0;

/// Returns a positive number as a fraction, with a multiple of π if it is one.
pub(super) fn fraction(c: f64) -> Fraction {
    let below = |below: u32| Fraction {
        above: String::new(),
        below: below.to_string(),
    };
    let whole = |above: String| Fraction {
        above,
        below: String::new(),
    };
    if c == 1.0 {
        return Fraction::default();
    }
    for k in [2, 4, 8, 16] {
        if c == 1.0 / f64::from(k) {
            return below(k);
        }
    }
    let plain = decimal(c);
    // a short decimal stays a decimal
    if plain.chars().count() <= DIGITS {
        return whole(plain);
    }
    if let Some(found) = of_pi(c) {
        return found;
    }
    for k in 3..=DENOMINATORS {
        let above = (c * f64::from(k)).round();
        if above / f64::from(k) == c && (1.0..=NUMERATOR).contains(&above) {
            return Fraction {
                above: if above == 1.0 {
                    String::new()
                } else {
                    decimal(above)
                },
                below: k.to_string(),
            };
        }
    }
    whole(plain)
}

/// Recognises π, its small multiples, and their halves and quarters.
fn of_pi(c: f64) -> Option<Fraction> {
    for k in [1u32, 2, 4] {
        for multiple in [1.0, 2.0, 3.0, 4.0, 8.0] {
            if multiple * PI / f64::from(k) == c {
                let above = match multiple {
                    1.0 => "π".to_owned(),
                    _ => format!("{multiple}·π"),
                };
                let below = if k == 1 { String::new() } else { k.to_string() };
                return Some(Fraction { above, below });
            }
        }
    }
    None
}

/// Prints a positive number in decimal notation; very large and very small numbers with a power of
/// ten.
pub(super) fn decimal(c: f64) -> String {
    if c.is_nan() {
        return "NaN".to_owned();
    }
    if c.is_infinite() {
        return "∞".to_owned();
    }
    if (1e-4..1e7).contains(&c) {
        return c.to_string();
    }
    let text = format!("{c:e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let power: String = exponent.chars().map(superscript).collect();
    match mantissa {
        "1" => format!("10{power}"),
        _ => format!("{mantissa}·10{power}"),
    }
}

/// Returns a digit or a minus sign as a superscript.
pub(super) fn superscript(c: char) -> char {
    match c {
        '0' => '⁰',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        '4' => '⁴',
        '5' => '⁵',
        '6' => '⁶',
        '7' => '⁷',
        '8' => '⁸',
        '9' => '⁹',
        '-' => '⁻',
        other => other,
    }
}

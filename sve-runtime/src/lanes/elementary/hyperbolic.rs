//! Hyperbolic functions and their inverses, from `eˣ`, `eˣ − 1` and `ln(1 + x)` in forms that do
//! not cancel.

use super::{exp, exp_m1, ln_1p, select};

/// Largest argument of the hyperbolic sine and cosine: its exponential is finite.
const EXPONENT: f64 = 709.0;

/// Largest argument: its square is finite.
const SQUARE: f64 = 1e150;

/// Returns the hyperbolic sine, to two units in the last place, for `|x| ≤ 709`; NaN otherwise.
#[inline(always)]
pub fn sinh(x: f64) -> f64 {
    let e = exp_m1(select(x.abs() <= EXPONENT, x.abs(), f64::NAN));
    (0.5 * (e + e / (e + 1.0))).copysign(x)
}

/// Returns the hyperbolic cosine, to 1.5 units in the last place, for `|x| ≤ 709`; NaN otherwise.
#[inline(always)]
pub fn cosh(x: f64) -> f64 {
    let e = exp(select(x.abs() <= EXPONENT, x.abs(), f64::NAN));
    0.5 * e + 0.5 / e
}

/// Returns the hyperbolic tangent, to 2.5 units in the last place.
#[inline(always)]
pub fn tanh(x: f64) -> f64 {
    let size = x.abs();
    // The hyperbolic tangent of larger arguments is 1.
    let size = select(size > 25.0, 25.0, size);
    let e = exp_m1(2.0 * size);
    (e / (e + 2.0)).copysign(x)
}

/// Returns the inverse of the hyperbolic sine, to two units in the last place, for `|x| ≤ 10¹⁵⁰`;
/// NaN otherwise.
#[inline(always)]
pub fn asinh(x: f64) -> f64 {
    let size = select(x.abs() <= SQUARE, x.abs(), f64::NAN);
    let square = size * size;
    ln_1p(size + square / (1.0 + (1.0 + square).sqrt())).copysign(x)
}

/// Returns the inverse of the hyperbolic cosine, to two units in the last place, for
/// `1 ≤ x ≤ 10¹⁵⁰`; NaN otherwise.
#[inline(always)]
pub fn acosh(x: f64) -> f64 {
    let more = select((1.0..=SQUARE).contains(&x), x - 1.0, f64::NAN);
    ln_1p(more + (2.0 * more + more * more).sqrt())
}

/// Returns the inverse of the hyperbolic tangent, to two units in the last place, for `|x| < 1`;
/// NaN otherwise.
#[inline(always)]
pub fn atanh(x: f64) -> f64 {
    let size = select(x.abs() < 1.0, x.abs(), f64::NAN);
    let twice = 2.0 * size;
    (0.5 * ln_1p(twice + twice * size / (1.0 - size))).copysign(x)
}

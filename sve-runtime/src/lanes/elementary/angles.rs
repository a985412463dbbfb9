//! Sine, cosine, tangent and angle addition.
//!
//! The argument is reduced by the nearest multiple of π/2 in three parts (W. Cody, W. Waite,
//! Software Manual for the Elementary Functions, 1980), the first two of 36 bits, so that their
//! products with a multiple below 2¹⁷ are exact. The remainder has a second, low part.
//! [`angle_addition`](crate::angle_addition) has the polynomials.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use super::{SIGN, nearest, select};
use crate::angle_addition::{cosine, sine};

/// π/2 = `A + B + C`, up to 2⁻¹³⁰.
const A: f64 = 1.570_796_326_792_333_3;
const B: f64 = 2.563_344_151_583_955_8e-12;
const C: f64 = 1.056_299_906_698_742_8e-23;

/// Largest argument: its multiple of π/2 is below 2¹⁷.
const LARGEST: f64 = 131_072.0;

/// Returns sine and cosine, to 1.1 units in the last place, for `|x| ≤ 2¹⁷`; NaN for larger
/// arguments.
///
/// No number of the range is nearer to a multiple of π/2 than 2⁻⁶¹, so the error of the reduction,
/// below 2⁻¹¹¹, is negligible.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let (multiple, quadrant) = nearest(x * FRAC_2_PI);
    let multiple = select(x.abs() <= LARGEST, multiple, f64::NAN);
    // exact: the difference is small and a multiple of 2⁻⁵³
    let first = x - multiple * A;
    let second = multiple * B;
    // the angle is r − rest
    let r = first - second;
    let rest = (second - (first - r)) + multiple * C;

    let r2 = r * r;
    // this order keeps the sign of −0
    let s = r - (rest - r * r2 * sine(r2));
    let c = 1.0 - (0.5 * r2 - (r2 * r2 * cosine(r2) + r * rest));

    let odd = quadrant & 1 == 1;
    let (s, c) = (select(odd, c, s), select(odd, s, c));
    let sign_of_sine = (quadrant << 62) & SIGN;
    let sign_of_cosine = (quadrant.wrapping_add(1) << 62) & SIGN;
    (
        f64::from_bits(s.to_bits() ^ sign_of_sine),
        f64::from_bits(c.to_bits() ^ sign_of_cosine),
    )
}

/// Returns the sine, see [`sin_cos`].
#[inline(always)]
pub fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// Returns the cosine, see [`sin_cos`].
#[inline(always)]
pub fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// Returns the tangent, to 2.5 units in the last place, for the arguments of [`sin_cos`].
#[inline(always)]
pub fn tan(x: f64) -> f64 {
    let (s, c) = sin_cos(x);
    s / c
}

/// Returns `(sin(a + by), cos(a + by))` from `sin a` and `cos a`, to two units of rounding of 1,
/// for `|by| ≤ π/4`; NaN for larger increments.
#[inline(always)]
pub fn sin_cos_of_sum(sin: f64, cos: f64, by: f64) -> (f64, f64) {
    let by = select(by.abs() <= FRAC_PI_4, by, f64::NAN);
    let x2 = by * by;
    // sin(by) = s, cos(by) = 1 − c: the small changes are added last
    let (s, c) = (by + by * x2 * sine(x2), 0.5 * x2 - x2 * x2 * cosine(x2));
    (sin + (cos * s - sin * c), cos - (sin * s + cos * c))
}

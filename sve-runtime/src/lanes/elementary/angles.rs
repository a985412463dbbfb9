//! Sine, cosine and tangent; an angle turned a little.
//!
//! The argument is reduced by the nearest multiple of π/2 in three parts (W. Cody, W. Waite, Software Manual for the Elementary
//! Functions, 1980), the first two of 36 bits, so that their products with a multiple below 2¹⁷ are exact. The remainder keeps a
//! second part. The polynomials are those of `crate::turn`.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use super::{SIGN, nearest, select};
use crate::turn::{cosine, sine};

/// π/2 = `A + B + C`, up to 2⁻¹³⁰.
const A: f64 = 1.570_796_326_792_333_3;
const B: f64 = 2.563_344_151_583_955_8e-12;
const C: f64 = 1.056_299_906_698_742_8e-23;

/// Arguments up to here have less than 2¹⁷ quarter turns.
const LARGEST: f64 = 131_072.0;

/// Sine and cosine, to 1.1 units in the last place, for `|x| ≤ 2¹⁷`; NaN beyond.
///
/// No number of the range is nearer to a multiple of π/2 than 2⁻⁶¹, so the error of the reduction, below 2⁻¹¹¹, counts nowhere.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let (turns, quadrant) = nearest(x * FRAC_2_PI);
    let turns = select(x.abs() <= LARGEST, turns, f64::NAN);
    // exact, for the difference is small and a multiple of 2⁻⁵³
    let first = x - turns * A;
    let second = turns * B;
    // the angle is r − rest
    let r = first - second;
    let rest = (second - (first - r)) + turns * C;

    let r2 = r * r;
    // in this order −0 remains −0
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

/// The sine, as [`sin_cos`] gives it.
#[inline(always)]
pub fn sin(x: f64) -> f64 {
    sin_cos(x).0
}

/// The cosine, as [`sin_cos`] gives it.
#[inline(always)]
pub fn cos(x: f64) -> f64 {
    sin_cos(x).1
}

/// The tangent, to 2.5 units in the last place, where [`sin_cos`] is right.
#[inline(always)]
pub fn tan(x: f64) -> f64 {
    let (s, c) = sin_cos(x);
    s / c
}

/// `(sin(a + by), cos(a + by))` from `sin a` and `cos a`, to two units of rounding of 1, for `|by| ≤ π/4`; NaN beyond.
#[inline(always)]
pub fn turn(sin: f64, cos: f64, by: f64) -> (f64, f64) {
    let by = select(by.abs() <= FRAC_PI_4, by, f64::NAN);
    let x2 = by * by;
    // sin(by) = s, cos(by) = 1 − c: what a small turn changes is added last
    let (s, c) = (by + by * x2 * sine(x2), 0.5 * x2 - x2 * x2 * cosine(x2));
    (sin + (cos * s - sin * c), cos - (sin * s + cos * c))
}

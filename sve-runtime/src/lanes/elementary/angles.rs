//! Sine, cosine and tangent; an angle turned a little.
//!
//! The argument is reduced by the nearest multiple of π/2 in three parts (W. Cody, W. Waite, Software Manual for the Elementary
//! Functions, 1980), the first two of 33 bits, so that their products with a multiple below 2²⁰ are exact. The remainder keeps a
//! second part. The polynomials are those of `crate::turn`.

use core::f64::consts::{FRAC_2_PI, FRAC_PI_4};

use super::{SIGN, nearest, select};
use crate::turn::{cosine, sine};

/// π/2 = `A + B + C`, up to 2⁻¹¹⁹.
const A: f64 = 1.570_796_326_734_125_6;
const B: f64 = 6.077_100_506_303_966e-11;
const C: f64 = 2.022_266_248_795_950_6e-21;

/// Arguments up to here have less than 2²⁰ quarter turns.
const LARGEST: f64 = 1_048_576.0;

/// Sine and cosine, to 0.8 units in the last place, for `|x| ≤ 2²⁰`; NaN beyond.
///
/// Where `x` is nearer to a multiple of π/2 than 2⁻⁶⁶ times that multiple, the one that vanishes there has instead an absolute error up
/// to 2⁻⁹⁹.
#[inline(always)]
pub fn sin_cos(x: f64) -> (f64, f64) {
    let size = x.abs();
    let (turns, quadrant) = nearest(size * FRAC_2_PI);
    let turns = select(size <= LARGEST, turns, f64::NAN);
    // exact, for the difference is small and both are multiples of 2⁻⁵³
    let first = size - turns * A;
    let second = turns * B;
    let r = first - second;
    let rest = ((first - r) - second) - turns * C;

    let r2 = r * r;
    let half = 0.5 * r2;
    let near_one = 1.0 - half;
    let cubic = r * r2 * sine(r2);
    let s = r + (cubic + rest * near_one);
    let c = near_one + (((1.0 - near_one) - half) + (r2 * r2 * cosine(r2) - (r + cubic) * rest));

    let odd = quadrant & 1 == 1;
    let (s, c) = (select(odd, c, s), select(odd, s, c));
    let sign_of_sine = (x.to_bits() ^ (quadrant << 62)) & SIGN;
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

/// The tangent, to two units in the last place, where [`sin_cos`] is right.
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

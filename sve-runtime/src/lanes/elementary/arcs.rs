//! Inverses of the trigonometric functions.
//!
//! The argument of the arc tangent of a/b is reduced to a quotient below tan π/8, which is a/b,
//! (a − b)/(a + b) or −b/a; then 0, π/4 or π/2 is added. Above ½ the arc sine is
//! `π/2 − 2 asin √((1 − x)/2)`. On the reduced range both are `x + x³` times a polynomial in x².

use core::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::{four, select};

/// π/2 minus `FRAC_PI_2`.
const HALF_PI_REST: f64 = 6.123_233_995_736_766e-17;

/// Coefficients of `(atan x − x)/x³` in x², up to x² = tan² π/8.
const T: [f64; 11] = [
    -0.333_333_333_333_333_3,
    0.199_999_999_999_954_8,
    -0.142_857_142_846_578_94,
    0.111_111_110_145_610_13,
    -0.090_909_045_498_846_11,
    0.076_921_825_351_166_48,
    -0.066_645_022_156_714_47,
    0.058_580_687_568_615_106,
    -0.050_850_304_928_109_41,
    0.039_219_552_532_551_29,
    -0.019_162_068_915_902_573,
];

/// Coefficients of `(asin x − x)/x³` in x², up to x² = ¼.
const S: [f64; 13] = [
    0.166_666_666_666_666_69,
    0.074_999_999_999_984_33,
    0.044_642_857_146_355_43,
    0.030_381_944_138_531_247,
    0.022_372_172_942_149_89,
    0.017_352_392_720_869_973,
    0.013_971_212_973_552_933,
    0.011_479_177_415_184_906,
    0.010_322_814_350_185_78,
    0.005_457_506_718_640_358,
    0.017_400_879_442_694_02,
    -0.014_851_887_071_247_204,
    0.028_757_851_367_421_566,
];

/// Returns the angle of the point (±b, a) for a, b ≥ 0, with −b for a point to the left, and the
/// reduced quotient.
#[inline(always)]
fn angle(a: f64, b: f64, left: bool) -> (f64, f64) {
    const SMALL: f64 = 0.414_213_562_373_095;
    const LARGE: f64 = 2.414_213_562_373_095;
    let (small, large) = (a <= SMALL * b, a > LARGE * b);
    let numerator = select(small, a, select(large, -b, a - b));
    let denominator = select(small, b, select(large, a, a + b));
    let z = numerator / denominator;
    let z2 = z * z;
    let z4 = z2 * z2;
    let last = (T[8] + z2 * T[9]) + z4 * T[10];
    let tail = four([T[0], T[1], T[2], T[3]], z2, z4)
        + z4 * z4 * (four([T[4], T[5], T[6], T[7]], z2, z4) + z4 * z4 * last);
    let offset = select(small, 0.0, select(large, FRAC_PI_2, FRAC_PI_4));
    let rest = select(small, 0.0, select(large, HALF_PI_REST, 0.5 * HALF_PI_REST));
    // for a point to the left, π minus the angle, with the low part of π
    let offset = select(left, PI - offset, offset);
    let rest = select(left, rest - 2.0 * HALF_PI_REST, rest);
    let more = z + (z * z2 * tail + rest);
    (select(left, offset - more, offset + more), z)
}

/// Returns the arc tangent, to two units in the last place.
#[inline(always)]
pub fn atan(x: f64) -> f64 {
    angle(x.abs(), 1.0, false).0.copysign(x)
}

/// Returns the angle of the point (x, y), to two units in the last place; NaN for the origin, for
/// coordinates above 10³⁰⁰, and if the quotient y/x or x/y underflows.
#[inline(always)]
pub fn atan2(y: f64, x: f64) -> f64 {
    const LARGEST: f64 = 1e300;
    let (a, b) = (y.abs(), x.abs());
    let a = select(a <= LARGEST, a, f64::NAN);
    let b = select(b <= LARGEST, b, f64::NAN);
    let (angle, z) = angle(a, b, x.is_sign_negative());
    let lost = z.abs() < f64::MIN_POSITIVE && a != 0.0 && b != 0.0 && a != b;
    select(lost, f64::NAN, angle).copysign(y)
}

/// Returns whether `|x| > ½`, and the arc sine of the reduced argument s in two parts:
/// `asin s − s`, and s.
#[inline(always)]
fn sine_of(size: f64) -> (bool, f64, f64) {
    let large = size > 0.5;
    let halved = 0.5 * (1.0 - size);
    let z = select(large, halved, size * size);
    let s = select(large, halved.sqrt(), size);
    let z2 = z * z;
    let z4 = z2 * z2;
    let tail = four([S[0], S[1], S[2], S[3]], z, z2)
        + z4 * (four([S[4], S[5], S[6], S[7]], z, z2)
            + z4 * (four([S[8], S[9], S[10], S[11]], z, z2) + z4 * S[12]));
    (large, s * z * tail, s)
}

/// Returns the arc sine, to two units in the last place; NaN for `|x| > 1`.
#[inline(always)]
pub fn asin(x: f64) -> f64 {
    let (large, more, s) = sine_of(x.abs());
    let far = FRAC_PI_2 - (2.0 * s + (2.0 * more - HALF_PI_REST));
    select(large, far, s + more).copysign(x)
}

/// Returns the arc cosine, to two units in the last place; NaN for `|x| > 1`.
#[inline(always)]
pub fn acos(x: f64) -> f64 {
    let (large, more, s) = sine_of(x.abs());
    let near = FRAC_PI_2 - (s.copysign(x) - (HALF_PI_REST - more.copysign(x)));
    let right = 2.0 * (s + more);
    let left = PI - 2.0 * (s + (more - HALF_PI_REST));
    select(large, select(x < 0.0, left, right), near)
}

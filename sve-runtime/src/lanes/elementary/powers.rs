//! Powers, cube roots, and the hypotenuse.
//!
//! `xʸ = 2^(y log₂ x)` with the logarithm in two parts, to a relative error of 2⁻⁶⁵, as in fdlibm's
//! `e_pow.c`: factors are truncated to 26 bits, so that their products are exact.

use super::exponentials::exp2_of_sum;
use super::logarithms::split;
use super::{SIGN, four, ln, select};

/// Coefficients of L in `3 atanh s/s = 3 + s² + s⁴ L(s²)`.
const L: [f64; 8] = [
    0.6,
    0.428_571_428_571_440_5,
    0.333_333_333_324_838_3,
    0.272_727_275_030_892,
    0.230_768_924_437_776_47,
    0.200_022_070_407_709_67,
    0.175_593_545_092_368_1,
    0.175_847_679_358_147_78,
];

/// `2/(3 ln 2)`, its first 26 bits, and the remainder.
const SCALE: f64 = 0.961_796_693_925_975_6;
const SCALE_FIRST: f64 = 0.961_796_686_053_276_1;
const SCALE_REST: f64 = 7.872_699_542_894_897e-9;

/// Returns the first 26 bits of a number.
#[inline(always)]
fn cut(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << 27) - 1))
}

/// Returns the logarithm to base 2 in two parts, the first of 26 bits.
#[inline(always)]
fn log2_in_parts(x: f64) -> (f64, f64) {
    let (k, f) = split(x);
    // s = f/(2 + f) in two parts
    let sum = 2.0 + f;
    let sum_first = cut(sum);
    let sum_rest = f - (sum_first - 2.0);
    let inverse = 1.0 / sum;
    let first = cut(f * inverse);
    let rest = ((f - first * sum_first) - first * sum_rest) * inverse;
    let s = first + rest;
    // 3 + s² + s⁴ L in two parts
    let z = s * s;
    let z2 = z * z;
    let series =
        four([L[0], L[1], L[2], L[3]], z, z2) + z2 * z2 * four([L[4], L[5], L[6], L[7]], z, z2);
    let small = z2 * series + rest * (first + s);
    let square = first * first;
    let three = cut(3.0 + square + small);
    let three_rest = small - ((three - 3.0) - square);
    // the product of the two, times 2/(3 ln 2)
    let product = first * three;
    let product_rest = rest * three + three_rest * s;
    let head = cut(product + product_rest);
    let head_rest = product_rest - (head - product);
    let large = SCALE_FIRST * head;
    let small = SCALE_REST * head + head_rest * SCALE;
    let result = cut(k + (large + small));
    (result, small - ((result - k) - large))
}

/// Returns `xʸ`, to 1.3 units in the last place, for x positive, normal and finite, or zero; NaN
/// otherwise.
#[inline(always)]
pub fn powf(x: f64, y: f64) -> f64 {
    let (log, log_rest) = log2_in_parts(x);
    let first = cut(y);
    let power = exp2_of_sum(first * log, (y - first) * log + y * log_rest);
    let of_zero = select(y > 0.0, 0.0, select(y < 0.0, f64::INFINITY, 1.0 + y));
    select(x == 0.0, of_zero, power)
}

/// Returns `xʸ lnⁿ x` for the arguments of [`powf`] and [`ln`].
#[inline(always)]
pub fn power_log(x: f64, y: f64, n: i32) -> f64 {
    let log = ln(x);
    let mut result = powf(x, y);
    for _ in 0..n {
        result *= log;
    }
    result
}

/// Returns the cube root, to 0.7 units in the last place, of a normal and finite number or zero;
/// NaN otherwise.
///
/// The exponent gives a guess to 5 bits, a polynomial improves it to 23 bits, and one step of
/// Newton's method to rounding (FreeBSD, `s_cbrt.c`).
#[inline(always)]
pub fn cbrt(x: f64) -> f64 {
    /// Coefficients of `(1 + u)^(−1/3)` for `|u| ≤ 0.12`.
    const C: [f64; 6] = [
        1.000_000_010_541_889_4,
        -0.333_333_342_875_250_07,
        0.222_209_053_610_332_77,
        -0.172_827_586_880_665_13,
        0.146_462_244_409_584_83,
        -0.127_027_186_652_432_3,
    ];
    /// Bits of 2⁵².
    const FROM_INTEGER: u64 = 0x4330_0000_0000_0000;
    let size = x.abs();
    let valid = (f64::MIN_POSITIVE..=f64::MAX).contains(&size);
    let size = select(valid, size, f64::NAN);
    // A third of the upper half of the bits, computed with floating-point numbers: vectors do not
    // divide integers.
    let upper = f64::from_bits(size.to_bits() >> 32 | FROM_INTEGER) - 4_503_599_627_370_496.0;
    let third = upper * (1.0 / 3.0) + 715_094_163.0;
    let guess = f64::from_bits((third + 4_503_599_627_370_496.0).to_bits() << 32);
    let u = guess * guess * (guess / size) - 1.0;
    let u2 = u * u;
    let better = guess * (four([C[0], C[1], C[2], C[3]], u, u2) + u2 * u2 * (C[4] + u * C[5]));
    // to 23 bits, so that the square is exact
    let t = f64::from_bits(better.to_bits().wrapping_add(1 << 29) & !((1 << 30) - 1));
    let quotient = size / (t * t);
    let root = t + t * ((quotient - t) / (2.0 * t + quotient));
    select(
        x == 0.0,
        x,
        f64::from_bits(root.to_bits() | x.to_bits() & SIGN),
    )
}

/// Returns `√(x² + y²)`, to 1.3 units in the last place; NaN where the sum of squares is not
/// between 2⁻⁹⁰⁰ and the largest number.
#[inline(always)]
pub fn hypot(x: f64, y: f64) -> f64 {
    const SMALLEST: f64 = 1e-270;
    let sum = x * x + y * y;
    select((SMALLEST..=f64::MAX).contains(&sum), sum.sqrt(), f64::NAN)
}

//! Logarithms.
//!
//! `x = 2ᵏ (1 + f)` with `√½ ≤ 1 + f < √2`; with `s = f/(2 + f)`, `ln(1 + f) = 2 atanh s = f −
//! f²/2 + s (f²/2 + s² R(s²))` (fdlibm, `e_log.c`).

use super::{four, select};

/// Bits of √½.
const ROOT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
/// Bits of 1.
const ONE: u64 = 0x3ff0_0000_0000_0000;
/// The bits of the mantissa.
const MANTISSA: u64 = (1 << 52) - 1;
/// Bits of 2⁵²: a bitwise or with an integer adds the integer.
const FROM_INTEGER: u64 = 0x4330_0000_0000_0000;

/// ln 2; the first part has 32 bits.
const LN_2_FIRST: f64 = 0.693_147_180_369_123_8;
const LN_2_REST: f64 = 1.908_214_929_270_587_7e-10;
/// 1/ln 2 and 1/ln 10; the first part has 21 bits.
const LOG2_E_FIRST: f64 = 1.442_694_664_001_464_8;
const LOG2_E_REST: f64 = 3.768_874_985_636_099e-7;
const LOG10_E_FIRST: f64 = 0.434_294_462_203_979_5;
const LOG10_E_REST: f64 = 1.969_927_233_546_362_7e-8;
/// log₁₀ 2; the first part has 32 bits.
const LOG10_2_FIRST: f64 = 0.301_029_995_549_470_2;
const LOG10_2_REST: f64 = 1.145_110_089_802_183_8e-10;

/// Coefficients of R in `2 atanh s = 2s + s³ R(s²)`.
const R: [f64; 7] = [
    0.666_666_666_666_667,
    0.399_999_999_998_994_44,
    0.285_714_286_260_032_7,
    0.222_222_111_302_598_78,
    0.181_828_894_556_749_47,
    0.153_317_106_182_107_73,
    0.146_165_854_248_886_23,
];

/// Returns the exponent k of a number and `f` with `x = 2ᵏ (1 + f)`, `√½ ≤ 1 + f < √2`; f is NaN
/// unless x is positive, normal and finite.
#[inline(always)]
pub(super) fn split(x: f64) -> (f64, f64) {
    let shifted = x.to_bits().wrapping_add(ONE - ROOT_HALF);
    // 2⁵² + k + 1023
    let k = f64::from_bits(shifted >> 52 | FROM_INTEGER) - (4_503_599_627_370_496.0 + 1023.0);
    let m = f64::from_bits((shifted & MANTISSA).wrapping_add(ROOT_HALF));
    let valid = (f64::MIN_POSITIVE..=f64::MAX).contains(&x);
    (k, select(valid, m - 1.0, f64::NAN))
}

/// Returns `f²/2` and `ln(1 + f) − f + f²/2`.
#[inline(always)]
fn tail(f: f64) -> (f64, f64) {
    let s = f / (2.0 + f);
    let half = 0.5 * f * f;
    let z = s * s;
    let z2 = z * z;
    let last = (R[4] + z * R[5]) + z2 * R[6];
    let r = z * (four([R[0], R[1], R[2], R[3]], z, z2) + z2 * z2 * last);
    (half, s * (half + r))
}

/// Returns the natural logarithm, to 0.9 units in the last place; NaN unless `x` is positive,
/// normal and finite.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    let (k, f) = split(x);
    let (half, rest) = tail(f);
    k * LN_2_FIRST - ((half - (rest + k * LN_2_REST)) - f)
}

/// Returns `ln(1 + x)`, to one unit in the last place, for `−1 < x < 2¹⁰²³`; NaN otherwise.
#[inline(always)]
pub fn ln_1p(x: f64) -> f64 {
    let sum = 1.0 + x;
    // rounding error of the sum
    let part = sum - x;
    let lost = (1.0 - part) + (x - (sum - part));
    let (k, f0) = split(sum);
    // 2⁻ᵏ; zero for the largest numbers, for which the rounding error is negligible
    let scale = f64::from_bits(((1023.0 - k + super::TO_INTEGER).to_bits()) << 52);
    let lost = lost * scale;
    let f = f0 + lost;
    let lost = (f0 - f) + lost;
    let (half, rest) = tail(f);
    let result = k * LN_2_FIRST - ((half - (rest + (k * LN_2_REST + lost))) - f);
    // keeps the sign of −0
    result.copysign(x)
}

/// Returns `ln(1 + f)` in two parts, the first of 20 bits.
#[inline(always)]
fn two_parts(f: f64) -> (f64, f64) {
    let (half, rest) = tail(f);
    let first = f64::from_bits((f - half).to_bits() & !0xffff_ffff);
    (first, ((f - first) - half) + rest)
}

/// Returns the logarithm to base 2, to one unit in the last place; NaN unless `x` is positive,
/// normal and finite.
#[inline(always)]
pub fn log2(x: f64) -> f64 {
    let (k, f) = split(x);
    let (first, rest) = two_parts(f);
    let large = first * LOG2_E_FIRST;
    let small = (rest + first) * LOG2_E_REST + rest * LOG2_E_FIRST;
    let sum = k + large;
    sum + (((k - sum) + large) + small)
}

/// Returns the logarithm to base 10, to one unit in the last place; NaN unless `x` is positive,
/// normal and finite.
#[inline(always)]
pub fn log10(x: f64) -> f64 {
    let (k, f) = split(x);
    let (first, rest) = two_parts(f);
    let large = first * LOG10_E_FIRST;
    let small = k * LOG10_2_REST + (first + rest) * LOG10_E_REST + rest * LOG10_E_FIRST;
    let power = k * LOG10_2_FIRST;
    let sum = power + large;
    sum + (((power - sum) + large) + small)
}

//! `eˣ`, `2ˣ` and `eˣ − 1`.
//!
//! `x = k ln 2 + r` with an integer k and `|r| ≤ ln 2/2`; then `eˣ = 2ᵏ (1 + (eʳ − 1))`, and
//! `eʳ − 1 = r + r² Q(r)`. The first part of ln 2 has 32 bits, so that its products with k are
//! exact.

use core::f64::consts::LOG2_E;

use super::{four, nearest, power_of_two, select};

/// Arguments of `eˣ` beyond this have no other values: infinity above, and 0 below.
const FAR: f64 = 750.0;

const LN_2_FIRST: f64 = 0.693_147_180_369_123_8;
const LN_2_REST: f64 = 1.908_214_929_270_587_7e-10;

/// Coefficients of Q in `eʳ − 1 = r + r² Q(r)`.
const Q: [f64; 11] = [
    0.5,
    0.166_666_666_666_666_7,
    0.041_666_666_666_666_67,
    0.008_333_333_333_326_136,
    0.001_388_888_888_888_374_8,
    0.000_198_412_698_748_206_27,
    2.480_158_732_554_774_3e-5,
    2.755_725_540_020_642_2e-6,
    2.755_727_364_311_03e-7,
    2.510_521_700_472_074_5e-8,
    2.091_468_696_808_687_6e-9,
];

/// Coefficients of P in `2ʳ − 1 = r ln 2 + r² P(r)`.
const P: [f64; 11] = [
    0.240_226_506_959_100_72,
    0.055_504_108_664_821_6,
    0.009_618_129_107_628_479,
    0.001_333_355_814_641_691_6,
    0.000_154_035_303_933_759_03,
    1.525_273_382_986_708e-5,
    1.321_548_680_291_925_6e-6,
    1.017_806_242_697_692_4e-7,
    7.054_899_947_032_901e-9,
    4.454_964_371_269_296_7e-10,
    2.572_509_925_288_868_7e-11,
];

/// Evaluates a polynomial of eleven terms.
#[inline(always)]
fn eleven(c: &[f64; 11], r: f64, r2: f64) -> f64 {
    let r4 = r2 * r2;
    let last = (c[8] + r * c[9]) + r2 * c[10];
    four([c[0], c[1], c[2], c[3]], r, r2) + r4 * (four([c[4], c[5], c[6], c[7]], r, r2) + r4 * last)
}

/// Returns the nearest number of a range; NaN for NaN.
#[inline(always)]
fn within(x: f64, low: f64, high: f64) -> f64 {
    let x = select(x < low, low, x);
    select(x > high, high, x)
}

/// Returns k and `eʳ − 1`.
#[inline(always)]
fn reduced(x: f64) -> (f64, f64) {
    let k = nearest(x * LOG2_E).0;
    let first = x - k * LN_2_FIRST;
    let rest = k * LN_2_REST;
    let r = first - rest;
    let r2 = r * r;
    (k, first - (rest - r2 * eleven(&Q, r, r2)))
}

/// Returns two normal powers of 2 whose product is 2 to the power of an integer k from −1140 to
/// 1140. The second one is 1 for `|k| ≤ 1021`.
#[inline(always)]
fn powers_of_two(k: f64) -> [f64; 2] {
    let is_far = k.abs() > 1021.0;
    let moved = select(is_far, 128f64.copysign(k), 0.0);
    let rest = select(k > 0.0, 2f64.powi(128), 2f64.powi(-128));
    [
        power_of_two(nearest(k - moved).1),
        select(is_far, rest, 1.0),
    ]
}

/// Returns `eˣ`, to 0.9 units in the last place; to a unit where it is subnormal.
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    let (k, e) = reduced(within(x, -FAR, FAR));
    let [scale, more] = powers_of_two(k);
    (1.0 + e) * scale * more
}

/// Returns `eˣ − 1`, to 1.5 units in the last place.
#[inline(always)]
pub fn exp_m1(x: f64) -> f64 {
    // below −100 the result is −1
    let (k, e) = reduced(within(x, -100.0, FAR));
    let [scale, more] = powers_of_two(k);
    // keeps the sign of −0
    ((scale * e + (scale - 1.0)) * more).copysign(x)
}

/// Returns `2ˣ`, to 1.2 units in the last place; to a unit where it is subnormal.
#[inline(always)]
pub fn exp2(x: f64) -> f64 {
    exp2_of_sum(x, 0.0)
}

/// Returns `2` to the power `x + rest`; `rest` is small relative to x or 1.
#[inline(always)]
pub(super) fn exp2_of_sum(x: f64, rest: f64) -> f64 {
    let rest = select(x.abs() > 1100.0, 0.0, rest);
    let x = within(x, -1100.0, 1100.0);
    let k = nearest(x).0;
    let first = x - k;
    let r = first + rest;
    let rest = (first - r) + rest;
    let r2 = r * r;
    let e = r * core::f64::consts::LN_2 + (r2 * eleven(&P, r, r2) + rest * core::f64::consts::LN_2);
    let [scale, more] = powers_of_two(k);
    (1.0 + e) * scale * more
}

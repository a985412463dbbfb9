//! Box and Muller's transform: random words to standard normals.
//!
//! Input: two words, uniform and independent, and a scale. Output: two independent normals of that standard deviation.
//! Invariant: a pure function of additions, multiplications, divisions and square roots, without fused operations: the
//! same bits on every machine, for one pair or for lanes of pairs. |z| ≤ √(130 ln 2) = 9.4926; a true normal
//! exceeds this bound once in 4·10²⁰ draws.
//!
//! The first word w gives the radius √(−2 ln u) with u = (w + ½)/2⁶⁴: small u, which give the tail of the distribution, keep all 64 bits
//! (53 bits would end the tail at 8.6). The second word gives the angle: 62 bits give an angle in (−π/4, π/4), where sine and cosine
//! need no argument reduction, and the two top bits give the quarter of the circle. Every cell of the partition is
//! represented by its centre, so all odd moments are exactly 0. Given the words, the relative error of each z is below 2·10⁻¹⁵
//! (1.7·10⁻¹⁵ in 60,000 pairs of all sizes against 45 digits).
//!
//! The logarithm of u = 2ᵉ m with √½ ≤ m < √2 is found by the series of artanh((m − 1)/(m + 1)). Sine and cosine are found by
//! tripling an angle in (−π/12, π/12): sin 3φ = s (3 − 4s²), cos 3φ = c (1 − 4s²), which takes fewer operations than direct polynomials. The
//! polynomials are minimax in the relative error, with an exact first coefficient (Remez' algorithm at 50 digits).
//!
//! Source: Box, Muller, *A note on the generation of random normal deviates*, Ann. Math. Statist. 29 (1958).

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6, LN_2};

#[cfg(feature = "ensemble")]
use crate::lanes::{LANES, Lane};

/// 2⁶⁴. Words are used as integers: to scale them to fractions would cost an operation.
const ONE: f64 = 4.0 * (1_u64 << 62) as f64;
/// 2⁶³, the range of a signed word.
const HALF: f64 = 0.5 * ONE;
const ROOT_HALF: f64 = FRAC_1_SQRT_2 * ONE;

/// Sign and exponent of a number.
const EXPONENT: u64 = 0xfff0_0000_0000_0000;
const EXPONENT_UNIT: u64 = 1 << 52;
const TWO_TO_52: f64 = EXPONENT_UNIT as f64;
const TWO_TO_84: f64 = TWO_TO_52 * (1_u64 << 32) as f64;
/// Offset that makes exponents positive.
const EXCESS: u64 = 1024;
const MINUS_TWO_LN_2: f64 = -2.0 * LN_2;

/// −4 artanh(s)/s in s², to 1.9·10⁻¹⁶ for |s| ≤ 0.1716.
const LOGARITHM: [f64; 7] = [
    -4.0,
    -1.333_333_333_331_749_9,
    -0.800_000_001_042_753_7,
    -0.571_428_343_020_530_6,
    -0.444_467_404_709_858_07,
    -0.362_473_747_679_247_06,
    -0.336_386_115_469_272_55,
];

/// 2 sin(πx/12)/x in x², to 1.0·10⁻¹⁶ for |x| ≤ 1.
const SINE: [f64; 5] = for_words(
    [
        FRAC_PI_6,
        -5.981_149_050_982_373_5e-3,
        2.049_707_463_832_443_2e-5,
        -3.344_870_575_547_403e-8,
        3.179_249_995_463_3e-11,
    ],
    1.0 / HALF,
);

/// 2 cos(πx/12) in x², to 9.4·10⁻¹⁶ for |x| ≤ 1.
const COSINE: [f64; 5] = for_words(
    [
        2.0,
        -6.853_891_945_195_072e-2,
        3.914_652_894_024_460_4e-4,
        -8.943_518_876_328_085e-7,
        1.092_574_279_629_52e-9,
    ],
    1.0,
);

/// Returns the coefficients for an argument that is 2⁶³ times as large, all multiplied by `factor`. Exact for powers of two.
const fn for_words(mut coefficients: [f64; 5], mut factor: f64) -> [f64; 5] {
    let mut k = 0;
    while k < 5 {
        coefficients[k] *= factor;
        factor *= 1.0 / (HALF * HALF);
        k += 1;
    }
    coefficients
}

/// Returns four normals of standard deviation `scale`, a pair for each two words.
#[inline(always)]
pub(crate) fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
    let [a, b, c, d] = words;
    let [z0, z1] = pair(a, b, scale);
    let [z2, z3] = pair(c, d, scale);
    [z0, z1, z2, z3]
}

/// Returns two independent normals of standard deviation `scale`.
#[inline(always)]
pub(crate) fn pair(radius: u64, angle: u64, scale: f64) -> [f64; 2] {
    normals::<true>(log_argument::<true>(radius), angle, 0.5 * scale)
}

/// Fills the four rows with [`four`] of each lane's words. `DIRECT` says how words become numbers, see [`number`].
///
/// A first loop generates the words and divides: the divider works while further words are generated. A single loop would take an eighth
/// longer.
#[cfg(feature = "ensemble")]
#[inline(always)]
pub(super) fn fill_lanes<const DIRECT: bool>(
    words: impl Fn(usize) -> [u64; 4],
    scale: f64,
    [a, b, c, d]: &mut [Lane; 4],
) {
    let half_scale = 0.5 * scale;
    let mut angles = [[0; LANES]; 2];
    let mut exponents = [[0; LANES]; 2];
    let mut quotients = [[0.0; LANES]; 2];
    for lane in 0..LANES {
        let words = words(lane);
        for j in 0..2 {
            LogArgument {
                exponent: exponents[j][lane],
                s: quotients[j][lane],
            } = log_argument::<DIRECT>(words[2 * j]);
            angles[j][lane] = words[2 * j + 1];
        }
    }
    for lane in 0..LANES {
        let argument = |j: usize| LogArgument {
            exponent: exponents[j][lane],
            s: quotients[j][lane],
        };
        [a[lane], b[lane]] = normals::<DIRECT>(argument(0), angles[0][lane], half_scale);
        [c[lane], d[lane]] = normals::<DIRECT>(argument(1), angles[1][lane], half_scale);
    }
}

/// A uniform number u = 2ᵉ m with √½ ≤ m < √2, in the form that its logarithm needs.
#[derive(Clone, Copy)]
struct LogArgument {
    /// e, in the bits of a number's exponent.
    exponent: u64,
    /// (m − 1)/(m + 1).
    s: f64,
}

/// Returns u = (w + ½)/2⁶⁴.
#[inline(always)]
fn log_argument<const DIRECT: bool>(w: u64) -> LogArgument {
    // u − 1 if u ≥ ½, which is exact near 1; otherwise u
    let near = number::<DIRECT>(w) + 0.5;
    let u = if near < 0.0 { near + ONE } else { near };
    let exponent = u.to_bits().wrapping_sub(ROOT_HALF.to_bits()) & EXPONENT;
    let m = f64::from_bits(u.to_bits().wrapping_sub(exponent));
    let f = if u >= ROOT_HALF { near } else { m - ONE };
    LogArgument {
        exponent,
        s: f / (m + ONE),
    }
}

/// Returns the two normals of a radius and an angle.
#[inline(always)]
fn normals<const DIRECT: bool>(radius: LogArgument, angle: u64, half_scale: f64) -> [f64; 2] {
    let LogArgument { exponent, s } = radius;
    let minus_two_ln = minus_two_ln_2::<DIRECT>(exponent) + s * polynomial7(&LOGARITHM, s * s);
    let half_r = half_scale * minus_two_ln.sqrt();
    // The shift drops the two top bits. The bit set is the centre of a cell of width 4.
    let x = number::<DIRECT>((angle << 2) | 2);
    let square = x * x;
    let c = polynomial5(&COSINE, square);
    let s = x * polynomial5(&SINE, square);
    let s_squared = s * s;
    let x = half_r * (c * (1.0 - s_squared));
    let y = half_r * (s * (3.0 - s_squared));
    // The top bits mirror the quarter around the first axis to the opposite quarter and to the other axis.
    let x = f64::from_bits(x.to_bits() ^ (angle & (1 << 63)));
    if angle & (1 << 62) == 0 {
        [x, y]
    } else {
        [y, x]
    }
}

/// Rounds a word, as a signed integer, to the nearest number.
///
/// `DIRECT` uses the instruction of the machine. Vectors before AVX-512 have none: the halves of the word become the low bits of 2⁵² and 2⁸⁴, the
/// last addition is the only rounding, and the bits are the same.
#[inline(always)]
fn number<const DIRECT: bool>(w: u64) -> f64 {
    if DIRECT {
        return w.cast_signed() as f64;
    }
    let low = f64::from_bits(TWO_TO_52.to_bits() | (w & 0xffff_ffff));
    // The inverted sign bit adds 2⁶³.
    let high = f64::from_bits(TWO_TO_84.to_bits() | ((w >> 32) ^ 0x8000_0000));
    (high - (TWO_TO_84 + HALF + TWO_TO_52)) + low
}

/// Returns −2e ln 2 for an exponent e in the bits of a number's exponent.
#[inline(always)]
fn minus_two_ln_2<const DIRECT: bool>(exponent: u64) -> f64 {
    if DIRECT {
        return exponent.cast_signed() as f64 * (MINUS_TWO_LN_2 / TWO_TO_52);
    }
    let shifted = exponent.wrapping_add(EXCESS * EXPONENT_UNIT) >> 52;
    (f64::from_bits(TWO_TO_52.to_bits() | shifted) - (TWO_TO_52 + EXCESS as f64)) * MINUS_TWO_LN_2
}

/// Evaluates a polynomial as two chains. Shorter chains would not help: many lanes are computed at the same time, and the scheduler of the processor
/// holds few operations.
#[inline(always)]
fn polynomial7(c: &[f64; 7], x: f64) -> f64 {
    let y = x * x;
    (c[0] + y * (c[2] + y * (c[4] + y * c[6]))) + x * (c[1] + y * (c[3] + y * c[5]))
}

/// Evaluates a polynomial as two chains.
#[inline(always)]
fn polynomial5(c: &[f64; 5], x: f64) -> f64 {
    let y = x * x;
    (c[0] + y * (c[2] + y * c[4])) + x * (c[1] + y * c[3])
}

#[cfg(test)]
mod tests;

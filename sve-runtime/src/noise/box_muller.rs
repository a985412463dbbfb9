//! Random words to standard normals.
//!
//! Input: two words, uniform and independent, and a scale. Output: two independent normals of that standard deviation.
//! Invariant: a pure function of additions, multiplications, divisions and square roots alone, none contracted into another: the
//! same bits on every machine, for one pair or for a lane of them. |z| ≤ √(130 ln 2) = 9.4926 always, where a true normal
//! exceeds this once in 4·10²⁰ draws.
//!
//! The first word w gives the radius √(−2 ln u) with u = (w + ½)/2⁶⁴, so that small u, the tail, keep all 64 bits
//! (53 would end it at 8.6). The second gives the angle: 62 bits of it an angle in (−π/4, π/4), where sine and cosine
//! need no reduction and lose nothing by it, its two top bits the quarter of the circle. Every cell of the partition is
//! represented by its centre, so all odd moments are exactly 0.
//!
//! The logarithm is that of u = 2ᵉ m with √½ ≤ m < √2, by the series of artanh((m − 1)/(m + 1)). There and for sine and cosine the
//! polynomials are those of least relative error with an exact first coefficient (by Remez' exchange at 50 digits).
//!
//! Source: Box, Muller, *A note on the generation of random normal deviates*, Ann. Math. Statist. 29 (1958).

/// 2⁶⁴: words are taken as they are, not as fractions, where a power of two costs an operation.
const ONE: f64 = 4.0 * (1_u64 << 62) as f64;
/// √½ of it.
const ROOT_HALF: f64 = core::f64::consts::FRAC_1_SQRT_2 * ONE;
/// Sign and exponent of a number.
const EXPONENT: u64 = 0xfff0_0000_0000_0000;

/// −2 ln 2 over the unit of the exponent.
const EXPONENT_UNIT: f64 = -2.0 * core::f64::consts::LN_2 / (1_u64 << 52) as f64;

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

/// sin(πx/4)/x in x², to 4·10⁻¹⁸ for |x| ≤ 1.
const SINE: [f64; 7] = scaled(
    [
        core::f64::consts::FRAC_PI_4,
        -0.080_745_512_188_280_6,
        0.002_490_394_570_189_368_8,
        -3.657_620_416_064_561_4e-5,
        3.133_616_253_296_359e-7,
        -1.757_152_234_710_080_2e-9,
        6.878_006_891_467_312e-12,
    ],
    1.0 / HALF,
);

/// cos(πx/4) in x², to 6·10⁻¹⁷ for |x| ≤ 1.
const COSINE: [f64; 7] = scaled(
    [
        1.0,
        -0.308_425_137_534_038_83,
        0.015_854_344_243_747_46,
        -0.000_325_991_886_497_932_55,
        3.590_859_195_895_426_6e-6,
        -2.460_951_470_965_325e-8,
        1.136_556_953_103_646_6e-10,
    ],
    1.0,
);

/// 2⁶³, the range of a word with sign.
const HALF: f64 = 0.5 * ONE;

/// The coefficients for an argument that is 2⁶³ times as large, and a factor for all of them. Exact: powers of two.
const fn scaled(mut coefficients: [f64; 7], mut factor: f64) -> [f64; 7] {
    let mut k = 0;
    while k < 7 {
        coefficients[k] *= factor;
        factor *= 1.0 / (HALF * HALF);
        k += 1;
    }
    coefficients
}

#[inline(always)]
fn polynomial(c: &[f64; 7], x: f64) -> f64 {
    c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * (c[4] + x * (c[5] + x * c[6])))))
}

/// Four normals of standard deviation `scale`, a pair from each two words.
#[inline(always)]
pub(super) fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
    let [a, b, c, d] = words;
    let [z0, z1] = pair(a, b, scale);
    let [z2, z3] = pair(c, d, scale);
    [z0, z1, z2, z3]
}

/// Two independent normals of standard deviation `scale`.
#[inline(always)]
pub(crate) fn pair(radius: u64, angle: u64, scale: f64) -> [f64; 2] {
    let r = scale * minus_two_ln(radius).sqrt();
    // the two top bits go; the bit set below them is the centre of a cell of width 4
    let x = ((angle << 2) | 2).cast_signed() as f64;
    let square = x * x;
    let c = r * polynomial(&COSINE, square);
    let s = r * (x * polynomial(&SINE, square));
    // the quarter around the first axis, mirrored to the opposite one and to the other axis
    let c = f64::from_bits(c.to_bits() ^ (angle & (1 << 63)));
    if angle & (1 << 62) == 0 {
        [c, s]
    } else {
        [s, c]
    }
}

/// −2 ln u with u = (w + ½)/2⁶⁴.
#[inline(always)]
fn minus_two_ln(w: u64) -> f64 {
    // u − 1 where u ≥ ½, so that near 1 nothing is lost; else u
    let near = w.cast_signed() as f64 + 0.5;
    let u = if near < 0.0 { near + ONE } else { near };
    let exponent = (u.to_bits().wrapping_sub(ROOT_HALF.to_bits())) & EXPONENT;
    let m = f64::from_bits(u.to_bits().wrapping_sub(exponent));
    let f = if u >= ROOT_HALF { near } else { m - ONE };
    let s = f / (m + ONE);
    exponent.cast_signed() as f64 * EXPONENT_UNIT + s * polynomial(&LOGARITHM, s * s)
}

#[cfg(test)]
mod tests {
    use super::{four, pair};

    /// From the formulas in the header at 40 digits.
    const REFERENCE: [([u64; 2], [f64; 2]); 8] = [
        ([0, 0], [9.492_583_076_949_755, 1.616_644_603_458_149_5e-18]),
        (
            [0, 0x4000_0000_0000_0000],
            [1.616_644_603_458_149_5e-18, 9.492_583_076_949_755],
        ),
        (
            [1, 0x9fff_ffff_ffff_ffff],
            [-6.629_928_690_998_745, 6.629_928_690_998_745],
        ),
        (
            [0x8000_0000_0000_0000, 0xe000_0000_0000_0000],
            [-0.832_554_611_157_697_8, -0.832_554_611_157_697_8],
        ),
        (
            [0x4071_fabe_e1dc_8e05, 0x02ed_3113_695c_9c62],
            [1.656_657_758_065_891, 0.119_199_236_083_475_37],
        ),
        (
            [0x3973_11b5_b89f_9d49, 0xe212_92c3_2580_24bc],
            [-1.158_668_211_232_867_5, -1.282_977_258_869_464_3],
        ),
        (
            [0x7eae_d935_4797_22b5, 0x9099_4358_c429_f31c],
            [-1.089_082_324_494_388, 0.469_977_386_988_023],
        ),
        (
            [0xf000_0000_0000_0000, 0x5123_4567_89ab_cdef],
            [0.146_702_083_207_769_6, 0.327_956_614_596_569_8],
        ),
    ];

    #[test]
    fn agrees_with_forty_digits() {
        for ([radius, angle], expected) in REFERENCE {
            let z = pair(radius, angle, 1.0);
            for i in 0..2 {
                // a few roundings of r, of the angle and of the product
                let tolerance = 4.0 * f64::EPSILON * expected[i].abs().max(0.5);
                assert!(
                    (z[i] - expected[i]).abs() <= tolerance,
                    "{radius:#x} {angle:#x} [{i}]: {} for {}",
                    z[i],
                    expected[i]
                );
            }
        }
    }

    #[test]
    fn the_ends_are_finite() {
        for radius in [0, 1, u64::MAX - 1, u64::MAX] {
            for angle in [0, 1, 1 << 61, (1 << 61) - 1, 1 << 63, u64::MAX] {
                for z in pair(radius, angle, 1.0) {
                    assert!(z.abs() <= (130.0 * 2.0_f64.ln()).sqrt() * (1.0 + f64::EPSILON));
                }
            }
        }
        // half a cell below 1: √(−2 ln(1 − 2⁻⁶⁵)) = 2⁻³²
        let smallest = 0.5_f64.powi(32);
        let z = pair(u64::MAX, 0, 1.0)[0];
        assert!((z - smallest).abs() <= 2.0 * f64::EPSILON * smallest, "{z}");
    }

    #[test]
    fn angle_bits_turn_the_pair_exactly() {
        let radius = 0x1234_5678_9abc_def0;
        for fraction in [0, 5, 1 << 60, (1 << 62) - 1, 0x0abc_def0_1234_5678] {
            let [x, y] = pair(radius, fraction, 1.0);
            assert_eq!(pair(radius, fraction | 1 << 63, 1.0), [-x, y]);
            assert_eq!(pair(radius, fraction | 1 << 62, 1.0), [y, x]);
            assert_eq!(pair(radius, fraction | 3 << 62, 1.0), [y, -x]);
            // the opposite cell of the same quarter
            assert_eq!(pair(radius, !fraction & ((1 << 62) - 1), 1.0), [x, -y]);
        }
    }

    #[test]
    fn small_uniforms_are_not_truncated() {
        // u = 2^-60 · 1.03125 and its neighbours are far below the 2^-53 of a usual uniform
        let [a, b, c] = [16, 17, 18].map(|w| pair(w, 0, 1.0)[0]);
        assert!(9.0 < c && c < b && b < a && a < 9.2, "{a} {b} {c}");
    }

    #[test]
    fn four_are_two_pairs() {
        let [a, b] = [pair(1 << 40, 2 << 50, 1.0), pair(3 << 45, 4 << 55, 1.0)];
        let words = [1 << 40, 2 << 50, 3 << 45, 4 << 55];
        assert_eq!(four(words, 1.0), [a[0], a[1], b[0], b[1]]);
    }
}

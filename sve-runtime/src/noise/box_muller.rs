//! Random words to standard normals.
//!
//! Input: two words, uniform and independent, and a scale. Output: two independent normals of that standard deviation.
//! Invariant: a pure function of additions, multiplications, divisions and square roots, none contracted into another: the
//! same bits on every machine, for one pair or for a lane of them. |z| ≤ √(130 ln 2) = 9.4926 always, where a true normal
//! exceeds this once in 4·10²⁰ draws.
//!
//! The first word w gives the radius √(−2 ln u) with u = (w + ½)/2⁶⁴, so that small u, the tail, keep all 64 bits
//! (53 would end it at 8.6). The second gives the angle: 62 bits of it an angle in (−π/4, π/4), where sine and cosine
//! need no reduction and lose nothing by it, its two top bits the quarter of the circle. Every cell of the partition is
//! represented by its centre, so all odd moments are exactly 0. Given the words, the relative error of each z is below 2·10⁻¹⁵
//! (1.7·10⁻¹⁵ in 60,000 pairs of all sizes against 45 digits).
//!
//! The logarithm is that of u = 2ᵉ m with √½ ≤ m < √2, by the series of artanh((m − 1)/(m + 1)). Sine and cosine are those of
//! three times an angle in (−π/12, π/12): sin 3φ = s (3 − 4s²), cos 3φ = c (1 − 4s²), fewer operations than direct ones. The
//! polynomials have the least relative error with an exact first coefficient (Remez' exchange at 50 digits).
//!
//! Source: Box, Muller, *A note on the generation of random normal deviates*, Ann. Math. Statist. 29 (1958).

use core::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_6, LN_2};

#[cfg(feature = "ensemble")]
use crate::lanes::{LANES, Lane};

/// 2⁶⁴: words are taken as they are, not as fractions, where a power of two costs an operation.
const ONE: f64 = 4.0 * (1_u64 << 62) as f64;
/// 2⁶³, the range of a word with sign.
const HALF: f64 = 0.5 * ONE;
const ROOT_HALF: f64 = FRAC_1_SQRT_2 * ONE;

/// Sign and exponent of a number.
const EXPONENT: u64 = 0xfff0_0000_0000_0000;
const EXPONENT_UNIT: u64 = 1 << 52;
const TWO_TO_52: f64 = EXPONENT_UNIT as f64;
const TWO_TO_84: f64 = TWO_TO_52 * (1_u64 << 32) as f64;
/// Makes exponents positive.
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

/// The coefficients for an argument that is 2⁶³ times as large, and a factor for all of them. Exact: powers of two.
const fn for_words(mut coefficients: [f64; 5], mut factor: f64) -> [f64; 5] {
    let mut k = 0;
    while k < 5 {
        coefficients[k] *= factor;
        factor *= 1.0 / (HALF * HALF);
        k += 1;
    }
    coefficients
}

/// Four normals of standard deviation `scale`, a pair from each two words.
#[inline(always)]
pub(crate) fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
    let [a, b, c, d] = words;
    let [z0, z1] = pair(a, b, scale);
    let [z2, z3] = pair(c, d, scale);
    [z0, z1, z2, z3]
}

/// Two independent normals of standard deviation `scale`.
#[inline(always)]
pub(crate) fn pair(radius: u64, angle: u64, scale: f64) -> [f64; 2] {
    turned::<true>(quotient::<true>(radius), angle, 0.5 * scale)
}

/// [`four`] for each lane. `DIRECT` says how words become numbers, see [`number`].
///
/// The quotients have a pass of their own with the words: the divider then works while words are made. In one pass the time is longer
/// by an eighth.
#[cfg(feature = "ensemble")]
#[inline(always)]
pub(super) fn row<const DIRECT: bool>(
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
            Quotient {
                exponent: exponents[j][lane],
                s: quotients[j][lane],
            } = quotient::<DIRECT>(words[2 * j]);
            angles[j][lane] = words[2 * j + 1];
        }
    }
    for lane in 0..LANES {
        let quotient = |j: usize| Quotient {
            exponent: exponents[j][lane],
            s: quotients[j][lane],
        };
        [a[lane], b[lane]] = turned::<DIRECT>(quotient(0), angles[0][lane], half_scale);
        [c[lane], d[lane]] = turned::<DIRECT>(quotient(1), angles[1][lane], half_scale);
    }
}

/// A uniform number u = 2ᵉ m with √½ ≤ m < √2.
#[derive(Clone, Copy)]
struct Quotient {
    /// e, at the place of an exponent.
    exponent: u64,
    /// (m − 1)/(m + 1).
    s: f64,
}

/// u = (w + ½)/2⁶⁴.
#[inline(always)]
fn quotient<const DIRECT: bool>(w: u64) -> Quotient {
    // u − 1 where u ≥ ½, so that near 1 nothing is lost; else u
    let near = number::<DIRECT>(w) + 0.5;
    let u = if near < 0.0 { near + ONE } else { near };
    let exponent = u.to_bits().wrapping_sub(ROOT_HALF.to_bits()) & EXPONENT;
    let m = f64::from_bits(u.to_bits().wrapping_sub(exponent));
    let f = if u >= ROOT_HALF { near } else { m - ONE };
    Quotient {
        exponent,
        s: f / (m + ONE),
    }
}

/// The normals of a radius and an angle.
#[inline(always)]
fn turned<const DIRECT: bool>(of: Quotient, angle: u64, half_scale: f64) -> [f64; 2] {
    let Quotient { exponent, s } = of;
    let minus_two_ln = minus_two_ln_2::<DIRECT>(exponent) + s * polynomial7(&LOGARITHM, s * s);
    let half_r = half_scale * minus_two_ln.sqrt();
    // the two top bits go; the bit set below them is the centre of a cell of width 4
    let x = number::<DIRECT>((angle << 2) | 2);
    let square = x * x;
    let c = polynomial5(&COSINE, square);
    let s = x * polynomial5(&SINE, square);
    let s_squared = s * s;
    let x = half_r * (c * (1.0 - s_squared));
    let y = half_r * (s * (3.0 - s_squared));
    // the quarter around the first axis, mirrored to the opposite one and to the other axis
    let x = f64::from_bits(x.to_bits() ^ (angle & (1 << 63)));
    if angle & (1 << 62) == 0 {
        [x, y]
    } else {
        [y, x]
    }
}

/// A word, as an integer with sign, to the nearest number. Without an instruction for it (`DIRECT` false: vectors before AVX-512) its
/// halves are put into the low bits of 2⁵² and 2⁸⁴, so the only rounding is the last addition, and the bits are the same.
#[inline(always)]
fn number<const DIRECT: bool>(w: u64) -> f64 {
    if DIRECT {
        return w.cast_signed() as f64;
    }
    let low = f64::from_bits(TWO_TO_52.to_bits() | (w & 0xffff_ffff));
    // the sign bit turned: an excess of 2⁶³
    let high = f64::from_bits(TWO_TO_84.to_bits() | ((w >> 32) ^ 0x8000_0000));
    (high - (TWO_TO_84 + HALF + TWO_TO_52)) + low
}

/// −2e ln 2 for an exponent e at its place.
#[inline(always)]
fn minus_two_ln_2<const DIRECT: bool>(exponent: u64) -> f64 {
    if DIRECT {
        return exponent.cast_signed() as f64 * (MINUS_TWO_LN_2 / TWO_TO_52);
    }
    let shifted = exponent.wrapping_add(EXCESS * EXPONENT_UNIT) >> 52;
    (f64::from_bits(TWO_TO_52.to_bits() | shifted) - (TWO_TO_52 + EXCESS as f64)) * MINUS_TWO_LN_2
}

/// In two chains, for many lanes are under way and the scheduler of the processor holds few.
#[inline(always)]
fn polynomial7(c: &[f64; 7], x: f64) -> f64 {
    let y = x * x;
    (c[0] + y * (c[2] + y * (c[4] + y * c[6]))) + x * (c[1] + y * (c[3] + y * c[5]))
}

/// Likewise.
#[inline(always)]
fn polynomial5(c: &[f64; 5], x: f64) -> f64 {
    let y = x * x;
    (c[0] + y * (c[2] + y * c[4])) + x * (c[1] + y * c[3])
}

#[cfg(test)]
mod tests {
    use super::{four, number, pair, quotient, turned};
    use crate::noise::threefry;

    /// What the header promises; 1.6·10⁻¹⁵ is the largest that was seen.
    const PROMISED: f64 = 2e-15;

    /// Words, and the exact transform of them at 45 digits.
    #[rustfmt::skip]
    const REFERENCE: [(u64, u64, [f64; 2]); 21] = [
        (0x0000_0000_0000_0000, 0x0000_0000_0000_0000, [9.492_583_076_949_755, 1.616_644_603_458_149_5e-18]),
        (0x0000_0000_0000_0000, 0x4000_0000_0000_0000, [1.616_644_603_458_149_5e-18, 9.492_583_076_949_755]),
        (0x0000_0000_0000_0001, 0x9fff_ffff_ffff_ffff, [-6.629_928_690_998_745, 6.629_928_690_998_745]),
        (0x8000_0000_0000_0000, 0xe000_0000_0000_0000, [-0.832_554_611_157_697_8, -0.832_554_611_157_697_8]),
        (0x4071_fabe_e1dc_8e05, 0x02ed_3113_695c_9c62, [1.656_657_758_065_891, 0.119_199_236_083_475_37]),
        (0x3973_11b5_b89f_9d49, 0xe212_92c3_2580_24bc, [-1.158_668_211_232_867_5, -1.282_977_258_869_464_3]),
        (0x7eae_d935_4797_22b5, 0x9099_4358_c429_f31c, [-1.089_082_324_494_388, 0.469_977_386_988_023]),
        (0xf000_0000_0000_0000, 0x5123_4567_89ab_cdef, [0.146_702_083_207_769_6, 0.327_956_614_596_569_8]),
        (0xffff_ffff_ffff_ffff, 0x1234_5678_9abc_def0, [2.099_742_475_908_980_2e-10, 1.006_028_030_072_297_7e-10]),
        (0xffff_ffff_ffff_fffe, 0x7fff_ffff_ffff_ffff, [-6.868_009_960_123_684e-29, 4.032_745_043_674_663_6e-10]),
        (0xffff_ffff_ffff_0000, 0x1fff_ffff_ffff_ffff, [5.960_441_740_128_155_4e-8, 5.960_441_740_128_155_4e-8]),
        (0xffff_ff01_2345_6789, 0x2000_0000_0000_0000, [0.000_243_597_489_731_866_87, -0.000_243_597_489_731_866_87]),
        (0xfff0_0000_0000_0001, 0x0000_0000_0000_0003, [0.022_098_435_789_617_073, 2.634_448_566_021_012e-20]),
        (0xb504_f333_f9de_6484, 0x0000_0001_0000_0000, [0.832_554_611_157_697_8, 1.217_959_192_781_625_3e-9]),
        (0xb504_f333_f9de_6485, 0xffff_ffff_0000_0000, [-1.217_959_192_498_047e-9, -0.832_554_611_157_697_8]),
        (0xb504_f333_f9de_6000, 0x8000_0000_0000_0001, [-0.832_554_611_157_697_9, 4.253_673_341_497_207_3e-19]),
        (0x7fff_ffff_ffff_ffff, 0x1555_5555_5555_5555, [1.019_666_990_168_809, 0.588_705_011_257_737_3]),
        (0x5a82_7999_fcef_3242, 0xd555_5555_5555_5555, [0.721_013_443_300_441_5, -1.248_831_916_736_546_7]),
        (0x0000_0000_000f_ffff, 0x3fff_ffff_ffff_ffff, [7.810_054_599_229_748, -1.330_099_775_604_534_6e-18]),
        (0x0000_0000_0020_0001, 0x2aaa_aaaa_aaaa_aaaa, [6.686_403_523_063_295, -3.860_396_873_951_055_7]),
        (0x0123_4567_89ab_cdef, 0xfedc_ba98_7654_3210, [-0.091_896_560_006_913_51, -3.289_947_693_606_653]),
    ];

    fn assert_close(radius: u64, angle: u64, expected: [f64; 2], tolerance: f64) {
        let z = pair(radius, angle, 1.0);
        for i in 0..2 {
            assert!(
                (z[i] - expected[i]).abs() <= tolerance * expected[i].abs(),
                "{radius:#x} {angle:#x} [{i}]: {:e} for {:e}",
                z[i],
                expected[i]
            );
        }
    }

    /// Words of all sizes, also near the ends and where the reduction of the logarithm changes.
    fn words() -> impl Iterator<Item = [u64; 2]> {
        (0..100_000).map(|i| {
            let [a, b, c, d] = threefry::block([i, 0, 0, 0], [9; 4]);
            let radius = match i % 4 {
                0 => a,
                1 => a >> (c % 64),
                2 => !(a >> (c % 64)),
                _ => 0xb504_f333_f9de_6484_u64.wrapping_add_signed(a.cast_signed() >> (c % 64)),
            };
            // the fraction of the quarter likewise
            let small = (b.cast_signed() >> (d % 62)).cast_unsigned() & ((1 << 62) - 1);
            let quarter = c & (3 << 62);
            let angle = match i / 4 % 3 {
                0 => b,
                1 => small | quarter,
                _ => (small ^ (1 << 61)) | quarter,
            };
            [radius, angle]
        })
    }

    #[test]
    fn agrees_with_exact_values() {
        for (radius, angle, expected) in REFERENCE {
            assert_close(radius, angle, expected, PROMISED);
        }
    }

    /// The formulas in the header by functions of the library.
    #[test]
    fn agrees_with_the_library_everywhere() {
        for [radius, angle] in words() {
            let two_to_64 = 2.0_f64.powi(64);
            let ln = if radius >> 63 == 0 {
                libm::log((radius as f64 + 0.5) / two_to_64)
            } else {
                libm::log1p(-((!radius) as f64 + 0.5) / two_to_64)
            };
            let r = (-2.0 * ln).sqrt();
            let fraction = ((angle << 2) | 2).cast_signed() as f64 / (0.5 * two_to_64);
            let (s, c) = libm::sincos(fraction * core::f64::consts::FRAC_PI_4);
            let x = if angle >> 63 == 0 { r * c } else { -r * c };
            let expected = if angle >> 62 & 1 == 0 {
                [x, r * s]
            } else {
                [r * s, x]
            };
            // the library and this formula round as well
            assert_close(radius, angle, expected, 2.0 * PROMISED);
        }
    }

    /// Machines without an instruction that turns words into numbers have the same bits.
    #[test]
    fn both_conversions_are_one() {
        for [radius, angle] in words() {
            for word in [radius, angle, radius ^ angle] {
                assert_eq!(
                    number::<false>(word).to_bits(),
                    number::<true>(word).to_bits()
                );
            }
            let split = turned::<false>(quotient::<false>(radius), angle, 0.5);
            assert_eq!(
                split.map(f64::to_bits),
                pair(radius, angle, 1.0).map(f64::to_bits)
            );
        }
        // ties are rounded to even
        for word in [
            (1 << 54) + 1,
            (1 << 54) + 2,
            (1 << 54) + 6,
            u64::MAX << 2,
            1 << 63,
            0,
            u64::MAX,
        ] {
            assert_eq!(
                number::<false>(word).to_bits(),
                number::<true>(word).to_bits()
            );
            assert_eq!(number::<true>(word), word.cast_signed() as f64);
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
    fn normals_beyond_eight_exist() {
        // 2⁻⁴⁹ < u < 2⁻⁴⁶ in the four directions
        for quarter in 0..4 {
            let z = pair(0x1_2345, quarter << 62, 1.0);
            let largest = z[0].abs().max(z[1].abs());
            assert!((8.0..8.4).contains(&largest), "{z:?}");
        }
    }

    #[test]
    fn a_scale_is_a_factor() {
        for [radius, angle] in words().take(1000) {
            let z = pair(radius, angle, 1.0);
            assert_eq!(pair(radius, angle, 0.25), z.map(|z| 0.25 * z));
            for (scaled, z) in pair(radius, angle, 0.3).into_iter().zip(z) {
                assert!((scaled - 0.3 * z).abs() <= PROMISED * (0.3 * z).abs());
            }
        }
    }

    #[test]
    fn four_are_two_pairs() {
        let [a, b] = [pair(1 << 40, 2 << 50, 1.0), pair(3 << 45, 4 << 55, 1.0)];
        let words = [1 << 40, 2 << 50, 3 << 45, 4 << 55];
        assert_eq!(four(words, 1.0), [a[0], a[1], b[0], b[1]]);
    }
}

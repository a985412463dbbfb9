//! Random words to standard normals.
//!
//! Input: two words, uniform and independent. Output: two independent standard normals.
//! Invariant: a pure function; |z| ≤ √(130 ln 2) = 9.4926 always, where a true normal exceeds this once in 4·10²⁰ draws.
//!
//! The first word w gives the radius √(−2 ln u) with u = (w + ½)/2⁶⁴, so that small u, the tail, keep all 64 bits
//! (53 would end it at 8.6). The second gives the angle: 62 bits of it an angle in (−π/4, π/4), where sine and cosine
//! need no reduction and lose nothing by it, its two top bits the quarter of the circle. Every cell of the partition is
//! represented by its centre, so all odd moments are exactly 0. Given the words, the error of z was at most
//! 1.7·10⁻¹⁵ for r ≥ 0.1 in 60,000 pairs against 40 digits; below, u near 1 is rounded to 2⁻⁵⁴, and z to 2⁻⁵⁴/r.
//!
//! Source: Box, Muller, *A note on the generation of random normal deviates*, Ann. Math. Statist. 29 (1958).

use core::f64::consts::FRAC_PI_4;

const TWO_TO_MINUS_64: f64 = 1.0 / (4.0 * (1_u64 << 62) as f64);
const TWO_TO_MINUS_63: f64 = 2.0 * TWO_TO_MINUS_64;

/// Four normals, a pair from each two words.
#[inline]
pub(crate) fn four(words: [u64; 4]) -> [f64; 4] {
    let [a, b, c, d] = words;
    let [z0, z1] = pair(a, b);
    let [z2, z3] = pair(c, d);
    [z0, z1, z2, z3]
}

/// Two independent standard normals.
#[inline]
pub(crate) fn pair(radius: u64, angle: u64) -> [f64; 2] {
    let u = (radius as f64 + 0.5) * TWO_TO_MINUS_64;
    let r = (-2.0 * u.ln()).sqrt();
    // the two top bits go; the bit set below them is the centre of a cell of width 4
    let fraction = ((angle << 2) | 2).cast_signed() as f64;
    let (s, c) = (fraction * (FRAC_PI_4 * TWO_TO_MINUS_63)).sin_cos();
    // the quarter around the first axis, mirrored to the opposite one and to the other axis;
    // with masks, for a branch on a random bit is mispredicted every second time
    let x = (r * c).to_bits() ^ (angle & (1 << 63));
    let y = (r * s).to_bits();
    let swapped = (x ^ y) & 0_u64.wrapping_sub((angle >> 62) & 1);
    [f64::from_bits(x ^ swapped), f64::from_bits(y ^ swapped)]
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
            let z = pair(radius, angle);
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
                for z in pair(radius, angle) {
                    assert!(z.abs() <= (130.0 * 2.0_f64.ln()).sqrt() * (1.0 + f64::EPSILON));
                }
            }
        }
        assert_eq!(pair(u64::MAX, 0)[0], 0.0);
    }

    #[test]
    fn angle_bits_turn_the_pair_exactly() {
        let radius = 0x1234_5678_9abc_def0;
        for fraction in [0, 5, 1 << 60, (1 << 62) - 1, 0x0abc_def0_1234_5678] {
            let [x, y] = pair(radius, fraction);
            assert_eq!(pair(radius, fraction | 1 << 63), [-x, y]);
            assert_eq!(pair(radius, fraction | 1 << 62), [y, x]);
            assert_eq!(pair(radius, fraction | 3 << 62), [y, -x]);
            // the opposite cell of the same quarter
            assert_eq!(pair(radius, !fraction & ((1 << 62) - 1)), [x, -y]);
        }
    }

    #[test]
    fn small_uniforms_are_not_truncated() {
        // u = 2^-60 · 1.03125 and its neighbours are far below the 2^-53 of a usual uniform
        let [a, b, c] = [16, 17, 18].map(|w| pair(w, 0)[0]);
        assert!(9.0 < c && c < b && b < a && a < 9.2, "{a} {b} {c}");
    }

    #[test]
    fn four_are_two_pairs() {
        let [a, b] = [pair(1 << 40, 2 << 50), pair(3 << 45, 4 << 55)];
        let words = [1 << 40, 2 << 50, 3 << 45, 4 << 55];
        assert_eq!(four(words), [a[0], a[1], b[0], b[1]]);
    }
}

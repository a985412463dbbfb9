//! Normals against exact values and the library.

use super::{four, log_argument, normals, number, pair};
use crate::noise::threefry;

/// The bound of the relative error in the documentation; 1.6·10⁻¹⁵ is the largest error seen.
const PROMISED: f64 = 2e-15;

/// Words, and their exact transforms at 45 digits.
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

/// Returns words of all sizes, also near the ends of the range and near the border between two exponents of the logarithm.
fn words() -> impl Iterator<Item = [u64; 2]> {
    (0..100_000).map(|i| {
        let [a, b, c, d] = threefry::block([i, 0, 0, 0], [9; 4]);
        let radius = match i % 4 {
            0 => a,
            1 => a >> (c % 64),
            2 => !(a >> (c % 64)),
            _ => 0xb504_f333_f9de_6484_u64.wrapping_add_signed(a.cast_signed() >> (c % 64)),
        };
        // angles of all sizes within a quarter
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

/// Compares with the formulas of the module's documentation, evaluated by functions of the library.
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
        // The library and this formula have rounding errors too.
        assert_close(radius, angle, expected, 2.0 * PROMISED);
    }
}

/// Checks that machines without an instruction that converts words to numbers give the same bits.
#[test]
fn both_conversions_give_the_same_bits() {
    for [radius, angle] in words() {
        for word in [radius, angle, radius ^ angle] {
            assert_eq!(
                number::<false>(word).to_bits(),
                number::<true>(word).to_bits()
            );
        }
        let split = normals::<false>(log_argument::<false>(radius), angle, 0.5);
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

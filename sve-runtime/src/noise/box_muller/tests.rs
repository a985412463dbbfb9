//! Normals against exact values: the formulas of the module's documentation in 106 bits, and at 50
//! digits.

mod exact;

use super::logarithm::{self, Uniform};
use super::{SIGN, four, pair, point, signed, unsigned};
use crate::noise::threefry;

/// The bound of the absolute error in the documentation, and the bound for radii above 8.5.
const PROMISED: f64 = 4e-15;
const PROMISED_FAR: f64 = 5e-15;

/// Words below this one give radii above 8.5: exp(−8.5²/2) = 2.05·10⁻¹⁶.
const FAR: u64 = 3781;

/// Words, and their exact transforms at 50 digits.
#[rustfmt::skip]
const REFERENCE: [(u64, u64, [f64; 2]); 21] = [
    (0x0000_0000_0000_0000, 0x0000_0000_0000_0000, [9.492_583_076_949_755, 1.616_644_603_458_149_5e-18]),
    (0x0000_0000_0000_0000, 0x4000_0000_0000_0000, [1.616_644_603_458_149_5e-18, -9.492_583_076_949_755]),
    (0x0000_0000_0000_0001, 0x9fff_ffff_ffff_ffff, [-6.629_928_690_998_745, 6.629_928_690_998_745]),
    (0x8000_0000_0000_0000, 0xe000_0000_0000_0000, [-0.832_554_611_157_697_8, -0.832_554_611_157_697_8]),
    (0x4071_fabe_e1dc_8e05, 0x02ed_3113_695c_9c62, [1.656_657_758_065_891, 0.119_199_236_083_475_37]),
    (0x3973_11b5_b89f_9d49, 0xe212_92c3_2580_24bc, [-1.282_977_258_869_464_1, -1.158_668_211_232_867_2]),
    (0x7eae_d935_4797_22b5, 0x9099_4358_c429_f31c, [-1.089_082_324_494_388, 0.469_977_386_988_023]),
    (0xf000_0000_0000_0000, 0x5123_4567_89ab_cdef, [0.146_702_083_207_769_6, -0.327_956_614_596_569_8]),
    (0xffff_ffff_ffff_ffff, 0x1234_5678_9abc_def0, [0.0, 0.0]),
    (0xffff_ffff_ffff_f7ff, 0x7fff_ffff_ffff_ffff, [1.490_116_119_384_765_6e-8, -2.537_758_335_535_641_4e-27]),
    (0xffff_ffff_ffff_0000, 0x1fff_ffff_ffff_ffff, [5.960_464_477_539_068e-8, 5.960_464_477_539_068e-8]),
    (0xffff_ff01_2345_6789, 0x2000_0000_0000_0000, [0.000_243_597_489_718_681_4, 0.000_243_597_489_718_681_4]),
    (0xfff0_0000_0000_0001, 0x0000_0000_0000_0003, [0.022_098_435_789_617_076, 2.634_448_566_021_012_4e-20]),
    (0xb504_f333_f9de_6484, 0x0000_0001_0000_0000, [0.832_554_611_157_697_7, 1.217_959_192_781_625e-9]),
    (0xc000_0000_0000_0000, 0xffff_ffff_0000_0000, [-0.758_527_616_440_932_1, -1.109_663_763_585_683_5e-9]),
    (0xbfff_ffff_ffff_fc00, 0x8000_0000_0000_0001, [-0.758_527_616_440_932_1, 3.875_455_925_176_613_6e-19]),
    (0x7fff_ffff_ffff_ffff, 0x1555_5555_5555_5555, [1.019_666_990_168_809, 0.588_705_011_257_737_3]),
    (0x5a82_7999_fcef_3242, 0xd555_5555_5555_5555, [-0.721_013_443_300_441_5, -1.248_831_916_736_546_7]),
    (0x0000_0000_000f_ffff, 0x3fff_ffff_ffff_ffff, [1.330_099_775_604_534_6e-18, 7.810_054_599_229_748]),
    (0x0000_0000_0020_0001, 0x2aaa_aaaa_aaaa_aaaa, [3.860_396_873_951_055_7, 6.686_403_523_063_295]),
    (0x0123_4567_89ab_cdef, 0xfedc_ba98_7654_3210, [-3.289_947_693_606_653, -0.091_896_560_006_913_51]),
];

/// Checks the errors of a pair. Returns the larger one, in units of its bound.
fn check(radius: u64, angle: u64, expected: [exact::Sum; 2]) -> f64 {
    let z = pair(radius, angle, 1.0);
    let error = |i: usize| expected[i].distance(z[i]);
    let error = error(0).max(error(1));
    let bound = if radius < FAR { PROMISED_FAR } else { PROMISED };
    assert!(error <= bound, "{radius:#x} {angle:#x}: {error:e}");
    error / bound
}

/// Returns words of all sizes, also near the ends of the range.
fn words() -> impl Iterator<Item = [u64; 2]> {
    (0..100_000).map(|i| {
        let [a, b, c, d] = threefry::block([i, 0, 0, 0], [9; 4]);
        let radius = match i % 4 {
            0 => a,
            1 => a >> (c % 64),
            2 => !(a >> (c % 64)),
            // near the borders of the intervals of the logarithm
            _ => ((b >> 59) << 59).wrapping_add_signed(a.cast_signed() >> (c % 64)),
        };
        // angles near the multiples of an eighth of a turn
        let eighth = (d >> 61) << 61;
        let angle = match i / 4 % 2 {
            0 => b,
            _ => eighth.wrapping_add_signed(b.cast_signed() >> (d % 62)),
        };
        [radius, angle]
    })
}

#[test]
fn agrees_with_exact_values() {
    for (radius, angle, expected) in REFERENCE {
        check(radius, angle, expected.map(exact::Sum::from));
        let in_106_bits = exact::pair(radius, angle);
        for (sum, expected) in in_106_bits.into_iter().zip(expected) {
            assert!(sum.distance(expected) <= f64::EPSILON * expected.abs() + 1e-28);
        }
    }
}

/// Compares with the formulas of the module's documentation in 106 bits.
#[test]
fn the_error_is_below_the_bound_everywhere() {
    let mut largest = 0.0;
    for [radius, angle] in words() {
        let part = check(radius, angle, exact::pair(radius, angle));
        largest = f64::max(largest, part);
    }
    assert!(
        largest > 0.5,
        "the bounds could be {largest} of what they are"
    );
}

/// Checks that machines without an instruction that converts words to numbers give the same bits.
#[test]
fn both_conversions_give_the_same_bits() {
    for [radius, angle] in words() {
        for word in [radius, angle, radius ^ angle] {
            assert_eq!(
                signed::<false>(word).to_bits(),
                signed::<true>(word).to_bits()
            );
            assert_eq!(
                unsigned::<false>(word).to_bits(),
                unsigned::<true>(word).to_bits()
            );
        }
        let uniform = Uniform::new(unsigned::<false>(radius));
        let diameter = uniform.minus_two_ln::<false>(uniform.constants()).sqrt();
        assert_eq!(
            point::<false>(diameter, angle).map(f64::to_bits),
            pair(radius, angle, 0.5).map(f64::to_bits)
        );
    }
    // ties are rounded to even
    let ties = [(1 << 54) + 1, (1 << 54) + 2, (1 << 54) + 6];
    for word in ties
        .into_iter()
        .chain([u64::MAX << 2, 1 << 63, 0, u64::MAX])
    {
        assert_eq!(signed::<false>(word), word.cast_signed() as f64);
        assert_eq!(unsigned::<false>(word), word as f64);
    }
}

/// Checks both ways to read the table, also for numbers with bits above the bits of an entry.
#[test]
fn the_table_is_read_alike_in_lanes() {
    let entries: [u64; 64] =
        core::array::from_fn(|k| (k as u64).wrapping_mul(0x1001_0000_0000_0001));
    let mut plain = [[0.0; 64]; 2];
    logarithm::look_up::<64, false>(&entries, &mut plain);
    assert_eq!(plain[1][5], plain[1][5 + 16]);
    if crate::lanes::dispatch::has_avx512() {
        let mut permuted = [[0.0; 64]; 2];
        logarithm::look_up::<64, true>(&entries, &mut permuted);
        assert_eq!(permuted, plain);
    }
}

#[test]
fn the_ends_are_finite() {
    for radius in [0, 1, u64::MAX - 1, u64::MAX] {
        for angle in [0, 1, 1 << 62, (1 << 62) - 1, 1 << 63, u64::MAX] {
            for z in pair(radius, angle, 1.0) {
                assert!(z.abs() <= (130.0 * 2.0_f64.ln()).sqrt() * (1.0 + f64::EPSILON));
            }
        }
    }
    // The number below 1, and 1 itself.
    let smallest = 0.5_f64.powi(26);
    let z = pair(u64::MAX - 2048, 0, 1.0)[0];
    assert!((z - smallest).abs() <= 2.0 * f64::EPSILON * smallest, "{z}");
    assert_eq!(pair(u64::MAX, 5, 1.0), [0.0; 2]);
}

/// Checks every number next to the border of two intervals, where m or the entry could belong to
/// the other interval.
#[test]
fn the_logarithm_is_continuous() {
    for interval in 24..=48_u64 {
        for exponent in 0..8 {
            let border = interval << (58 - exponent);
            for ulps in -2..=2 {
                let word = border.wrapping_add_signed(ulps << (11 - exponent));
                check(word, 1 << 61, exact::pair(word, 1 << 61));
            }
        }
    }
}

#[test]
fn angle_bits_turn_the_pair_exactly() {
    let radius = 0x1234_5678_9abc_def0;
    for fraction in [0, 5, 1 << 60, (1 << 62) - 1, 0x0abc_def0_1234_5678] {
        let [x, y] = pair(radius, fraction, 1.0);
        assert_eq!(pair(radius, fraction | SIGN, 1.0), [-x, y]);
        // the opposite cell of the same half
        assert_eq!(pair(radius, !fraction & !SIGN, 1.0), [x, -y]);
        assert_eq!(pair(radius, !fraction, 1.0), [-x, -y]);
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
            assert!((scaled - 0.3 * z).abs() <= 2.0 * f64::EPSILON * (0.3 * z).abs());
        }
    }
}

#[test]
fn four_are_two_pairs() {
    let [a, b] = [pair(1 << 40, 2 << 50, 1.0), pair(3 << 45, 4 << 55, 1.0)];
    let words = [1 << 40, 2 << 50, 3 << 45, 4 << 55];
    assert_eq!(four(words, 1.0), [a[0], a[1], b[0], b[1]]);
}

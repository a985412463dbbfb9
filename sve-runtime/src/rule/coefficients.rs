//! The fractions of the step in compositions.
//!
//! Negative fractions cannot be avoided: every composition of order above 2 has some (Sheng 1989;
//! Suzuki 1991).

use super::composed::Composition;
use super::split::Coefficients;

/// The composition of order 8 with 17 substeps of Kahan and Li (1997), *Composition constants for
/// raising the orders of unconventional schemes for ordinary differential equations*, Math. Comp.
/// 66, 1089–1099 (method s17odr8a).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct KahanLi8;

/// The first nine of the 17 fractions, which are the same in reverse order.
const KAHAN_LI: [f64; 9] = [
    0.130_202_483_088_890_08,
    0.561_162_981_775_108_4,
    -0.389_474_962_644_847_3,
    0.158_841_906_555_155_6,
    -0.395_903_894_133_237_57,
    0.184_539_640_978_315_7,
    0.258_374_387_686_322_04,
    0.295_011_723_609_310_3,
    -0.605_508_533_830_034_5,
];

impl Composition for KahanLi8 {
    type Each<T: Clone> = [T; 9];
    const NAME: &'static str = "Kahan–Li 8";
    const ORDER: u32 = 8;
    const FRACTIONS: &'static [f64] = &palindrome::<9, 17>(KAHAN_LI);

    fn each<T: Clone>(prepare: impl Fn(f64) -> T) -> [T; 9] {
        core::array::from_fn(|number| prepare(KAHAN_LI[number]))
    }

    fn distinct(number: usize) -> usize {
        number.min(16 - number)
    }
}

/// Returns all `2K − 1` fractions of a symmetric sequence from the first `K`.
const fn palindrome<const K: usize, const ALL: usize>(first: [f64; K]) -> [f64; ALL] {
    let mut all = [0.0; ALL];
    let mut number = 0;
    while number < ALL {
        all[number] = if number < K {
            first[number]
        } else {
            first[ALL - 1 - number]
        };
        number += 1;
    }
    all
}

/// The splitting of order 4 with 6 stages of Blanes and Moan (2002), *Practical symplectic
/// partitioned Runge–Kutta and Runge–Kutta–Nyström methods*, J. Comput. Appl. Math. 142, 313–330
/// (method S6).
///
/// For Lagrangians T(v) − V(t, q).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoan4;

/// Kicks and drifts of [`BlanesMoan4`]: the first half of each sequence, without the middle.
const MOAN4_KICKS: [f64; 3] = [
    0.079_203_696_431_195_7,
    0.353_172_906_049_774,
    -0.042_065_080_357_719_5,
];
const MOAN4_DRIFTS: [f64; 2] = [0.209_515_106_613_362, -0.143_851_773_179_818];

impl Coefficients for BlanesMoan4 {
    type Each<T: Clone> = [T; 6];
    const NAME: &'static str = "Blanes–Moan 4";
    const ORDER: u32 = 4;
    const FRACTIONS: &'static [f64] = &{
        let [k1, k2, k3] = MOAN4_KICKS;
        let [d1, d2] = MOAN4_DRIFTS;
        let kicks = palindrome::<4, 7>([k1, k2, k3, 1.0 - 2.0 * (k1 + k2 + k3)]);
        let d3 = 0.5 - (d1 + d2);
        alternating::<6, 7, 12>([d1, d2, d3, d3, d2, d1], kicks)
    };

    fn each<T: Clone>(prepare: impl Fn(usize) -> T) -> [T; 6] {
        core::array::from_fn(prepare)
    }
}

/// The splitting of order 6 with 11 stages of Blanes and Moan (2002), *Practical symplectic
/// partitioned Runge–Kutta and Runge–Kutta–Nyström methods*, J. Comput. Appl. Math. 142, 313–330
/// (method SRKN11).
///
/// For Lagrangians ½vᵀMv − V(t, q) with a constant matrix M.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BlanesMoanRkn6;

const RKN6_KICKS: [f64; 5] = [
    0.041_464_998_518_262_4,
    0.198_128_671_918_067,
    -0.040_006_192_104_153_3,
    0.075_253_984_301_580_7,
    -0.011_511_387_420_687_9,
];
const RKN6_DRIFTS: [f64; 5] = [
    0.123_229_775_946_271,
    0.290_553_797_799_558,
    -0.127_049_212_625_417,
    -0.246_331_761_062_075,
    0.357_208_872_795_928,
];

impl Coefficients for BlanesMoanRkn6 {
    type Each<T: Clone> = [T; 11];
    const NAME: &'static str = "Blanes–Moan RKN 6";
    const ORDER: u32 = 6;
    const FRACTIONS: &'static [f64] = &{
        let [k1, k2, k3, k4, k5] = RKN6_KICKS;
        let [d1, d2, d3, d4, d5] = RKN6_DRIFTS;
        let k6 = 0.5 - (k1 + k2 + k3 + k4 + k5);
        let d6 = 1.0 - 2.0 * (d1 + d2 + d3 + d4 + d5);
        let kicks = [k1, k2, k3, k4, k5, k6, k6, k5, k4, k3, k2, k1];
        alternating::<11, 12, 22>(palindrome::<6, 11>([d1, d2, d3, d4, d5, d6]), kicks)
    };

    fn each<T: Clone>(prepare: impl Fn(usize) -> T) -> [T; 11] {
        core::array::from_fn(prepare)
    }
}

/// Returns the fractions α₁, β₁, α₂, … of a splitting that begins and ends with a kick.
///
/// The initial-point rule kicks and then drifts, each by α; the endpoint rule drifts and then
/// kicks, each by β. So the kicks are α₁, β₁ + α₂, …, `β_K`, and the drifts α₁ + β₁, α₂ + β₂, ….
const fn alternating<const K: usize, const KICKS: usize, const ALL: usize>(
    drifts: [f64; K],
    kicks: [f64; KICKS],
) -> [f64; ALL] {
    let mut all = [0.0; ALL];
    let (mut number, mut beta) = (0, 0.0);
    while number < K {
        let alpha = kicks[number] - beta;
        beta = drifts[number] - alpha;
        all[2 * number] = alpha;
        all[2 * number + 1] = beta;
        number += 1;
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_add_up_to_the_step() {
        for fractions in [
            KahanLi8::FRACTIONS,
            BlanesMoan4::FRACTIONS,
            BlanesMoanRkn6::FRACTIONS,
        ] {
            let sum: f64 = fractions.iter().sum();
            assert!((sum - 1.0).abs() < 1e-15, "{sum}");
        }
    }

    #[test]
    fn fractions_read_the_same_from_both_ends() {
        for (fractions, digits) in [
            (KahanLi8::FRACTIONS, 0.0),
            (BlanesMoan4::FRACTIONS, 1e-15),
            (BlanesMoanRkn6::FRACTIONS, 1e-15),
        ] {
            for (a, b) in fractions.iter().zip(fractions.iter().rev()) {
                assert!((a - b).abs() <= digits, "{a} {b}");
            }
        }
    }
}

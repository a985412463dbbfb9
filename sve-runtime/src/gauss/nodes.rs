//! The nodes of the Gauss rules: the roots of the Legendre polynomials on (−1, 1).
//!
//! Each is an unevaluated sum of two `f64`, computed with 60 digits by Newton's method on the
//! polynomials. Roots that are not negative, ascending; the others follow by symmetry.

use super::double_double::Double;

/// The roots of the Legendre polynomials of degree 1 to 8 that are not negative.
const ROOTS: [&[(f64, f64)]; 8] = [
    &[(0.0, 0.0)],
    &[(0.577_350_269_189_625_7, 3.345_028_073_935_634_5e-17)],
    &[
        (0.0, 0.0),
        (0.774_596_669_241_483_4, -2.724_206_173_492_736_3e-17),
    ],
    &[
        (0.339_981_043_584_856_26, 7.491_321_706_962_178e-18),
        (0.861_136_311_594_052_6, 2.686_141_298_670_239e-18),
    ],
    &[
        (0.0, 0.0),
        (0.538_469_310_105_683_1, -1.667_815_489_469_664_6e-17),
        (0.906_179_845_938_664, 2.909_730_553_174_891e-17),
    ],
    &[
        (0.238_619_186_083_196_9, 3.917_524_250_872_457e-18),
        (0.661_209_386_466_264_5, 3.212_031_102_377_179e-17),
        (0.932_469_514_203_152, -2.224_576_391_529_02e-17),
    ],
    &[
        (0.0, 0.0),
        (0.405_845_151_377_397_2, -1.724_927_544_754_71e-17),
        (0.741_531_185_599_394_5, -2.022_013_477_406_989_7e-17),
        (0.949_107_912_342_758_5, 3.825_796_587_866_57e-17),
    ],
    &[
        (0.183_434_642_495_649_8, -2.896_768_206_985_904_6e-18),
        (0.525_532_409_916_329, -4.999_907_577_775_897e-18),
        (0.796_666_477_413_626_7, 1.162_571_982_974_972_4e-17),
        (0.960_289_856_497_536_3, -5.548_850_679_084_28e-17),
    ],
];

/// Returns root `i` of the Legendre polynomial of this degree, in ascending order from 0.
pub(super) const fn root(degree: usize, i: usize) -> Double {
    let roots = ROOTS[degree - 1];
    let negative = degree - roots.len();
    if i >= negative {
        let (high, low) = roots[i - negative];
        Double { high, low }
    } else {
        let (high, low) = roots[roots.len() - 1 - i];
        Double {
            high: -high,
            low: -low,
        }
    }
}

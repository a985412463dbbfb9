//! Angle addition: sine and cosine of a sum of two angles, the second of which is small.
//!
//! Input: sine and cosine of an angle, and an increment of the angle. Output: sine and cosine of
//! the sum, by the addition theorems. The truncation error of the polynomials is below 10⁻²⁰, far
//! below rounding error. It has the same sign in every step, so a larger error would make the
//! energy of a long run drift. [`sine`] and [`cosine`] are the polynomials of fdlibm on [−π/4, π/4]
//! (`k_sin.c` and `k_cos.c`).

use core::f64::consts::FRAC_PI_4;

/// Largest increment that needs only the first terms of the series. Iterations of small steps have
/// such increments. The error is below 3·10⁻²¹.
const SMALL: f64 = 1.0 / 32.0;

/// The first coefficients of [`SINE`] for small increments. The fourth term is replaced by its best
/// approximation of degree two, from the Chebyshev polynomial T₃ on [0, `SMALL`²], whose error is
/// 32 times smaller than the term.
const SMALL_SINE: [f64; 3] = {
    let t = SMALL * SMALL;
    [
        SINE[0] + SINE[3] * (t * t * t / 32.0),
        SINE[1] - SINE[3] * (t * t * 9.0 / 16.0),
        SINE[2] + SINE[3] * (1.5 * t),
    ]
};

/// Taylor's coefficients of `(sin x − x)/x³` in x². The truncation error is below 10⁻¹⁹ at π/4, and
/// below 10⁻²³ at ½.
const SINE: [f64; 8] = [
    -1.0 / 6.0,
    1.0 / 120.0,
    -1.0 / 5_040.0,
    1.0 / 362_880.0,
    -1.0 / 39_916_800.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 1_307_674_368_000.0,
    1.0 / 355_687_428_096_000.0,
];

/// Taylor's coefficients of `(cos x − 1 + x²/2)/x⁴` in x².
const COSINE: [f64; 8] = [
    1.0 / 24.0,
    -1.0 / 720.0,
    1.0 / 40_320.0,
    -1.0 / 3_628_800.0,
    1.0 / 479_001_600.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 20_922_789_888_000.0,
    -1.0 / 6_402_373_705_728_000.0,
];

/// Returns `(sin(a + by), cos(a + by))` from `sin a` and `cos a`, to two units of rounding of 1.
#[inline]
pub fn sin_cos_of_sum(sin: f64, cos: f64, by: f64) -> (f64, f64) {
    let x2 = by * by;
    let (s, c) = if by.abs() <= SMALL {
        let s = (SMALL_SINE[0] + x2 * SMALL_SINE[1]) + x2 * x2 * SMALL_SINE[2];
        let c = (COSINE[0] + x2 * COSINE[1]) + x2 * x2 * COSINE[2];
        (s, c)
    } else if by.abs() <= FRAC_PI_4 {
        (series(&SINE, x2), series(&COSINE, x2))
    } else {
        return sin_cos_of_large_sum(sin, cos, by);
    };
    // sin(by) = s, cos(by) = 1 − c: the small changes are added last
    let (s, c) = (by + by * x2 * s, 0.5 * x2 - x2 * x2 * c);
    (sin + (cos * s - sin * c), cos - (sin * s + cos * c))
}

/// Returns the sum of the eight terms of a series in `x2`.
#[inline(always)]
fn series(c: &[f64; 8], x2: f64) -> f64 {
    let x4 = x2 * x2;
    let low = (c[0] + x2 * c[1]) + x4 * (c[2] + x2 * c[3]);
    let high = (c[4] + x2 * c[5]) + x4 * (c[6] + x2 * c[7]);
    low + (x4 * x4) * high
}

#[cold]
fn sin_cos_of_large_sum(sin: f64, cos: f64, by: f64) -> (f64, f64) {
    let (s, c) = by.sin_cos();
    (sin * c + cos * s, cos * c - sin * s)
}

/// Returns `(sin x − x)/x³` of `x²`.
#[inline(always)]
#[allow(clippy::excessive_precision)] // as their authors print them
pub(crate) fn sine(x2: f64) -> f64 {
    const S: [f64; 6] = [
        -1.666_666_666_666_663_243_48e-01,
        8.333_333_333_322_489_461_24e-03,
        -1.984_126_982_985_794_931_34e-04,
        2.755_731_370_707_006_767_89e-06,
        -2.505_076_025_340_686_341_95e-08,
        1.589_690_995_211_550_102_21e-10,
    ];
    let x4 = x2 * x2;
    (S[0] + x2 * S[1]) + x4 * ((S[2] + x2 * S[3]) + x4 * (S[4] + x2 * S[5]))
}

/// Returns `(cos x − 1 + x²/2)/x⁴` of `x²`.
#[inline(always)]
#[allow(clippy::excessive_precision)] // as their authors print them
pub(crate) fn cosine(x2: f64) -> f64 {
    const C: [f64; 6] = [
        4.166_666_666_666_660_190_37e-02,
        -1.388_888_888_887_410_957_49e-03,
        2.480_158_728_947_672_941_78e-05,
        -2.755_731_435_139_066_330_35e-07,
        2.087_572_321_298_174_827_90e-09,
        -1.135_964_755_778_819_482_65e-11,
    ];
    let x4 = x2 * x2;
    (C[0] + x2 * C[1]) + x4 * ((C[2] + x2 * C[3]) + x4 * (C[4] + x2 * C[5]))
}

#[cfg(test)]
mod tests {
    use super::sin_cos_of_sum;

    #[test]
    fn agrees_with_the_standard_library() {
        let mut worst: f64 = 0.0;
        for i in 0..200 {
            let a = 0.037 * f64::from(i) - 3.0;
            let (sin, cos) = a.sin_cos();
            for j in -300..=300 {
                // increments up to ±3, on both sides of π/4, and down to tiny ones
                let by = 0.01 * f64::from(j) * 0.5f64.powi(i % 40);
                let (s, c) = sin_cos_of_sum(sin, cos, by);
                let (exact_s, exact_c) = (
                    sin * by.cos() + cos * by.sin(),
                    cos * by.cos() - sin * by.sin(),
                );
                worst = worst.max((s - exact_s).abs()).max((c - exact_c).abs());
                worst = worst.max((s * s + c * c - 1.0).abs());
            }
        }
        // The bound has three roundings of numbers up to 1, and the roundings of sin a and cos a,
        // twice in the square.
        assert!(worst <= 4.0 * f64::EPSILON, "{worst:e}");
    }

    #[test]
    fn an_increment_of_zero_changes_nothing() {
        let (sin, cos) = 0.3f64.sin_cos();
        assert_eq!(sin_cos_of_sum(sin, cos, 0.0), (sin, cos));
        assert!(sin_cos_of_sum(sin, cos, f64::NAN).0.is_nan());
    }
}

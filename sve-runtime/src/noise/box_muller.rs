//! Box and Muller's transform: random words to standard normals.
//!
//! Input: two words, uniform and independent, and a scale. Output: two independent normals whose
//! standard deviation is the scale. Invariant: a pure function of additions, multiplications, fused
//! multiply-adds and square roots: the same bits on every machine, for one pair or for lanes of
//! pairs. |z| ≤ √(130 ln 2) = 9.4926; a true normal exceeds this bound once in 4·10²⁰ draws.
//!
//! The first word w gives the radius √(−2 ln u) with u = (w + ½)/2⁶⁴, rounded to the nearest
//! number: small u, which give the tail of the distribution, keep 64 bits (53 bits would end the
//! tail at 8.6). The second word gives the angle. Its lower 63 bits, taken as the signed number t
//! in (−1, 1) at the centre of a cell of width 2⁻⁶², give the half turn θ = πt/2, where no argument
//! needs to be reduced; the top bit is the sign of the cosine. Opposite cells have opposite values,
//! so all odd moments are exactly 0. Given u and θ, the absolute error of each z is below 4·10⁻¹⁵,
//! and below 5·10⁻¹⁵ for radii above 8.5, which occur once in 5·10¹⁵ pairs.
//!
//! With A = sin(θ/2) and B = cos(θ/2), half the sine is AB and half the cosine ½ − A², which takes
//! fewer operations than direct polynomials. The polynomials are minimax (Remez' algorithm at 60
//! digits): A minimises its own absolute error, B the absolute error of the sine.
//!
//! Source: Box, Muller, *A note on the generation of random normal deviates*, Ann. Math. Statist.
//! 29 (1958).

mod logarithm;

use core::f64::consts::FRAC_PI_4;

use crate::lanes::dispatch::{Kernel, dispatch};
use logarithm::Uniform;

/// Sign bit of a number.
const SIGN: u64 = 1 << 63;

/// 2⁶³, the range of a signed word. Words are used as integers, since scaling them to fractions
/// would cost an operation.
const HALF: f64 = (1_u64 << 63) as f64;

/// Coefficients of sin(πt/4)/t in t², to 1.4·10⁻¹⁷ for |t| ≤ 1.
const SINE: [f64; 7] = for_words(
    [
        FRAC_PI_4,
        -0.080_745_512_188_280_09,
        0.002_490_394_570_185_252_3,
        -3.657_620_414_660_072_4e-5,
        3.133_616_020_227_391e-7,
        -1.757_133_659_076_54e-9,
        6.872_309_833_131_536e-12,
    ],
    1.0 / HALF,
);

/// Coefficients of cos(πt/4) in t². Their error changes the sine by at most 6.4·10⁻¹⁷ for |t| ≤ 1.
const COSINE: [f64; 7] = for_words(
    [
        1.0,
        -0.308_425_137_534_036_33,
        0.015_854_344_243_719_43,
        -0.000_325_991_886_388_057,
        3.590_858_999_514_584e-6,
        -2.460_935_094_485_885_5e-8,
        1.136_039_410_878_723_5e-10,
    ],
    1.0,
);

/// Returns the coefficients for an argument that is 2⁶³ times as large, all multiplied by `factor`.
/// Exact for powers of two.
const fn for_words(mut coefficients: [f64; 7], mut factor: f64) -> [f64; 7] {
    let mut k = 0;
    while k < 7 {
        coefficients[k] *= factor;
        factor *= 1.0 / (HALF * HALF);
        k += 1;
    }
    coefficients
}

/// Returns two independent normals of standard deviation `scale`.
pub(crate) fn pair(radius: u64, angle: u64, scale: f64) -> [f64; 2] {
    dispatch(Pair {
        radius,
        angle,
        scale,
    })
}

/// Returns four normals of standard deviation `scale`, a pair for each two words.
pub(crate) fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
    dispatch(Four { words, scale })
}

/// The arguments of [`pair`].
struct Pair {
    radius: u64,
    angle: u64,
    scale: f64,
}

impl Kernel for Pair {
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self) -> [f64; 2] {
        inlined_pair(self.radius, self.angle, self.scale)
    }
}

/// The arguments of [`four`].
struct Four {
    words: [u64; 4],
    scale: f64,
}

impl Kernel for Four {
    type Output = [f64; 4];

    #[inline(always)]
    fn run(self) -> [f64; 4] {
        inlined_four(self.words, self.scale)
    }
}

/// Computes [`four`] within a [`Kernel`]. Elsewhere a fused operation can be a call of the library.
#[inline(always)]
pub(super) fn inlined_four([a, b, c, d]: [u64; 4], scale: f64) -> [f64; 4] {
    let [z0, z1] = inlined_pair(a, b, scale);
    let [z2, z3] = inlined_pair(c, d, scale);
    [z0, z1, z2, z3]
}

#[inline(always)]
fn inlined_pair(radius: u64, angle: u64, scale: f64) -> [f64; 2] {
    let uniform = Uniform::new(unsigned::<true>(radius));
    let root = uniform.minus_two_ln::<true>(uniform.constants()).sqrt();
    point::<true>(2.0 * scale * root, angle)
}

/// Intermediate results of [`fill_lanes`], one row of lanes each. They are kept between calls,
/// since clearing them would take a tenth of the time.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Workspace<const L: usize> {
    words: [[u64; L]; 4],
    uniforms: [[Uniform; L]; 2],
    entries: [[u64; L]; 2],
    /// Two rows for each pair.
    constants: [[[f64; L]; 2]; 2],
}

impl<const L: usize> Workspace<L> {
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self {
            words: [[0; L]; 4],
            uniforms: [[Uniform::ONE; L]; 2],
            entries: [[0; L]; 2],
            constants: [[[0.0; L]; 2]; 2],
        }
    }
}

/// Fills the four rows with [`four`] of each lane's words. `AVX512` is true if the machine has
/// AVX-512.
///
/// The loops are separate because the words alone take all registers, and the table of the
/// logarithm is read for several lanes at once.
#[inline(always)]
pub(super) fn fill_lanes<const L: usize, const AVX512: bool>(
    words: impl Fn(usize) -> [u64; 4],
    scale: f64,
    work: &mut Workspace<L>,
    [a, b, c, d]: &mut [[f64; L]; 4],
) {
    for lane in 0..L {
        let four = words(lane);
        for i in 0..4 {
            work.words[i][lane] = four[i];
        }
    }
    for j in 0..2 {
        for lane in 0..L {
            let uniform = Uniform::new(unsigned::<AVX512>(work.words[2 * j][lane]));
            work.uniforms[j][lane] = uniform;
            work.entries[j][lane] = uniform.entry();
        }
        logarithm::look_up::<L, AVX512>(&work.entries[j], &mut work.constants[j]);
    }
    let [_, first_angles, _, second_angles] = &work.words;
    for lane in 0..L {
        let diameter = |j: usize| {
            let [reciprocals, logarithms] = &work.constants[j];
            let constants = [reciprocals[lane], logarithms[lane]];
            let minus_two_ln = work.uniforms[j][lane].minus_two_ln::<AVX512>(constants);
            2.0 * scale * minus_two_ln.sqrt()
        };
        [a[lane], b[lane]] = point::<AVX512>(diameter(0), first_angles[lane]);
        [c[lane], d[lane]] = point::<AVX512>(diameter(1), second_angles[lane]);
    }
}

/// Returns the coordinates of a point of a circle, given twice the radius.
#[inline(always)]
fn point<const DIRECT: bool>(diameter: f64, angle: u64) -> [f64; 2] {
    // The shift drops the top bit. The bit set is the centre of a cell of width 2.
    let t = signed::<DIRECT>((angle << 1) | 1);
    let square = t * t;
    let a = t * polynomial(&SINE, square);
    let half_sine = a * polynomial(&COSINE, square);
    let half_cosine = (-a).mul_add(a, 0.5);
    let x = diameter * half_cosine;
    [
        f64::from_bits(x.to_bits() ^ (angle & SIGN)),
        diameter * half_sine,
    ]
}

const TWO_TO_52: f64 = (1_u64 << 52) as f64;
const TWO_TO_84: f64 = TWO_TO_52 * (1_u64 << 32) as f64;

/// Rounds a word to the nearest number.
///
/// Vectors of x86-64 before AVX-512 (`DIRECT` is false) have no instruction for it: the halves of
/// the word become the low bits of 2⁵² and 2⁸⁴, the last addition is the only rounding, and the
/// bits are the same.
#[inline(always)]
fn unsigned<const DIRECT: bool>(w: u64) -> f64 {
    if DIRECT || cfg!(not(target_arch = "x86_64")) {
        return w as f64;
    }
    let high = f64::from_bits(TWO_TO_84.to_bits() | (w >> 32));
    (high - (TWO_TO_84 + TWO_TO_52)) + low_half(w)
}

/// Rounds a word, as a signed integer, to the nearest number.
#[inline(always)]
fn signed<const DIRECT: bool>(w: u64) -> f64 {
    if DIRECT || cfg!(not(target_arch = "x86_64")) {
        return w.cast_signed() as f64;
    }
    // The inverted sign bit adds 2⁶³.
    let high = f64::from_bits(TWO_TO_84.to_bits() | ((w >> 32) ^ 0x8000_0000));
    (high - (TWO_TO_84 + HALF + TWO_TO_52)) + low_half(w)
}

/// Returns 2⁵² plus the lower half of a word.
#[inline(always)]
fn low_half(w: u64) -> f64 {
    f64::from_bits(TWO_TO_52.to_bits() | (w & 0xffff_ffff))
}

/// Evaluates a polynomial by Horner's scheme. Shorter chains would take more operations, and many
/// lanes are computed at the same time.
#[inline(always)]
fn polynomial<const N: usize>(coefficients: &[f64; N], x: f64) -> f64 {
    let mut sum = coefficients[N - 1];
    for k in (0..N - 1).rev() {
        sum = sum.mul_add(x, coefficients[k]);
    }
    sum
}

#[cfg(test)]
mod tests;

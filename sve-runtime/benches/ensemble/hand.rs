//! The limits of a machine: ensembles written by hand for one system each, with nothing but the
//! arithmetic.
//!
//! Input: streams of words. Output: normals, or sums of observables every [`RECORD`] steps. Loops
//! over [`W`] lanes are fused around the whole step; noise never leaves the registers.
//!
//! Sources: Box, Muller (1958); sine and cosine on (−π/4, π/4) with the coefficients of fdlibm.
//! ln(1 + f) has no division, since a division of 512 bits takes as long as 16 multiplications: its
//! polynomial is the Chebyshev interpolant of (ln(1 + f) − f + f²/2)/f³ on (√½ − 1, √2 − 1), within
//! 2.2·10⁻¹⁵.

use crate::wide::{Kernel, fma};
use crate::words::{Words, Xoshiro};

/// Number of lanes of kernels that keep their streams in registers.
pub(crate) const W: usize = 8;
/// Number of steps between two records.
pub(crate) const RECORD: usize = 100;

/// Returns ln u for 0 < u ≤ 1.
#[inline(always)]
fn ln<const F: bool>(u: f64) -> f64 {
    const C: [f64; 18] = [
        0.333_333_333_333_331_76,
        -0.249_999_999_999_995_4,
        0.200_000_000_002_108_74,
        -0.166_666_666_671_113_16,
        0.142_857_142_398_433_17,
        -0.124_999_998_922_177_75,
        0.111_111_148_779_067_3,
        -0.100_000_103_909_847_12,
        0.090_907_604_953_914_16,
        -0.083_328_454_797_870_04,
        0.076_953_223_569_670_71,
        -0.071_550_403_912_597_02,
        0.066_377_588_359_067_11,
        -0.060_867_462_424_881_856,
        0.059_358_470_292_036_815,
        -0.066_201_997_218_413_33,
        0.062_776_731_412_576_32,
        -0.029_269_770_657_022_43,
    ];
    // 2⁵² + 2⁵¹. An integer added to the bits of this number is added to the number.
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let exponent = (u
        .to_bits()
        .wrapping_sub(core::f64::consts::FRAC_1_SQRT_2.to_bits()))
    .cast_signed()
        >> 52;
    let mantissa = u.to_bits().wrapping_sub(exponent.cast_unsigned() << 52);
    let exponent = f64::from_bits(MAGIC.to_bits().wrapping_add(exponent.cast_unsigned())) - MAGIC;
    let f = f64::from_bits(mantissa) - 1.0;
    let (z, w) = (f * f, f * f * f * f);
    let two = |k: usize| fma::<F>(f, C[k + 1], C[k]);
    let four = |k: usize| fma::<F>(z, two(k + 2), two(k));
    let eight = |k: usize| fma::<F>(w, four(k + 4), four(k));
    let v = w * w;
    let tail = fma::<F>(v, fma::<F>(v, two(16), eight(8)), eight(0));
    let one = fma::<F>(f * z, tail, fma::<F>(-0.5, z, f));
    fma::<F>(exponent, core::f64::consts::LN_2, one)
}

/// Returns sine and cosine for |x| ≤ π/4.
#[inline(always)]
fn sin_cos<const F: bool>(x: f64) -> (f64, f64) {
    const S: [f64; 6] = [
        -1.666_666_666_666_663_2e-1,
        8.333_333_333_322_49e-3,
        -1.984_126_982_985_795e-4,
        2.755_731_370_707_006_8e-6,
        -2.505_076_025_340_686_3e-8,
        1.589_690_995_211_55e-10,
    ];
    const C: [f64; 6] = [
        4.166_666_666_666_66e-2,
        -1.388_888_888_887_411e-3,
        2.480_158_728_947_673e-5,
        -2.755_731_435_139_066_3e-7,
        2.087_572_321_298_175e-9,
        -1.135_964_755_778_819_5e-11,
    ];
    let z = x * x;
    let w = z * z;
    let sum = |c: &[f64; 6]| {
        let two = |k: usize| fma::<F>(z, c[k + 1], c[k]);
        fma::<F>(w * w, two(4), fma::<F>(w, two(2), two(0)))
    };
    let s = fma::<F>(x * z, sum(&S), x);
    let c = fma::<F>(w, sum(&C), fma::<F>(z, -0.5, 1.0));
    (s, c)
}

/// Returns two normals from two words, by Box and Muller, with all bits of the first word and 54
/// bits of the second.
#[inline(always)]
pub(crate) fn pair<const F: bool>(radius: u64, angle: u64) -> [f64; 2] {
    const CELL: f64 = 1.0 / 18_446_744_073_709_551_616.0;
    let u = fma::<F>(radius as f64, CELL, 0.5 * CELL);
    let r = (-2.0 * ln::<F>(u)).sqrt();
    let fraction = f64::from_bits(((angle << 2) >> 12) | 1.0_f64.to_bits()) - 1.5;
    let (s, c) = sin_cos::<F>(fraction * core::f64::consts::FRAC_PI_2);
    // the top bits choose the quarter
    let x = (r * c).to_bits() ^ (angle & (1 << 63));
    let y = (r * s).to_bits();
    let swapped = (x ^ y) & 0_u64.wrapping_sub((angle >> 62) & 1);
    [f64::from_bits(x ^ swapped), f64::from_bits(y ^ swapped)]
}

/// A fill of rows with words.
pub(crate) struct Fill<'a, G, T, const W: usize>(
    pub(crate) &'a mut G,
    pub(crate) &'a mut [[[T; W]; 4]],
);

impl<G: Words<W>, const W: usize> Kernel for Fill<'_, G, u64, W> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let mut words = *self.0;
        for rows in self.1 {
            for lane in 0..W {
                let four = words.four(lane);
                for i in 0..4 {
                    rows[i][lane] = four[i];
                }
            }
            words.advance();
        }
        *self.0 = words;
    }
}

/// Fills rows with normals.
impl<G: Words<W>, const W: usize> Kernel for Fill<'_, G, f64, W> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let mut words = *self.0;
        for rows in self.1 {
            // There are two passes, since the words of a counter take all registers.
            let mut block = [[0; W]; 4];
            for lane in 0..W {
                let four = words.four(lane);
                for i in 0..4 {
                    block[i][lane] = four[i];
                }
            }
            words.advance();
            let [a, b, c, d] = rows;
            for lane in 0..W {
                [a[lane], b[lane]] = pair::<F>(block[0][lane], block[1][lane]);
            }
            for lane in 0..W {
                [c[lane], d[lane]] = pair::<F>(block[2][lane], block[3][lane]);
            }
        }
        *self.0 = words;
    }
}

/// A fill of rows with normals from streams that stay in registers.
pub(crate) struct Stream<'a>(
    pub(crate) &'a mut Xoshiro<W>,
    pub(crate) &'a mut [[[f64; W]; 2]],
);

impl Kernel for Stream<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let mut words = *self.0;
        for [x, y] in self.1 {
            for lane in 0..W {
                let (a, b) = (words.next(lane), words.next(lane));
                [x[lane], y[lane]] = pair::<F>(a, b);
            }
        }
        *self.0 = words;
    }
}

/// Sums over paths of an observable and its square, one pair for each record.
pub(crate) type Sums = Vec<[f64; 2]>;

/// Task A: the linear oscillator by the endpoint rule from (1, 0), its energy.
pub(crate) struct Oscillators<'a> {
    pub(crate) words: &'a mut Xoshiro<W>,
    pub(crate) tiles: usize,
    pub(crate) h: f64,
    pub(crate) sigma: f64,
    pub(crate) sums: &'a mut Sums,
}

impl Kernel for Oscillators<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let (h, sigma) = (self.h, self.sigma * self.h.sqrt());
        let mut words = *self.words;
        for _ in 0..self.tiles {
            let (mut q, mut p) = ([1.0; W], [0.0; W]);
            for sums in &mut *self.sums {
                for _ in 0..RECORD / 2 {
                    for lane in 0..W {
                        let (a, b) = (words.next(lane), words.next(lane));
                        for z in pair::<F>(a, b) {
                            q[lane] = fma::<F>(h, p[lane], q[lane]);
                            p[lane] = fma::<F>(-h, q[lane], fma::<F>(sigma, z, p[lane]));
                        }
                    }
                }
                record(sums, &q, &p, |q, p| 0.5 * (q * q + p * p));
            }
        }
        *self.words = words;
    }
}

/// Task B: the Kubo oscillator by the midpoint rule from (1, 0), its coordinate.
pub(crate) struct Kubos<'a> {
    pub(crate) words: &'a mut Xoshiro<W>,
    pub(crate) tiles: usize,
    pub(crate) h: f64,
    pub(crate) a: f64,
    pub(crate) sigma: f64,
    pub(crate) sums: &'a mut Sums,
}

impl Kernel for Kubos<'_> {
    #[inline(always)]
    fn run<const F: bool>(self) {
        let (mean, sigma) = (0.5 * self.a * self.h, 0.5 * self.sigma * self.h.sqrt());
        let mut words = *self.words;
        for _ in 0..self.tiles {
            let (mut q, mut p) = ([1.0; W], [0.0; W]);
            for sums in &mut *self.sums {
                for _ in 0..RECORD / 2 {
                    for lane in 0..W {
                        let (a, b) = (words.next(lane), words.next(lane));
                        let half = pair::<F>(a, b).map(|z| fma::<F>(sigma, z, mean));
                        // the Cayley form of two steps with one division
                        let d = half.map(|x| fma::<F>(x, x, 1.0));
                        let inverse = 2.0 / (d[0] * d[1]);
                        for (x, k) in [(half[0], inverse * d[1]), (half[1], inverse * d[0])] {
                            let (c, s) = (k - 1.0, k * x);
                            let (q0, p0) = (q[lane], p[lane]);
                            q[lane] = fma::<F>(c, q0, s * p0);
                            p[lane] = fma::<F>(c, p0, -(s * q0));
                        }
                    }
                }
                record(sums, &q, &p, |q, _| q);
            }
        }
        *self.words = words;
    }
}

#[inline(always)]
fn record(sums: &mut [f64; 2], q: &[f64; W], p: &[f64; W], f: impl Fn(f64, f64) -> f64) {
    for lane in 0..W {
        let value = f(q[lane], p[lane]);
        sums[0] += value;
        sums[1] += value * value;
    }
}

/// Number of lanes of the pendulum, whose iterations are long chains.
pub(crate) const LONG: usize = 32;

/// Pendulums by the midpoint rule, L = v²/2 + g cos q.
pub(crate) struct Pendulums<'a> {
    pub(crate) q: &'a mut [[f64; LONG]],
    pub(crate) p: &'a mut [[f64; LONG]],
    pub(crate) steps: usize,
    pub(crate) h: f64,
    pub(crate) g: f64,
}

impl Kernel for Pendulums<'_> {
    /// Makes steps with one unknown, the velocity at the midpoint. The kick is extrapolated from
    /// the last two kicks, so that two iterations reach rounding at h = 0.1. The second iteration
    /// turns sine and cosine, and improves the reciprocal of the first.
    #[inline(always)]
    fn run<const F: bool>(self) {
        let (h, half, kick) = (self.h, 0.5 * self.h, 0.5 * self.h * self.g);
        let stiffness = half * kick;
        for (q, p) in self.q.iter_mut().zip(self.p) {
            let (mut last, mut before) = ([0.0; LONG], [0.0; LONG]);
            for lane in 0..LONG {
                last[lane] = -kick * any_sin_cos::<F>(q[lane]).0;
                before[lane] = -kick * any_sin_cos::<F>(q[lane] - h * p[lane]).0;
            }
            for _ in 0..self.steps {
                for lane in 0..LONG {
                    let (q0, p0) = (q[lane], p[lane]);
                    let mut v = p0 + (2.0 * last[lane] - before[lane]);
                    let (s, c) = any_sin_cos::<F>(fma::<F>(half, v, q0));
                    let inverse = 1.0 / fma::<F>(stiffness, c, 1.0);
                    let change = (p0 - v - kick * s) * inverse;
                    v += change;
                    let x = half * change;
                    let z = x * x;
                    let sx = fma::<F>(x * z, fma::<F>(z, 1.0 / 120.0, -1.0 / 6.0), x);
                    let cx = fma::<F>(z, fma::<F>(z, 1.0 / 24.0, -0.5), 1.0);
                    let (s, c) = (fma::<F>(s, cx, c * sx), fma::<F>(c, cx, -(s * sx)));
                    let inverse = inverse * (2.0 - fma::<F>(stiffness, c, 1.0) * inverse);
                    v += (p0 - v - kick * s) * inverse;
                    before[lane] = last[lane];
                    last[lane] = v - p0;
                    q[lane] = fma::<F>(h, v, q0);
                    p[lane] = 2.0 * v - p0;
                }
            }
        }
    }
}

/// Returns starts of `count` pendulums, a multiple of [`LONG`]: all librations, from small ones to
/// three quarters of the way up.
pub(crate) fn pendulum_starts(count: usize) -> (Vec<[f64; LONG]>, Vec<[f64; LONG]>) {
    let q = |k: usize| 0.1 + 2.2 * k as f64 / count as f64;
    let rows = |f: &dyn Fn(usize) -> f64| {
        (0..count / LONG)
            .map(|tile| core::array::from_fn(|lane| f(tile * LONG + lane)))
            .collect()
    };
    (rows(&q), rows(&|_| 0.3))
}

/// Returns sine and cosine where |x| is far below 2⁵¹ rounding errors. Reduces x by two parts of
/// π/2.
#[inline(always)]
fn any_sin_cos<const F: bool>(x: f64) -> (f64, f64) {
    const MAGIC: f64 = 6_755_399_441_055_744.0;
    let shifted = fma::<F>(x, core::f64::consts::FRAC_2_PI, MAGIC);
    let (turns, quarter) = (shifted - MAGIC, shifted.to_bits());
    let reduced = fma::<F>(turns, -core::f64::consts::FRAC_PI_2, x);
    let (s, c) = sin_cos::<F>(fma::<F>(turns, -6.123_233_995_736_766e-17, reduced));
    let (s, c) = (s.to_bits(), c.to_bits());
    let swapped = (s ^ c) & 0_u64.wrapping_sub(quarter & 1);
    let sign = |quarter: u64| (quarter & 2) << 62;
    (
        f64::from_bits(s ^ swapped ^ sign(quarter)),
        f64::from_bits(c ^ swapped ^ sign(quarter.wrapping_add(1))),
    )
}

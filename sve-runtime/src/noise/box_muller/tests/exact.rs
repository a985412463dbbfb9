//! The transform in sums of two numbers, which have 106 bits.
//!
//! Source: Dekker, *A floating-point technique for extending the available precision*, Numer. Math.
//! 18 (1971).

use core::f64::consts::{FRAC_PI_2, LN_2};

/// The sum of two numbers; the second is the rounding error of the first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sum(f64, f64);

const HALF_PI: Sum = Sum(FRAC_PI_2, 6.123_233_995_736_766e-17);
const LN_OF_2: Sum = Sum(LN_2, 2.319_046_813_846_299_6e-17);

impl From<f64> for Sum {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Sum {
    /// Returns the sum of two numbers.
    fn of(a: f64, b: f64) -> Self {
        let sum = a + b;
        let part = sum - a;
        Self(sum, (a - (sum - part)) + (b - part))
    }

    fn plus(self, other: Self) -> Self {
        let high = Self::of(self.0, other.0);
        Self::of(high.0, high.1 + (self.1 + other.1))
    }

    fn times(self, other: Self) -> Self {
        let high = self.0 * other.0;
        let low = self.0.mul_add(other.0, -high);
        Self::of(high, low + (self.0 * other.1 + self.1 * other.0))
    }

    fn over(self, divisor: f64) -> Self {
        let high = self.0 / divisor;
        let rest = (-high).mul_add(divisor, self.0) + self.1;
        Self::of(high, rest / divisor)
    }

    fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self::from(0.0);
        }
        let high = self.0.sqrt();
        let rest = (-high).mul_add(high, self.0) + self.1;
        Self::of(high, rest / (2.0 * high))
    }

    /// Returns the distance from a number.
    pub(super) fn distance(self, x: f64) -> f64 {
        ((x - self.0) - self.1).abs()
    }
}

/// Returns the normals of two words.
pub(super) fn pair(radius: u64, angle: u64) -> [Sum; 2] {
    let r = minus_two_ln(radius as f64 + 0.5).sqrt();
    let t = ((angle << 1) | 1).cast_signed();
    let rounded = t as f64;
    let rest = (i128::from(t) - rounded as i128) as f64;
    let half = (1_u64 << 63) as f64;
    let theta = Sum::of(rounded / half, rest / half).times(HALF_PI);
    let sign = if angle >> 63 == 0 { 1.0 } else { -1.0 };
    let cosine = r.times(series(theta, 0)).times(sign.into());
    [cosine, r.times(series(theta, 1))]
}

/// Returns the sine (`first` = 1) or the cosine (`first` = 0) by Taylor's series.
fn series(theta: Sum, first: u32) -> Sum {
    let square = theta.times(theta);
    let mut term = if first == 1 { theta } else { Sum::from(1.0) };
    let mut sum = term;
    for k in (first + 2..40).step_by(2) {
        term = term.times(square).over(-f64::from(k * (k - 1)));
        sum = sum.plus(term);
    }
    sum
}

/// Returns −2 ln u for 2⁶⁴ u.
fn minus_two_ln(scaled: f64) -> Sum {
    let (mut m, mut e) = (scaled / 2.0_f64.powi(64), 0.0);
    while m < core::f64::consts::FRAC_1_SQRT_2 {
        m *= 2.0;
        e -= 1.0;
    }
    // ln m = y + ln(m exp(−y)), and the argument is next to 1
    let y = libm::log(m);
    let rest = exp(-y).times(m.into()).plus((-1.0).into());
    let ln = Sum::of(y, rest.0 - 0.5 * rest.0 * rest.0 + rest.1);
    ln.plus(LN_OF_2.times(e.into())).times((-2.0).into())
}

/// Returns exp x for |x| < 1.
fn exp(x: f64) -> Sum {
    let part = x / 256.0;
    let (mut term, mut sum) = (Sum::from(1.0), Sum::from(1.0));
    for k in 1..14 {
        term = term.times(part.into()).over(f64::from(k));
        sum = sum.plus(term);
    }
    (0..8).fold(sum, |power, _| power.times(power))
}

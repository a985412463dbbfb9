//! Numbers of 106 bits as unevaluated sums of two `f64`, for tests of zero and for oracles whose
//! own rounding must not matter.
//!
//! Error-free transformations of Dekker (1971) and Knuth. The relative error of an operation is a
//! few 2⁻¹⁰⁴. The crate of the integration tests compiles this file too, so the file uses nothing
//! else of this crate.

use core::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`.
#[derive(Clone, Copy, Debug)]
pub struct Double {
    high: f64,
    low: f64,
}

impl Double {
    /// 1.
    pub const ONE: Self = Self {
        high: 1.0,
        low: 0.0,
    };

    /// Creates a number from its two parts.
    pub const fn new(high: f64, low: f64) -> Self {
        Self { high, low }
    }

    /// Returns the nearest `f64`.
    pub fn nearest(self) -> f64 {
        self.high + self.low
    }

    /// Returns the absolute value.
    #[must_use]
    pub fn abs(self) -> Self {
        if self.nearest() < 0.0 { -self } else { self }
    }

    /// Returns `self · 2ᵏ`, in two factors so that neither overflows.
    #[must_use]
    pub fn times_two_to(self, k: i32) -> Self {
        let [first, second] = [k / 2, k - k / 2].map(|k| 2.0f64.powi(k));
        Self {
            high: self.high * first * second,
            low: self.low * first * second,
        }
    }

    /// Returns `selfᵏ` by repeated squaring.
    #[must_use]
    pub fn power(self, k: i32) -> Self {
        let (mut square, mut left) = (self, k.unsigned_abs());
        let mut product = Self::ONE;
        while left > 0 {
            if left % 2 == 1 {
                product = product * square;
            }
            left /= 2;
            if left > 0 {
                square = square * square;
            }
        }
        if k < 0 { Self::ONE / product } else { product }
    }

    /// Returns `a + b` for operands of any magnitudes.
    fn sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let b_part = high - a;
        let low = (a - (high - b_part)) + (b - b_part);
        Self { high, low }
    }

    fn with(self, low: f64) -> Self {
        Self::sum(self.high, self.low + low)
    }
}

impl From<f64> for Double {
    fn from(high: f64) -> Self {
        Self { high, low: 0.0 }
    }
}

impl Neg for Double {
    type Output = Self;
    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Add for Double {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::sum(self.high, other.high).with(self.low + other.low)
    }
}

impl Sub for Double {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Double {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let high = self.high * other.high;
        let low = self.high.mul_add(other.high, -high);
        Self { high, low }.with(self.high * other.low + self.low * other.high)
    }
}

impl Div for Double {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let first = Self::from(self.high / other.high);
        let rest = self - first * other;
        let second = rest.high / other.high;
        first.with(second)
    }
}

//! Numbers of 106 bits as unevaluated sums of two `f64`, in constant functions: the compiler
//! computes the matrices of the Gauss rules.
//!
//! Error-free transformations of Dekker (1971) and Knuth; a relative error of a few 2⁻¹⁰⁴ per
//! operation.

/// `high + low`, with `high` the nearest `f64`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Double {
    pub(super) high: f64,
    pub(super) low: f64,
}

impl Double {
    pub(super) const ZERO: Self = Self::of(0.0);
    pub(super) const ONE: Self = Self::of(1.0);

    /// Returns the number with the value of an `f64`.
    pub(super) const fn of(x: f64) -> Self {
        Self { high: x, low: 0.0 }
    }

    /// Returns the exact sum of two `f64`.
    const fn exact_sum(a: f64, b: f64) -> Self {
        let high = a + b;
        let part = high - a;
        let low = (a - (high - part)) + (b - part);
        Self { high, low }
    }

    /// Returns the exact product of two `f64`. Splits each into halves of 26 bits, since constant
    /// functions have no fused operations.
    const fn exact_product(a: f64, b: f64) -> Self {
        const SPLITTER: f64 = 134_217_729.0;
        let (shifted_a, shifted_b) = (SPLITTER * a, SPLITTER * b);
        let (a1, b1) = (shifted_a - (shifted_a - a), shifted_b - (shifted_b - b));
        let (a2, b2) = (a - a1, b - b1);
        let high = a * b;
        let low = ((a1 * b1 - high) + a1 * b2 + a2 * b1) + a2 * b2;
        Self { high, low }
    }

    pub(super) const fn plus(self, other: Self) -> Self {
        let high = Self::exact_sum(self.high, other.high);
        let low = Self::exact_sum(self.low, other.low);
        let sum = Self::exact_sum(high.high, high.low + low.high);
        Self::exact_sum(sum.high, sum.low + low.low)
    }

    pub(super) const fn minus(self, other: Self) -> Self {
        self.plus(other.negated())
    }

    pub(super) const fn negated(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }

    pub(super) const fn times(self, other: Self) -> Self {
        let product = Self::exact_product(self.high, other.high);
        let cross = self.high * other.low + self.low * other.high;
        Self::exact_sum(product.high, product.low + cross)
    }

    pub(super) const fn over(self, other: Self) -> Self {
        let first = Self::of(self.high / other.high);
        let rest = self.minus(other.times(first));
        let second = Self::of(rest.high / other.high);
        let rest = rest.minus(other.times(second));
        let third = Self::of(rest.high / other.high);
        first.plus(second).plus(third)
    }

    /// Returns the nearest multiple of `2^-bits`, exactly, for numbers below 2 in magnitude and
    /// `bits` up to 60.
    pub(super) const fn to_multiple_of_two_to_minus(self, bits: u32) -> f64 {
        let scale = (1u64 << bits) as f64;
        // a product with a power of two is exact
        let (high, low) = (self.high * scale, self.low * scale);
        let mut whole = high as i64;
        let mut rest = (high - whole as f64) + low;
        while rest > 0.5 {
            whole += 1;
            rest -= 1.0;
        }
        while rest < -0.5 {
            whole -= 1;
            rest += 1.0;
        }
        whole as f64 / scale
    }
}

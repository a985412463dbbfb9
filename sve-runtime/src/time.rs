//! Times of steps.

/// Returns the time `start + steps h`, rounded once by a fused operation, which has the same bits
/// on every machine.
#[inline]
pub(crate) fn time_after(start: f64, steps: u64, h: f64) -> f64 {
    let steps = steps as f64;
    if start == 0.0 {
        // The product alone is rounded once too, and is faster on machines without a fused
        // operation.
        steps * h
    } else {
        steps.mul_add(h, start)
    }
}

/// Returns whether a step can lead from the time `t` to `end`.
#[inline]
pub(crate) fn is_next_time(t: f64, end: f64) -> bool {
    end.is_finite() && end != t
}

/// Returns the distance from a time to the next number.
pub(crate) fn unit(t: f64) -> f64 {
    t.abs().next_up() - t.abs()
}

/// Decimal digits with which a number prints as it was written: a decimal number of 15 digits
/// survives the conversion to `f64` and back.
const DIGITS: u64 = 1_000_000_000_000_000;

/// Largest power of ten that is exact in `f64`.
const LARGEST_EXPONENT: i32 = 22;

/// The times t₀ + k h as decimal numbers: 0.1 · 3 is 0.3.
///
/// The start and the step size are taken as the decimal numbers that they print as, such as 1.5 and
/// 0.1, as long as the sum has at most 15 digits. The time is then the `f64` that prints as the
/// sum. If the sum has more digits, as for h = 1/3, the time is t₀ + k h with start and step size
/// in binary, rounded once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WrittenTimes {
    start: f64,
    h: f64,
    /// Start and step size in units of a power of ten, and its exponent.
    decimal: Option<([i64; 2], i32)>,
}

impl WrittenTimes {
    pub(crate) fn new(start: f64, h: f64) -> Self {
        let decimal = common_decimals(start, h);
        Self { start, h, decimal }
    }

    /// Returns the time after a number of steps.
    pub(crate) fn after(&self, steps: u64) -> f64 {
        self.decimal_after(steps)
            .unwrap_or_else(|| time_after(self.start, steps, self.h))
    }

    fn decimal_after(&self, steps: u64) -> Option<f64> {
        let ([start, h], exponent) = self.decimal?;
        let time = h
            .checked_mul(i64::try_from(steps).ok()?)?
            .checked_add(start)?;
        if time.unsigned_abs() >= DIGITS {
            return None;
        }
        // both are exact, so the result is rounded once
        let unit = 10_f64.powi(exponent.abs());
        let time = time as f64;
        Some(if exponent < 0 {
            time / unit
        } else {
            time * unit
        })
    }

    /// Returns whether start and step size are finite and the step size is not zero.
    pub(crate) fn are_known(&self) -> bool {
        self.start.is_finite() && self.h.is_finite() && self.h != 0.0
    }

    /// Returns the step size.
    pub(crate) fn h(&self) -> f64 {
        self.h
    }

    /// Returns whether a time comes before another one.
    pub(crate) fn is_before(&self, t: f64, other: f64) -> bool {
        (t - other) * self.h.signum() < 0.0
    }

    /// Returns the number of whole steps before a time, and whether the time after these steps
    /// equals this time up to rounding. `None` if the time is before the start, or not finite.
    pub(crate) fn position(&self, t: f64) -> Option<(u64, bool)> {
        let steps = (t - self.start) / self.h;
        let tolerance =
            (4.0 * f64::EPSILON * (t.abs() + self.start.abs())).min(0.25 * self.h.abs());
        let nearest = steps.round();
        if nearest >= 0.0 && nearest < u64::MAX as f64 {
            #[allow(clippy::cast_sign_loss)] // it is not negative
            let nearest = nearest as u64;
            if (time_after(self.start, nearest, self.h) - t).abs() <= tolerance {
                return Some((nearest, true));
            }
        }
        #[allow(clippy::cast_sign_loss)] // it is not negative
        (steps >= 0.0 && steps < u64::MAX as f64).then_some((steps as u64, false))
    }
}

/// Returns two numbers in units of a common power of ten, and its exponent. `None` if one of them
/// has more than 15 digits in this unit.
fn common_decimals(start: f64, h: f64) -> Option<([i64; 2], i32)> {
    let ([start, h], [of_start, of_h]) = {
        let ((a, of_a), (b, of_b)) = (decimals(start)?, decimals(h)?);
        ([a, b], [of_a, of_b])
    };
    let exponent = match (start, h) {
        (0, _) => of_h,
        _ => of_start.min(of_h),
    };
    let scaled = |digits: i64, of: i32| {
        let factor = 10_i64.checked_pow(u32::try_from(of - exponent).unwrap_or(0))?;
        let scaled = digits.checked_mul(factor)?;
        (scaled.unsigned_abs() < DIGITS).then_some(scaled)
    };
    let both = [scaled(start, of_start)?, scaled(h, of_h)?];
    (exponent.abs() <= LARGEST_EXPONENT).then_some((both, exponent))
}

/// Returns the digits of a number as an integer, and the exponent of its last digit. `None` if the
/// number has more than 15 digits.
fn decimals(x: f64) -> Option<(i64, i32)> {
    if x == 0.0 {
        return Some((0, 0));
    }
    let text = format!("{x:e}");
    let (mantissa, exponent) = text.split_once('e')?;
    let places = mantissa
        .split_once('.')
        .map_or(0, |(_, places)| places.len());
    let digits: i64 = mantissa.replace('.', "").parse().ok()?;
    let exponent = exponent.parse::<i32>().ok()? - places as i32;
    (digits.unsigned_abs() < DIGITS).then_some((digits, exponent))
}

#[cfg(test)]
mod tests {
    use super::{WrittenTimes, time_after};

    #[test]
    fn times_print_as_one_writes_them() {
        for (start, h, steps, text) in [
            (0.0, 0.1, 3, "0.3"),
            (0.0, 0.1, 1_000_000_007, "100000000.7"),
            (0.3, 0.1, 6, "0.9"),
            (1.5, 0.01, 7, "1.57"),
            (-2.0, 0.2, 7, "-0.6"),
            (0.0, -0.1, 3, "-0.3"),
            (0.0, 1e-3, 33, "0.033"),
            (100.0, 1e-7, 3, "100.0000003"),
            (0.0, 3e5, 3, "900000.0"),
            (0.0, 5e-324, 2, "1e-323"),
            (7.0, 0.7, 0, "7.0"),
            (0.0, 1e300, 3, "3e300"),
        ] {
            let times = WrittenTimes::new(start, h);
            assert_eq!(format!("{:?}", times.after(steps)), text);
        }
    }

    /// Checks that a time is the nearest number to the decimal sum if the sum has at most 15
    /// digits.
    #[test]
    fn times_are_the_nearest_numbers_to_decimal_sums() {
        for h in [7, 13, 1001, 99_999] {
            let times = WrittenTimes::new(0.25, h as f64 / 1e5);
            for k in (0..1000).chain(1_000_000..1_000_100) {
                let units = 25_000 + k * h;
                let text = format!("{}.{:05}", units / 100_000, units % 100_000);
                assert_eq!(times.after(k), text.parse::<f64>().unwrap());
            }
        }
    }

    #[test]
    fn numbers_of_many_digits_are_rounded_once() {
        for (start, h) in [(0.0, 1.0 / 3.0), (0.1, 0.3_f64.sqrt()), (1.0 / 7.0, 0.1)] {
            let times = WrittenTimes::new(start, h);
            for k in 0..100 {
                assert_eq!(times.after(k), time_after(start, k, h));
            }
        }
        assert_eq!(WrittenTimes::new(0.0, 1.0 / 3.0).after(3), 1.0);
    }

    /// A decimal sum becomes too long at some step. Times increase at this step too, and everywhere
    /// are within two units of rounding.
    #[test]
    fn times_increase_where_decimals_end() {
        let times = WrittenTimes::new(0.0, 0.123_456_789_01);
        let mut last = -1.0;
        for k in 80_000..82_000 {
            let (time, binary) = (times.after(k), time_after(0.0, k, 0.123_456_789_01));
            assert!(time > last && (time - binary).abs() <= 2.0 * f64::EPSILON * binary);
            last = time;
        }
    }

    #[test]
    fn positions_are_whole_steps_up_to_rounding() {
        let times = WrittenTimes::new(0.0, 0.1);
        for k in 0..10_000 {
            assert_eq!(times.position(k as f64 / 10.0), Some((k, true)));
            assert_eq!(times.position(0.1 * k as f64), Some((k, true)));
            assert_eq!(times.position(0.1 * k as f64 + 1e-9), Some((k, false)));
        }
        assert_eq!(times.position(-0.05), None);
        assert_eq!(times.position(f64::NAN), None);
        assert_eq!(times.position(f64::INFINITY), None);
        assert_eq!(
            WrittenTimes::new(1.0, -0.5).position(-0.75),
            Some((3, false))
        );
    }
}

//! Derivatives of a power with respect to its exponent.
//!
//! Input: base `x`, exponent `y`, order of the derivative `n`. Output: `x^y lnⁿ x`, extended
//! continuously to x = 0.

/// Returns `x^y lnⁿ x`. For y > 0 the value at x = 0 is the limit, zero.
#[inline]
pub fn power_log(x: f64, y: f64, n: i32) -> f64 {
    if x == 0.0 && y > 0.0 {
        return 0.0;
    }
    x.powf(y) * x.ln().powi(n)
}

#[cfg(test)]
mod tests {
    use super::power_log;

    #[test]
    fn is_the_derivative_in_the_exponent() {
        for (x, y) in [(0.3f64, 1.7f64), (2.5, -0.4), (4.0, 0.0)] {
            let slope = (x.powf(y + 1e-5) - x.powf(y - 1e-5)) / 2e-5;
            // Errors of the difference: truncation 1e-10 f‴/6, rounding 1e-16/1e-5.
            assert!((power_log(x, y, 1) - slope).abs() < 1e-9);
            let again = (power_log(x, y + 1e-5, 1) - power_log(x, y - 1e-5, 1)) / 2e-5;
            assert!((power_log(x, y, 2) - again).abs() < 1e-9);
        }
    }

    #[test]
    fn a_base_of_zero_has_the_limit_if_there_is_one() {
        for zero in [0.0, -0.0] {
            assert_eq!(power_log(zero, 1e-3, 1), 0.0);
            assert_eq!(power_log(zero, 2.0, 2), 0.0);
            // the limit does not exist
            assert!(!power_log(zero, 0.0, 1).is_finite());
            assert!(!power_log(zero, -1.0, 1).is_finite());
        }
        assert!(power_log(-1.0, 2.0, 1).is_nan());
        assert!(power_log(f64::NAN, 2.0, 1).is_nan());
        assert!(power_log(0.0, f64::NAN, 1).is_nan());
    }
}

//! Means with standard errors.
//!
//! Input: independent values, one for each path. Output: an [`Estimate`]. Sums run in the order of
//! the paths.

/// A number with its standard error: 0 without randomness, NaN for a single random value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The number.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// A number without randomness.
    pub(super) fn certain(value: f64) -> Self {
        Self {
            value,
            standard_error: 0.0,
        }
    }

    /// Returns the mean of independent values.
    pub(super) fn mean(values: &[f64]) -> Self {
        let n = values.len() as f64;
        let value = values.iter().sum::<f64>() / n;
        let squares: f64 = values.iter().map(|x| (x - value).powi(2)).sum();
        // a single value gives 0/0, NaN: its error is unknown
        let standard_error = (squares / (n - 1.0) / n).sqrt();
        Self {
            value,
            standard_error,
        }
    }

    /// Returns the root of the mean of independent squares; `δ√m = δm / 2√m` to first order.
    pub(super) fn root_mean(squares: &[f64]) -> Self {
        let mean = Self::mean(squares);
        let value = mean.value.sqrt();
        let standard_error = if value == 0.0 {
            0.0
        } else {
            mean.standard_error / (2.0 * value)
        };
        Self {
            value,
            standard_error,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Estimate;

    #[test]
    fn mean_of_squares() {
        // mean 7, deviations −3, 2, 1
        let squares = [4.0, 9.0, 8.0];
        let Estimate {
            value,
            standard_error,
        } = Estimate::mean(&squares);
        assert_eq!(value, 7.0);
        assert!((standard_error.powi(2) - 14.0 / 2.0 / 3.0).abs() < 1e-15);
        let root = Estimate::root_mean(&squares);
        assert_eq!(root.value, 7.0_f64.sqrt());
        assert_eq!(root.standard_error, standard_error / (2.0 * root.value));
        assert!(Estimate::mean(&[1.0]).standard_error.is_nan());
    }
}

//! Bounds of rounding errors, for residuals whose terms' magnitudes do not show them.

/// Returns a bound of the error of `f(x)` if the error of x is at most `error`.
#[cold]
pub fn propagated_error(f: impl Fn(f64) -> f64, x: f64, error: f64) -> f64 {
    let value = f(x);
    let (above, below) = ((f(x + error) - value).abs(), (f(x - error) - value).abs());
    // The larger one, or NaN: at the boundary of its domain a function has no bound.
    let largest = if above > below { above } else { below };
    largest + 0.0 * above + f64::EPSILON * value.abs()
}

#[cfg(test)]
mod tests {
    use super::propagated_error;

    #[test]
    fn the_error_grows_with_the_slope() {
        let bound = propagated_error(|x| x * x, 3.0, 1e-6);
        assert!((bound - 6e-6).abs() < 1e-11, "{bound:e}");
        assert_eq!(propagated_error(|_| 2.0, 1.0, 1e-3), 2.0 * f64::EPSILON);
    }

    #[test]
    fn there_is_no_bound_at_the_boundary_of_the_domain() {
        assert!(propagated_error(f64::sqrt, 0.0, 1e-6).is_nan());
    }
}

//! The course of an error along a long path: its largest value in each part of the time.

/// Returns the decimal logarithm of the largest |error| in each part of a path, at the end of the
/// part.
///
/// An error that oscillates passes through zero, and a picture of all its values would show how
/// close to zero the steps came.
///
/// # Errors
/// The error of a step.
///
/// # Panics
/// If `length`, the number of errors in a part, is 0.
pub fn envelope<E>(
    errors: impl Iterator<Item = Result<(f64, f64), E>>,
    length: usize,
) -> Result<Vec<(f64, f64)>, E> {
    let (mut points, mut largest, mut count) = (Vec::new(), 0.0_f64, 0);
    for error in errors {
        let (t, error) = error?;
        // NaN is kept.
        largest = if error.is_nan() {
            error
        } else {
            largest.max(error.abs())
        };
        count += 1;
        if count % length == 0 {
            points.push((t, largest.log10()));
            largest = 0.0;
        }
    }
    Ok(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_part_has_its_largest_error() {
        let errors = [1e-3, -1e-2, 1e-5, 1e-4, 7.0].into_iter().enumerate();
        let errors = errors.map(|(k, error)| Ok::<_, ()>((k as f64, error)));
        assert_eq!(envelope(errors, 2), Ok(vec![(1.0, -2.0), (3.0, -4.0)]));
    }
}

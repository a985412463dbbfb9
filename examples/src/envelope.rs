//! The course of a quantity along a long path: its largest value, or its range, in each part of the
//! time.

use crate::figure::{Layer, Pen};
use crate::palette::Color;

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

/// Returns a layer with the range of a series in each of `parts` parts, and its middle. A line
/// through all points of a fast oscillation would be a block.
pub fn range_of(label: &str, points: &[(f64, f64)], parts: usize, color: Color) -> Layer {
    let [middles, ends] = ranges(points, parts);
    Layer::new(label, middles, Pen::line(color, 1.0)).band(ends)
}

/// Returns the middle of each part, and the least and the greatest value in it.
fn ranges(points: &[(f64, f64)], parts: usize) -> [Vec<(f64, f64)>; 2] {
    let length = points.len().div_ceil(parts.max(1)).max(1);
    let of = |part: &[(f64, f64)]| {
        let values = part.iter().map(|point| point.1);
        let (least, greatest) = (
            values.clone().fold(f64::INFINITY, f64::min),
            values.fold(f64::NEG_INFINITY, f64::max),
        );
        let middle = f64::midpoint(part[0].0, part[part.len() - 1].0);
        ((middle, f64::midpoint(least, greatest)), (least, greatest))
    };
    let (middles, ends) = points.chunks(length).map(of).unzip();
    [middles, ends]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_contains_all_values() {
        let points = [(0.0, 1.0), (1.0, -2.0), (2.0, 5.0), (3.0, 6.0)];
        let [middles, ends] = ranges(&points, 2);
        assert_eq!(middles, [(0.5, -0.5), (2.5, 5.5)]);
        assert_eq!(ends, [(-2.0, 1.0), (5.0, 6.0)]);
    }

    #[test]
    fn each_part_has_its_largest_error() {
        let errors = [1e-3, -1e-2, 1e-5, 1e-4, 7.0].into_iter().enumerate();
        let errors = errors.map(|(k, error)| Ok::<_, ()>((k as f64, error)));
        assert_eq!(envelope(errors, 2), Ok(vec![(1.0, -2.0), (3.0, -4.0)]));
    }
}

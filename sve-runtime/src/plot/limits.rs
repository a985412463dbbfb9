//! Errors with standard errors on two axes of powers. An error that is not distinguishable from
//! zero is an upper limit.

use super::figure::{Layer, Pen, Shape, Symbols};

/// Number of standard errors below which an error is not distinguishable from zero.
const SIGNIFICANT: f64 = 2.0;

impl Layer {
    /// Returns the errors on two axes of powers, from abscissas, errors and their standard errors
    /// (0 for exact errors): one layer with the errors and bars of two standard errors on either
    /// side, and one layer with upper limits of the errors below two standard errors. No line goes
    /// through a missing error.
    pub fn errors(
        label: impl Into<String>,
        pen: Pen,
        points: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> [Self; 2] {
        let (mut found, mut bars, mut limits) = (Vec::new(), Vec::new(), Vec::new());
        for (x, error, standard_error) in points {
            // A single path has no standard error, and no bar.
            let spread = if standard_error.is_nan() {
                0.0
            } else {
                SIGNIFICANT * standard_error
            };
            let (x, error) = (x.log10(), error.abs());
            if error > spread {
                found.push((x, error.log10()));
                bars.push(((error - spread).log10(), (error + spread).log10()));
            } else {
                // A point that is not finite ends a line.
                found.push((x, f64::NAN));
                bars.push((f64::NAN, f64::NAN));
                limits.push((x, (error + spread).log10()));
            }
        }
        let symbol = Symbols {
            shape: Shape::Limit,
            radius: 3.2,
            count: None,
        };
        let arrows = Pen {
            line: None,
            symbol: Some(symbol),
            ..pen
        };
        let label = label.into();
        let limits = Layer::new(format!("{label}, upper limit"), limits, arrows);
        [Layer::new(label, found, pen).bars(bars), limits.unlisted()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_below_two_standard_errors_is_a_limit() {
        let points = [(0.1, 1e-2, 1e-3), (0.01, -1e-3, 1e-3), (0.001, 1e-4, 0.0)];
        let [found, limits] = Layer::errors("method", Pen::series(0), points);
        assert!((found.points[0].1 + 2.0).abs() < 1e-12);
        assert!(found.points[1].1.is_nan() && found.points[2].1 == -4.0);
        assert_eq!(limits.points.len(), 1);
        let [single, none] = Layer::errors("method", Pen::series(0), [(0.1, 1e-2, f64::NAN)]);
        assert!(single.points[0].1 == -2.0 && none.points.is_empty());
        assert!((limits.points[0].1 - 3e-3_f64.log10()).abs() < 1e-12);
    }
}

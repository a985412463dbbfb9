//! Numbers with bounds of their rounding errors, for residuals whose terms' magnitudes do not show
//! these errors.
//!
//! A running error analysis (Higham, Accuracy and Stability of Numerical Algorithms, section 3.3):
//! each operation propagates the errors of its operands to first order and adds the rounding of its
//! result. Inputs are exact, and stay `f64`.

/// A number with a bound of its rounding error.
#[derive(Clone, Copy, Debug)]
pub struct Rounded {
    value: f64,
    error: f64,
}

/// An operand: a number with a bound, or an exact one.
pub trait Operand: Copy {
    /// Returns the number.
    fn value(self) -> f64;
    /// Returns the bound of its error; `None` if it is exact.
    fn error(self) -> Option<f64>;
}

impl Operand for f64 {
    fn value(self) -> f64 {
        self
    }

    fn error(self) -> Option<f64> {
        None
    }
}

impl Operand for Rounded {
    fn value(self) -> f64 {
        self.value
    }

    fn error(self) -> Option<f64> {
        Some(self.error)
    }
}

/// Returns the bound of the error of a number; zero if it is exact.
pub fn error(a: impl Operand) -> f64 {
    a.error().unwrap_or(0.0)
}

/// Returns the result of an operation, with the error that it inherits from each operand.
fn result<const K: usize>(value: f64, inherited: [Option<f64>; K]) -> Rounded {
    let inherited: f64 = inherited.into_iter().flatten().sum();
    let error = inherited + f64::EPSILON * value.abs();
    Rounded { value, error }
}

/// Returns `a + b`.
pub fn add(a: impl Operand, b: impl Operand) -> Rounded {
    result(a.value() + b.value(), [a.error(), b.error()])
}

/// Returns `a − b`.
pub fn sub(a: impl Operand, b: impl Operand) -> Rounded {
    result(a.value() - b.value(), [a.error(), b.error()])
}

/// Returns `a b`.
pub fn mul(a: impl Operand, b: impl Operand) -> Rounded {
    let (of_a, of_b) = (b.value().abs(), a.value().abs());
    let errors = [
        a.error().map(|error| of_a * error),
        b.error().map(|error| of_b * error),
    ];
    result(a.value() * b.value(), errors)
}

/// Returns `a / b`.
pub fn div(a: impl Operand, b: impl Operand) -> Rounded {
    let ratio = a.value() / b.value();
    let errors = [
        a.error().map(|error| error / b.value().abs()),
        b.error().map(|error| (ratio / b.value()).abs() * error),
    ];
    result(ratio, errors)
}

/// Returns `1 / a`.
pub fn recip(a: impl Operand) -> Rounded {
    let inverse = 1.0 / a.value();
    let error = a.error().map(|error| inverse * inverse * error);
    result(inverse, [error])
}

/// Returns `−a`.
pub fn neg(a: impl Operand) -> Rounded {
    result(-a.value(), [a.error()])
}

/// Returns `|a|`.
pub fn abs(a: impl Operand) -> Rounded {
    result(a.value().abs(), [a.error()])
}

/// Returns `f(a)`.
pub fn call(f: impl Fn(f64) -> f64, a: impl Operand) -> Rounded {
    let x = a.value();
    let error = a.error().map(|error| propagated_error(&f, x, error));
    result(f(x), [error])
}

/// Returns `f(a, b)`.
pub fn call2(f: impl Fn(f64, f64) -> f64, a: impl Operand, b: impl Operand) -> Rounded {
    let (x, y) = (a.value(), b.value());
    let errors = [
        a.error()
            .map(|error| propagated_error(|x| f(x, y), x, error)),
        b.error()
            .map(|error| propagated_error(|y| f(x, y), y, error)),
    ];
    result(f(x, y), errors)
}

/// Returns `sin(a)` and `cos(a)`.
pub fn sin_cos(a: impl Operand) -> (Rounded, Rounded) {
    pair(a.value().sin_cos(), error(a))
}

/// Returns `sin(α + by)` and `cos(α + by)`, from sine and cosine of α.
pub fn sin_cos_of_sum(
    sin: impl Operand,
    cos: impl Operand,
    by: impl Operand,
) -> (Rounded, Rounded) {
    let values = crate::angle_addition::sin_cos_of_sum(sin.value(), cos.value(), by.value());
    pair(values, error(sin) + error(cos) + error(by))
}

/// Returns a sine and a cosine, which differ by at most as much as their angles.
fn pair((sin, cos): (f64, f64), inherited: f64) -> (Rounded, Rounded) {
    let error = inherited + f64::EPSILON;
    (Rounded { value: sin, error }, Rounded { value: cos, error })
}

/// Returns a bound of the error of `f(x)` if the error of x is at most `error`.
#[cold]
fn propagated_error(f: impl Fn(f64) -> f64, x: f64, error: f64) -> f64 {
    let value = f(x);
    let (above, below) = ((f(x + error) - value).abs(), (f(x - error) - value).abs());
    // Takes the larger difference, or NaN: at the boundary of its domain a function has no bound.
    let largest = if above > below { above } else { below };
    largest + 0.0 * above + f64::EPSILON * value.abs()
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn an_exact_operand_adds_nothing() {
        let e = f64::EPSILON;
        let x = add(1.0, 2.0);
        assert_eq!((x.value(), error(x), error(3.0)), (3.0, 3.0 * e, 0.0));
        assert_eq!(error(mul(x, 4.0)), 12.0 * e + 12.0 * e);
        assert_eq!(error(mul(x, x)), 9.0 * e + 9.0 * e + 9.0 * e);
        assert_eq!(error(sub(4.0, x)), 3.0 * e + e);
        assert_eq!(error(div(6.0, x)), 2.0 / 3.0 * (3.0 * e) + 2.0 * e);
        assert_eq!(error(recip(neg(0.5))), 4.0 * (0.5 * e) + 2.0 * e);
        assert_eq!(error(abs(-2.0)), 2.0 * e);
        assert_eq!(error(call(f64::sqrt, 4.0)), 2.0 * e);
        assert_eq!(error(call2(f64::hypot, 3.0, 4.0)), 5.0 * e);
    }

    /// The bound holds where digits cancel: 1 + x − 1 for a small x.
    #[test]
    fn the_bound_contains_the_error_of_a_difference() {
        let x = 1e-9 / 3.0;
        let found = sub(add(1.0, x), 1.0);
        let actual = (found.value() - x).abs();
        assert!(
            actual > 0.0 && actual <= error(found),
            "{actual:e} {found:?}"
        );
        let (sin, cos) = sin_cos(found);
        assert_eq!(error(sin), error(found) + f64::EPSILON);
        let (sum, _) = sin_cos_of_sum(sin, cos, 0.1);
        assert!((sum.value() - (found.value() + 0.1).sin()).abs() <= error(sum));
    }
}

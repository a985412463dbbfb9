//! The zero of a function between two points at which it has different signs.
//!
//! Input: a function that can fail, a bracket and the values at its ends. Output: a point at which
//! the function is zero, or next to which it changes its sign; of a bracket without a change of
//! sign, the end with the smaller value. Invariant: the bracket always contains a change of sign,
//! so the function only has to be continuous.
//!
//! Source: T. R. Chandrupatla, *A new hybrid quadratic/bisection algorithm for finding the zero of
//! a nonlinear function without using derivatives*, Advances in Engineering Software 28 (1997)
//! 145–149. The first point here is the point of the secant.

/// Width of the last bracket, for brackets within [0, 1].
const WIDTH: f64 = f64::EPSILON;

/// Largest number of evaluations. Bisection alone takes 52; the interpolation takes at most about
/// twice as many.
const EVALUATIONS: u32 = 200;

/// A point with its value.
type Point = (f64, f64);

/// The result of a search.
pub(in crate::trajectory) struct Zero {
    /// The end of the last bracket with the smaller value.
    pub(in crate::trajectory) at: f64,
    /// The values at both ends of the last bracket.
    pub(super) values: [f64; 2],
}

/// Finds a zero between two points whose values have different signs. Rounding errors may give a
/// zero at an end both values the same sign: it is then the end with the smaller value.
pub(in crate::trajectory) fn zero_between<E>(
    mut function: impl FnMut(f64) -> Result<f64, E>,
    bracket: [Point; 2],
) -> Result<Zero, E> {
    let [first, second] = bracket;
    // `new` and `other` bracket the zero; `before` is the point that was discarded last.
    let (mut other, mut new) = (first, second);
    let mut fraction = new.1 / (new.1 - other.1);
    let has_same_sign = first.1 > 0.0 && second.1 > 0.0 || first.1 < 0.0 && second.1 < 0.0;
    let most = if has_same_sign { 0 } else { EVALUATIONS };
    for _ in 0..most {
        let best = if new.1.abs() < other.1.abs() {
            new
        } else {
            other
        };
        let limit = WIDTH / (other.0 - new.0).abs();
        if best.1 == 0.0 || limit > 0.5 {
            break;
        }
        let x = new.0 + fraction.clamp(limit, 1.0 - limit) * (other.0 - new.0);
        let point = (x, function(x)?);
        let before;
        if (point.1 > 0.0) == (new.1 > 0.0) {
            before = new;
        } else {
            (before, other) = (other, new);
        }
        new = point;
        fraction = next_fraction(new, other, before);
    }
    let best = if new.1.abs() < other.1.abs() {
        new
    } else {
        other
    };
    Ok(Zero {
        at: best.0,
        values: [new.1, other.1],
    })
}

/// Returns the next point as a fraction of the way from `new` to `other`: by inverse quadratic
/// interpolation if the interpolation is monotone, otherwise the middle.
fn next_fraction(new: Point, other: Point, before: Point) -> f64 {
    let x = (new.0 - other.0) / (before.0 - other.0);
    let y = (new.1 - other.1) / (before.1 - other.1);
    if y * y < x && (1.0 - y) * (1.0 - y) < 1.0 - x {
        let [a, b, c] = [new.1, other.1, before.1];
        a / (b - a) * c / (b - c)
            + (before.0 - new.0) / (other.0 - new.0) * a / (c - a) * b / (c - b)
    } else {
        0.5
    }
}

#[cfg(test)]
mod tests {
    use super::zero_between;

    type Function<'a> = &'a dyn Fn(f64) -> f64;

    fn search(function: impl Fn(f64) -> f64) -> (f64, u32) {
        let mut count = 0;
        let ends = [0.0, 1.0].map(|x| (x, function(x)));
        let counted = |x| {
            count += 1;
            Ok::<f64, ()>(function(x))
        };
        let zero = zero_between(counted, ends).unwrap();
        (zero.at, count)
    }

    #[test]
    fn zeros_are_found_to_the_last_bits() {
        let cases: [(Function<'_>, f64, u32); 6] = [
            (&|x| x - 0.3, 0.3, 3),
            (&|x| (x - 0.7) * (1.0 + x * x), 0.7, 9),
            (&|x| x.sin() - 0.5, 0.5_f64.asin(), 9),
            (&|x| x.exp() - 1.001, 1.001_f64.ln(), 9),
            (&|x| (x - 0.25).powi(3), 0.25, 100),
            (&|x| if x < 0.625 { -1.0 } else { 2.0 }, 0.625, 60),
        ];
        for (k, (function, expected, most)) in cases.into_iter().enumerate() {
            let (zero, count) = search(function);
            let tolerance = if k == 4 { 1e-5 } else { 3e-16 };
            assert!((zero - expected).abs() <= tolerance, "{k}: {zero}");
            assert!(count <= most, "{k}: {count} evaluations");
        }
    }

    #[test]
    fn an_error_of_the_function_ends_the_search() {
        let result = zero_between(|_| Err("undefined"), [(0.0, -1.0), (1.0, 1.0)]);
        assert!(matches!(result, Err("undefined")));
    }
}

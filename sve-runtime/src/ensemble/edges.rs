//! Edges of the bins of a histogram, correctly rounded.
//!
//! Input: a range, the number of its equal parts, and the number of an edge. Output: the `f64`
//! nearest to `low + k (high − low)/n`, so that −0.5 is an edge of −3..3 in 12 bins. Invariant: the
//! first edge is `low`, the last one `high`, and edges ascend.
//!
//! The edge is formed as `(low (n − k) + high k)/n` in pairs of numbers, with 106 bits together:
//! each operation has a relative error below 2⁻¹⁰⁰.
//!
//! Source: M. Joldes, J.-M. Muller, V. Popescu, *Tight and rigorous error bounds for basic building
//! blocks of double-word arithmetic*, ACM Trans. Math. Softw. 44 (2017), algorithms 2 (sum), 6
//! (accurate sum of pairs) and 15 (quotient); T. J. Dekker, *A floating-point technique for
//! extending the available precision*, Numer. Math. 18 (1971), for the product without a fused
//! operation.

/// Returns an edge of the equal parts of a range.
pub(super) fn edge([low, high]: [f64; 2], edge: usize, parts: usize) -> f64 {
    if edge == 0 {
        return low;
    }
    if edge >= parts {
        return high;
    }
    let unit = unit(low.abs().max(high.abs()));
    let (low, high) = (low / unit, high / unit);
    let (before, after) = (edge as f64, (parts - edge) as f64);
    let sum = add_pairs(product(low, after), product(high, before));
    quotient(sum, parts as f64) * unit
}

/// Returns a power of two that scales a range to the middle of the exponents, where no operation
/// overflows or underflows.
fn unit(size: f64) -> f64 {
    const LARGE: f64 = f64::from_bits((1023 + 500) << 52);
    const SMALL: f64 = f64::from_bits((1023 - 500) << 52);
    if size > LARGE {
        LARGE
    } else if size < SMALL {
        SMALL
    } else {
        1.0
    }
}

/// A number of twice the precision: a high and a low part.
type Pair = (f64, f64);

/// Returns a + b exactly.
fn sum(a: f64, b: f64) -> Pair {
    let sum = a + b;
    let second = sum - a;
    (sum, (a - (sum - second)) + (b - second))
}

/// Returns a + b exactly, for |a| ≥ |b|.
fn sum_of_ordered(a: f64, b: f64) -> Pair {
    let sum = a + b;
    (sum, b - (sum - a))
}

/// Returns the upper 26 bits of a number, and the lower ones.
fn halves(a: f64) -> Pair {
    const SPLITTER: f64 = ((1_u64 << 27) + 1) as f64;
    let scaled = SPLITTER * a;
    let high = scaled - (scaled - a);
    (high, a - high)
}

/// Returns a b exactly.
fn product(a: f64, b: f64) -> Pair {
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    let rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, rest)
}

fn add_pairs(a: Pair, b: Pair) -> Pair {
    let (high, rest) = sum(a.0, b.0);
    let (low, rest_of_low) = sum(a.1, b.1);
    let (high, rest) = sum_of_ordered(high, rest + low);
    sum_of_ordered(high, rest_of_low + rest)
}

/// Returns the quotient of a pair and a number, rounded.
fn quotient(a: Pair, b: f64) -> f64 {
    let high = a.0 / b;
    let (product, rest) = product(high, b);
    let left = ((a.0 - product) - rest) + a.1;
    high + left / b
}

#[cfg(test)]
mod tests {
    use super::edge;

    fn count(number: impl TryInto<usize>) -> usize {
        number.try_into().ok().expect("a number of parts")
    }

    /// Ranges of whole numbers over powers of two, whose edges can be had from integers:
    /// (low (n − k) + high k)/n, rounded half to even.
    #[test]
    fn edges_are_correctly_rounded() {
        let mut checked = 0;
        for (low, high) in [
            (-3_i64, 3),
            (-7, 100),
            (1, 2),
            (-1001, -1),
            (0, 1),
            (5, 12345),
        ] {
            for shift in [0, 40, -900, 900] {
                let scale = 2.0_f64.powi(shift);
                for parts in 1..60_i64 {
                    for k in 0..=parts {
                        let numerator = low * (parts - k) + high * k;
                        // The numbers are below 2⁵³, so their quotient is rounded once.
                        let expected = numerator as f64 / parts as f64 * scale;
                        let range = [low as f64 * scale, high as f64 * scale];
                        let found = edge(range, count(k), count(parts));
                        assert_eq!(found, expected, "{low}..{high}, {k} of {parts}");
                        checked += 1;
                    }
                }
            }
        }
        assert!(checked > 40_000);
        assert_eq!(edge([-3.0, 3.0], 5, 12), -0.5);
    }

    /// Bounds with up to 53 bits, against integers of 128 bits.
    #[test]
    fn edges_of_any_bounds_are_correctly_rounded() {
        let mut word = 1_u64;
        let mut next = |bits: u32| {
            word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            i128::from(word >> (64 - bits))
        };
        for _ in 0..20_000 {
            let low = next(52) - (1 << 51);
            let high = low + 1 + next(52);
            let parts = 2 + next(12);
            let k = 1 + next(40) % (parts - 1);
            let numerator = low * (parts - k) + high * k;
            // the quotient with 60 binary places, and a last bit that is set if there is a
            // remainder
            let scaled = numerator << 60;
            let exact = scaled.div_euclid(parts) | i128::from(scaled.rem_euclid(parts) != 0);
            let expected = exact as f64 / (1_u64 << 60) as f64;
            let range = [low as f64, high as f64];
            assert_eq!(edge(range, count(k), count(parts)), expected);
        }
    }
}

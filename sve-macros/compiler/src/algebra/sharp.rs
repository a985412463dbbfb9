//! Evaluation in 106 bits, with a bound of the rounding error and a bound of the error that inexact
//! constants cause.
//!
//! A constant such as 0.1 or √2 stands for a number that differs from it by half a unit in the last
//! place, and folding constants rounds again. No precision of the evaluation removes that
//! uncertainty, so it is carried beside the rounding errors: between the two bounds a value can be
//! called neither zero nor different from zero.

use super::Map;
use super::elementary::{ARGUMENT, Double, ROUNDING, of};
use super::expr::{Arena, Binary, Bits, Expr, Function, Node, Symbol};

/// Relative rounding error of an operation in 106 bits.
const OPERATION: f64 = 1.0 / (1u128 << 102) as f64;

/// Relative uncertainty of a constant that may be rounded: its literal, and a few roundings of
/// folded constants.
const CONSTANT: f64 = 2.0 * f64::EPSILON;

/// Last bits of a mantissa that are zero in a constant which is taken as exact, such as 0.5 or 3.
/// One of 2²⁶ rounded constants is taken as exact by chance.
const SPARE_BITS: u64 = (1 << 26) - 1;

/// Relative slope below which a value has lost the information of its argument.
const FLAT: f64 = 1e-20;

/// Magnitudes below which the second part of a number may underflow.
const TINY: f64 = 1e-270;

/// Factor on the bounds of rounding errors, which are of first order; it leaves room for the second
/// order.
const SLACK: f64 = 64.0;

/// The same factor for the uncertainty of constants.
const CONSTANT_SLACK: f64 = 4.0;

/// A number of 106 bits with bounds of its errors.
#[derive(Clone, Copy)]
pub(crate) struct Sharp {
    value: Double,
    /// Bound of the rounding errors; NaN if the value has lost the information of its argument.
    error: f64,
    /// Bound of the error that the uncertainty of constants causes.
    constant_error: f64,
}

/// The result of a test for zero by the bounds of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// Zero within its rounding errors.
    Zero,
    /// Larger than its rounding errors, but not larger than the uncertainty of its constants.
    Undecided,
    NotZero,
    /// No statement: undefined at this point, or without significant digits.
    Nothing,
}

impl Sharp {
    /// Returns a number without uncertainty.
    pub(crate) fn exact(value: f64) -> Self {
        Self {
            value: of(value),
            error: 0.0,
            constant_error: 0.0,
        }
    }

    fn constant(bits: Bits) -> Self {
        Self {
            constant_error: uncertainty(bits) * bits.get().abs(),
            ..Self::exact(bits.get())
        }
    }

    /// Returns the magnitude.
    pub(crate) fn size(self) -> f64 {
        self.value.nearest().abs()
    }

    /// Returns whether the number is zero, as far as its bounds tell.
    pub(crate) fn verdict(self) -> Verdict {
        let (size, error, constant_error) = (self.size(), self.error, self.constant_error);
        if !(size.is_finite() && error.is_finite() && constant_error.is_finite()) {
            Verdict::Nothing
        } else if size <= SLACK * error {
            Verdict::Zero
        } else if size <= SLACK * error + CONSTANT_SLACK * constant_error {
            Verdict::Undecided
        } else {
            Verdict::NotZero
        }
    }

    /// Returns `self · 2ᵏ`.
    pub(crate) fn times_two_to(self, k: i32) -> Self {
        let [first, second] = [k / 2, k - k / 2].map(|k| 2.0f64.powi(k));
        Self {
            value: self.value.times_two_to(k),
            error: self.error * first * second,
            constant_error: self.constant_error * first * second,
        }
    }

    /// Returns the quotient.
    pub(crate) fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        let size = value.nearest().abs();
        let part = |a: f64, b: f64| (a + size * b) / other.size();
        Self {
            value,
            error: part(self.error, other.error) + OPERATION * size,
            constant_error: part(self.constant_error, other.constant_error),
        }
    }

    /// Returns `self − a·b`.
    pub(crate) fn minus_product(self, a: Self, b: Self) -> Self {
        let product = a.value * b.value;
        let part = |of_a: f64, of_b: f64| of_a * b.size() + a.size() * of_b;
        let sizes = self.size() + product.nearest().abs();
        Self {
            value: self.value - product,
            error: self.error + part(a.error, b.error) + OPERATION * sizes,
            constant_error: self.constant_error + part(a.constant_error, b.constant_error),
        }
    }

    /// Returns the value with an unbounded error if it has too few digits.
    fn checked(self) -> Self {
        let size = self.size();
        if size == 0.0 || size >= TINY {
            self
        } else {
            self.without_digits_if(true)
        }
    }

    /// Returns the value with an unbounded error if `condition` holds: then it has lost the
    /// information of its argument.
    fn without_digits_if(self, condition: bool) -> Self {
        Self {
            error: if condition { f64::NAN } else { self.error },
            ..self
        }
    }
}

/// Returns the relative uncertainty of a constant.
fn uncertainty(bits: Bits) -> f64 {
    if bits.get().to_bits() & SPARE_BITS == 0 {
        0.0
    } else {
        CONSTANT
    }
}

impl Arena {
    /// Evaluates nodes at a point. Operands precede their users in `nodes`.
    pub(super) fn evaluate_sharp(
        &self,
        nodes: &[Expr],
        at: impl Fn(Symbol) -> f64,
    ) -> Map<Expr, Sharp> {
        self.spend(32 * nodes.len());
        let mut values: Map<Expr, Sharp> = Map::default();
        values.reserve(nodes.len());
        for &e in nodes {
            let value = match self.node(e) {
                Node::Constant(bits) => Sharp::constant(*bits),
                Node::Symbol(symbol) => Sharp::exact(at(*symbol)),
                Node::Opaque(x, _) => values[x],
                Node::Sum(constant, terms) => sum(*constant, terms, &values),
                Node::Product(factors) => product(factors, &values),
                Node::Call(function, x) => call(*function, values[x]),
                Node::Call2(function, x, y) => call2(*function, values[x], values[y]),
            };
            values.insert(e, value.checked());
        }
        values
    }
}

fn sum(constant: Bits, terms: &[(Expr, Bits)], values: &Map<Expr, Sharp>) -> Sharp {
    let mut sum = Sharp::constant(constant);
    let mut sizes = sum.size();
    for (x, c) in terms {
        let (x, factor) = (values[x], c.get().abs());
        sum.value = sum.value + of(c.get()) * x.value;
        let size = factor * x.size();
        sizes += size;
        sum.error += factor * x.error;
        sum.constant_error += factor * x.constant_error + uncertainty(*c) * size;
    }
    // each partial sum is rounded, and is no larger than the sum of all magnitudes
    sum.error += OPERATION * (1 + terms.len()) as f64 * sizes;
    sum
}

fn product(factors: &[(Expr, i32)], values: &Map<Expr, Sharp>) -> Sharp {
    let mut product = Double::ONE;
    // relative bounds of the factors that are not zero; absolute bounds of the others
    let (mut error, mut constant_error) = (0.0, 0.0);
    let mut vanishing: Option<[f64; 2]> = None;
    let mut others = 1.0;
    for (x, k) in factors {
        let (x, times) = (values[x], f64::from(k.abs()));
        product = product * x.value.power(*k);
        if x.size() == 0.0 {
            let bounds = [x.error, x.constant_error].map(|bound| bound.powi(*k));
            let outer = vanishing.unwrap_or([1.0, 1.0]);
            vanishing = Some([outer[0] * bounds[0], outer[1] * bounds[1]]);
        } else {
            error += times * (2.0 * OPERATION + x.error / x.size());
            constant_error += times * x.constant_error / x.size();
            others *= x.size().powi(*k);
        }
    }
    let size = product.nearest().abs();
    let underflows = size == 0.0 && vanishing.is_none();
    let [error, constant_error] = match vanishing {
        Some([error, constant_error]) => [error * others, constant_error * others],
        None => [error * size, constant_error * size],
    };
    Sharp {
        value: product,
        error,
        constant_error,
    }
    .without_digits_if(underflows)
}

fn call(function: Function, x: Sharp) -> Sharp {
    let value = function.evaluate_double(x.value);
    let (size, at) = (value.nearest().abs(), x.size());
    let slope = function.slope(x.value.nearest(), value.nearest()).abs();
    let reach = slope * at;
    let is_flat = reach <= FLAT * size && at != 0.0;
    let (exponent, constant_uncertainty) = exponent(function, x);
    Sharp {
        value,
        error: slope * x.error + ARGUMENT * (reach + exponent * size) + ROUNDING * size,
        constant_error: slope * x.constant_error + constant_uncertainty * exponent * size,
    }
    .without_digits_if(is_flat)
}

/// Returns, for a power with a constant exponent, the exponent to the base e and the uncertainty of
/// the constant; zeros for other functions.
fn exponent(function: Function, x: Sharp) -> (f64, f64) {
    match function {
        Function::Powf(k) => ((k.get() * x.size().ln()).abs(), uncertainty(k)),
        _ => (0.0, 0.0),
    }
}

fn call2(function: Binary, x: Sharp, y: Sharp) -> Sharp {
    let value = function.evaluate_double(x.value, y.value);
    let near = value.nearest();
    let (dx, dy) = function.slopes(x.value.nearest(), y.value.nearest(), near);
    let through = |of_x: f64, of_y: f64| {
        // an exact argument contributes no error, even if the slope is infinite
        let part = |slope: f64, bound: f64| {
            if bound == 0.0 {
                0.0
            } else {
                slope.abs() * bound
            }
        };
        part(dx, of_x) + part(dy, of_y)
    };
    let underflows = near == 0.0 && x.size() != 0.0 && y.size() != 0.0;
    Sharp {
        value,
        error: through(x.error + ARGUMENT * x.size(), y.error + ARGUMENT * y.size())
            + ROUNDING * near.abs(),
        constant_error: through(x.constant_error, y.constant_error),
    }
    .without_digits_if(underflows)
}

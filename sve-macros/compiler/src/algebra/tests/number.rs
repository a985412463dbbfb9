//! Numbers for oracles: forward-mode derivatives and running error bounds, written without the
//! algebra under test.
//!
//! [`Dual`] is a value with a derivative in one direction; nested, it gives derivatives of any
//! order. [`Bounded`] is a value with a first-order bound of its rounding error, underflow
//! included.

use crate::algebra::elementary::Double;
use crate::algebra::{Binary, Function};

/// The types of numbers in which expressions can be evaluated.
pub(crate) trait Number: Copy {
    fn of(value: f64) -> Self;
    /// Returns the plain value.
    fn value(self) -> f64;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn call(self, function: Function) -> Self;
    fn call2(self, function: Binary, other: Self) -> Self;

    fn scale(self, c: f64) -> Self {
        self.times(Self::of(c))
    }

    fn minus(self, other: Self) -> Self {
        self.plus(other.scale(-1.0))
    }

    fn power(self, k: i32) -> Self {
        if k == 0 {
            return Self::of(1.0);
        }
        let product = (1..k.abs()).fold(self, |product, _| product.times(self));
        if k < 0 {
            Self::of(1.0).over(product)
        } else {
            product
        }
    }
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }
    fn value(self) -> f64 {
        self
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn times(self, other: Self) -> Self {
        self * other
    }
    fn over(self, other: Self) -> Self {
        self / other
    }
    fn call(self, function: Function) -> Self {
        function.evaluate(self)
    }
    fn call2(self, function: Binary, other: Self) -> Self {
        function.evaluate(self, other)
    }
}

impl Number for Double {
    fn of(value: f64) -> Self {
        value.into()
    }
    fn value(self) -> f64 {
        self.nearest()
    }
    fn plus(self, other: Self) -> Self {
        self + other
    }
    fn times(self, other: Self) -> Self {
        self * other
    }
    fn over(self, other: Self) -> Self {
        self / other
    }
    fn call(self, function: Function) -> Self {
        function.evaluate_double(self)
    }
    fn call2(self, function: Binary, other: Self) -> Self {
        function.evaluate_double(self, other)
    }
}

/// Returns the derivative of a function, by the formula of a table of derivatives.
fn slope<T: Number>(function: Function, x: T, value: T) -> T {
    let one = T::of(1.0);
    let root = |y: T| one.over(y.call(Function::Sqrt));
    match function {
        Function::Sqrt => T::of(0.5).over(value),
        Function::Cbrt => value.over(x.scale(3.0)),
        Function::Exp => value,
        Function::Exp2 => value.scale(std::f64::consts::LN_2),
        Function::ExpM1 => x.call(Function::Exp),
        Function::Ln => one.over(x),
        Function::Ln1p => one.over(one.plus(x)),
        Function::Log2 => one.over(x.scale(std::f64::consts::LN_2)),
        Function::Log10 => one.over(x.scale(std::f64::consts::LN_10)),
        Function::Sin => x.call(Function::Cos),
        Function::Cos => x.call(Function::Sin).scale(-1.0),
        Function::Tan => x.call(Function::Cos).power(-2),
        Function::Asin => root(one.minus(x.power(2))),
        Function::Acos => root(one.minus(x.power(2))).scale(-1.0),
        Function::Atan => one.over(one.plus(x.power(2))),
        Function::Sinh => x.call(Function::Cosh),
        Function::Cosh => x.call(Function::Sinh),
        Function::Tanh => x.call(Function::Cosh).power(-2),
        Function::Asinh => root(one.plus(x.power(2))),
        Function::Acosh => root(x.power(2).minus(one)),
        Function::Atanh => one.over(one.minus(x.power(2))),
        Function::Powf(k) => value.scale(k.get()).over(x),
        Function::Abs => x.over(value),
    }
}

/// Returns the derivatives of a function of two arguments.
fn slopes<T: Number>(function: Binary, x: T, y: T, value: T) -> (T, T) {
    match function {
        Binary::Atan2 => {
            let norm = x.power(2).plus(y.power(2));
            (y.over(norm), x.scale(-1.0).over(norm))
        }
        Binary::Hypot => (x.over(value), y.over(value)),
        Binary::Pow => (y.times(value).over(x), x.call(Function::Ln).times(value)),
        Binary::PowLog(n) => {
            let ln = x.call(Function::Ln);
            let lower = x.call2(Binary::Pow, y).times(ln.power(n - 1)).over(x);
            let dx = y.times(ln).plus(T::of(f64::from(n))).times(lower);
            (dx, value.times(ln))
        }
    }
}

/// A value and its derivative.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Dual<T> {
    pub(crate) value: T,
    pub(crate) slope: T,
}

impl<T: Number> Dual<T> {
    /// Returns a variable. `slope` is its component in the direction of differentiation.
    pub(crate) fn new(value: T, slope: f64) -> Self {
        let slope = T::of(slope);
        Self { value, slope }
    }
}

impl<T: Number> Number for Dual<T> {
    fn of(value: f64) -> Self {
        Self::new(T::of(value), 0.0)
    }
    fn value(self) -> f64 {
        self.value.value()
    }
    fn plus(self, other: Self) -> Self {
        Self {
            value: self.value.plus(other.value),
            slope: self.slope.plus(other.slope),
        }
    }
    fn times(self, other: Self) -> Self {
        Self {
            value: self.value.times(other.value),
            slope: (self.slope.times(other.value)).plus(self.value.times(other.slope)),
        }
    }
    fn over(self, other: Self) -> Self {
        let value = self.value.over(other.value);
        let slope = self.slope.minus(value.times(other.slope)).over(other.value);
        Self { value, slope }
    }
    fn call(self, function: Function) -> Self {
        let value = self.value.call(function);
        let outer = slope(function, self.value, value);
        Self {
            value,
            slope: outer.times(self.slope),
        }
    }
    fn call2(self, function: Binary, other: Self) -> Self {
        let value = self.value.call2(function, other.value);
        let (dx, dy) = slopes(function, self.value, other.value, value);
        Self {
            value,
            slope: dx.times(self.slope).plus(dy.times(other.slope)),
        }
    }
}

/// A value and a bound of its error.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounded {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

impl Bounded {
    /// Returns a rounded value with the error that follows from the errors of the operands.
    /// Functions of the standard library have an error of one unit in the last place.
    fn rounded(value: f64, inherited: f64) -> Self {
        // an exact zero of exact operands stays exact; otherwise underflow may lose the smallest
        // number
        let exact = inherited == 0.0 && value == 0.0;
        let least = if exact { 0.0 } else { f64::from_bits(1) };
        Self {
            value,
            error: inherited + f64::EPSILON * value.abs() + least,
        }
    }

    /// Returns whether two values of one quantity differ by no more than their errors. `SLACK`
    /// leaves room for the second order.
    pub(crate) fn agrees(self, other: Self) -> bool {
        (self.value - other.value).abs() <= SLACK * (self.error + other.error)
    }

    /// Returns whether agreement of the value is significant, that is, whether at least half of its
    /// digits are certain.
    pub(crate) fn is_sharp(self) -> bool {
        self.value.is_finite() && self.error <= 1e-8 * (1e-3 + self.value.abs())
    }
}

/// Factor on the bounds, which are of first order and count the rounding of a sum once.
const SLACK: f64 = 4.0;

impl Number for Bounded {
    fn of(value: f64) -> Self {
        Self { value, error: 0.0 }
    }
    fn value(self) -> f64 {
        self.value
    }
    fn plus(self, other: Self) -> Self {
        Self::rounded(self.value + other.value, self.error + other.error)
    }
    fn times(self, other: Self) -> Self {
        let (a, b) = (self, other);
        if a.error + b.error == 0.0 && (a.value == 0.0 || b.value == 0.0) {
            return Self::of(a.value * b.value);
        }
        let inherited = a.value.abs() * b.error + b.value.abs() * a.error + a.error * b.error;
        let underflow = f64::from_bits(1);
        Self::rounded(a.value * b.value, inherited + underflow)
    }
    fn over(self, other: Self) -> Self {
        let value = self.value / other.value;
        let inherited = (self.error + value.abs() * other.error) / other.value.abs();
        let underflow = if self.value == 0.0 {
            0.0
        } else {
            f64::from_bits(1)
        };
        Self::rounded(value, inherited + underflow)
    }
    fn call(self, function: Function) -> Self {
        let value = function.evaluate(self.value);
        let steep = slope(function, self.value, value).abs();
        let inherited = if self.error == 0.0 {
            0.0
        } else {
            steep * self.error
        };
        Self::rounded(value, inherited)
    }
    fn call2(self, function: Binary, other: Self) -> Self {
        let value = function.evaluate(self.value, other.value);
        let (dx, dy) = slopes(function, self.value, other.value, value);
        let part = |slope: f64, error: f64| {
            if error == 0.0 {
                0.0
            } else {
                slope.abs() * error
            }
        };
        Self::rounded(value, part(dx, self.error) + part(dy, other.error))
    }
}

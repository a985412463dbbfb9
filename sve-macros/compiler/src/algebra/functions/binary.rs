//! The functions of two arguments, one entry each.

use super::super::elementary;
use super::{Arena, Double, Expr};

/// Functions of two arguments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Atan2,
    Hypot,
    Pow,
    /// `x^y lnⁿ x` with n > 0, the derivatives of `x^y` in y: zero at x = 0 where y > 0.
    PowLog(i32),
}

impl Binary {
    /// The functions that a body may call as methods of `f64` with an argument.
    pub(crate) const METHODS: &[Self] = &[Self::Atan2, Self::Hypot, Self::Pow];

    /// Returns the entry of the function.
    pub(crate) fn entry(self) -> &'static BinaryEntry {
        match self {
            Self::Atan2 => &ATAN2,
            Self::Hypot => &HYPOT,
            Self::Pow => &POW,
            Self::PowLog(_) => &POW_LOG,
        }
    }

    /// Returns the number n of logarithms in a derivative of a power.
    pub(crate) fn logarithms(self) -> Option<i32> {
        match self {
            Self::PowLog(n) => Some(n),
            _ => None,
        }
    }

    fn n(self) -> i32 {
        self.logarithms().unwrap_or(0)
    }

    /// Returns the name of the method of `f64` or of the function of the runtime.
    pub(crate) fn name(self) -> &'static str {
        self.entry().name
    }

    /// f(x, y).
    pub(crate) fn evaluate(self, x: f64, y: f64) -> f64 {
        (self.entry().value)(x, y, self.n())
    }

    /// f(x, y) in 106 bits.
    pub(in crate::algebra) fn evaluate_double(self, x: Double, y: Double) -> Double {
        (self.entry().double)(x, y, self.n())
    }

    /// Returns the derivatives in x and y up to their signs. The caller passes `value = f(x, y)`.
    pub(in crate::algebra) fn slopes(self, x: f64, y: f64, value: f64) -> (f64, f64) {
        (self.entry().slopes)(x, y, value, self.n())
    }

    /// Returns the derivatives in x and y. The caller passes `value = f(x, y)`.
    pub(in crate::algebra) fn derivatives(
        self,
        arena: &mut Arena,
        x: Expr,
        y: Expr,
        value: Expr,
    ) -> (Expr, Expr) {
        (self.entry().derivatives)(arena, [x, y], value, self.n())
    }
}

/// The properties of a function of two arguments. The last argument of each function pointer is the
/// number of logarithms.
pub(crate) struct BinaryEntry {
    pub(crate) name: &'static str,
    /// True if the function is a method of `f64`. Otherwise generated code calls the function of
    /// the runtime.
    pub(crate) is_method: bool,
    value: fn(f64, f64, i32) -> f64,
    /// The value in 106 bits.
    double: fn(Double, Double, i32) -> Double,
    /// The derivatives up to their signs, from arguments and value.
    slopes: fn(f64, f64, f64, i32) -> (f64, f64),
    /// The derivatives, from arguments and value.
    derivatives: fn(&mut Arena, [Expr; 2], Expr, i32) -> (Expr, Expr),
    /// The expression that replaces the function if its second argument is a constant.
    pub(in crate::algebra) with_constant: Option<fn(&mut Arena, Expr, f64) -> Expr>,
    /// True if the function is defined only for a nonnegative first argument.
    pub(crate) needs_nonnegative: bool,
    /// The bound of the change of the value by the changes of the arguments.
    pub(crate) bound: BinaryBound,
    /// True if the square of the value is the sum of the squares of the arguments.
    pub(in crate::algebra) is_norm: bool,
    pub(in crate::algebra) notation: BinaryNotation,
}

/// Bound of the change of a function of two arguments if these change by at most r and s.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum BinaryBound {
    /// At most `r + s`.
    Sum,
    /// At most `(r + s)/(hypot(x, y) − r − s)`.
    Angle,
    /// No bound.
    None,
}

/// The notation of a call of two arguments in formulas.
#[derive(Clone, Copy)]
pub(in crate::algebra) enum BinaryNotation {
    /// `name(x, y)`
    Name,
    /// `x^y`
    Power,
}

static ATAN2: BinaryEntry = BinaryEntry {
    name: "atan2",
    is_method: true,
    value: |x, y, _| x.atan2(y),
    double: |x, y, _| elementary::atan2(x, y),
    slopes: |x, y, _, _| {
        let norm = x * x + y * y;
        (y / norm, x / norm)
    },
    derivatives: |arena, [x, y], _, _| {
        // the squares of x and y may overflow even if hypot(x, y) does not
        let norm = arena.call2(Binary::Hypot, x, y);
        let (dx, dy) = (
            arena.product(&[(y, 1), (norm, -2)]),
            arena.product(&[(x, 1), (norm, -2)]),
        );
        (dx, arena.neg(dy))
    },
    with_constant: None,
    needs_nonnegative: false,
    bound: BinaryBound::Angle,
    is_norm: false,
    notation: BinaryNotation::Name,
};

static HYPOT: BinaryEntry = BinaryEntry {
    name: "hypot",
    is_method: true,
    value: |x, y, _| x.hypot(y),
    double: |x, y, _| elementary::hypot(x, y),
    slopes: |x, y, value, _| (x / value, y / value),
    derivatives: |arena, [x, y], value, _| (arena.div(x, value), arena.div(y, value)),
    with_constant: None,
    needs_nonnegative: false,
    bound: BinaryBound::Sum,
    is_norm: true,
    notation: BinaryNotation::Name,
};

static POW: BinaryEntry = BinaryEntry {
    name: "powf",
    is_method: true,
    value: |x, y, _| x.powf(y),
    double: |x, y, _| elementary::pow(x, y),
    slopes: |x, y, value, _| (y * value / x, x.ln() * value),
    derivatives: |arena, [x, y], _, n| arena.power_derivatives(x, y, n),
    with_constant: Some(Arena::constant_power),
    needs_nonnegative: true,
    bound: BinaryBound::None,
    is_norm: false,
    notation: BinaryNotation::Power,
};

static POW_LOG: BinaryEntry = BinaryEntry {
    name: "power_log",
    is_method: false,
    value: |x, y, n| {
        if x == 0.0 && y > 0.0 {
            0.0
        } else {
            x.powf(y) * x.ln().powi(n)
        }
    },
    double: |x, y, n| {
        if x.nearest() == 0.0 && y.nearest() > 0.0 {
            elementary::of(0.0)
        } else {
            elementary::pow(x, y) * elementary::ln(x).power(n)
        }
    },
    slopes: |x, y, value, n| {
        let ln = x.ln();
        ((y + f64::from(n) / ln) * value / x, ln * value)
    },
    derivatives: |arena, [x, y], _, n| arena.power_derivatives(x, y, n),
    with_constant: None,
    // the power itself, from which this derivative comes, has the condition
    needs_nonnegative: false,
    bound: BinaryBound::None,
    is_norm: false,
    notation: BinaryNotation::Name,
};

impl Arena {
    /// Returns the derivatives of `x^y lnⁿ x`: `y x^(y−1) lnⁿ x + n x^(y−1) lnⁿ⁻¹ x` and
    /// `x^y lnⁿ⁺¹ x`.
    fn power_derivatives(&mut self, x: Expr, y: Expr, n: i32) -> (Expr, Expr) {
        if self.constant_value(x) == Some(0.0) {
            // the derivative of 0^y exists for y > 0, where 0^y is 0
            let zero = self.constant(0.0);
            return (zero, zero);
        }
        let lower = self.sum(-1.0, &[(1.0, y)]);
        let power = self.power_log(x, lower, n);
        let mut terms = vec![(1.0, self.mul(y, power))];
        if n > 0 {
            terms.push((f64::from(n), self.power_log(x, lower, n - 1)));
        }
        (self.sum(0.0, &terms), self.power_log(x, y, n + 1))
    }

    /// Returns `x^y lnⁿ x`.
    fn power_log(&mut self, x: Expr, y: Expr, n: i32) -> Expr {
        match self.constant_value(x) {
            _ if n == 0 => self.call2(Binary::Pow, x, y),
            Some(base) if base > 0.0 => {
                let power = self.call2(Binary::Pow, x, y);
                self.scale(base.ln().powi(n), power)
            }
            _ => self.call2(Binary::PowLog(n), x, y),
        }
    }
}

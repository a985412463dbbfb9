//! The functions of one argument, an entry each: name, values, derivative, parity, sign, domain, bounds, notation.
//!
//! A new function is an entry in a file here, a variant of [`Function`] with a line in [`Function::entry`], and its name in the language
//! (`interpret/floats.rs`). Relations between functions, such as `cos²x + sin²x = 1`, are in `stable`.

mod circular;
mod exponentials;
mod hyperbolic;
mod powers;

use super::double_double::Double;
use super::expr::{Arena, Bits, Expr};

/// Functions of one argument.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Function {
    Sqrt,
    Cbrt,
    Exp,
    Exp2,
    ExpM1,
    Ln,
    Ln1p,
    Log2,
    Log10,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    /// A power with a constant exponent that is neither integer nor half-integer.
    Powf(Bits),
    /// The magnitude: not in the language, since it is not smooth; bounds are made of it.
    Abs,
}

impl Function {
    /// What is known of the function.
    pub(crate) fn entry(self) -> &'static Entry {
        match self {
            Self::Sqrt => &powers::SQRT,
            Self::Cbrt => &powers::CBRT,
            Self::Powf(_) => &powers::POWF,
            Self::Abs => &powers::ABS,
            Self::Exp => &exponentials::EXP,
            Self::Exp2 => &exponentials::EXP2,
            Self::ExpM1 => &exponentials::EXP_M1,
            Self::Ln => &exponentials::LN,
            Self::Ln1p => &exponentials::LN_1P,
            Self::Log2 => &exponentials::LOG2,
            Self::Log10 => &exponentials::LOG10,
            Self::Sin => &circular::SIN,
            Self::Cos => &circular::COS,
            Self::Tan => &circular::TAN,
            Self::Asin => &circular::ASIN,
            Self::Acos => &circular::ACOS,
            Self::Atan => &circular::ATAN,
            Self::Sinh => &hyperbolic::SINH,
            Self::Cosh => &hyperbolic::COSH,
            Self::Tanh => &hyperbolic::TANH,
            Self::Asinh => &hyperbolic::ASINH,
            Self::Acosh => &hyperbolic::ACOSH,
            Self::Atanh => &hyperbolic::ATANH,
        }
    }

    /// The exponent of a power; NaN for other functions, which do not ask.
    pub(crate) fn exponent(self) -> f64 {
        match self {
            Self::Powf(k) => k.get(),
            _ => f64::NAN,
        }
    }

    /// The name of the method of `f64`, and of the function of the runtime in lanes.
    pub(crate) fn name(self) -> &'static str {
        self.entry().name
    }

    /// f(x).
    pub(crate) fn evaluate(self, x: f64) -> f64 {
        (self.entry().value)(x, self.exponent())
    }

    /// f(x) in 106 bits.
    pub(super) fn evaluate_double(self, x: Double) -> Double {
        (self.entry().double)(x, self.exponent())
    }

    /// f′(x) up to its sign, with `value = f(x)` at hand.
    pub(super) fn slope(self, x: f64, value: f64) -> f64 {
        (self.entry().slope)(x, value, self.exponent())
    }

    /// `f′(x)`, with `value = f(x)` at hand.
    pub(super) fn derivative(self, arena: &mut Arena, x: Expr, value: Expr) -> Expr {
        (self.entry().derivative)(arena, x, value, self.exponent())
    }

    /// Where the function is defined.
    pub(crate) fn domain(self) -> Domain {
        (self.entry().domain)(self.exponent())
    }
}

/// What is known of a function. The last argument of each function in it is the exponent of a power.
pub(crate) struct Entry {
    /// The method of `f64`, and the function of the runtime in lanes.
    pub(crate) name: &'static str,
    value: fn(f64, f64) -> f64,
    /// The value in 106 bits.
    double: fn(Double, f64) -> Double,
    /// The derivative up to its sign, from argument and value.
    slope: fn(f64, f64, f64) -> f64,
    /// The derivative, from argument and value.
    derivative: fn(&mut Arena, Expr, Expr, f64) -> Expr,
    pub(super) parity: Parity,
    /// What is known of the sign of the values.
    pub(crate) sign: Sign,
    domain: fn(f64) -> Domain,
    /// What bounds the change of the value by that of the argument.
    pub(crate) bound: Bound,
    pub(super) notation: Notation,
    /// The letter of numbered names in formulas, `s1`.
    pub(crate) letter: char,
    /// Whether the method of `f64` is an instruction of the processor, which loops over lanes may call.
    pub(crate) is_instruction: bool,
}

/// `f(−x)` beside `f(x)`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Parity {
    Even,
    Odd,
    None,
}

/// What is known of the sign of a number.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Positive,
    NonNegative,
    Unknown,
}

/// Where a function is defined.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Domain {
    Everywhere,
    /// From a number on, which itself belongs to it or does not.
    From {
        least: f64,
        is_closed: bool,
    },
    /// From −1 to 1, which themselves belong to it or do not.
    WithinOne {
        is_closed: bool,
    },
}

/// How much a function changes when its argument x changes by at most r.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    /// By r, and its values are within ±1.
    Wave,
    /// By r.
    Slope,
    /// By `(constant + |value|)(e^(rate r) − 1)`.
    Growth { constant: f64, rate: f64 },
    /// By `r/√x`.
    Root,
    /// By `r/|x|^(2/3)`.
    CubeRoot,
    /// By `scale r / (shift + x − r)`.
    Logarithm { shift: f64, scale: f64 },
    /// By `r/√(1 − (|x| + r)²)`, or its square.
    Arc { is_root: bool },
    /// As `x^k`.
    Power,
    /// Without a bound.
    None,
}

/// How a call is written in formulas.
#[derive(Clone, Copy)]
pub(super) enum Notation {
    /// `name(x)`
    Name(&'static str),
    /// `√x`
    Radical(&'static str),
    /// `2^x`
    PowerOf(&'static str),
    /// `x^k`
    Power,
    /// `exp(x) − 1`
    ExpMinusOne,
    /// `ln(1 + x)`
    LogOfOnePlus,
}

fn everywhere(_: f64) -> Domain {
    Domain::Everywhere
}

fn within_one(_: f64) -> Domain {
    Domain::WithinOne { is_closed: true }
}

fn positive(_: f64) -> Domain {
    Domain::From {
        least: 0.0,
        is_closed: false,
    }
}

impl Arena {
    /// `1 + x²`.
    fn one_and_square(&mut self, x: Expr) -> Expr {
        let squared = self.pow(x, 2);
        self.sum(1.0, &[(1.0, squared)])
    }

    /// `(a + b x)(1 + x)`, which is ±(1 − x²) and does not cancel next to x = ±1.
    fn factored(&mut self, a: f64, b: f64, x: Expr) -> Expr {
        let (minus, plus) = (self.sum(a, &[(b, x)]), self.sum(1.0, &[(1.0, x)]));
        self.mul(minus, plus)
    }

    /// `1/√x`.
    fn inverse_root(&mut self, x: Expr) -> Expr {
        let root = self.call(Function::Sqrt, x);
        self.pow(root, -1)
    }
}

//! The functions, an entry each: name, values, derivative, parity, sign, domain, bounds, forms that
//! do not cancel, notation.
//!
//! A new function of one argument is an entry in a file here and a line in the table of
//! [`Function`]; one of two arguments is both in `binary.rs`. The language, the back end and the
//! lanes take its name from the entry.

mod binary;
mod circular;
mod exponentials;
mod hyperbolic;
mod powers;

use super::double_double::Double;
use super::expr::{Arena, Bits, Expr};
pub(super) use binary::BinaryNotation;
pub(crate) use binary::{Binary, BinaryBound};

/// Defines [`Function`] from its methods of `f64`, each with its entry.
macro_rules! functions {
    ($($function:ident => $file:ident::$entry:ident,)*) => {
        /// Functions of one argument.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub(crate) enum Function {
            $($function,)*
            /// A power with a constant exponent that is neither integer nor half-integer.
            Powf(Bits),
            /// The magnitude: not in the language, since it is not smooth; bounds are made of it.
            Abs,
        }

        impl Function {
            /// The functions that a body may call as methods of `f64` without an argument.
            pub(crate) const METHODS: &[Self] = &[$(Self::$function,)*];

            /// What is known of the function.
            pub(crate) fn entry(self) -> &'static Entry {
                match self {
                    $(Self::$function => &$file::$entry,)*
                    Self::Powf(_) => &powers::POWF,
                    Self::Abs => &powers::ABS,
                }
            }
        }
    };
}

functions! {
    Sqrt => powers::SQRT,
    Cbrt => powers::CBRT,
    Exp => exponentials::EXP,
    Exp2 => exponentials::EXP2,
    ExpM1 => exponentials::EXP_M1,
    Ln => exponentials::LN,
    Ln1p => exponentials::LN_1P,
    Log2 => exponentials::LOG2,
    Log10 => exponentials::LOG10,
    Sin => circular::SIN,
    Cos => circular::COS,
    Tan => circular::TAN,
    Asin => circular::ASIN,
    Acos => circular::ACOS,
    Atan => circular::ATAN,
    Sinh => hyperbolic::SINH,
    Cosh => hyperbolic::COSH,
    Tanh => hyperbolic::TANH,
    Asinh => hyperbolic::ASINH,
    Acosh => hyperbolic::ACOSH,
    Atanh => hyperbolic::ATANH,
}

impl Function {
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

    /// The functions whose quotient by this one is a function, with that function.
    pub(super) fn quotients(self) -> impl Iterator<Item = (Self, Self)> {
        Self::METHODS
            .iter()
            .filter_map(move |&dividend| match dividend.entry().stable.quotient {
                Some((divisor, quotient)) if divisor == self => Some((dividend, quotient)),
                _ => None,
            })
    }

    /// Where the function is defined.
    pub(crate) fn domain(self) -> Domain {
        (self.entry().domain)(self.exponent())
    }
}

/// What is known of a function. The last argument of each function in it is the exponent of a
/// power.
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
    pub(super) stable: Stable,
    pub(super) notation: Notation,
    /// The letter of numbered names in formulas, `s1`.
    pub(crate) letter: char,
    /// Whether the method of `f64` is an instruction of the processor, which loops over lanes may
    /// call.
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

/// The identities of a function f from which its forms that do not cancel follow.
pub(super) struct Stable {
    /// `f(x) − 1`.
    pub(crate) less_one: Option<Form>,
    /// `f(x)² − 1`.
    pub(crate) square_less_one: Option<Form>,
    /// The function g with `f(1 + y) = g(y)`.
    pub(crate) of_one_plus: Option<Function>,
    /// Functions g and q with `f(x) / g(x) = q(x)`, where q does not overflow.
    pub(crate) quotient: Option<(Function, Function)>,
    /// Whether no value is below 1, so that the sum of 1 and `f(x) − 1` does not cancel.
    pub(crate) is_at_least_one: bool,
    /// Whether `f(x)^k = f(k x)`.
    pub(crate) power_scales_argument: bool,
}

impl Stable {
    const NONE: Self = Self {
        less_one: None,
        square_less_one: None,
        of_one_plus: None,
        quotient: None,
        is_at_least_one: false,
        power_scales_argument: false,
    };
}

/// `scale · function(factor · x)^power`.
#[derive(Clone, Copy)]
pub(super) struct Form {
    pub(crate) scale: f64,
    pub(crate) function: Function,
    pub(crate) factor: f64,
    pub(crate) power: i32,
    /// Whether the function costs a call more. Sine and cosine of an angle are one call.
    pub(crate) is_further_call: bool,
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

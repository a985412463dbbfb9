//! The functions of one argument, one entry each: name, values, derivative, parity, sign, domain,
//! bounds, forms that do not cancel, notation.
//!
//! To add a function of one argument, add an entry in a file of this folder and a line to the table
//! of [`Function`]; a function of two arguments needs both in `binary.rs`. The language, the back
//! end and the lanes take its name from the entry.

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
            /// The absolute value. It is not in the language, since it is not smooth; bounds
            /// contain it.
            Abs,
        }

        impl Function {
            /// The functions that a body may call as methods of `f64` without an argument.
            pub(crate) const METHODS: &[Self] = &[$(Self::$function,)*];

            /// Returns the entry of the function.
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
    /// Returns the exponent of a power; NaN for other functions, which do not use it.
    pub(crate) fn exponent(self) -> f64 {
        match self {
            Self::Powf(k) => k.get(),
            _ => f64::NAN,
        }
    }

    /// Returns the name of the method of `f64`, which is also the name of the function of the
    /// runtime for lanes.
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

    /// Returns f′(x) up to its sign. The caller passes `value = f(x)`.
    pub(super) fn slope(self, x: f64, value: f64) -> f64 {
        (self.entry().slope)(x, value, self.exponent())
    }

    /// Returns `f′(x)`. The caller passes `value = f(x)`.
    pub(super) fn derivative(self, arena: &mut Arena, x: Expr, value: Expr) -> Expr {
        (self.entry().derivative)(arena, x, value, self.exponent())
    }

    /// Returns the functions whose quotient by this one is a function, each with this quotient.
    pub(super) fn quotients(self) -> impl Iterator<Item = (Self, Self)> {
        Self::METHODS
            .iter()
            .filter_map(move |&dividend| match dividend.entry().stable.quotient {
                Some((divisor, quotient)) if divisor == self => Some((dividend, quotient)),
                _ => None,
            })
    }

    /// Returns the domain of the function.
    pub(crate) fn domain(self) -> Domain {
        (self.entry().domain)(self.exponent())
    }
}

/// The properties of a function. The last argument of each function pointer is the exponent of a
/// power.
pub(crate) struct Entry {
    /// The name of the method of `f64` and of the function of the runtime for lanes.
    pub(crate) name: &'static str,
    value: fn(f64, f64) -> f64,
    /// The value in 106 bits.
    double: fn(Double, f64) -> Double,
    /// The derivative up to its sign, from argument and value.
    slope: fn(f64, f64, f64) -> f64,
    /// The derivative, from argument and value.
    derivative: fn(&mut Arena, Expr, Expr, f64) -> Expr,
    pub(super) parity: Parity,
    /// The sign of the values.
    pub(crate) sign: Sign,
    domain: fn(f64) -> Domain,
    /// The bound of the change of the value by the change of the argument.
    pub(crate) bound: Bound,
    pub(super) stable: Stable,
    pub(super) notation: Notation,
    /// The first letter of numbered names in formulas, as in `s1`.
    pub(crate) letter: char,
    /// True if the method of `f64` is a processor instruction. Loops over lanes may call such a
    /// method.
    pub(crate) is_instruction: bool,
}

/// The relation of `f(−x)` to `f(x)`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Parity {
    Even,
    Odd,
    None,
}

/// The sign of a number, as far as it is known.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sign {
    Positive,
    NonNegative,
    Unknown,
}

/// The domain of a function.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Domain {
    Everywhere,
    /// The numbers from `from` on, with or without `from` itself.
    From {
        least: f64,
        is_closed: bool,
    },
    /// The interval from −1 to 1, with or without its ends.
    WithinOne {
        is_closed: bool,
    },
}

/// Bound of the change of a function if its argument x changes by at most r.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    /// At most r, with values within ±1.
    Wave,
    /// At most r.
    Slope,
    /// At most `(constant + |value|)(e^(rate r) − 1)`.
    Growth { constant: f64, rate: f64 },
    /// At most `r/√x`.
    Root,
    /// At most `r/|x|^(2/3)`.
    CubeRoot,
    /// At most `scale r / (shift + x − r)`.
    Logarithm { shift: f64, scale: f64 },
    /// At most `r/√(1 − (|x| + r)²)`, or its square.
    Arc { is_root: bool },
    /// The bound of `x^k`.
    Power,
    /// No bound.
    None,
}

/// The identities of a function f from which its stable forms follow.
pub(super) struct Stable {
    /// `f(x) − 1`.
    pub(crate) less_one: Option<Form>,
    /// `f(x)² − 1`.
    pub(crate) square_less_one: Option<Form>,
    /// The function g with `g(y) = f(1 + y)`.
    pub(crate) of_one_plus: Option<Function>,
    /// Functions g and q with `f(x) / g(x) = q(x)`, where q does not overflow.
    pub(crate) quotient: Option<(Function, Function)>,
    /// True if no value is below 1, so that the sum of 1 and `f(x) − 1` does not cancel.
    pub(crate) is_at_least_one: bool,
    /// True if `f(x)^k = f(k x)`.
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
    /// True if the function costs an additional call. The sine and cosine of one angle are one
    /// call.
    pub(crate) is_further_call: bool,
}

/// The notation of a call in formulas.
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
    /// Returns `1 + x²`.
    fn one_and_square(&mut self, x: Expr) -> Expr {
        let squared = self.pow(x, 2);
        self.sum(1.0, &[(1.0, squared)])
    }

    /// Returns `(a + b x)(1 + x)`, which is ±(1 − x²) and does not cancel next to x = ±1.
    fn factored(&mut self, a: f64, b: f64, x: Expr) -> Expr {
        let (minus, plus) = (self.sum(a, &[(b, x)]), self.sum(1.0, &[(1.0, x)]));
        self.mul(minus, plus)
    }

    /// Returns `1/√x`.
    fn inverse_root(&mut self, x: Expr) -> Expr {
        let root = self.call(Function::Sqrt, x);
        self.pow(root, -1)
    }
}

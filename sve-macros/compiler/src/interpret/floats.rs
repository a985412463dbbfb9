//! Methods of `f64`: those that are smooth, and what to write instead of the others.

use std::f64::consts;

use proc_macro2::Span;

use super::Lowering;
use super::calls::Argument;
use super::integers::Integer;
use super::value::Value;
use crate::algebra::{Binary, Expr, Function};
use crate::errors::nearest;

/// The largest power that `powi` takes.
const POWER: u64 = 1024;

/// The methods of `f64` that are made of functions of the algebra, with the number of their arguments beside the receiver.
const COMPOSED: &[(&str, usize)] = &[
    ("powi", 1),
    ("recip", 0),
    ("mul_add", 2),
    ("sin_cos", 0),
    ("to_radians", 0),
    ("to_degrees", 0),
    ("log", 1),
];

/// What to write for a function of whole numbers.
macro_rules! staircase {
    () => {
        ": `x - (TAU * x).sin() / TAU` is a smooth staircase through the integers; a value that is held for several steps is a parameter, changed between steps through `system_mut`"
    };
}

/// What to write for a remainder.
macro_rules! periodic {
    () => {
        ": an angle needs no reduction in `sin` and `cos`; a function of the period P is made of `(TAU * x / P).sin()` and `.cos()`, and one that switches twice in a period is `((TAU * x / P).sin() / width).tanh()`"
    };
}
pub(super) use periodic;

/// Methods of `f64` that are not smooth, and what to write instead.
const ROUGH: &[(&str, &str)] = &[
    (
        "abs",
        "`abs` has no derivative at 0: write `x * x` for a square, or `(x * x + eps * eps).sqrt()` for a smooth modulus",
    ),
    (
        "signum",
        "`signum` is not continuous: use `(x / width).tanh()`",
    ),
    (
        "min",
        "`min` is not smooth: use a smooth penalty, such as `(-x / width).exp()`",
    ),
    (
        "max",
        "`max` is not smooth: use a smooth penalty, such as `(x / width).exp()`",
    ),
    (
        "clamp",
        "`clamp` is not smooth: use `width * (x / width).tanh()`",
    ),
    (
        "floor",
        concat!(
            "`floor` is not continuous, and its slope is 0",
            staircase!()
        ),
    ),
    (
        "ceil",
        concat!("`ceil` is not continuous, and its slope is 0", staircase!()),
    ),
    (
        "round",
        concat!(
            "`round` is not continuous, and its slope is 0",
            staircase!()
        ),
    ),
    (
        "trunc",
        concat!(
            "`trunc` is not continuous, and its slope is 0",
            staircase!()
        ),
    ),
    ("fract", concat!("`fract` is not continuous", periodic!())),
    (
        "rem_euclid",
        concat!("`rem_euclid` is not continuous", periodic!()),
    ),
    (
        "div_euclid",
        "`div_euclid` is not continuous: divide with `/`",
    ),
    (
        "copysign",
        "`copysign` is not continuous: use `(x / width).tanh()`",
    ),
];

impl Lowering<'_> {
    /// A method of `f64`; the receiver is the first of the arguments.
    pub(super) fn float_method(&mut self, name: &str, at: Span, arguments: &[Argument]) -> Value {
        if let Some((_, message)) = ROUGH.iter().find(|r| r.0 == name) {
            return self.refuse(&at, message);
        }
        let unary = unary(name);
        let Some(expected) = operands(name) else {
            return self.refuse(&at, no_method(name));
        };
        let [receiver, rest @ ..] = arguments else {
            return Value::Poison;
        };
        if rest.len() != expected {
            let message = format!(
                "`{name}` takes {}, here {}",
                plural(expected, "argument"),
                are(rest.len())
            );
            return self.refuse(&at, message);
        }
        let x = self.scalar(&receiver.value, &receiver.at);
        if let ("powi", [exponent]) = (name, rest) {
            return self.powi(x, exponent);
        }
        let rest: Vec<Option<Expr>> = rest
            .iter()
            .map(|argument| self.scalar(&argument.value, &argument.at))
            .collect();
        let Some(rest) = rest.into_iter().collect::<Option<Vec<Expr>>>() else {
            return Value::Poison;
        };
        let Some(x) = x else { return Value::Poison };
        let value = self.smooth(name, x, &rest);
        let outside = |x: f64| unary.is_some_and(|f| !f.evaluate(x).is_finite());
        let undefined = match value {
            Value::Scalar(e) => !self.arena.is_finite(e),
            _ => false,
        };
        if undefined || self.arena.constant_value(x).is_some_and(outside) {
            let message = format!(
                "`{name}` is not defined at this constant: its value is not a finite number"
            );
            return self.refuse(&at, message);
        }
        value
    }

    fn smooth(&mut self, name: &str, x: Expr, rest: &[Expr]) -> Value {
        let arena = &mut *self.arena;
        if let Some(function) = unary(name) {
            return Value::Scalar(arena.call(function, x));
        }
        if let (Some(function), [y]) = (binary(name), rest) {
            return Value::Scalar(arena.call2(function, x, *y));
        }
        Value::Scalar(match (name, rest) {
            ("recip", _) => arena.pow(x, -1),
            ("to_radians", _) => arena.scale(consts::PI / 180.0, x),
            ("to_degrees", _) => arena.scale(180.0 / consts::PI, x),
            ("sin_cos", _) => {
                let pair = [Function::Sin, Function::Cos].map(|f| Value::Scalar(arena.call(f, x)));
                return Value::Tuple(pair.into());
            }
            ("log", [base]) => {
                let [x, base] = [x, *base].map(|e| arena.call(Function::Ln, e));
                arena.div(x, base)
            }
            ("mul_add", [y, z]) => {
                let product = arena.mul(x, *y);
                arena.add(product, *z)
            }
            _ => return Value::Poison,
        })
    }

    fn powi(&mut self, x: Option<Expr>, exponent: &Argument) -> Value {
        let at = &exponent.at;
        let k = match &exponent.value {
            Value::Int(k) if k.value.unsigned_abs() <= POWER => k.value as i32,
            Value::Poison => return Value::Poison,
            Value::Int(Integer { value: k, .. }) => {
                return self.refuse(
                    at,
                    format!("the power {k} is out of proportion; the limit is {POWER}"),
                );
            }
            Value::Scalar(e) if self.integral(*e).is_some() => {
                let k = self.integral(*e).unwrap_or_default();
                let message = format!("the exponent of `powi` is an integer: write `{k}`");
                return self.refuse(at, message);
            }
            other => {
                let message = format!(
                    "the exponent of `powi` must be an integer known at compile time, and this is {}; for others use `powf`",
                    other.kind()
                );
                return self.refuse(at, message);
            }
        };
        let Some(x) = x else { return Value::Poison };
        if k < 0 && self.arena.constant_value(x) == Some(0.0) {
            return self.refuse(
                at,
                "this divides by zero: a negative power of the constant 0",
            );
        }
        let value = self.arena.pow(x, k);
        if !self.arena.is_finite(value) {
            return self.refuse(at, "the constants here overflow an `f64`");
        }
        Value::Scalar(value)
    }

    /// The integer that an expression is.
    fn integral(&self, expr: Expr) -> Option<i64> {
        let value = self.arena.constant_value(expr)?;
        (value.fract() == 0.0 && value.abs() < 1e9).then_some(value as i64)
    }
}

/// Whether `f64` has a smooth method of this name.
pub(super) fn is_smooth_method(name: &str) -> bool {
    operands(name).is_some()
}

/// Whether `f64` has a method of this name, smooth or not.
pub(super) fn is_method(name: &str) -> bool {
    is_smooth_method(name) || ROUGH.iter().any(|r| r.0 == name)
}

/// How a function that is written `sin(x)` is called as a method; of those that are smooth.
pub(super) fn method_meant(name: &str) -> Option<String> {
    match (operands(name), other_name(name)) {
        (Some(0), _) => Some(format!("{name}()")),
        (Some(1), _) => Some(format!("{name}(y)")),
        (Some(_), _) => Some(format!("{name}(y, z)")),
        (None, Some("powi` or `powf")) => Some("powi(n)` or `x.powf(y)".to_owned()),
        // of how many numbers `norm` is meant is not seen
        (None, Some("hypot") | None) => None,
        (None, Some(method)) if method.ends_with(')') => Some(method.to_owned()),
        (None, Some(method)) => method_meant(method),
    }
}

/// Arguments of a method beside the receiver.
fn operands(name: &str) -> Option<usize> {
    let of_entries = unary(name).map(|_| 0).or(binary(name).map(|_| 1));
    let composed = COMPOSED.iter().find(|m| m.0 == name);
    of_entries.or(composed.map(|m| m.1))
}

/// The function of one argument with this method.
fn unary(name: &str) -> Option<Function> {
    let mut methods = Function::METHODS.iter().copied();
    methods.find(|f| f.name() == name)
}

/// The function of two arguments with this method.
fn binary(name: &str) -> Option<Binary> {
    let mut methods = Binary::METHODS.iter().copied();
    methods.find(|f| f.name() == name)
}

fn no_method(name: &str) -> String {
    let of_entries = Function::METHODS.iter().map(|f| f.name());
    let of_entries = of_entries.chain(Binary::METHODS.iter().map(|f| f.name()));
    let known = of_entries.chain(COMPOSED.iter().map(|m| m.0));
    match other_name(name).or_else(|| nearest(name, known)) {
        Some(near) => format!("`{name}` is not a function of `f64`; did you mean `{near}`?"),
        None => format!(
            "`{name}` is not among the smooth functions of `f64` (`powi`, `sqrt`, `exp`, `ln`, `sin`, `atan2`, `hypot`, …): compose it of them in a function of this `impl` block"
        ),
    }
}

/// What a function is called here that has another name elsewhere.
pub(super) fn other_name(name: &str) -> Option<&'static str> {
    Some(match name {
        "pow" => "powi` or `powf",
        "square" | "squared" | "sqr" => "powi(2)",
        "arcsin" => "asin",
        "arccos" => "acos",
        "arctan" => "atan",
        "arctan2" => "atan2",
        "arsinh" | "arcsinh" => "asinh",
        "arcosh" | "arccosh" => "acosh",
        "artanh" | "arctanh" => "atanh",
        "loge" => "ln",
        "log1p" => "ln_1p",
        "expm1" => "exp_m1",
        "norm" => "hypot",
        _ => return None,
    })
}

/// `1 argument`, `2 arguments`.
pub(super) fn plural(n: usize, noun: &str) -> String {
    let s = if n == 1 { "" } else { "s" };
    match n {
        0 => format!("no {noun}s"),
        _ => format!("{n} {noun}{s}"),
    }
}

/// `are 2`.
pub(super) fn are(n: usize) -> String {
    match n {
        0 => "are none".to_owned(),
        1 => "is 1".to_owned(),
        _ => format!("are {n}"),
    }
}

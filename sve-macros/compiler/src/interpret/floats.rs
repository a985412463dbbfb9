//! The smooth methods of `f64`, under all their names.

use std::f64::consts::PI;

use proc_macro2::Span;

use super::Lowering;
use super::calls::Argument;
use super::integers::Integer;
use super::methods::{Run, names_of_numbers, of_numbers, rough_method};
use super::value::Value;
use crate::algebra::{Arena, Binary, Expr, Function};
use crate::errors::nearest;

/// Largest exponent that `powi` takes.
const POWER: u64 = 1024;

/// The methods whose result is not computed by an expression of numbers alone, with the number of
/// their arguments.
const OWN: [(&str, usize); 2] = [("powi", 1), ("sin_cos", 0)];

pub(super) fn to_radians(arena: &mut Arena, x: &[Expr]) -> Expr {
    arena.scale(PI / 180.0, x[0])
}

pub(super) fn to_degrees(arena: &mut Arena, x: &[Expr]) -> Expr {
    arena.scale(180.0 / PI, x[0])
}

pub(super) fn mul_add(arena: &mut Arena, x: &[Expr]) -> Expr {
    let product = arena.mul(x[0], x[1]);
    arena.add(product, x[2])
}

/// Returns the logarithm of the first number to the base of the second.
pub(super) fn log(arena: &mut Arena, x: &[Expr]) -> Expr {
    let [x, base] = [x[0], x[1]].map(|e| arena.call(Function::Ln, e));
    arena.div(x, base)
}

impl Lowering<'_> {
    /// Calls a method of a number. The receiver is the first argument.
    pub(super) fn number_method(
        &mut self,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Option<Value> {
        if let ("round", [number]) = (name, arguments)
            && self.scene.is_scene()
        {
            let number = self.scalar(&number.value, &number.at)?;
            return self.rounded(number, at);
        }
        if let Some(message) = rough_method(name) {
            return self.refuse(&at, message);
        }
        let Some(expected) = operands(name) else {
            return self.refuse(&at, no_method(name));
        };
        let found = arguments.len().saturating_sub(1);
        if found != expected {
            return self.refuse(&at, wrong_arity(&format!("`{name}`"), expected, found));
        }
        if let ("powi", [base, exponent]) = (name, arguments) {
            let x = self.scalar(&base.value, &base.at);
            return self.powi(x, exponent);
        }
        let numbers = self.scalars(arguments)?;
        if name == "sin_cos" {
            let pair = [Function::Sin, Function::Cos].map(|f| self.arena.call(f, numbers[0]));
            return Some(Value::Tuple(pair.map(Value::Scalar).into()));
        }
        let function = unary(name);
        let value = match (function, binary(name), of_numbers(name)) {
            (Some(function), _, _) => self.arena.call(function, numbers[0]),
            (_, Some(function), _) => self.arena.call2(function, numbers[0], numbers[1]),
            (_, _, Some((_, Run::Float(compute)))) => compute(self.arena, &numbers),
            _ => return None,
        };
        let is_outside = |x: f64| function.is_some_and(|f| !f.evaluate(x).is_finite());
        let constant = self.arena.constant_value(numbers[0]);
        if self.arena.is_finite(value) && !constant.is_some_and(is_outside) {
            return Some(Value::Scalar(value));
        }
        let message =
            format!("`{name}` is not defined at this constant: its value is not a finite number");
        self.refuse(&at, message)
    }

    fn powi(&mut self, x: Option<Expr>, exponent: &Argument) -> Option<Value> {
        let at = &exponent.at;
        let k = match &exponent.value {
            Value::Poison => return None,
            Value::Int(Integer { value: k, .. }) if k.unsigned_abs() <= POWER => *k as i32,
            other => {
                let message = self.wrong_exponent(other);
                return self.refuse(at, message);
            }
        };
        let x = x?;
        if k < 0 && self.arena.constant_value(x) == Some(0.0) {
            let message = "this divides by zero: a negative power of the constant 0";
            return self.refuse(at, message);
        }
        let value = self.arena.pow(x, k);
        self.finite(value, at)
    }

    /// Returns the message for an exponent that `powi` does not take.
    fn wrong_exponent(&self, exponent: &Value) -> String {
        let number = match exponent {
            Value::Scalar(e) => self.arena.constant_value(*e),
            _ => None,
        };
        match (exponent, number) {
            (Value::Int(Integer { value: k, .. }), _) => {
                format!("the power {k} is out of proportion; the limit is {POWER}")
            }
            (_, Some(k)) if k.fract() == 0.0 && k.abs() < 1e9 => {
                format!("the exponent of `powi` is an integer: write `{k}`")
            }
            (other, _) => format!(
                "the exponent of `powi` must be an integer known at compile time, and this is {}; for others use `powf`",
                other.kind()
            ),
        }
    }
}

/// Returns whether `f64` has a smooth method with this name.
pub(super) fn is_smooth_method(name: &str) -> bool {
    operands(name).is_some()
}

/// Returns whether `f64` has a method with this name, smooth or not.
pub(super) fn is_method(name: &str) -> bool {
    is_smooth_method(name) || rough_method(name).is_some()
}

/// Returns the method call that replaces a function written as `sin(x)`; `None` if no smooth method
/// has this name.
pub(super) fn method_meant(name: &str) -> Option<String> {
    match (operands(name), other_name(name)) {
        (Some(0), _) => Some(format!("{name}()")),
        (Some(1), _) => Some(format!("{name}(y)")),
        (Some(_), _) => Some(format!("{name}(y, z)")),
        (None, Some("powi` or `powf")) => Some("powi(n)` or `x.powf(y)".to_owned()),
        // the number of arguments of `norm` is unknown here
        (None, Some("hypot") | None) => None,
        (None, Some(method)) if method.ends_with(')') => Some(method.to_owned()),
        (None, Some(method)) => method_meant(method),
    }
}

/// Returns the number of arguments of a method beside the receiver.
fn operands(name: &str) -> Option<usize> {
    let of_functions = unary(name).map(|_| 0).or(binary(name).map(|_| 1));
    let of_table = || of_numbers(name).map(|(count, _)| count);
    let own = || OWN.iter().find(|method| method.0 == name);
    of_functions
        .or_else(of_table)
        .or_else(|| own().map(|method| method.1))
}

/// Returns the function of one argument with this method.
fn unary(name: &str) -> Option<Function> {
    let mut methods = Function::METHODS.iter().copied();
    methods.find(|f| f.name() == name)
}

/// Returns the function of two arguments with this method.
fn binary(name: &str) -> Option<Binary> {
    let mut methods = Binary::METHODS.iter().copied();
    methods.find(|f| f.name() == name)
}

fn no_method(name: &str) -> String {
    let of_entries = Function::METHODS.iter().map(|f| f.name());
    let of_entries = of_entries.chain(Binary::METHODS.iter().map(|f| f.name()));
    let known = of_entries
        .chain(names_of_numbers())
        .chain(OWN.iter().map(|method| method.0));
    match other_name(name).or_else(|| nearest(name, known)) {
        Some(near) => format!("`{name}` is not a function of `f64`; did you mean `{near}`?"),
        None => format!(
            "`{name}` is not among the smooth functions of `f64` (`powi`, `sqrt`, `exp`, `ln`, `sin`, `atan2`, `hypot`, …): compose it of them in a function of this `impl` block"
        ),
    }
}

/// Returns the name that a function has here, for a name that it has in other languages.
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

/// Returns the message for a call with too many or too few arguments.
pub(super) fn wrong_arity(callee: &str, expected: usize, found: usize) -> String {
    let takes = plural(expected, "argument");
    format!("{callee} takes {takes}, here {}", are(found))
}

/// Returns `1 argument`, `2 arguments`.
pub(super) fn plural(n: usize, noun: &str) -> String {
    let s = if n == 1 { "" } else { "s" };
    match n {
        0 => format!("no {noun}s"),
        _ => format!("{n} {noun}{s}"),
    }
}

/// Returns `are 2`.
pub(super) fn are(n: usize) -> String {
    match n {
        0 => "are none".to_owned(),
        1 => "is 1".to_owned(),
        _ => format!("are {n}"),
    }
}

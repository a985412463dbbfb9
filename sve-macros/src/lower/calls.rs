//! Calls: smooth functions of `f64`, helpers and constants of the block.

use std::f64::consts;

use syn::spanned::Spanned;
use syn::{Expr as Syntax, FnArg, Pat};

use super::Lowering;
use super::value::Value;
use crate::errors::nearest;
use crate::symbolic::{Binary, Expr, Function};

/// Methods of `f64` with one operand.
const UNARY: &[(&str, Function)] = &[
    ("sqrt", Function::Sqrt),
    ("cbrt", Function::Cbrt),
    ("exp", Function::Exp),
    ("exp2", Function::Exp2),
    ("exp_m1", Function::ExpM1),
    ("ln", Function::Ln),
    ("ln_1p", Function::Ln1p),
    ("log2", Function::Log2),
    ("log10", Function::Log10),
    ("sin", Function::Sin),
    ("cos", Function::Cos),
    ("tan", Function::Tan),
    ("asin", Function::Asin),
    ("acos", Function::Acos),
    ("atan", Function::Atan),
    ("sinh", Function::Sinh),
    ("cosh", Function::Cosh),
    ("tanh", Function::Tanh),
    ("asinh", Function::Asinh),
    ("acosh", Function::Acosh),
    ("atanh", Function::Atanh),
];

/// The other methods of `f64` that are understood.
const OTHER: &[&str] = &[
    "powi",
    "powf",
    "atan2",
    "hypot",
    "recip",
    "mul_add",
    "sin_cos",
    "to_radians",
    "to_degrees",
];

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
    ("clamp", "`clamp` is not smooth: use `tanh`"),
    ("floor", "`floor` is not continuous"),
    ("ceil", "`ceil` is not continuous"),
    ("round", "`round` is not continuous"),
    ("trunc", "`trunc` is not continuous"),
    (
        "fract",
        "`fract` is not continuous: a periodic function is made of `sin` and `cos`",
    ),
    (
        "rem_euclid",
        "`rem_euclid` is not continuous: an angle needs no reduction, use `sin` and `cos`",
    ),
    ("div_euclid", "`div_euclid` is not continuous"),
];

const CONSTANTS: &[(&str, f64)] = &[
    ("PI", consts::PI),
    ("TAU", consts::TAU),
    ("E", consts::E),
    ("SQRT_2", consts::SQRT_2),
    ("LN_2", consts::LN_2),
    ("LN_10", consts::LN_10),
    ("LOG2_E", consts::LOG2_E),
    ("LOG2_10", consts::LOG2_10),
    ("LOG10_E", consts::LOG10_E),
    ("LOG10_2", consts::LOG10_2),
    ("FRAC_1_PI", consts::FRAC_1_PI),
    ("FRAC_2_PI", consts::FRAC_2_PI),
    ("FRAC_1_SQRT_2", consts::FRAC_1_SQRT_2),
    ("FRAC_2_SQRT_PI", consts::FRAC_2_SQRT_PI),
    ("FRAC_PI_2", consts::FRAC_PI_2),
    ("FRAC_PI_3", consts::FRAC_PI_3),
    ("FRAC_PI_4", consts::FRAC_PI_4),
    ("FRAC_PI_6", consts::FRAC_PI_6),
    ("FRAC_PI_8", consts::FRAC_PI_8),
];

/// Calls of helpers inside each other.
const CALL_DEPTH: usize = 64;

/// Whether `std::f64::consts` has this name.
pub(super) fn is_float_constant(name: &str) -> bool {
    CONSTANTS.iter().any(|c| c.0 == name)
}

impl Lowering<'_> {
    /// Whether a path begins with the type of this block.
    fn is_self(&self, name: &str) -> bool {
        name == "Self"
            || matches!(&*self.block.item.self_ty, syn::Type::Path(ty) if ty.path.is_ident(name))
    }

    pub(super) fn constant_named(&self, name: &str) -> Option<&syn::ImplItemConst> {
        self.block.constants.iter().find(|c| c.ident == name)
    }

    /// `Self::K`, `std::f64::consts::PI`.
    pub(super) fn long_path(&mut self, expr: &syn::ExprPath) -> Value {
        let names: Vec<String> = expr
            .path
            .segments
            .iter()
            .map(|s| s.ident.to_string())
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        match names.as_slice() {
            [owner, name] if self.is_self(owner) => self.block_constant(expr, name),
            [.., "consts", name] => match CONSTANTS.iter().find(|c| c.0 == *name) {
                Some(&(_, value)) => Value::Scalar(self.arena.constant(value)),
                None => self.refuse(expr, format!("there is no constant `{name}` in `std::f64::consts`")),
            },
            _ => self.refuse(expr, "this path is not known here: constants are `Self::NAME` of this block or `std::f64::consts::NAME`"),
        }
    }

    fn block_constant(&mut self, expr: &syn::ExprPath, name: &str) -> Value {
        let last = expr.path.segments.last();
        let block = self.block;
        let Some(constant) = block.constants.iter().find(|c| c.ident == name) else {
            let known: Vec<String> = block
                .constants
                .iter()
                .map(|c| c.ident.to_string())
                .collect();
            let message = match nearest(name, known.iter().map(String::as_str)) {
                Some(near) => {
                    format!("this block has no constant `{name}`; did you mean `{near}`?")
                }
                None => format!(
                    "this block has no constant `{name}`: the macro sees only this `impl` block, so put `const {name}` here"
                ),
            };
            return self.refuse(&last, message);
        };
        let key = format!("const {name}");
        if self.active.contains(&key) {
            return self.refuse(&last, format!("the constant `{name}` is defined by itself"));
        }
        self.active.push(key);
        let outer = std::mem::replace(&mut self.scopes, vec![std::collections::HashMap::new()]);
        let value = self.eval(&constant.expr);
        self.scopes = outer;
        self.active.pop();
        value
    }

    pub(super) fn call(&mut self, call: &syn::ExprCall) -> Value {
        let Syntax::Path(path) = &*call.func else {
            return self.refuse(
                &call.func,
                "only functions of this block and of `f64` can be called",
            );
        };
        let names: Vec<String> = path
            .path
            .segments
            .iter()
            .map(|s| s.ident.to_string())
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        match names.as_slice() {
            ["f64", "from"] if arguments.len() == 1 => match self.eval(arguments[0]) {
                Value::Int(i) => Value::Scalar(self.arena.constant(i as f64)),
                other => other,
            },
            ["f64", name] if !arguments.is_empty() => {
                let receiver = self.eval(arguments[0]);
                self.float_method(name, path.span(), (&receiver, arguments[0]), &arguments[1..])
            }
            [owner, name] if self.is_self(owner) => {
                let at = path.path.segments.last().span();
                self.helper(name, at, None, &arguments)
            }
            [name] if self.variable(name).is_some() => match self.variable(name) {
                Some(Value::Poison) => Value::Poison,
                _ => self.refuse(path, format!("`{name}` is a variable, not a function")),
            },
            _ => self.refuse(path, format!("the function `{}` is not known here: make it a function of this `impl` block and call `self.{}(…)`", names.join("::"), names.last().unwrap_or(&""))),
        }
    }

    pub(super) fn method_call(&mut self, call: &syn::ExprMethodCall) -> Value {
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        let name = call.method.to_string();
        if matches!(&*call.receiver, Syntax::Path(path) if path.path.is_ident("self")) {
            return self.helper(&name, call.method.span(), Some(()), &arguments);
        }
        let receiver = self.eval(&call.receiver);
        if let (Value::Array(values), "len") = (&receiver, name.as_str()) {
            return Value::Int(values.len() as i64);
        }
        if let (Value::Int(i), "pow") = (&receiver, name.as_str())
            && let [exponent] = arguments.as_slice()
            && let Value::Int(k) = self.eval(exponent)
        {
            return match u32::try_from(k).ok().and_then(|k| i.checked_pow(k)) {
                Some(power) => Value::Int(power),
                None => self.refuse(&call.method, "this power overflows"),
            };
        }
        if let (Value::Field(path), "len") = (&receiver, name.as_str()) {
            let message = format!(
                "the length of `{}` is not known to the macro: write a literal, or a constant of this block",
                super::readable(&path.access())
            );
            return self.refuse(&call.method, message);
        }
        if let Value::Array(_) = receiver {
            return self.refuse(&call.method, format!("`{name}` of an array is not understood: write a loop, `let mut sum = 0.0; for i in 0..N {{ sum += … }}`"));
        }
        self.float_method(
            &name,
            call.method.span(),
            (&receiver, &call.receiver),
            &arguments,
        )
    }

    /// A method of `f64`.
    fn float_method(
        &mut self,
        name: &str,
        at: proc_macro2::Span,
        receiver: (&Value, &Syntax),
        arguments: &[&Syntax],
    ) -> Value {
        if let Some((_, message)) = ROUGH.iter().find(|r| r.0 == name) {
            self.errors.push(at, message);
            return Value::Poison;
        }
        let unary = UNARY.iter().find(|u| u.0 == name);
        let expected = match (unary, name) {
            (Some(_), _) | (None, "recip" | "sin_cos" | "to_radians" | "to_degrees") => 0,
            (None, "powi" | "powf" | "atan2" | "hypot") => 1,
            (None, "mul_add") => 2,
            _ => {
                let known = UNARY.iter().map(|u| u.0).chain(OTHER.iter().copied());
                let hint = nearest(name, known)
                    .map(|near| format!("; did you mean `{near}`?"))
                    .unwrap_or_default();
                self.errors.push(
                    at,
                    format!("`{name}` is not a function that can be differentiated here{hint}"),
                );
                return Value::Poison;
            }
        };
        if arguments.len() != expected {
            self.errors.push(
                at,
                format!(
                    "`{name}` takes {expected} arguments, here are {}",
                    arguments.len()
                ),
            );
            return Value::Poison;
        }
        let x = self.scalar(receiver.0, receiver.1);
        if name == "powi" {
            return self.powi(x, arguments[0]);
        }
        let rest: Vec<Option<Expr>> = arguments
            .iter()
            .map(|argument| {
                let value = self.eval(argument);
                self.scalar(&value, argument)
            })
            .collect();
        let Some(rest) = rest.into_iter().collect::<Option<Vec<Expr>>>() else {
            return Value::Poison;
        };
        let Some(x) = x else { return Value::Poison };
        let value = self.smooth(name, unary.map(|u| u.1), x, &rest);
        if let Value::Scalar(e) = value
            && !self.arena.is_finite(e)
        {
            self.errors
                .push(at, format!("`{name}` is not defined at this constant"));
            return Value::Poison;
        }
        value
    }

    fn smooth(&mut self, name: &str, unary: Option<Function>, x: Expr, rest: &[Expr]) -> Value {
        let arena = &mut *self.arena;
        Value::Scalar(match (unary, name, rest) {
            (Some(function), ..) => arena.call(function, x),
            (_, "recip", _) => arena.pow(x, -1),
            (_, "to_radians", _) => arena.scale(consts::PI / 180.0, x),
            (_, "to_degrees", _) => arena.scale(180.0 / consts::PI, x),
            (_, "sin_cos", _) => {
                let pair = [Function::Sin, Function::Cos].map(|f| Value::Scalar(arena.call(f, x)));
                return Value::Tuple(pair.into());
            }
            (_, "powf", [y]) => arena.call2(Binary::Pow, x, *y),
            (_, "atan2", [y]) => arena.call2(Binary::Atan2, x, *y),
            (_, "hypot", [y]) => arena.call2(Binary::Hypot, x, *y),
            (_, "mul_add", [y, z]) => {
                let product = arena.mul(x, *y);
                arena.add(product, *z)
            }
            _ => return Value::Poison,
        })
    }

    fn powi(&mut self, x: Option<Expr>, exponent: &Syntax) -> Value {
        let k = match self.eval(exponent) {
            Value::Int(k) if k.unsigned_abs() <= 1024 => k as i32,
            Value::Poison => return Value::Poison,
            Value::Int(k) => return self.refuse(exponent, format!("the power {k} is out of proportion; the limit is 1024")),
            _ => return self.refuse(exponent, "the exponent of `powi` must be an integer known at compile time; for others use `powf`"),
        };
        let Some(x) = x else { return Value::Poison };
        if k < 0 && self.arena.constant_value(x) == Some(0.0) {
            return self.refuse(exponent, "this divides by zero");
        }
        let value = self.arena.pow(x, k);
        if !self.arena.is_finite(value) {
            return self.refuse(exponent, "the constants here overflow an `f64`");
        }
        Value::Scalar(value)
    }

    /// Inlines a function of the block.
    fn helper(
        &mut self,
        name: &str,
        at: proc_macro2::Span,
        method: Option<()>,
        arguments: &[&Syntax],
    ) -> Value {
        let block = self.block;
        let mut values: Vec<Value> = arguments.iter().map(|a| self.eval(a)).collect();
        let found = block.functions.iter().find(|f| f.sig.ident == name);
        let Some(helper) = found else {
            return self.no_function(name, at);
        };
        if self.broken.contains(name) {
            return Value::Poison;
        }
        if self.active.iter().any(|a| a == name) {
            self.errors.push(
                at,
                format!("`{name}` calls itself: recursion cannot be unrolled, write a `for` loop"),
            );
            return Value::Poison;
        }
        if self.active.len() >= CALL_DEPTH {
            self.errors.push(at, "helpers call each other too deeply");
            return Value::Poison;
        }
        let mut inputs: Vec<Pat> = Vec::new();
        let mut receiver = false;
        for input in &helper.sig.inputs {
            match input {
                FnArg::Receiver(_) => receiver = true,
                FnArg::Typed(typed) => inputs.push((*typed.pat).clone()),
            }
        }
        // `Self::f(self, x)` passes the receiver as an argument
        if receiver && method.is_none() && !values.is_empty() {
            values.remove(0);
        }
        if values.len() != inputs.len() {
            self.errors.push(
                at,
                format!(
                    "`{name}` takes {} arguments, here are {}",
                    inputs.len(),
                    values.len()
                ),
            );
            return Value::Poison;
        }
        self.active.push(name.to_owned());
        let outer = std::mem::replace(&mut self.scopes, vec![std::collections::HashMap::new()]);
        for (pattern, value) in inputs.iter().zip(values) {
            self.bind(pattern, value);
        }
        let mistakes = self.errors.count();
        let value = self.block_value(&helper.block);
        self.scopes = outer;
        self.active.pop();
        if self.errors.count() > mistakes {
            self.broken.insert(name.to_owned());
        }
        value
    }

    fn no_function(&mut self, name: &str, at: proc_macro2::Span) -> Value {
        let known: Vec<String> = self
            .block
            .functions
            .iter()
            .map(|f| f.sig.ident.to_string())
            .collect();
        let message = match nearest(name, known.iter().map(String::as_str)) {
            Some(near) => format!("this block has no function `{name}`; did you mean `{near}`?"),
            None => format!(
                "this block has no function `{name}`: the macro sees only this `impl` block, so put the function here"
            ),
        };
        self.errors.push(at, message);
        Value::Poison
    }
}

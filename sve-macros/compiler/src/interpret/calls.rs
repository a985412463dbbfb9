//! Calls: smooth functions of `f64`, helpers and constants of the block.

use std::collections::HashMap;
use std::f64::consts;
use std::rc::Rc;

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Expr as Syntax, FnArg};

use super::Lowering;
use super::floats::{are, plural};
use super::integers::{Integer, integer_constant, is_integer};
use super::references::mutable;
use super::value::{FieldPath, Value};
use crate::errors::nearest;

/// A value that a function is given, and where it is written.
pub(super) struct Argument {
    pub(super) value: Value,
    pub(super) at: Span,
}

/// What `std::f64::consts` has.
pub(super) const CONSTANTS: &[(&str, f64)] = &[
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

/// What `std::f64::consts` has under this name.
pub(super) fn float_constant(name: &str) -> Option<f64> {
    CONSTANTS.iter().find(|c| c.0 == name).map(|c| c.1)
}

/// Whether a name is in capitals, as those of constants are.
pub(super) fn is_constant_name(name: &str) -> bool {
    name.chars().any(char::is_uppercase) && !name.chars().any(char::is_lowercase)
}

/// Methods that return what they are called on.
fn is_copy(name: &str) -> bool {
    matches!(name, "clone" | "to_owned" | "as_slice" | "each_ref")
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
            ["std" | "core", "f64", "consts", name]
            | ["f64", "consts", name]
            | ["consts", name] => match float_constant(name) {
                Some(value) => Value::Scalar(self.arena.constant(value)),
                None => {
                    let near = nearest(name, CONSTANTS.iter().map(|c| c.0))
                        .map(|near| format!("; did you mean `{near}`?"))
                        .unwrap_or_default();
                    self.refuse(&expr.path.segments.last(), format!("there is no constant `{name}` in `std::f64::consts`{near}"))
                }
            },
            ["f64", "EPSILON"] => Value::Scalar(self.arena.constant(f64::EPSILON)),
            ["f64", "MIN_POSITIVE"] => Value::Scalar(self.arena.constant(f64::MIN_POSITIVE)),
            ["f64", "MAX" | "MIN" | "INFINITY" | "NEG_INFINITY" | "NAN"] => {
                self.refuse(expr, "this number has no place in a formula: it overflows, or is none")
            }
            [ty, name @ ("MAX" | "MIN" | "BITS")]
                if let Some(value) = integer_constant(ty, name) =>
            {
                Value::Int(value)
            }
            ["f64", name] if super::floats::is_method(name) => {
                let message = format!("a function is called, or named in `map` and its like: pass a closure, `|x| x.{name}()`");
                self.refuse(expr, message)
            }
            // a constant from elsewhere
            [.., name] if is_constant_name(name) && expr.qself.is_none() => Value::Field(FieldPath::outside(expr.path.clone())),
            _ => self.refuse(expr, "this path is not known here: constants are `Self::NAME` of this block, `std::f64::consts::NAME`, or outside the block in capitals"),
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
            if block.functions.iter().any(|f| f.sig.ident == name) {
                let message = format!(
                    "a function is called, or named in `map` and its like: pass a closure, `|x| Self::{name}(x)`"
                );
                return self.refuse(&last, message);
            }
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
        if self.broken.contains(&key) {
            return Value::Poison;
        }
        self.enclosed(key, |this| match this.eval(&constant.expr) {
            Value::Field(path) if is_integer(&constant.ty) => {
                let message = format!("this is {}: write the number itself", path.kind());
                this.refuse(&constant.expr, message)
            }
            value => this.number(value, &constant.ty, &constant.expr),
        })
    }

    pub(super) fn call(&mut self, call: &syn::ExprCall) -> Value {
        let arguments: Vec<Argument> = call.args.iter().map(|a| self.argument(a)).collect();
        self.apply(&call.func, arguments)
    }

    pub(super) fn argument(&mut self, expr: &Syntax) -> Argument {
        Argument {
            value: self.eval(expr),
            at: expr.span(),
        }
    }

    /// Calls what an expression names: a function of the block or of `f64`, or a closure written in place.
    pub(super) fn apply(&mut self, function: &Syntax, arguments: Vec<Argument>) -> Value {
        let path = match function {
            Syntax::Path(path) => path,
            Syntax::Closure(closure) => return self.closure(closure, arguments),
            Syntax::Paren(inner) => return self.apply(&inner.expr, arguments),
            Syntax::Group(inner) => return self.apply(&inner.expr, arguments),
            _ => {
                return self.refuse(
                    function,
                    "only functions of this block and of `f64` can be called",
                );
            }
        };
        let names: Vec<String> = path
            .path
            .segments
            .iter()
            .map(|s| s.ident.to_string())
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let at = path.path.segments.last().span();
        match names.as_slice() {
            ["f64", "from"] => match arguments.first().map(|a| &a.value) {
                Some(Value::Int(i)) => Value::Scalar(self.arena.constant(i.value as f64)),
                Some(other) => other.clone(),
                None => self.refuse(&at, "`from` takes 1 argument, here are none"),
            },
            ["f64", name] if arguments.is_empty() => self.refuse(
                &at,
                format!("`f64::{name}` needs the number to act on, as in `f64::{name}(x)`"),
            ),
            ["f64", name] => self.float_method(name, at, &arguments),
            [owner, name] if self.is_self(owner) => self.helper(name, at, false, arguments),
            [name] if self.variable(name).is_some() => match self.variable(name) {
                Some(Value::Poison) => Value::Poison,
                Some(Value::Closure(closure)) => {
                    let closure = Rc::clone(closure);
                    self.call_closure(&closure, arguments, path)
                }
                _ => self.refuse(path, format!("`{name}` is a variable, not a function")),
            },
            ["from_fn"] | [.., "array", "from_fn"] => self.array_from_fn(path, &arguments),
            [name] if self.block.functions.iter().any(|f| f.sig.ident == name) => self.refuse(
                path,
                format!("a function of this block is called `self.{name}(…)`, or `Self::{name}(…)` if it has no `self`"),
            ),
            [name] if let Some(method) = super::floats::method_meant(name) => self.refuse(
                path,
                format!("`{name}` is a method of numbers in Rust: write `x.{method}`"),
            ),
            _ => {
                let name = names.last().copied().unwrap_or_default();
                self.refuse(path, format!("the function `{}` is not known here: make it a function of this `impl` block and call `self.{name}(…)`", names.join("::")))
            }
        }
    }

    pub(super) fn method_call(&mut self, call: &syn::ExprMethodCall) -> Value {
        let name = call.method.to_string();
        let at = call.method.span();
        if matches!(&*call.receiver, Syntax::Path(path) if path.path.is_ident("self")) {
            let arguments = call.args.iter().map(|a| self.argument(a)).collect();
            return self.helper(&name, at, true, arguments);
        }
        if name == "iter_mut" && call.args.is_empty() {
            return self.iterate_mutably(&call.receiver, at);
        }
        let receiver = self.argument(&call.receiver);
        if let Value::Poison = receiver.value
            && !super::floats::is_method(&name)
        {
            // of what type it would be is not known
            return Value::Poison;
        }
        if is_copy(&name) && call.args.is_empty() {
            return receiver.value;
        }
        if name == "into" && call.args.is_empty() {
            return Self::converted(receiver.value);
        }
        if let Some(value) = self.sequence_method(call, &receiver) {
            return value;
        }
        let mut arguments = vec![receiver];
        for argument in &call.args {
            let argument = self.argument(argument);
            arguments.push(argument);
        }
        if let Some(value) = self.integer_method(&name, at, &arguments) {
            return value;
        }
        self.float_method(&name, at, &arguments)
    }

    /// Inlines a function of the block; `method` says that it was called `self.name(…)`.
    fn helper(
        &mut self,
        name: &str,
        at: Span,
        method: bool,
        mut arguments: Vec<Argument>,
    ) -> Value {
        let block = self.block;
        let Some(helper) = block.functions.iter().find(|f| f.sig.ident == name) else {
            return self.no_function(name, at);
        };
        if self.broken.contains(name) {
            return Value::Poison;
        }
        if self.active.iter().any(|a| a == name) {
            let message =
                format!("`{name}` calls itself: recursion cannot be unrolled, write a `for` loop");
            return self.refuse(&at, message);
        }
        if self.active.len() >= CALL_DEPTH {
            let message = format!(
                "helpers call each other more than {CALL_DEPTH} deep: write the formula in fewer functions"
            );
            return self.refuse(&at, message);
        }
        let inputs: Vec<&syn::PatType> = helper
            .sig
            .inputs
            .iter()
            .filter_map(|input| match input {
                FnArg::Receiver(_) => None,
                FnArg::Typed(typed) => Some(typed),
            })
            .collect();
        let receiver = inputs.len() < helper.sig.inputs.len();
        if method && !receiver {
            let message = format!("`{name}` has no `self`: call it `Self::{name}(…)`");
            return self.refuse(&at, message);
        }
        // `Self::f(self, x)` passes the receiver as an argument
        if receiver && !method && !arguments.is_empty() {
            arguments.remove(0);
        }
        if arguments.len() != inputs.len() {
            let message = format!(
                "`{name}` takes {}, here {}",
                plural(inputs.len(), "argument"),
                are(arguments.len())
            );
            return self.refuse(&at, message);
        }
        if let Some(word) = inputs.iter().find_map(|input| mutable(&input.ty)) {
            return self.refuse(
                &word,
                "`&mut` is not understood: a helper returns what it computes",
            );
        }
        // before the function is entered: this mistake is the caller's
        let values: Vec<Value> = inputs
            .iter()
            .zip(arguments)
            .map(|(input, argument)| self.number(argument.value, &input.ty, &argument.at))
            .collect();
        self.enclosed(name.to_owned(), |this| {
            for (input, argument) in inputs.iter().zip(values) {
                let value = this.ascribed(argument, &input.ty);
                this.bind_length(&input.ty, &value);
                this.bind(&input.pat, value);
            }
            let value = this.block_value(&helper.block);
            match (&helper.sig.output, helper.block.stmts.last()) {
                (syn::ReturnType::Type(_, ty), Some(last)) => {
                    let value = this.awaited(value, ty, last);
                    this.number(value, ty, last)
                }
                _ => value,
            }
        })
    }

    /// Runs something with scopes of its own, as a function or constant that is called `name`.
    fn enclosed(&mut self, name: String, run: impl FnOnce(&mut Self) -> Value) -> Value {
        let scopes = std::mem::replace(&mut self.scopes, vec![HashMap::new()]);
        let floor = std::mem::take(&mut self.floor);
        let is_lazy = std::mem::take(&mut self.is_lazy);
        let frame = self.enter_frame();
        let outer = self.errors.enter(&name);
        self.active.push(name.clone());
        let mistakes = self.errors.count();
        let value = run(self);
        if self.errors.count() > mistakes {
            self.broken.insert(name);
        }
        self.active.pop();
        self.errors.leave(outer);
        self.frame = frame;
        self.is_lazy = is_lazy;
        self.floor = floor;
        self.scopes = scopes;
        value
    }

    /// Gives the function or closure that is entered a number; returns that of the one around.
    pub(super) fn enter_frame(&mut self) -> usize {
        self.frames += 1;
        std::mem::replace(&mut self.frame, self.frames)
    }

    /// The name `K` of a helper `fn f<const K: usize>(x: [f64; K])` is the length of its argument.
    fn bind_length(&mut self, ty: &syn::Type, value: &Value) {
        let ty = match ty {
            syn::Type::Reference(reference) => &*reference.elem,
            other => other,
        };
        let (syn::Type::Array(array), Value::Array(values)) = (ty, value) else {
            return;
        };
        if let Syntax::Path(path) = &array.len
            && let Some(name) = path.path.get_ident()
            && let Some(scope) = self.scopes.last_mut()
        {
            scope.insert(name.to_string(), Value::Int(Integer::count(values.len())));
        }
        if let Some(first) = values.first() {
            self.bind_length(&array.elem, first);
        }
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

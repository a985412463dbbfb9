//! Constants: those of the block, of `std::f64::consts`, and those from outside the block.

use std::f64::consts;

use quote::quote;

use super::Lowering;
use super::fields::FieldPath;
use super::integers::{integer_constant, is_integer};
use super::value::Value;
use crate::errors::nearest;

/// The constants in `std::f64::consts`.
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

/// What shows that a module is `std::f64::consts`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Certainty {
    Sure,
    ByName,
}

/// Returns the name of a scope's entry for an imported module of the standard library. No variable has such a name.
pub(super) fn imported_module(name: &str) -> String {
    format!("use {name}")
}

/// Returns the constant of this name in `std::f64::consts`.
pub(super) fn float_constant(name: &str) -> Option<f64> {
    CONSTANTS.iter().find(|c| c.0 == name).map(|c| c.1)
}

/// Returns whether a name is in capitals, as names of constants are.
pub(super) fn is_constant_name(name: &str) -> bool {
    name.chars().any(char::is_uppercase) && !name.chars().any(char::is_lowercase)
}

impl Lowering<'_> {
    pub(super) fn constant_named(&self, name: &str) -> Option<&syn::ImplItemConst> {
        self.block.constants.iter().find(|c| c.ident == name)
    }

    /// Evaluates a path of several segments, such as `Self::K` or `std::f64::consts::PI`.
    pub(super) fn long_path(&mut self, expr: &syn::ExprPath) -> Value {
        let names: Vec<String> = expr
            .path
            .segments
            .iter()
            .map(|s| s.ident.to_string())
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        if let [module @ .., name] = names.as_slice()
            && let Some(certainty) = self.standard_constants(module)
            && (certainty == Certainty::Sure || float_constant(name).is_some())
        {
            return self.standard_constant(&expr.path, name, certainty);
        }
        if let [ty, name @ ("MAX" | "MIN" | "BITS")] = names.as_slice()
            && let Some(value) = integer_constant(ty, name)
        {
            return Value::Int(value);
        }
        match names.as_slice() {
            [owner, name] if self.is_self(owner) => self.block_constant(expr, name),
            ["f64", "EPSILON"] => Value::Scalar(self.arena.constant(f64::EPSILON)),
            ["f64", "MIN_POSITIVE"] => Value::Scalar(self.arena.constant(f64::MIN_POSITIVE)),
            ["f64", "MAX" | "MIN" | "INFINITY" | "NEG_INFINITY" | "NAN"] => {
                self.refuse(expr, "this number has no place in a formula: it overflows, or is none")
            }
            ["f64", name] if super::floats::is_method(name) => {
                let message = format!("a function is called, or named in `map` and its like: pass a closure, `|x| x.{name}()`");
                self.refuse(expr, message)
            }
            // a constant from outside the block
            [.., name] if is_constant_name(name) && expr.qself.is_none() => Value::Field(FieldPath::outside(expr.path.clone())),
            _ => self.refuse(expr, "this path is not known here: constants are `Self::NAME` of this block, `std::f64::consts::NAME`, or outside the block in capitals"),
        }
    }

    /// Whether a module is `std::f64::consts`: by its full path or an import within the body, or by its name, which may be that of
    /// another module.
    fn standard_constants(&self, module: &[&str]) -> Option<Certainty> {
        let first = match module {
            ["std" | "core", "f64", "consts"] => return Some(Certainty::Sure),
            [first @ "f64", "consts"] | [first @ "consts"] => first,
            _ => return None,
        };
        let is_imported = self.held(&imported_module(first)).is_some();
        Some(if is_imported {
            Certainty::Sure
        } else {
            Certainty::ByName
        })
    }

    /// A constant of `std::f64::consts`.
    fn standard_constant(&mut self, path: &syn::Path, name: &str, certainty: Certainty) -> Value {
        let Some(value) = float_constant(name) else {
            let near = nearest(name, CONSTANTS.iter().map(|c| c.0))
                .map(|near| format!("; did you mean `{near}`?"))
                .unwrap_or_default();
            let message = format!("there is no constant `{name}` in `std::f64::consts`{near}");
            return self.refuse(&path.segments.last(), message);
        };
        if certainty == Certainty::ByName {
            self.read_as_standard(path, value);
        }
        Value::Scalar(self.arena.constant(value))
    }

    /// Notes a path that has to be checked: generated code compares its value with the one that it is read as.
    fn read_as_standard(&mut self, path: &syn::Path, value: f64) {
        let path = quote!(#path);
        let text = path.to_string();
        if self.constants.iter().all(|(p, _)| p.to_string() != text) {
            self.constants.push((path, value));
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
            value => {
                let value = this.ascribed(value, &constant.ty);
                this.number(value, &constant.ty, &constant.expr)
            }
        })
    }
}

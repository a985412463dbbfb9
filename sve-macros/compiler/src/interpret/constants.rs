//! Constants: of the block, of `std::f64::consts`, and from outside the block.

use std::f64::consts;

use quote::quote;

use super::Lowering;
use super::calls::names;
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

/// The evidence that a module is `std::f64::consts`.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Certainty {
    Sure,
    ByName,
}

/// Returns the name under which a scope holds an imported module of the standard library. No
/// variable has such a name.
pub(super) fn imported_module(name: &str) -> String {
    format!("use {name}")
}

/// Returns the constant of this name in `std::f64::consts`.
pub(super) fn float_constant(name: &str) -> Option<f64> {
    CONSTANTS.iter().find(|c| c.0 == name).map(|c| c.1)
}

/// Returns whether a name is written in capitals, as names of constants are.
pub(super) fn is_constant_name(name: &str) -> bool {
    name.chars().any(char::is_uppercase) && !name.chars().any(char::is_lowercase)
}

impl<'a> Lowering<'a> {
    pub(super) fn constant_named(&self, name: &str) -> Option<&'a syn::ImplItemConst> {
        self.block.constants.iter().find(|c| c.ident == name)
    }

    /// Evaluates a path of several segments, such as `Self::K` or `std::f64::consts::PI`.
    pub(super) fn long_path(&mut self, expr: &syn::ExprPath) -> Option<Value> {
        let names = names(expr);
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
            return Some(Value::Int(value));
        }
        let message = match names.as_slice() {
            [owner, name] if self.is_self(owner) => return self.block_constant(expr, name),
            ["f64", "EPSILON"] => return Some(self.constant(f64::EPSILON)),
            ["f64", "MIN_POSITIVE"] => return Some(self.constant(f64::MIN_POSITIVE)),
            ["f64", "MAX" | "MIN" | "INFINITY" | "NEG_INFINITY" | "NAN"] => {
                "this number has no place in a formula: it overflows, or is none".to_owned()
            }
            ["f64", name] if super::floats::is_method(name) => {
                format!("a function is called, or named in `map` and its like: pass a closure, `|x| x.{name}()`")
            }
            // a constant from outside the block
            [.., name] if is_constant_name(name) && expr.qself.is_none() => {
                return Some(Value::Field(FieldPath::outside(expr.path.clone())));
            }
            _ => "this path is not known here: constants are `Self::NAME` of this block, `std::f64::consts::NAME`, or outside the block in capitals".to_owned(),
        };
        self.refuse(expr, message)
    }

    /// Returns whether a module is `std::f64::consts`. Its full path or an import within the body
    /// proves this; the name alone may belong to another module.
    fn standard_constants(&self, module: &[&str]) -> Option<Certainty> {
        let first = match module {
            ["std" | "core", "f64", "consts"] => return Some(Certainty::Sure),
            [first @ "f64", "consts"] | [first @ "consts"] => first,
            _ => return None,
        };
        let is_imported = self.frame.held(&imported_module(first)).is_some();
        Some(if is_imported {
            Certainty::Sure
        } else {
            Certainty::ByName
        })
    }

    /// Returns a constant of `std::f64::consts`.
    fn standard_constant(
        &mut self,
        path: &syn::Path,
        name: &str,
        certainty: Certainty,
    ) -> Option<Value> {
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
        Some(self.constant(value))
    }

    /// Records a path that must be checked: generated code compares its value with the constant
    /// that the macro took it for.
    fn read_as_standard(&mut self, path: &syn::Path, value: f64) {
        let path = quote!(#path);
        let text = path.to_string();
        if self.constants.iter().all(|(p, _)| p.to_string() != text) {
            self.constants.push((path, value));
        }
    }

    fn block_constant(&mut self, expr: &syn::ExprPath, name: &str) -> Option<Value> {
        let last = expr.path.segments.last();
        let Some(constant) = self.constant_named(name) else {
            let message = self.no_constant(name);
            return self.refuse(&last, message);
        };
        let key = format!("const {name}");
        if self.calls.is_active(&key) {
            return self.refuse(&last, format!("the constant `{name}` is defined by itself"));
        }
        if self.calls.broken.contains(&key) {
            return None;
        }
        self.enclosed(key, |this| match this.eval(&constant.expr)? {
            Value::Field(path) if is_integer(&constant.ty) => {
                let message = format!("this is {}: write the number itself", path.kind());
                this.refuse(&constant.expr, message)
            }
            value => {
                let value = this.ascribed(value, &constant.ty);
                Some(this.number(value, &constant.ty, &constant.expr))
            }
        })
    }

    fn no_constant(&self, name: &str) -> String {
        let (functions, constants) = (&self.block.functions, &self.block.constants);
        if functions.iter().any(|f| f.sig.ident == name) {
            return format!(
                "a function is called, or named in `map` and its like: pass a closure, `|x| Self::{name}(x)`"
            );
        }
        let known: Vec<String> = constants.iter().map(|c| c.ident.to_string()).collect();
        match nearest(name, known.iter().map(String::as_str)) {
            Some(near) => format!("this block has no constant `{name}`; did you mean `{near}`?"),
            None => format!(
                "this block has no constant `{name}`: the macro sees only this `impl` block, so put `const {name}` here"
            ),
        }
    }
}

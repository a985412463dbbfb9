//! Calls of functions. Finds the function of the block, the closure or the constructor that a name
//! refers to.

use std::rc::Rc;

use proc_macro2::Span;
use syn::Expr as Syntax;
use syn::spanned::Spanned;

use super::Lowering;
use super::floats::method_meant;
use super::matrices::Constructor;
use super::scenes::streams;
use super::value::Value;

/// An argument of a call: its value, and its place in the source.
pub(super) struct Argument {
    pub(super) value: Value,
    pub(super) at: Span,
}

impl Lowering<'_> {
    /// Returns whether a name is the type of this block.
    pub(super) fn is_self(&self, name: &str) -> bool {
        name == "Self"
            || matches!(&*self.block.item.self_ty, syn::Type::Path(ty) if ty.path.is_ident(name))
    }

    pub(super) fn argument(&mut self, expr: &Syntax) -> Argument {
        Argument {
            value: self.value(expr),
            at: expr.span(),
        }
    }

    pub(super) fn arguments<'e>(
        &mut self,
        exprs: impl IntoIterator<Item = &'e Syntax>,
    ) -> Vec<Argument> {
        exprs.into_iter().map(|expr| self.argument(expr)).collect()
    }

    pub(super) fn call(&mut self, call: &syn::ExprCall) -> Option<Value> {
        let arguments = self.arguments(&call.args);
        self.apply(&call.func, arguments)
    }

    /// Calls a function of the block or of `f64`, a closure in a variable, or a closure that is
    /// written in place.
    pub(super) fn apply(&mut self, function: &Syntax, arguments: Vec<Argument>) -> Option<Value> {
        let path = match function {
            Syntax::Path(path) => path,
            Syntax::Closure(closure) => return self.closure(closure, arguments),
            Syntax::Paren(inner) => return self.apply(&inner.expr, arguments),
            Syntax::Group(inner) => return self.apply(&inner.expr, arguments),
            _ => {
                let message = "only functions of this block and of `f64` can be called";
                return self.refuse(function, message);
            }
        };
        let names = names(path);
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let at = path.path.segments.last().span();
        match (names.as_slice(), arguments.as_slice()) {
            (["f64", "from"], []) => self.refuse(&at, "`from` takes 1 argument, here are none"),
            (["f64", "from"], [argument, ..]) => match &argument.value {
                Value::Int(i) => Some(self.constant(i.value as f64)),
                Value::Index(i) => Some(Value::Scalar(self.number_of(*i))),
                other => Some(other.clone()),
            },
            (["f64", name], []) => {
                let message =
                    format!("`f64::{name}` needs the number to act on, as in `f64::{name}(x)`");
                self.refuse(&at, message)
            }
            (["f64", name], _) => self.number_method(name, at, &arguments),
            ([owner, name], _) if self.is_self(owner) => self.helper(name, at, false, arguments),
            (names, _) => self.path_call(path, names, arguments),
        }
    }

    /// Evaluates a call of a path that belongs neither to `f64` nor to this block.
    fn path_call(
        &mut self,
        path: &syn::ExprPath,
        names: &[&str],
        arguments: Vec<Argument>,
    ) -> Option<Value> {
        if names.len() > 1
            && let Some((made, name)) = Constructor::of(path)
        {
            return self.construct(made, &name, &arguments);
        }
        if let [name] = names
            && let Some(variable) = self.frame.variable(name)
        {
            return match variable {
                Value::Poison => None,
                Value::Closure(closure) => {
                    let closure = Rc::clone(closure);
                    self.call_closure(&closure, arguments, path)
                }
                _ => self.refuse(path, format!("`{name}` is a variable, not a function")),
            };
        }
        let message = match names {
            ["Vec", ..] if self.scene.is_scene() => streams::NO_VEC.to_owned(),
            ["from_fn"] | [.., "array", "from_fn"] => return self.array_from_fn(path, &arguments),
            [name] if self.block.functions.iter().any(|f| f.sig.ident == name) => format!(
                "a function of this block is called `self.{name}(…)`, or `Self::{name}(…)` if it has no `self`"
            ),
            _ => {
                let name = names.last().copied().unwrap_or_default();
                match method_meant(name).filter(|_| names.len() == 1) {
                    Some(method) => {
                        format!("`{name}` is a method of numbers in Rust: write `x.{method}`")
                    }
                    None => format!(
                        "the function `{}` is not known here: make it a function of this `impl` block and call `self.{name}(…)`",
                        names.join("::")
                    ),
                }
            }
        };
        self.refuse(path, message)
    }
}

/// Returns the names of the segments of a path.
pub(super) fn names(path: &syn::ExprPath) -> Vec<String> {
    let segments = path.path.segments.iter();
    segments.map(|segment| segment.ident.to_string()).collect()
}

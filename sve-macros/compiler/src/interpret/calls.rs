//! Calls of functions and methods. Finds the function of the block, the closure or the table of methods that a name refers to.

use std::rc::Rc;

use proc_macro2::Span;
use syn::Expr as Syntax;
use syn::spanned::Spanned;

use super::Lowering;
use super::value::Value;

/// An argument of a call: its value, and where it is written.
pub(super) struct Argument {
    pub(super) value: Value,
    pub(super) at: Span,
}

/// Returns whether a method returns a copy of its receiver.
fn is_copy(name: &str) -> bool {
    matches!(name, "clone" | "to_owned" | "as_slice" | "each_ref")
}

impl Lowering<'_> {
    /// Returns whether a name is the type of this block.
    pub(super) fn is_self(&self, name: &str) -> bool {
        name == "Self"
            || matches!(&*self.block.item.self_ty, syn::Type::Path(ty) if ty.path.is_ident(name))
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

    /// Calls a function of the block or of `f64`, a closure in a variable, or a closure that is written in place.
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
            names => self.path_call(path, names, arguments),
        }
    }

    /// Evaluates a call of a path that is neither of `f64` nor of this block.
    fn path_call(
        &mut self,
        path: &syn::ExprPath,
        names: &[&str],
        arguments: Vec<Argument>,
    ) -> Value {
        if names.len() > 1
            && let Some(value) = self.construct(path, &arguments)
        {
            return value;
        }
        match names {
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
            _ => {
                let name = names.last().copied().unwrap_or_default();
                let message = match super::floats::method_meant(name).filter(|_| names.len() == 1) {
                    Some(method) => {
                        format!("`{name}` is a method of numbers in Rust: write `x.{method}`")
                    }
                    None => format!("the function `{}` is not known here: make it a function of this `impl` block and call `self.{name}(…)`", names.join("::")),
                };
                self.refuse(path, message)
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
            // a poisoned receiver has no type, by which its method could be checked
            return Value::Poison;
        }
        if let Some(value) = self.matrix_method(call, &receiver) {
            return value;
        }
        if is_copy(&name) && call.args.is_empty() {
            return receiver.value;
        }
        if name == "into" && call.args.is_empty() {
            return self.converted(receiver.value);
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
}

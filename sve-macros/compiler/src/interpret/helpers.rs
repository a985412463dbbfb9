//! Functions of the block. A call of a function is replaced by its body.

use std::collections::HashSet;

use proc_macro2::Span;
use syn::{Expr as Syntax, FnArg, ImplItemFn};

use super::Lowering;
use super::calls::Argument;
use super::floats::wrong_arity;
use super::frames::Scope;
use super::places::variable_name;
use super::references::mutable;
use super::value::Value;
use crate::errors::nearest;
use crate::syntax::nalgebra::{Size, Written};

/// Largest depth of nested calls.
const CALL_DEPTH: usize = 64;

/// The helpers and constants that are called.
#[derive(Default)]
pub(super) struct Calls {
    /// The helpers and constants that are being evaluated. A repeated name shows recursion.
    pub(super) active: Vec<String>,
    /// The helpers and constants in which a mistake has been reported.
    pub(super) broken: HashSet<String>,
}

impl Calls {
    pub(super) fn is_active(&self, name: &str) -> bool {
        self.active.iter().any(|active| active == name)
    }
}

impl Lowering<'_> {
    /// Inlines a function of the block. `is_method` says that it is called as `self.name(…)`.
    pub(super) fn helper(
        &mut self,
        name: &str,
        at: Span,
        is_method: bool,
        arguments: Vec<Argument>,
    ) -> Option<Value> {
        let block = self.block;
        let Some(helper) = block.functions.iter().find(|f| f.sig.ident == name) else {
            let message = self.no_function(name);
            return self.refuse(&at, message);
        };
        if self.calls.broken.contains(name) {
            return None;
        }
        let message = if self.calls.is_active(name) {
            format!("`{name}` calls itself: recursion cannot be unrolled, write a `for` loop")
        } else if self.calls.active.len() >= CALL_DEPTH {
            format!(
                "helpers call each other more than {CALL_DEPTH} deep: write the formula in fewer functions"
            )
        } else if is_method && helper.sig.receiver().is_none() {
            format!("`{name}` has no `self`: call it `Self::{name}(…)`")
        } else {
            return self.inlined(helper, at, is_method, arguments);
        };
        self.refuse(&at, message)
    }

    /// Executes a function of the block with arguments.
    fn inlined(
        &mut self,
        helper: &ImplItemFn,
        at: Span,
        is_method: bool,
        mut arguments: Vec<Argument>,
    ) -> Option<Value> {
        let name = helper.sig.ident.to_string();
        let inputs = helper.sig.inputs.iter();
        let inputs = inputs.filter_map(|input| match input {
            FnArg::Receiver(_) => None,
            FnArg::Typed(typed) => Some(typed),
        });
        let inputs: Vec<&syn::PatType> = inputs.collect();
        // `Self::f(self, x)` passes the receiver as an argument
        if helper.sig.receiver().is_some() && !is_method && !arguments.is_empty() {
            arguments.remove(0);
        }
        if arguments.len() != inputs.len() {
            let message = wrong_arity(&format!("`{name}`"), inputs.len(), arguments.len());
            return self.refuse(&at, message);
        }
        if let Some(word) = inputs.iter().find_map(|input| mutable(&input.ty)) {
            return self.refuse(
                &word,
                "`&mut` is not understood: a helper returns what it computes",
            );
        }
        // arguments are checked outside of the function, since the caller made their mistakes
        let pairs = inputs.iter().zip(arguments);
        let values: Vec<Value> = pairs
            .map(|(input, argument)| self.number(argument.value, &input.ty, &argument.at))
            .collect();
        self.enclosed(name, |this| {
            for (input, argument) in inputs.iter().zip(values) {
                let value = this.ascribed(argument, &input.ty);
                this.bind_length(&input.ty, &value);
                this.bind(&input.pat, value);
            }
            let value = this.block_value(&helper.block)?;
            match (&helper.sig.output, helper.block.stmts.last()) {
                (syn::ReturnType::Type(_, ty), Some(last)) => {
                    let value = this.awaited(value, ty, last);
                    let value = this.ascribed(value, ty);
                    Some(this.number(value, ty, last))
                }
                _ => Some(value),
            }
        })
    }

    /// Calls `run` in a new frame, as the body of the function or constant `name`.
    pub(super) fn enclosed<T>(&mut self, name: String, run: impl FnOnce(&mut Self) -> T) -> T {
        let outer = self.errors.enter(&name);
        self.calls.active.push(name.clone());
        let mistakes = self.errors.count();
        let value = self.in_frame(Scope::new(), run);
        if self.errors.count() > mistakes {
            self.calls.broken.insert(name);
        }
        self.calls.active.pop();
        self.errors.leave(outer);
        value
    }

    /// Binds the const parameter `K` of a helper `fn f<const K: usize>(x: [f64; K])` or
    /// `(x: SVector<f64, K>)` to the length of its argument.
    fn bind_length(&mut self, ty: &syn::Type, value: &Value) {
        let ty = match ty {
            syn::Type::Reference(reference) => &*reference.elem,
            other => other,
        };
        match (ty, value) {
            (syn::Type::Array(array), Value::Array(values)) => {
                self.bind_const(&array.len, values.len());
                if let Some(first) = values.first() {
                    self.bind_length(&array.elem, first);
                }
            }
            (ty, Value::Matrix(matrix)) => {
                let Some(written) = Written::of_type(ty) else {
                    return;
                };
                for (size, found) in [
                    (written.rows, matrix.ty.rows),
                    (written.columns, matrix.ty.columns),
                ] {
                    if let Size::Written(name) = size {
                        self.bind_const(&name, found);
                    }
                }
            }
            _ => {}
        }
    }

    /// Binds a length that is a single name to a value.
    fn bind_const(&mut self, length: &Syntax, value: usize) {
        if let Some(name) = variable_name(length) {
            self.frame.set(&name, Value::count(value));
        }
    }

    fn no_function(&self, name: &str) -> String {
        let known: Vec<String> = self
            .block
            .functions
            .iter()
            .map(|f| f.sig.ident.to_string())
            .collect();
        match nearest(name, known.iter().map(String::as_str)) {
            Some(near) => format!("this block has no function `{name}`; did you mean `{near}`?"),
            None => format!(
                "this block has no function `{name}`: the macro sees only this `impl` block, so put the function here"
            ),
        }
    }
}

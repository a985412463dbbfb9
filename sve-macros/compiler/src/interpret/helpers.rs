//! Functions of the block. A function is inlined where it is called.

use std::collections::HashMap;

use proc_macro2::Span;
use syn::{Expr as Syntax, FnArg};

use super::Lowering;
use super::calls::Argument;
use super::floats::{are, plural};
use super::integers::Integer;
use super::references::mutable;
use super::value::Value;
use crate::errors::nearest;
use crate::syntax::nalgebra::{Size, Written};

/// Largest depth of nested calls.
const CALL_DEPTH: usize = 64;

impl Lowering<'_> {
    /// Inlines a function of the block. `method` says that it is called as `self.name(…)`.
    pub(super) fn helper(
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
        // arguments are checked outside of the function, since their mistakes are the caller's
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
                    let value = this.ascribed(value, ty);
                    this.number(value, ty, last)
                }
                _ => value,
            }
        })
    }

    /// Calls `run` with new scopes, as the body of the function or constant `name`.
    pub(super) fn enclosed(&mut self, name: String, run: impl FnOnce(&mut Self) -> Value) -> Value {
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

    /// Numbers the frame of the function or closure that is entered. Returns the number of the enclosing frame.
    pub(super) fn enter_frame(&mut self) -> usize {
        self.frames += 1;
        std::mem::replace(&mut self.frame, self.frames)
    }

    /// Binds the const parameter `K` of a helper `fn f<const K: usize>(x: [f64; K])` or `(x: SVector<f64, K>)` to the length of its
    /// argument.
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
                let sizes = [
                    (written.rows, matrix.ty.rows),
                    (written.columns, matrix.ty.columns),
                ];
                for (written, size) in sizes {
                    if let Size::Written(name) = written {
                        self.bind_const(&name, size);
                    }
                }
            }
            _ => {}
        }
    }

    /// Binds a length that is a single name to a value.
    fn bind_const(&mut self, length: &Syntax, value: usize) {
        if let Syntax::Path(path) = length
            && let Some(name) = path.path.get_ident()
            && let Some(scope) = self.scopes.last_mut()
        {
            scope.insert(name.to_string(), Value::Int(Integer::count(value)));
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

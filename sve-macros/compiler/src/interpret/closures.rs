//! Closures. A closure is executed where it is called, with the variables that it captured where it is written.

use std::cell::Cell;
use std::collections::HashMap;
use std::rc::Rc;

use proc_macro2::Ident;
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{ExprClosure, Pat};

use super::Lowering;
use super::calls::Argument;
use super::floats::{are, plural};
use super::references::mutable;
use super::value::Value;

/// A closure that a variable holds.
pub(super) struct Closure {
    syntax: ExprClosure,
    /// The captured variables. They cannot change while the closure borrows them.
    captured: HashMap<String, Value>,
    /// Whether a mistake in the closure has been reported.
    is_broken: Cell<bool>,
}

impl Lowering<'_> {
    /// Returns the value of a closure that is not called where it is written.
    pub(super) fn capture(&mut self, closure: &ExprClosure) -> Value {
        let mut names = Names(Vec::new());
        names.visit_expr(&closure.body);
        let mut captured = HashMap::new();
        let mut size = 1;
        for name in names.0 {
            if let Some(value) = self.variable(&name) {
                size += value.entries();
                captured.insert(name, value.clone());
            }
        }
        if !self.work(size, closure) {
            return Value::Poison;
        }
        Value::Closure(Rc::new(Closure {
            syntax: closure.clone(),
            captured,
            is_broken: Cell::new(false),
        }))
    }

    /// Calls a closure that a variable holds.
    pub(super) fn call_closure(
        &mut self,
        closure: &Closure,
        arguments: Vec<Argument>,
        at: &impl Spanned,
    ) -> Value {
        let size = closure.captured.values().map(Value::entries);
        let size = size.sum::<usize>();
        if closure.is_broken.get() || !self.work(size, at) {
            return Value::Poison;
        }
        if let Some(refused) = self.arity(&closure.syntax, &arguments, at) {
            return refused;
        }
        let mistakes = self.errors.count();
        let scopes = std::mem::replace(&mut self.scopes, vec![closure.captured.clone()]);
        let is_lazy = std::mem::take(&mut self.is_lazy);
        let frame = self.enter_frame();
        let value = self.closure(&closure.syntax, arguments);
        self.frame = frame;
        self.is_lazy = is_lazy;
        self.scopes = scopes;
        closure.is_broken.set(self.errors.count() > mistakes);
        value
    }

    /// Executes a closure that is written where it is called.
    pub(super) fn closure(&mut self, closure: &ExprClosure, arguments: Vec<Argument>) -> Value {
        if let Some(refused) = self.arity(closure, &arguments, closure) {
            return refused;
        }
        let floor = std::mem::replace(&mut self.floor, self.scopes.len());
        self.scopes.push(HashMap::new());
        for (pattern, argument) in closure.inputs.iter().zip(arguments) {
            let is_reference = matches!(argument.value, Value::Place(_));
            let value = match pattern {
                Pat::Type(typed) => {
                    if let Some(word) = mutable(&typed.ty).filter(|_| !is_reference) {
                        self.refuse(
                            &word,
                            "`&mut` is not understood: a closure returns what it computes",
                        )
                    } else {
                        self.number(argument.value, &typed.ty, &argument.at)
                    }
                }
                _ => Self::as_index(argument.value, pattern, &closure.body),
            };
            self.bind(pattern, value);
        }
        let value = self.eval(&closure.body);
        self.scopes.pop();
        self.floor = floor;
        value
    }

    /// Reports an error at `at` if the number of arguments is not that of the closure.
    fn arity(
        &mut self,
        closure: &ExprClosure,
        arguments: &[Argument],
        at: &impl Spanned,
    ) -> Option<Value> {
        (closure.inputs.len() != arguments.len()).then(|| {
            let message = format!(
                "this closure takes {}, here {}",
                plural(closure.inputs.len(), "argument"),
                are(arguments.len())
            );
            self.refuse(at, message)
        })
    }
}

/// The names in an expression.
struct Names(Vec<String>);

impl<'ast> Visit<'ast> for Names {
    fn visit_ident(&mut self, ident: &'ast Ident) {
        self.0.push(ident.to_string());
    }
}

//! Closures. A closure is executed where it is called, with the variables that it captured where it
//! is written.

use std::cell::Cell;
use std::rc::Rc;

use proc_macro2::Ident;
use syn::spanned::Spanned;
use syn::visit::Visit;
use syn::{ExprClosure, Pat};

use super::Lowering;
use super::calls::Argument;
use super::floats::wrong_arity;
use super::frames::Scope;
use super::references::mutable;
use super::value::Value;

/// A closure that a variable holds.
pub(super) struct Closure {
    syntax: ExprClosure,
    /// The captured variables. They cannot change while the closure borrows them.
    captured: Scope,
    /// True if a mistake in the closure has been reported.
    is_broken: Cell<bool>,
}

impl Lowering<'_> {
    /// Returns the value of a closure that is not called where it is written.
    pub(super) fn capture(&mut self, closure: &ExprClosure) -> Option<Value> {
        let mut names = Names(Vec::new());
        names.visit_expr(&closure.body);
        let mut captured = Scope::new();
        let mut size = 1;
        for name in names.0 {
            if let Some(value) = self.frame.variable(&name) {
                size += value.entries();
                captured.insert(name, value.clone());
            }
        }
        self.work(size, closure)?;
        Some(Value::Closure(Rc::new(Closure {
            syntax: closure.clone(),
            captured,
            is_broken: Cell::new(false),
        })))
    }

    /// Calls a closure that a variable holds.
    pub(super) fn call_closure(
        &mut self,
        closure: &Closure,
        arguments: Vec<Argument>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let size = closure.captured.values().map(Value::entries);
        let size = size.sum::<usize>();
        if closure.is_broken.get() {
            return None;
        }
        self.work(size, at)?;
        self.check_arity(&closure.syntax, &arguments, at)?;
        let mistakes = self.errors.count();
        let value = self.in_frame(closure.captured.clone(), |this| {
            this.closure(&closure.syntax, arguments)
        });
        closure.is_broken.set(self.errors.count() > mistakes);
        value
    }

    /// Executes a closure that is written where it is called.
    pub(super) fn closure(
        &mut self,
        closure: &ExprClosure,
        arguments: Vec<Argument>,
    ) -> Option<Value> {
        self.check_arity(closure, &arguments, closure)?;
        let scopes = self.frame.scopes.len();
        let floor = std::mem::replace(&mut self.frame.floor, scopes);
        let value = self.scoped(|this| {
            for (pattern, argument) in closure.inputs.iter().zip(arguments) {
                let value = this.passed(argument, pattern, &closure.body);
                this.bind(pattern, value);
            }
            this.eval(&closure.body)
        });
        self.frame.floor = floor;
        value
    }

    /// Returns the value of an argument as the parameter of a closure.
    fn passed(&mut self, argument: Argument, parameter: &Pat, body: &syn::Expr) -> Value {
        let Pat::Type(typed) = parameter else {
            return Self::as_index(argument.value, parameter, body);
        };
        let is_reference = matches!(argument.value, Value::Place(_));
        match mutable(&typed.ty).filter(|_| !is_reference) {
            Some(word) => {
                let message = "`&mut` is not understood: a closure returns what it computes";
                self.errors.push(word, message);
                Value::Poison
            }
            None => self.number(argument.value, &typed.ty, &argument.at),
        }
    }

    /// Reports an error at `at` if the number of arguments differs from the number of the closure's
    /// parameters.
    fn check_arity(
        &mut self,
        closure: &ExprClosure,
        arguments: &[Argument],
        at: &impl Spanned,
    ) -> Option<()> {
        if closure.inputs.len() == arguments.len() {
            return Some(());
        }
        let message = wrong_arity("this closure", closure.inputs.len(), arguments.len());
        self.refuse(at, message)
    }
}

/// The names in an expression.
struct Names(Vec<String>);

impl<'ast> Visit<'ast> for Names {
    fn visit_ident(&mut self, ident: &'ast Ident) {
        self.0.push(ident.to_string());
    }
}

//! Expressions of a body: numbers, names, arrays; and the messages for expressions that are not understood.

use syn::spanned::Spanned;
use syn::{Expr as Syntax, Lit};

use super::Lowering;
use super::branches::LoopExit;
use super::constants::is_constant_name;
use super::fields::FieldPath;
use super::integers::Kind;
use super::value::Value;
use crate::errors::nearest;

/// Largest depth of nested expressions in the source.
const DEPTH: usize = 200;

impl Lowering<'_> {
    /// Reports a mistake and returns a poisoned value.
    pub(super) fn refuse(&mut self, at: &impl Spanned, message: impl std::fmt::Display) -> Value {
        self.errors.push(at.span(), message);
        Value::Poison
    }

    /// Evaluates an expression.
    pub(super) fn eval(&mut self, expr: &Syntax) -> Value {
        if !self.tick(expr) {
            return Value::Poison;
        }
        let value = self
            .deeper(expr, |this| this.eval_inner(expr))
            .unwrap_or(Value::Poison);
        let value = self.read_through(value);
        self.typed(value)
    }

    /// Calls `run` one level of nesting deeper, or reports that the nesting is too deep.
    pub(super) fn deeper<T>(
        &mut self,
        at: &impl Spanned,
        run: impl FnOnce(&mut Self) -> T,
    ) -> Option<T> {
        if self.depth >= DEPTH {
            let message = format!(
                "this expression is nested more than {DEPTH} deep: name parts of it with `let`"
            );
            self.refuse(at, message);
            return None;
        }
        self.depth += 1;
        let value = run(self);
        self.depth -= 1;
        Some(value)
    }

    fn eval_inner(&mut self, expr: &Syntax) -> Value {
        match expr {
            Syntax::Lit(literal) => self.literal(&literal.lit),
            Syntax::Paren(inner) => self.eval(&inner.expr),
            Syntax::Group(inner) => self.eval(&inner.expr),
            Syntax::Reference(reference) if reference.mutability.is_none() => {
                self.eval(&reference.expr)
            }
            Syntax::Path(path) => self.path(path),
            Syntax::Unary(unary) => self.unary(unary),
            Syntax::Binary(binary) => self.binary(binary),
            Syntax::Index(index) => match &*index.index {
                Syntax::Range(range) => self.slice(&index.expr, range),
                _ => self.entry(expr),
            },
            Syntax::Field(_) => self.entry(expr),
            Syntax::Range(range) => self.range(range),
            Syntax::If(branch) => self.branch(branch),
            Syntax::Continue(e) if e.label.is_none() => self.leave(LoopExit::Continue),
            Syntax::Break(e) if e.label.is_none() && e.expr.is_none() => {
                self.leave(LoopExit::Break)
            }
            Syntax::Cast(cast) => self.cast(cast),
            Syntax::Array(array) => {
                Value::Array(array.elems.iter().map(|e| self.eval(e)).collect())
            }
            Syntax::Tuple(tuple) if tuple.elems.is_empty() => Value::Unit,
            Syntax::Tuple(tuple) => {
                Value::Tuple(tuple.elems.iter().map(|e| self.eval(e)).collect())
            }
            Syntax::Repeat(repeat) => self.repeat(repeat),
            Syntax::Block(block) if block.label.is_none() => self.block_value(&block.block),
            Syntax::ForLoop(for_loop) => self.for_loop(for_loop),
            Syntax::Assign(assign) => {
                let value = self.eval(&assign.right);
                self.store(&assign.left, value);
                Value::Unit
            }
            Syntax::Closure(closure) => self.capture(closure),
            Syntax::Call(call) => self.call(call),
            Syntax::MethodCall(call) => self.method_call(call),
            other => {
                let (at, message) = refusal(other);
                self.refuse(&at, message)
            }
        }
    }

    fn literal(&mut self, literal: &Lit) -> Value {
        match literal {
            Lit::Float(float) if matches!(float.suffix(), "" | "f64") => {
                match float.base10_parse::<f64>() {
                    Ok(value) if value.is_finite() => Value::Scalar(self.arena.constant(value)),
                    _ => self.refuse(literal, "this number does not fit into an `f64`"),
                }
            }
            Lit::Int(int) if int.suffix() == "f64" => match int.base10_parse::<f64>() {
                Ok(value) => Value::Scalar(self.arena.constant(value)),
                Err(_) => self.refuse(literal, "this number does not fit into an `f64`"),
            },
            Lit::Int(int) => match int.base10_parse::<i64>() {
                Ok(value) => {
                    let kind = Kind::named(int.suffix());
                    self.typed_literal(value, kind, literal)
                }
                Err(_) => self.refuse(literal, "this integer is too large"),
            },
            Lit::Float(_) => self.refuse(
                literal,
                "every number of a body is an `f64`: leave out the suffix",
            ),
            _ => self.refuse(literal, "only numbers have a place here"),
        }
    }

    fn path(&mut self, expr: &syn::ExprPath) -> Value {
        let path = &expr.path;
        if let Some(ident) = path.get_ident() {
            let name = ident.to_string();
            if name == "self" {
                return Value::Field(FieldPath::new());
            }
            if let Some(value) = self.variable(&name) {
                let (size, value) = (value.entries(), value.clone());
                return if self.work(size, expr) {
                    value
                } else {
                    Value::Poison
                };
            }
            if self.constant_named(&name).is_some() {
                return self.refuse(
                    expr,
                    format!("a constant of this block is written `Self::{name}`"),
                );
            }
            if is_constant_name(&name) {
                return Value::Field(FieldPath::outside(path.clone()));
            }
            let message = self.unknown(&name);
            return self.refuse(expr, message);
        }
        self.long_path(expr)
    }

    /// Returns the message for a name that is not a variable.
    fn unknown(&self, name: &str) -> String {
        let mut known: Vec<&str> = self
            .scopes
            .iter()
            .flat_map(|scope| scope.keys().map(String::as_str))
            .collect();
        known.sort_unstable();
        match nearest(name, known) {
            Some(near) => format!("`{name}` is not known here; did you mean `{near}`?"),
            None => format!(
                "`{name}` is not known here: a parameter is a field of the struct, written `self.{name}`; a constant is written in capitals"
            ),
        }
    }

    fn repeat(&mut self, repeat: &syn::ExprRepeat) -> Value {
        let value = self.eval(&repeat.expr);
        let Some(n) = self.index_value(&repeat.len) else {
            return Value::Poison;
        };
        let size = n.saturating_mul(value.entries());
        if size > super::STEPS / 20 {
            return self.refuse(
                &repeat.len,
                format!(
                    "an array of {size} numbers is too large to unroll; the limit is {}",
                    super::STEPS / 20
                ),
            );
        }
        if !self.work(size, &repeat.len) {
            return Value::Poison;
        }
        Value::Array(vec![value; n])
    }
}

/// Returns the message for a macro call.
pub(super) fn no_macro(path: &syn::Path) -> &'static str {
    let name = path.segments.last().map(|s| s.ident.to_string());
    match name.as_deref() {
        Some(
            "assert" | "assert_eq" | "assert_ne" | "debug_assert" | "debug_assert_eq"
            | "debug_assert_ne",
        ) => "a step is not derived from assertions: check parameters where the system is made",
        Some("print" | "println" | "eprint" | "eprintln" | "dbg") => {
            "a step does not print: leave this out, and print the states of a trajectory"
        }
        _ => "a macro call cannot be differentiated: write the formula",
    }
}

/// Returns the message for syntax outside the language, and the token at which it is reported.
fn refusal(expr: &Syntax) -> (proc_macro2::Span, &'static str) {
    match expr {
        Syntax::Match(e) => (
            e.match_token.span,
            "`match` is not smooth: a Lagrangian is one formula everywhere; on an index write `if i == 0 { … } else { … }`",
        ),
        Syntax::While(e) => (
            e.while_token.span,
            "the rounds of `while` are not known at compile time: write `for i in A..B`",
        ),
        Syntax::Loop(e) => (
            e.loop_token.span,
            "the rounds of `loop` are not known at compile time: write `for i in A..B`",
        ),
        Syntax::Macro(e) => (e.mac.path.span(), no_macro(&e.mac.path)),
        Syntax::Return(e) => (
            e.return_token.span,
            "`return` is not needed: end the body with the value",
        ),
        Syntax::Break(e) => (
            e.break_token.span,
            "`break` with a label or a value is not understood: shorten the loop's range",
        ),
        Syntax::Continue(e) => (
            e.continue_token.span,
            "`continue` with a label is not understood: write a condition on the indices around the rest",
        ),
        Syntax::Unsafe(e) => (e.unsafe_token.span, "`unsafe` has no place in a formula"),
        Syntax::Try(e) => (
            e.question_token.span,
            "`?` leaves the function early: a body is straight-line code, leave it out",
        ),
        Syntax::Struct(e) => (
            e.path.span(),
            "structures are not understood here: use arrays and tuples, `(a, b)`",
        ),
        Syntax::Reference(e) => (
            e.and_token.span,
            "`&mut` is not understood: a helper returns what it computes",
        ),
        other => (
            other.span(),
            "this expression is not understood: a body is made of `let`, arithmetic, arrays, `for` over constant bounds, helpers of this block and smooth `f64` functions",
        ),
    }
}

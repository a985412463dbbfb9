//! Expressions of a body: numbers, names and arrays, and the messages for expressions that are not
//! understood.

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
    /// Evaluates an expression. After a mistake, the value is poisoned.
    pub(super) fn value(&mut self, expr: &Syntax) -> Value {
        self.eval(expr).unwrap_or(Value::Poison)
    }

    fn values<'e>(&mut self, exprs: impl IntoIterator<Item = &'e Syntax>) -> Vec<Value> {
        exprs.into_iter().map(|expr| self.value(expr)).collect()
    }

    /// Evaluates an expression. Returns `None` after a mistake, which has been reported.
    pub(super) fn eval(&mut self, expr: &Syntax) -> Option<Value> {
        self.tick(expr)?;
        let value = self.deeper(expr, |this| this.eval_inner(expr))?;
        let value = self.frame.read_through(value?);
        let value = self.fields.typed(value);
        match self.known_integer(value) {
            Value::Poison => None,
            value => Some(value),
        }
    }

    /// Calls `run` one level of nesting deeper, or reports that the nesting is too deep.
    pub(super) fn deeper<T>(
        &mut self,
        at: &impl Spanned,
        run: impl FnOnce(&mut Self) -> T,
    ) -> Option<T> {
        if self.limits.depth >= DEPTH {
            let message = format!(
                "this expression is nested more than {DEPTH} deep: name parts of it with `let`"
            );
            return self.refuse(at, message);
        }
        self.limits.depth += 1;
        let value = run(self);
        self.limits.depth -= 1;
        Some(value)
    }

    fn eval_inner(&mut self, expr: &Syntax) -> Option<Value> {
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
            Syntax::Continue(e) if e.label.is_none() => self.leave(LoopExit::Continue, expr),
            Syntax::Break(e) if e.label.is_none() && e.expr.is_none() => {
                self.leave(LoopExit::Break, expr)
            }
            Syntax::Cast(cast) => self.cast(cast),
            Syntax::Array(array) => Some(Value::Array(self.values(&array.elems))),
            Syntax::Tuple(tuple) if tuple.elems.is_empty() => Some(Value::Unit),
            Syntax::Tuple(tuple) => Some(Value::Tuple(self.values(&tuple.elems))),
            Syntax::Repeat(repeat) => self.repeat(repeat),
            Syntax::Block(block) if block.label.is_none() => self.block_value(&block.block),
            Syntax::ForLoop(for_loop) => self.for_loop(for_loop),
            Syntax::Assign(assign) => {
                let value = self.value(&assign.right);
                self.store(&assign.left, value);
                Some(Value::Unit)
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

    fn literal(&mut self, literal: &Lit) -> Option<Value> {
        let value = match literal {
            Lit::Float(float) if matches!(float.suffix(), "" | "f64") => float.base10_parse(),
            Lit::Int(int) if int.suffix() == "f64" => int.base10_parse(),
            Lit::Int(int) => {
                return match int.base10_parse::<i64>() {
                    Ok(value) => self.typed_literal(value, Kind::named(int.suffix()), literal),
                    Err(_) => self.refuse(literal, "this integer is too large"),
                };
            }
            Lit::Float(_) => {
                let message = "every number of a body is an `f64`: leave out the suffix";
                return self.refuse(literal, message);
            }
            _ => return self.refuse(literal, "only numbers have a place here"),
        };
        match value {
            Ok(value) if f64::is_finite(value) => Some(self.constant(value)),
            _ => self.refuse(literal, "this number does not fit into an `f64`"),
        }
    }

    fn path(&mut self, expr: &syn::ExprPath) -> Option<Value> {
        let path = &expr.path;
        let Some(ident) = path.get_ident() else {
            return self.long_path(expr);
        };
        let name = ident.to_string();
        if name == "self" {
            return Some(Value::Field(FieldPath::default()));
        }
        if let Some(value) = self.frame.variable(&name) {
            let (size, value) = (value.entries(), value.clone());
            self.work(size, expr)?;
            return Some(value);
        }
        if self.constant_named(&name).is_some() {
            let message = format!("a constant of this block is written `Self::{name}`");
            return self.refuse(expr, message);
        }
        if is_constant_name(&name) {
            return Some(Value::Field(FieldPath::outside(path.clone())));
        }
        let message = self.unknown(&name);
        self.refuse(expr, message)
    }

    /// Returns the message for a name that is not a variable.
    fn unknown(&self, name: &str) -> String {
        let scopes = self.frame.scopes.iter();
        let mut known: Vec<&str> = scopes
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

    fn repeat(&mut self, repeat: &syn::ExprRepeat) -> Option<Value> {
        let value = self.value(&repeat.expr);
        let n = self.index_value(&repeat.len)?;
        let size = n.saturating_mul(value.entries());
        let limit = super::STEPS / 20;
        if size > limit {
            let message =
                format!("an array of {size} numbers is too large to unroll; the limit is {limit}");
            return self.refuse(&repeat.len, message);
        }
        self.work(size, &repeat.len)?;
        Some(Value::Array(vec![value; n]))
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

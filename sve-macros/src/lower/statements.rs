//! Statements of a body: blocks, `let`, loops, assignments.

use std::collections::HashMap;

use syn::{Block, Expr as Syntax, ExprForLoop, RangeLimits, Stmt};

use super::Lowering;
use super::value::Value;

impl Lowering<'_> {
    /// Runs a block in a scope of its own; the value of its last expression.
    pub(super) fn block_value(&mut self, block: &Block) -> Value {
        self.scopes.push(HashMap::new());
        let mut last = Value::Unit;
        for statement in &block.stmts {
            if !self.tick(statement) {
                last = Value::Poison;
                break;
            }
            last = self.statement(statement);
        }
        self.scopes.pop();
        last
    }

    fn statement(&mut self, statement: &Stmt) -> Value {
        match statement {
            Stmt::Local(local) => {
                let value = match &local.init {
                    Some(init) if init.diverge.is_none() => self.eval(&init.expr),
                    Some(_) => self.refuse(local, "`let … else` branches: a body is straight-line code"),
                    None => self.refuse(local, "give this variable a value where it is declared, as in `let mut x = 0.0;`"),
                };
                self.bind(&local.pat, value);
                Value::Unit
            }
            Stmt::Expr(expr, semicolon) => {
                let value = self.eval(expr);
                match (semicolon, value) {
                    (_, Value::Poison) => Value::Poison,
                    (None, value) => value,
                    (Some(_), _) => Value::Unit,
                }
            }
            Stmt::Item(item) => self.refuse(item, "items inside a body are not seen: make it a function or constant of this `impl` block"),
            Stmt::Macro(mac) => self.refuse(&mac.mac.path, "a macro call cannot be differentiated: write the formula"),
        }
    }

    pub(super) fn for_loop(&mut self, for_loop: &ExprForLoop) -> Value {
        let items = match &*for_loop.expr {
            Syntax::Range(range) => self.range(range),
            other => match self.eval(other) {
                Value::Array(values) => Some(values),
                Value::Poison => None,
                value => {
                    let message = format!(
                        "a loop runs over a range `A..B` with bounds known at compile time or over an array, and this is {}",
                        value.kind()
                    );
                    self.refuse(other, message);
                    None
                }
            },
        };
        let Some(items) = items else {
            return Value::Poison;
        };
        let mistakes = self.errors.count();
        for item in items {
            if !self.tick(&for_loop.for_token) {
                return Value::Poison;
            }
            self.scopes.push(HashMap::new());
            self.bind(&for_loop.pat, item);
            self.block_value(&for_loop.body);
            self.scopes.pop();
            if self.errors.count() > mistakes {
                // the same mistake in the next round would be the same error
                return Value::Poison;
            }
        }
        Value::Unit
    }

    fn range(&mut self, range: &syn::ExprRange) -> Option<Vec<Value>> {
        let (Some(start), Some(end)) = (&range.start, &range.end) else {
            self.refuse(range, "a loop needs both bounds: `A..B`");
            return None;
        };
        let (from, to) = (self.eval(start), self.eval(end));
        match (from, to) {
            (Value::Int(from), Value::Int(to)) => {
                let to = match range.limits {
                    RangeLimits::HalfOpen(_) => to,
                    RangeLimits::Closed(_) => to.saturating_add(1),
                };
                if to.saturating_sub(from) > super::STEPS as i64 {
                    self.refuse(
                        range,
                        format!(
                            "this loop has {} rounds, too many to unroll; the limit is {}",
                            to.saturating_sub(from),
                            super::STEPS
                        ),
                    );
                    return None;
                }
                Some((from..to).map(Value::Int).collect())
            }
            (Value::Poison, _) | (_, Value::Poison) => None,
            (Value::Int(_), other) => {
                let message = format!(
                    "the bounds of a loop must be known at compile time (a literal, `q.len()`, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(end, message);
                None
            }
            (other, _) => {
                let message = format!(
                    "the bounds of a loop must be known at compile time (a literal, a constant of this block), and this is {}",
                    other.kind()
                );
                self.refuse(start, message);
                None
            }
        }
    }
}

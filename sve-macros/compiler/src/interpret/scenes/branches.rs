//! Branches that are kept: an `if` whose condition is known when the program runs.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::visit::Visit;

use super::Lowering;
use super::assigned::assigned;
use super::kept::Nest;
use crate::interpret::branches::Truth;
use crate::interpret::value::Value;
use crate::model::scene::{Condition, Head};

impl Lowering<'_> {
    /// Executes `if` with a condition that is known when the program runs.
    pub(in crate::interpret) fn kept_branch(
        &mut self,
        branch: &syn::ExprIf,
        condition: Condition,
    ) -> Option<Value> {
        let holds = Truth::Running(condition);
        let fails = holds.clone().not();
        let at = branch.if_token.span;
        let names = assigned(|names| names.visit_block(&branch.then_branch));
        let (then, rest) = self.part(&holds, at, &names, |x| x.block_value(&branch.then_branch));
        let (other, other_rest) = match &branch.else_branch {
            Some((_, other)) => {
                let names = assigned(|names| names.visit_expr(other));
                self.part(&fails, at, &names, |x| x.eval(other))
            }
            None => (Some(Value::Unit), Truth::Known(true)),
        };
        let skips = [&rest, &other_rest].map(|rest| matches!(rest, Truth::Known(false)));
        if !matches!(
            (&rest, &other_rest),
            (Truth::Known(true), Truth::Known(true))
        ) {
            self.scene.rest = holds.and(rest).or(fails.and(other_rest));
        }
        match (then?, other?, skips) {
            (_, value, [true, false]) | (value, _, [false, true]) => Some(value),
            (Value::Unit, ..) | (_, Value::Unit, _) => Some(Value::Unit),
            (then, other, _) => self.leaves([&then, &then, &other], &mut |x, [then, _, other]| {
                x.either(then, other, at)
            }),
        }
    }

    /// Returns the value of an `if` from the values of its parts.
    fn either(&mut self, then: &Value, other: &Value, at: Span) -> Option<Value> {
        let is_integer = |value: &Value| matches!(value, Value::Int(_) | Value::Index(_));
        if is_integer(then) || is_integer(other) {
            let integers = self.running(then).zip(self.running(other));
            return match integers {
                Some((then, other)) if then == other => Some(self.index_value_of(then)),
                _ => self.refuse(
                    &at,
                    "an integer cannot depend on a condition known when the program runs: compute it, on a ring with `%`, as in `(i + 1) % n`",
                ),
            };
        }
        let (then, other) = (self.scalar(then, &at)?, self.scalar(other, &at)?);
        Some(Value::Scalar(self.arena.add(then, other)))
    }

    /// Executes a part of a branch. Also returns whether the rest of the loop's body is executed
    /// after it.
    fn part(
        &mut self,
        condition: &Truth,
        at: Span,
        names: &[(String, Span)],
        run: impl FnOnce(&mut Self) -> Option<Value>,
    ) -> (Option<Value>, Truth) {
        let Truth::Running(condition) = condition else {
            return (None, Truth::Known(true));
        };
        let head = Head::If(condition.clone());
        let mut rest = Truth::Known(true);
        let value = self.kept(Nest::Branch, &head, at, names, |x| {
            let value = run(x);
            rest = std::mem::take(&mut x.scene.rest);
            if x.leaving.take().is_some() {
                rest = Truth::Known(false);
                return Some(Value::Unit);
            }
            value
        });
        (value, rest)
    }

    /// Executes the rest of a block after a branch with `continue`.
    pub(in crate::interpret) fn rest_of_block(
        &mut self,
        statements: &[syn::Stmt],
        rest: Truth,
        run: impl FnOnce(&mut Self) -> Option<Value>,
    ) {
        let mut all = rest.clone();
        if let (Truth::Running(_), Some(first)) = (&rest, statements.first()) {
            let at = first.span();
            let names = assigned(|names| {
                for statement in statements {
                    names.visit_stmt(statement);
                }
            });
            let (_, inner) = self.part(&rest, at, &names, |x| {
                run(x);
                Some(Value::Unit)
            });
            all = rest.and(inner);
        }
        self.scene.rest = all;
    }
}

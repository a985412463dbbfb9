//! Control flow that is decided at compile time: `if` on integers, `continue` and `break`. In a
//! scene a condition may also be decided when the program runs.
//!
//! Outside of kept loops a condition on a coordinate or parameter is refused, since a Lagrangian is
//! one formula everywhere.

use syn::{BinOp, Expr as Syntax, Lit, UnOp};

use super::Lowering;
use super::scenes::Nest;
use super::value::Value;
use crate::model::scene::{Comparison, Condition, Int};

/// The value of a condition.
#[derive(Clone)]
pub(super) enum Truth {
    Known(bool),
    /// The condition is decided when the program runs.
    Running(Condition),
}

impl Default for Truth {
    fn default() -> Self {
        Self::Known(true)
    }
}

impl Truth {
    pub(super) fn not(self) -> Self {
        match self {
            Self::Known(holds) => Self::Known(!holds),
            Self::Running(Condition::Not(inner)) => Self::Running(*inner),
            Self::Running(condition) => Self::Running(Condition::Not(condition.into())),
        }
    }

    pub(super) fn and(self, other: Self) -> Self {
        match (self, other) {
            (Self::Known(true), other) | (other, Self::Known(true)) => other,
            (Self::Known(false), _) | (_, Self::Known(false)) => Self::Known(false),
            (Self::Running(a), Self::Running(b)) => {
                Self::Running(Condition::And(a.into(), b.into()))
            }
        }
    }

    pub(super) fn or(self, other: Self) -> Self {
        match (self, other) {
            (Self::Known(false), other) | (other, Self::Known(false)) => other,
            (Self::Known(true), _) | (_, Self::Known(true)) => Self::Known(true),
            (Self::Running(a), Self::Running(b)) => {
                Self::Running(Condition::Or(a.into(), b.into()))
            }
        }
    }
}

/// The reason why a condition has no value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Undecided {
    /// The condition depends on a value that is not known at compile time.
    Unknown,
    /// A mistake in the condition has been reported.
    Reported,
}

/// The statement that ends an iteration of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LoopExit {
    Continue,
    Break,
}

impl Lowering<'_> {
    pub(super) fn branch(&mut self, branch: &syn::ExprIf) -> Option<Value> {
        match self.decide(&branch.cond) {
            Ok(Truth::Known(true)) => self.block_value(&branch.then_branch),
            Ok(Truth::Running(condition)) => self.kept_branch(branch, condition),
            Ok(Truth::Known(false)) => match &branch.else_branch {
                Some((_, other)) => self.eval(other),
                None => Some(Value::Unit),
            },
            Err(Undecided::Reported) => None,
            Err(Undecided::Unknown) => self.refuse(
                &branch.if_token,
                "`if` on a number is not smooth: a Lagrangian is one formula everywhere; use a smooth transition such as `tanh` (conditions on indices, `if i != j`, are understood); for variants of a system write a type each",
            ),
        }
    }

    /// Evaluates a condition.
    pub(super) fn decide(&mut self, condition: &Syntax) -> Result<Truth, Undecided> {
        self.tick(condition).ok_or(Undecided::Reported)?;
        match condition {
            Syntax::Paren(inner) => self.decide_deeper(&inner.expr),
            Syntax::Group(inner) => self.decide_deeper(&inner.expr),
            Syntax::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
                self.decide_deeper(&unary.expr).map(Truth::not)
            }
            Syntax::Lit(literal) => match &literal.lit {
                Lit::Bool(value) => Ok(Truth::Known(value.value)),
                _ => Err(Undecided::Unknown),
            },
            Syntax::Binary(binary) => match binary.op {
                BinOp::And(_) => match self.decide_deeper(&binary.left)? {
                    Truth::Known(false) => Ok(Truth::Known(false)),
                    left => Ok(left.and(self.decide_deeper(&binary.right)?)),
                },
                BinOp::Or(_) => match self.decide_deeper(&binary.left)? {
                    Truth::Known(true) => Ok(Truth::Known(true)),
                    left => Ok(left.or(self.decide_deeper(&binary.right)?)),
                },
                _ => self.compare(binary),
            },
            Syntax::MethodCall(call) if call.method == "is_empty" && self.scene.is_scene() => {
                let value = self.value(&call.receiver);
                let stream = self.stream(&value).ok_or(Undecided::Unknown)?;
                Ok(self.is_empty(&stream))
            }
            _ => Err(Undecided::Unknown),
        }
    }

    fn decide_deeper(&mut self, condition: &Syntax) -> Result<Truth, Undecided> {
        self.deeper(condition, |this| this.decide(condition))
            .unwrap_or(Err(Undecided::Reported))
    }

    fn compare(&mut self, binary: &syn::ExprBinary) -> Result<Truth, Undecided> {
        let (left, right) = (self.value(&binary.left), self.value(&binary.right));
        match (&left, &right) {
            // the other operand is a number, so the poisoned one was a number too, and such a
            // condition is reported anyway
            (Value::Poison, Value::Scalar(_) | Value::Field(_))
            | (Value::Scalar(_) | Value::Field(_), Value::Poison)
                if !self.scene.is_scene() =>
            {
                return Err(Undecided::Unknown);
            }
            (Value::Poison, _) | (_, Value::Poison) => return Err(Undecided::Reported),
            _ => {}
        }
        let Some((comparison, is_swapped, is_negated)) = comparison(&binary.op) else {
            return Err(Undecided::Unknown);
        };
        let (a, b) = if is_swapped {
            (&right, &left)
        } else {
            (&left, &right)
        };
        let truth = if let (Value::Int(a), Value::Int(b)) = (a, b) {
            Truth::Known(comparison.holds(&a.value, &b.value))
        } else if let Some((a, b)) = self.integers_compared(comparison, a, b) {
            self.compared(comparison, a, b)
        } else if self.scene.is_in_kept_loop() {
            let [a, b] = [a, b].map(|number| self.scalar(number, binary));
            let (a, b) = a.zip(b).ok_or(Undecided::Reported)?;
            Truth::Running(Condition::Numbers(comparison, a, b))
        } else {
            return Err(Undecided::Unknown);
        };
        Ok(if is_negated { truth.not() } else { truth })
    }

    /// Returns the operands of a comparison of integers; `None` for numbers. Two fields whose type
    /// no other use shows are integers if they are compared with `==` or `!=`.
    fn integers_compared(
        &mut self,
        comparison: Comparison,
        a: &Value,
        b: &Value,
    ) -> Option<(Int, Int)> {
        match (comparison, a, b) {
            (Comparison::Equal, Value::Field(_), Value::Field(_)) => {
                self.running(a).zip(self.running(b))
            }
            _ => self.running_pair(a, b),
        }
    }

    /// Compares integers.
    pub(super) fn compared(&mut self, comparison: Comparison, a: Int, b: Int) -> Truth {
        let integers = &self.scene.integers;
        match (integers.value(a), integers.value(b)) {
            (Some(a), Some(b)) => Truth::Known(comparison.holds(&a, &b)),
            _ => Truth::Running(Condition::Integers(comparison, a, b)),
        }
    }

    /// Executes `continue` or `break`: the rest of the loop's body is skipped.
    pub(super) fn leave(&mut self, exit: LoopExit, at: &Syntax) -> Option<Value> {
        if exit == LoopExit::Break && matches!(self.scene.nest(), Some(Nest::Kept | Nest::Branch)) {
            return self.refuse(
                at,
                "a kept loop adds all its terms, so it has no `break`: shorten its range, or skip terms with `continue`",
            );
        }
        self.leaving = Some(exit);
        None
    }
}

/// Returns a comparison, whether its operands are exchanged, and whether it is negated.
fn comparison(op: &BinOp) -> Option<(Comparison, bool, bool)> {
    Some(match op {
        BinOp::Eq(_) => (Comparison::Equal, false, false),
        BinOp::Ne(_) => (Comparison::Equal, false, true),
        BinOp::Lt(_) => (Comparison::Less, false, false),
        BinOp::Gt(_) => (Comparison::Less, true, false),
        BinOp::Le(_) => (Comparison::LessOrEqual, false, false),
        BinOp::Ge(_) => (Comparison::LessOrEqual, true, false),
        _ => return None,
    })
}

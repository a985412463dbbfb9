//! Control flow that is decided at compile time: `if` on integers, `continue` and `break`.
//!
//! A condition on a coordinate or parameter is refused, since a Lagrangian is one formula
//! everywhere.

use syn::{BinOp, Expr as Syntax, Lit, UnOp};

use super::Lowering;
use super::value::Value;

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
            Ok(true) => self.block_value(&branch.then_branch),
            Ok(false) => match &branch.else_branch {
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

    /// Evaluates a condition on integers.
    pub(super) fn decide(&mut self, condition: &Syntax) -> Result<bool, Undecided> {
        self.tick(condition).ok_or(Undecided::Reported)?;
        match condition {
            Syntax::Paren(inner) => self.decide_deeper(&inner.expr),
            Syntax::Group(inner) => self.decide_deeper(&inner.expr),
            Syntax::Unary(unary) if matches!(unary.op, UnOp::Not(_)) => {
                self.decide_deeper(&unary.expr).map(|holds| !holds)
            }
            Syntax::Lit(literal) => match &literal.lit {
                Lit::Bool(value) => Ok(value.value),
                _ => Err(Undecided::Unknown),
            },
            Syntax::Binary(binary) => match binary.op {
                BinOp::And(_) => {
                    Ok(self.decide_deeper(&binary.left)? && self.decide_deeper(&binary.right)?)
                }
                BinOp::Or(_) => {
                    Ok(self.decide_deeper(&binary.left)? || self.decide_deeper(&binary.right)?)
                }
                _ => self.compare(binary),
            },
            _ => Err(Undecided::Unknown),
        }
    }

    fn decide_deeper(&mut self, condition: &Syntax) -> Result<bool, Undecided> {
        self.deeper(condition, |this| this.decide(condition))
            .unwrap_or(Err(Undecided::Reported))
    }

    fn compare(&mut self, binary: &syn::ExprBinary) -> Result<bool, Undecided> {
        let (left, right) = (self.value(&binary.left), self.value(&binary.right));
        let (a, b) = match (left, right) {
            (Value::Int(a), Value::Int(b)) => (a.value, b.value),
            // the other operand is a number, so the poisoned one was a number too, and such a
            // condition is reported anyway
            (Value::Poison, Value::Scalar(_) | Value::Field(_))
            | (Value::Scalar(_) | Value::Field(_), Value::Poison) => {
                return Err(Undecided::Unknown);
            }
            (Value::Poison, _) | (_, Value::Poison) => return Err(Undecided::Reported),
            _ => return Err(Undecided::Unknown),
        };
        match binary.op {
            BinOp::Eq(_) => Ok(a == b),
            BinOp::Ne(_) => Ok(a != b),
            BinOp::Lt(_) => Ok(a < b),
            BinOp::Le(_) => Ok(a <= b),
            BinOp::Gt(_) => Ok(a > b),
            BinOp::Ge(_) => Ok(a >= b),
            _ => Err(Undecided::Unknown),
        }
    }

    /// Executes `continue` or `break`: the rest of the loop's body is skipped.
    pub(super) fn leave(&mut self, exit: LoopExit) -> Option<Value> {
        self.leaving = Some(exit);
        None
    }
}

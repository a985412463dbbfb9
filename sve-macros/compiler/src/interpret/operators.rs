//! Operators of numbers, and the messages for operators that are not arithmetic.

use syn::{BinOp, Expr as Syntax, UnOp};

use super::Lowering;
use super::value::Value;
use crate::algebra::Expr;

impl Lowering<'_> {
    pub(super) fn unary(&mut self, unary: &syn::ExprUnary) -> Value {
        let value = self.eval(&unary.expr);
        match (&unary.op, value) {
            (_, Value::Poison) => Value::Poison,
            (UnOp::Neg(op), Value::Int(i)) => self.negated(i, op),
            (UnOp::Neg(op), Value::Matrix(matrix)) => self.negative(&matrix, op),
            (UnOp::Neg(_), value) => match self.operand(&value, &unary.expr) {
                Some(x) => Value::Scalar(self.arena.neg(x)),
                None => Value::Poison,
            },
            (UnOp::Deref(_), value) => value,
            (op, _) => self.refuse(
                op,
                "`!` is for conditions on indices, `if !(i == j)`: it has no derivative",
            ),
        }
    }

    pub(super) fn binary(&mut self, binary: &syn::ExprBinary) -> Value {
        if let Some(op) = compound(&binary.op) {
            let left = self.eval(&binary.left);
            let right = self.eval(&binary.right);
            let value = self.arithmetic(
                op,
                &binary.op,
                (&left, &binary.left),
                (&right, &binary.right),
            );
            self.store(&binary.left, value);
            return Value::Unit;
        }
        // a long sum is a tree that is deep on the left, so this loop replaces the recursion
        let mut spine = Vec::new();
        let mut innermost = binary;
        while let Some(op) = plain(&innermost.op) {
            spine.push((op, innermost));
            match &*innermost.left {
                Syntax::Binary(left) if plain(&left.op).is_some() => innermost = left,
                _ => break,
            }
        }
        if spine.is_empty() {
            // reports the mistakes in the operands
            self.eval(&binary.left);
            self.eval(&binary.right);
            return self.refuse(&binary.op, no_derivative(&binary.op));
        }
        let mut value = self.eval(&innermost.left);
        for (op, outer) in spine.into_iter().rev() {
            let right = self.eval(&outer.right);
            value = self.arithmetic(op, &outer.op, (&value, &outer.left), (&right, &outer.right));
        }
        value
    }

    fn arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        left: (&Value, &Syntax),
        right: (&Value, &Syntax),
    ) -> Value {
        if let Some(value) = self.matrix_arithmetic(op, token, left, right) {
            return value;
        }
        if let (Value::Int(a), Value::Int(b)) = (left.0, right.0) {
            return self.integer_arithmetic(op, token, *a, *b);
        }
        if let (Value::Poison, Value::Int(_)) | (Value::Int(_), Value::Poison) = (left.0, right.0) {
            // the poisoned operand may have been an integer, so the other operand is not wrong
            return Value::Poison;
        }
        let a = self.operand(left.0, left.1);
        let b = self.operand(right.0, right.1);
        let (Some(a), Some(b)) = (a, b) else {
            return Value::Poison;
        };
        let value = match op {
            '+' => self.arena.add(a, b),
            '-' => self.arena.sub(a, b),
            '*' => self.arena.mul(a, b),
            '%' => return self.refuse(token, REMAINDER),
            _ => {
                if self.arena.constant_value(b) == Some(0.0) {
                    return self.refuse(right.1, DIVISION_BY_ZERO);
                }
                self.arena.div(a, b)
            }
        };
        if self.arena.is_finite(value) {
            Value::Scalar(value)
        } else {
            self.refuse(token, "the constants here overflow an `f64`")
        }
    }

    /// Returns the number of an operand, or reports an error that says how to write the operand as a number.
    pub(super) fn operand(&mut self, value: &Value, syntax: &Syntax) -> Option<Expr> {
        if let Value::Field(path) = value {
            self.taken_for_number = Some(path.clone());
        }
        if let (Value::Int(_), Some(message)) = (value, as_number(syntax)) {
            self.refuse(syntax, message);
            return None;
        }
        self.scalar(value, syntax)
    }
}

/// Returns a message that says how to write an integer expression as a number; `None` if its value can be written.
fn as_number(syntax: &Syntax) -> Option<String> {
    let text = crate::syntax::readable(syntax);
    match syntax {
        Syntax::Paren(inner) => as_number(&inner.expr),
        Syntax::Path(_) | Syntax::MethodCall(_) => Some(format!(
            "an integer stands where an `f64` belongs: write `{text} as f64`"
        )),
        Syntax::Binary(binary) if matches!(binary.op, BinOp::Div(_)) => Some(format!(
            "`{text}` divides integers, without the fraction: write its numbers as `1.0 / 2.0`"
        )),
        Syntax::Binary(_) => Some(format!(
            "an integer stands where an `f64` belongs: write `({text}) as f64`"
        )),
        // `x ** 2`
        Syntax::Unary(unary) if matches!(unary.op, UnOp::Deref(_)) => Some(
            "`**` is not a power in Rust: write `x.powi(2)`, or `x.powf(y)` for other exponents"
                .to_owned(),
        ),
        _ => None,
    }
}

/// The message for a quotient by the constant 0.
pub(super) const DIVISION_BY_ZERO: &str = "this divides by zero: the denominator is the constant 0";

/// The message for `%` of numbers.
pub(super) const REMAINDER: &str = concat!("`%` is not continuous", super::floats::periodic!());

/// Returns the message for an operator that is not arithmetic.
fn no_derivative(op: &BinOp) -> &'static str {
    match op {
        BinOp::RemAssign(_) => REMAINDER,
        BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) => {
            "a comparison has no value in a formula: use a smooth transition such as `tanh` (conditions on indices belong in `if`)"
        }
        BinOp::BitXor(_) | BinOp::BitXorAssign(_) => {
            "`^` is not a power in Rust: write `x.powi(2)`, or `x.powf(y)` for other exponents"
        }
        _ => "this operator is none of numbers: a formula has `+`, `-`, `*` and `/`",
    }
}

fn plain(op: &BinOp) -> Option<char> {
    match op {
        BinOp::Add(_) => Some('+'),
        BinOp::Sub(_) => Some('-'),
        BinOp::Mul(_) => Some('*'),
        BinOp::Div(_) => Some('/'),
        BinOp::Rem(_) => Some('%'),
        _ => None,
    }
}

fn compound(op: &BinOp) -> Option<char> {
    match op {
        BinOp::AddAssign(_) => Some('+'),
        BinOp::SubAssign(_) => Some('-'),
        BinOp::MulAssign(_) => Some('*'),
        BinOp::DivAssign(_) => Some('/'),
        _ => None,
    }
}

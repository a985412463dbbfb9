//! Operators of numbers, and the messages for operators that are not arithmetic.

use syn::{BinOp, Expr as Syntax, UnOp};

use super::Lowering;
use super::methods::rough_method;
use super::value::Value;
use crate::algebra::Expr;

impl Lowering<'_> {
    pub(super) fn unary(&mut self, unary: &syn::ExprUnary) -> Option<Value> {
        match (&unary.op, self.eval(&unary.expr)?) {
            (UnOp::Neg(op), Value::Int(i)) => self.negated(i, op),
            (UnOp::Neg(_), Value::Index(i)) => {
                let zero = self.scene.integers.constant(0);
                Some(self.running_arithmetic('-', zero, i))
            }
            (UnOp::Neg(op), Value::Matrix(matrix)) => self.negative(&matrix, op),
            (UnOp::Neg(_), value) => {
                let x = self.operand(&value, &unary.expr)?;
                Some(Value::Scalar(self.arena.neg(x)))
            }
            (UnOp::Deref(_), value) => Some(value),
            (op, _) => self.refuse(
                op,
                "`!` is for conditions on indices, `if !(i == j)`: it has no derivative",
            ),
        }
    }

    pub(super) fn binary(&mut self, binary: &syn::ExprBinary) -> Option<Value> {
        if let Some(op) = compound(&binary.op) {
            let left = self.value(&binary.left);
            let value = self.operated(op, binary, &left);
            self.store(&binary.left, value);
            return Some(Value::Unit);
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
            self.value(&binary.left);
            self.value(&binary.right);
            return self.refuse(&binary.op, no_derivative(&binary.op));
        }
        let mut value = self.value(&innermost.left);
        for (op, outer) in spine.into_iter().rev() {
            value = self.operated(op, outer, &value);
        }
        Some(value)
    }

    /// Evaluates the right operand and computes with both.
    fn operated(&mut self, op: char, binary: &syn::ExprBinary, left: &Value) -> Value {
        let right = self.value(&binary.right);
        let (left, right) = ((left, &*binary.left), (&right, &*binary.right));
        self.arithmetic(op, &binary.op, left, right)
            .unwrap_or(Value::Poison)
    }

    fn arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        left: (&Value, &Syntax),
        right: (&Value, &Syntax),
    ) -> Option<Value> {
        match (left.0, right.0) {
            (Value::Matrix(matrix), _) | (_, Value::Matrix(matrix)) => {
                return self.matrix_arithmetic(op, token, matrix.ty, left, right);
            }
            (Value::Int(a), Value::Int(b)) => return self.integer_arithmetic(op, token, *a, *b),
            // the poisoned operand may have been an integer, so the other operand is not wrong
            (Value::Poison, Value::Int(_) | Value::Index(_))
            | (Value::Int(_) | Value::Index(_), Value::Poison) => return None,
            (left, right) => {
                if let Some((a, b)) = self.running_pair(left, right) {
                    return Some(self.running_arithmetic(op, a, b));
                }
            }
        }
        let a = self.operand(left.0, left.1);
        let (a, b) = a.zip(self.operand(right.0, right.1))?;
        let value = match op {
            '+' => self.arena.add(a, b),
            '-' => self.arena.sub(a, b),
            '*' => self.arena.mul(a, b),
            '/' if self.arena.constant_value(b) == Some(0.0) => {
                return self.refuse(right.1, DIVISION_BY_ZERO);
            }
            '/' => self.arena.div(a, b),
            _ => return self.refuse(token, rough_method("%").unwrap_or_default()),
        };
        self.finite(value, token)
    }

    /// Returns the number of an operand, or reports an error that says how to write the operand as
    /// a number.
    pub(super) fn operand(&mut self, value: &Value, syntax: &Syntax) -> Option<Expr> {
        if let Value::Field(path) = value {
            self.fields.taken_for_number = Some(path.clone());
        }
        match (value, as_number(syntax)) {
            (Value::Int(_), Some(message)) => self.refuse(syntax, message),
            _ => self.scalar(value, syntax),
        }
    }
}

/// Returns a message that says how to write an integer expression as a number; `None` if its value
/// can be written.
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

/// Returns the message for an operator that is not arithmetic.
fn no_derivative(op: &BinOp) -> String {
    match op {
        BinOp::RemAssign(_) => return rough_method("%").unwrap_or_default(),
        BinOp::Eq(_) | BinOp::Ne(_) | BinOp::Lt(_) | BinOp::Le(_) | BinOp::Gt(_) | BinOp::Ge(_) => {
            "a comparison has no value in a formula: use a smooth transition such as `tanh` (conditions on indices belong in `if`)"
        }
        BinOp::BitXor(_) | BinOp::BitXorAssign(_) => {
            "`^` is not a power in Rust: write `x.powi(2)`, or `x.powf(y)` for other exponents"
        }
        _ => "this operator is none of numbers: a formula has `+`, `-`, `*` and `/`",
    }
    .to_owned()
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

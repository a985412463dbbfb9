//! `+ − * /` of vectors, matrices, rotations and numbers.
//!
//! In a sum, a parameter without a type annotation has the type of the other operand. In a product or quotient it is a number: generated
//! code reads it as an `f64`, and a parameter of another type is a type error at the parameter.

use syn::spanned::Spanned;
use syn::{BinOp, Expr as Syntax};

use super::refused::unknown_type;
use super::{Kind, Matrix, MatrixType};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::operators::{DIVISION_BY_ZERO, REMAINDER};
use crate::interpret::value::Value;
use crate::syntax::readable;

/// An operand.
enum Operand {
    Number(Expr),
    Matrix(Matrix<Expr>),
}

impl Lowering<'_> {
    /// Computes with two operands; `None` if neither is a matrix.
    pub(in crate::interpret) fn matrix_arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        left: (&Value, &Syntax),
        right: (&Value, &Syntax),
    ) -> Option<Value> {
        let ty = match (left.0, right.0) {
            (Value::Matrix(matrix), _) | (_, Value::Matrix(matrix)) => matrix.ty,
            _ => return None,
        };
        let a = self.matrix_operand(op, left, ty);
        let b = self.matrix_operand(op, right, ty);
        let (Some(a), Some(b)) = (a, b) else {
            return Some(Value::Poison);
        };
        let result = match op {
            '+' | '-' => self.matrix_sum(op, token, a, b),
            '*' => self.matrix_product(token, a, b),
            '/' => self.matrix_quotient(token, a, b, right.1),
            _ => Err(REMAINDER.to_owned()),
        };
        Some(result.unwrap_or_else(|message| {
            let hint = self.hint(left.1, right.1);
            self.refuse(token, message + &hint)
        }))
    }

    /// Evaluates an operand of an operation with a matrix of type `ty`.
    fn matrix_operand(
        &mut self,
        op: char,
        (value, syntax): (&Value, &Syntax),
        ty: MatrixType,
    ) -> Option<Operand> {
        match value {
            Value::Matrix(matrix) => self.numbers(matrix, syntax).map(Operand::Matrix),
            Value::Field(path) if !path.is_self() && !path.is_number() => match (op, ty.kind) {
                ('+' | '-', _) => {
                    let matrix = Matrix::of_field(path, ty.plain());
                    self.numbers(&matrix, syntax).map(Operand::Matrix)
                }
                (_, Kind::Rotation) => {
                    self.refuse(syntax, unknown_type(path, &ty.plain().to_string()));
                    None
                }
                _ => self.operand(value, syntax).map(Operand::Number),
            },
            _ => self.operand(value, syntax).map(Operand::Number),
        }
    }

    /// Computes `-a`.
    pub(in crate::interpret) fn negative(
        &mut self,
        matrix: &Matrix<Value>,
        op: &impl Spanned,
    ) -> Value {
        if matrix.ty.kind == Kind::Rotation {
            return self.refuse(op, "a rotation has no negative: write `r.inverse()`");
        }
        let Some(mut matrix) = self.numbers(matrix, op) else {
            return Value::Poison;
        };
        for entry in &mut matrix.entries {
            *entry = self.arena.neg(*entry);
        }
        matrix.into()
    }

    fn matrix_sum(
        &mut self,
        op: char,
        token: &BinOp,
        a: Operand,
        b: Operand,
    ) -> Result<Value, String> {
        let (a, b) = match (a, b) {
            (Operand::Matrix(a), Operand::Matrix(b)) => (a, b),
            (Operand::Matrix(Matrix { ty, .. }), _) | (_, Operand::Matrix(Matrix { ty, .. })) => {
                return Err(format!(
                    "a number and a `{ty}` have no sum: write `v.add_scalar(x)` to add a number to each entry"
                ));
            }
            _ => return Ok(Value::Poison),
        };
        if a.ty != b.ty || a.ty.kind != Kind::Matrix {
            return Err(format!("a `{}` and a `{}` have no sum", a.ty, b.ty));
        }
        if !self.work(a.ty.len(), token) {
            return Ok(Value::Poison);
        }
        let pairs = a.entries.into_iter().zip(b.entries);
        let entries = pairs
            .map(|(a, b)| match op {
                '+' => self.arena.add(a, b),
                _ => self.arena.sub(a, b),
            })
            .collect();
        Ok(self.computed_matrix(Matrix { ty: a.ty, entries }, token))
    }

    fn matrix_product(&mut self, token: &BinOp, a: Operand, b: Operand) -> Result<Value, String> {
        match (a, b) {
            (Operand::Number(x), Operand::Matrix(matrix))
            | (Operand::Matrix(matrix), Operand::Number(x)) => self.multiple(x, matrix, token),
            (Operand::Matrix(a), Operand::Matrix(b)) => {
                let product = self.product(&a, &b, token)?;
                Ok(product.map_or(Value::Poison, |product| {
                    self.computed_matrix(product, token)
                }))
            }
            _ => Ok(Value::Poison),
        }
    }

    /// Computes a number times a matrix.
    fn multiple(&mut self, x: Expr, matrix: Matrix<Expr>, token: &BinOp) -> Result<Value, String> {
        if matrix.ty.kind == Kind::Rotation {
            return Err(
                "a number times a rotation is no rotation: write `x * r.into_inner()`".to_owned(),
            );
        }
        if !self.work(matrix.ty.len(), token) {
            return Ok(Value::Poison);
        }
        let entries = matrix.entries.into_iter();
        let entries = entries.map(|entry| self.arena.mul(entry, x)).collect();
        let ty = matrix.ty.plain();
        Ok(self.computed_matrix(Matrix { ty, entries }, token))
    }

    /// Computes the product of two matrices. Returns `None` after a reported error, and `Err` with the message if the sizes differ.
    pub(super) fn product(
        &mut self,
        a: &Matrix<Expr>,
        b: &Matrix<Expr>,
        at: &impl Spanned,
    ) -> Result<Option<Matrix<Expr>>, String> {
        if a.ty.columns != b.ty.rows {
            if a.ty.is_vector() && a.ty.has_size_of(b.ty) {
                return Err("two vectors have no product `*`: write `a.dot(&b)`, `a.cross(&b)`, `a.component_mul(&b)`, or `a * b.transpose()` for the outer product".to_owned());
            }
            return Err(format!(
                "a `{}` and a `{}` have no product: the columns of the first are not as many as the rows of the second",
                a.ty, b.ty
            ));
        }
        let kind = match a.ty.kind {
            Kind::Rotation => b.ty.kind,
            _ => Kind::Matrix,
        };
        let ty = MatrixType {
            kind,
            rows: a.ty.rows,
            columns: b.ty.columns,
        };
        if let Some(message) = ty.unusable() {
            return Err(message);
        }
        if !self.work(ty.len().saturating_mul(a.ty.columns), at) {
            return Ok(None);
        }
        let rows = a.transposed();
        let mut entries = Vec::with_capacity(ty.len());
        for column in b.entries.chunks(b.ty.rows) {
            for row in rows.entries.chunks(rows.ty.rows) {
                entries.push(self.inner_product(row, column));
            }
        }
        Ok(Some(Matrix { ty, entries }))
    }

    fn matrix_quotient(
        &mut self,
        token: &BinOp,
        a: Operand,
        b: Operand,
        at: &Syntax,
    ) -> Result<Value, String> {
        let (matrix, x) = match (a, b) {
            (Operand::Matrix(matrix), Operand::Number(x)) => (matrix, x),
            (_, Operand::Matrix(divisor)) => {
                return Err(match divisor.ty.kind {
                    Kind::Rotation => "division by a rotation is not understood: write `a * r.inverse()`",
                    _ if divisor.ty.is_vector() => {
                        "nothing is divided by a vector: write `a.component_div(&b)` for a quotient of each entry"
                    }
                    _ => "nothing is divided by a matrix: make its inverse a parameter, or write the formula of a small one",
                }
                .to_owned());
            }
            _ => return Ok(Value::Poison),
        };
        if matrix.ty.kind == Kind::Rotation {
            return Err("a rotation is not divided by a number".to_owned());
        }
        if self.arena.constant_value(x) == Some(0.0) {
            return Ok(self.refuse(at, DIVISION_BY_ZERO));
        }
        let entries = matrix.entries.into_iter();
        let entries = entries.map(|entry| self.arena.div(entry, x)).collect();
        let ty = matrix.ty.plain();
        Ok(self.computed_matrix(Matrix { ty, entries }, token))
    }

    /// Returns an addition to a message about sizes if a parameter in an operand was taken for a number.
    fn hint(&mut self, left: &Syntax, right: &Syntax) -> String {
        let example = self.example_of_type(None);
        let Some(path) = &self.taken_for_number else {
            return String::new();
        };
        let name = readable(&path.access());
        if ![left, right]
            .iter()
            .any(|syntax| readable(syntax).contains(&name))
        {
            return String::new();
        }
        format!(
            "; `{name}` is taken for a number, and if it is none, name its type: `let {}: {example} = {name};`",
            path.name()
        )
    }
}

//! `+ − * /` of vectors, matrices, rotations and numbers.
//!
//! In a sum, a parameter without a type annotation has the type of the other operand. In a product
//! or quotient it is a number: generated code reads it as an `f64`, and a parameter of another type
//! is a type error at the parameter.

use syn::spanned::Spanned;
use syn::{BinOp, Expr as Syntax};

use super::formulas::{each, entrywise, inner};
use super::{Kind, Matrix, MatrixType};
use crate::algebra::{Arena, Expr};
use crate::interpret::Lowering;
use crate::interpret::methods::{rough_method, unknown_type};
use crate::interpret::operators::DIVISION_BY_ZERO;
use crate::interpret::value::Value;
use crate::syntax::readable;

/// An operand.
enum Operand {
    Number(Expr),
    Matrix(Matrix<Expr>),
}

/// A result: `None` after a reported error, and `Err` with the message if there is no such
/// operation.
type Computed = Result<Option<Matrix<Expr>>, String>;

impl Lowering<'_> {
    /// Computes with two operands, one of which is a matrix of type `ty`.
    pub(in crate::interpret) fn matrix_arithmetic(
        &mut self,
        op: char,
        token: &BinOp,
        ty: MatrixType,
        left: (&Value, &Syntax),
        right: (&Value, &Syntax),
    ) -> Option<Value> {
        let a = self.matrix_operand(op, left, ty);
        let operands = a.zip(self.matrix_operand(op, right, ty))?;
        let result = match op {
            '+' | '-' => self.matrix_sum(op, token, operands),
            '*' => self.matrix_product(token, operands),
            '/' => self.matrix_quotient(operands, right.1),
            _ => Err(rough_method("%").unwrap_or_default()),
        };
        match result {
            Ok(matrix) => self.finite_matrix(matrix?, token),
            Err(message) => {
                let hint = self.hint(left.1, right.1);
                self.refuse(token, message + &hint)
            }
        }
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
                    self.refuse(syntax, unknown_type(path, &ty.plain().to_string()))
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
    ) -> Option<Value> {
        if matrix.ty.kind == Kind::Rotation {
            return self.refuse(op, "a rotation has no negative: write `r.inverse()`");
        }
        let mut matrix = self.numbers(matrix, op)?;
        for entry in &mut matrix.entries {
            *entry = self.arena.neg(*entry);
        }
        Some(matrix.into())
    }

    fn matrix_sum(&mut self, op: char, token: &BinOp, operands: (Operand, Operand)) -> Computed {
        let (a, b) = match operands {
            (Operand::Matrix(a), Operand::Matrix(b)) => (a, b),
            (Operand::Matrix(Matrix { ty, .. }), _) | (_, Operand::Matrix(Matrix { ty, .. })) => {
                return Err(format!(
                    "a number and a `{ty}` have no sum: write `v.add_scalar(x)` to add a number to each entry"
                ));
            }
            _ => return Ok(None),
        };
        if a.ty != b.ty || a.ty.kind != Kind::Matrix {
            return Err(format!("a `{}` and a `{}` have no sum", a.ty, b.ty));
        }
        let operation = if op == '+' { Arena::add } else { Arena::sub };
        let within = self.work(a.ty.len(), token);
        Ok(within.map(|()| entrywise(self.arena, &a, &b, operation)))
    }

    fn matrix_product(&mut self, token: &BinOp, operands: (Operand, Operand)) -> Computed {
        match operands {
            (Operand::Matrix(a), Operand::Matrix(b)) => self.product(&a, &b, token),
            (Operand::Number(x), Operand::Matrix(matrix))
            | (Operand::Matrix(matrix), Operand::Number(x)) => {
                if matrix.ty.kind == Kind::Rotation {
                    return Err(
                        "a number times a rotation is no rotation: write `x * r.into_inner()`"
                            .to_owned(),
                    );
                }
                let within = self.work(matrix.ty.len(), token);
                Ok(within.map(|()| each(self.arena, &matrix, x, Arena::mul)))
            }
            _ => Ok(None),
        }
    }

    /// Computes the product of two matrices.
    pub(super) fn product(
        &mut self,
        a: &Matrix<Expr>,
        b: &Matrix<Expr>,
        at: &impl Spanned,
    ) -> Computed {
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
        let amount = ty.len().saturating_mul(a.ty.columns);
        if self.work(amount, at).is_none() {
            return Ok(None);
        }
        let rows: Vec<_> = (0..a.ty.rows).map(|i| a.row(i)).collect();
        let mut entries = Vec::with_capacity(ty.len());
        for column in (0..b.ty.columns).map(|j| b.column(j)) {
            entries.extend(rows.iter().map(|row| inner(self.arena, row, &column)));
        }
        Ok(Some(Matrix { ty, entries }))
    }

    fn matrix_quotient(&mut self, operands: (Operand, Operand), at: &Syntax) -> Computed {
        let (matrix, x) = match operands {
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
            _ => return Ok(None),
        };
        if matrix.ty.kind == Kind::Rotation {
            return Err("a rotation is not divided by a number".to_owned());
        }
        if self.arena.constant_value(x) == Some(0.0) {
            return Ok(self.refuse(at, DIVISION_BY_ZERO));
        }
        Ok(Some(each(self.arena, &matrix, x, Arena::div)))
    }

    /// Returns an addition to a message about sizes if a parameter in an operand was taken for a
    /// number.
    fn hint(&mut self, left: &Syntax, right: &Syntax) -> String {
        let example = self.example_of_vector();
        let Some(path) = &self.fields.taken_for_number else {
            return String::new();
        };
        let name = readable(&path.access());
        let mut operands = [left, right].into_iter();
        if !operands.any(|syntax| readable(syntax).contains(&name)) {
            return String::new();
        }
        format!(
            "; `{name}` is taken for a number, and if it is none, name its type: `let {}: {example} = {name};`",
            path.name()
        )
    }
}

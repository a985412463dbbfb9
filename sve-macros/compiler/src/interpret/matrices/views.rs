//! Submatrices, and iterators over entries, rows and columns.

use syn::{Expr as Syntax, ExprMethodCall, GenericArgument};

use super::{Matrix, MatrixType};
use crate::interpret::Lowering;
use crate::interpret::integers::Integer;
use crate::interpret::value::Value;
use crate::syntax::nalgebra::length;

/// The first row or column of a submatrix, and the number of rows or columns.
type Range<'e> = (&'e Syntax, &'e Syntax);

/// Whether a method gives a part of a vector or matrix, or runs a closure for each entry, and arrays have no such method. Those whose
/// size is a generic argument have it written, if `has_generics`.
pub(super) fn is_method(name: &str, has_generics: bool) -> bool {
    match name {
        "fixed_rows" | "fixed_columns" | "fixed_view" => has_generics,
        "rows" | "columns" | "nrows" | "ncols" | "column_iter" | "row_iter" | "zip_map" => true,
        _ => false,
    }
}

/// Whether a method makes sense for matrices more than for vectors.
pub(super) fn is_of_matrices(name: &str) -> bool {
    matches!(
        name,
        "fixed_columns" | "fixed_view" | "columns" | "ncols" | "column_iter" | "row_iter"
    )
}

impl Lowering<'_> {
    /// Calls a method that returns a submatrix, an iterator or a size; `None` for other methods.
    pub(super) fn view_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Matrix<Value>,
    ) -> Option<Value> {
        let arguments: Vec<&Syntax> = call.args.iter().collect();
        let ty = receiver.ty;
        let size = |n: usize| Some(Value::Int(Integer::count(n)));
        match (call.method.to_string().as_str(), arguments.as_slice()) {
            ("len", []) => size(ty.len()),
            ("nrows", []) => size(ty.rows),
            ("ncols", []) => size(ty.columns),
            ("iter" | "into_iter", []) => Some(Value::Sequence(receiver.entries.clone())),
            ("as_slice", []) => Some(Value::Array(receiver.entries.clone())),
            ("column_iter", []) => Some(Value::Sequence(parts(
                receiver,
                MatrixType::vector(ty.rows),
            ))),
            ("row_iter", []) => Some(Value::Sequence(parts(
                receiver,
                MatrixType::matrix(1, ty.columns),
            ))),
            ("rows", [from, count]) => Some(self.part(call, receiver, (Some((from, count)), None))),
            ("columns", [from, count]) => {
                Some(self.part(call, receiver, (None, Some((from, count)))))
            }
            ("fixed_rows", [from]) => {
                let [count] = generic_lengths(call)?;
                Some(self.part(call, receiver, (Some((from, &count)), None)))
            }
            ("fixed_columns", [from]) => {
                let [count] = generic_lengths(call)?;
                Some(self.part(call, receiver, (None, Some((from, &count)))))
            }
            ("fixed_view", [row, column]) => {
                let [rows, columns] = generic_lengths(call)?;
                let within = (Some((*row, &rows)), Some((*column, &columns)));
                Some(self.part(call, receiver, within))
            }
            (name, []) => components(receiver, name),
            _ => None,
        }
    }

    /// Returns the submatrix of a range of rows and a range of columns. `None` stands for all rows or columns.
    fn part(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Matrix<Value>,
        (rows, columns): (Option<Range<'_>>, Option<Range<'_>>),
    ) -> Value {
        let rows = self.rows_within(rows, receiver.ty.rows, "rows");
        let columns = self.rows_within(columns, receiver.ty.columns, "columns");
        let Some(((row, height), (column, width))) = rows.zip(columns) else {
            return Value::Poison;
        };
        let size = MatrixType::matrix(height, width);
        if let Some(message) = size.unusable() {
            return self.refuse(&call.method, message);
        }
        if !self.work(size.len(), call) {
            return Value::Poison;
        }
        Value::Matrix(receiver.part((row, column), size))
    }

    /// Evaluates a range of rows or columns, or reports an error if the range is not within `bound`.
    fn rows_within(
        &mut self,
        range: Option<Range<'_>>,
        bound: usize,
        what: &str,
    ) -> Option<(usize, usize)> {
        let Some((first, count)) = range else {
            return Some((0, bound));
        };
        let from = self.index_value(first)?;
        let length = self.index_value(count)?;
        if from.saturating_add(length) <= bound {
            return Some((from, length));
        }
        let message =
            format!("{length} {what} from {from} on are not within the {bound} that there are");
        self.refuse(first, message);
        None
    }
}

/// Returns the generic arguments of a call, if there are `N` of them.
fn generic_lengths<const N: usize>(call: &ExprMethodCall) -> Option<[Syntax; N]> {
    let arguments: Vec<&GenericArgument> = call.turbofish.iter().flat_map(|t| &t.args).collect();
    let lengths: Option<Vec<Syntax>> = arguments.into_iter().map(length).collect();
    lengths?.try_into().ok()
}

/// Splits a matrix into submatrices of this size: all rows or all columns.
fn parts(matrix: &Matrix<Value>, size: MatrixType) -> Vec<Value> {
    let is_column = size.columns == 1 && size.rows == matrix.ty.rows;
    let count = if is_column {
        matrix.ty.columns
    } else {
        matrix.ty.rows
    };
    (0..count)
        .map(|i| {
            let from = if is_column { (0, i) } else { (i, 0) };
            Value::Matrix(matrix.part(from, size))
        })
        .collect()
}

/// Returns the vector of the components in a name: `v.xy()`, `v.zx()`, `v.xyz()`.
fn components(matrix: &Matrix<Value>, name: &str) -> Option<Value> {
    if !(2..=3).contains(&name.len()) || !matrix.ty.is_vector() {
        return None;
    }
    let entry = |letter: char| matrix.entries.get("xyz".find(letter)?).cloned();
    let entries: Vec<Value> = name.chars().map(entry).collect::<Option<_>>()?;
    Some(Value::Matrix(Matrix {
        ty: MatrixType::vector(entries.len()),
        entries,
    }))
}

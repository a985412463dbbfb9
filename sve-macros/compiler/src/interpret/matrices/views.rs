//! Submatrices, and iterators over entries, rows and columns.

use syn::{Expr as Syntax, ExprMethodCall};

use super::{Matrix, MatrixType};
use crate::interpret::Lowering;
use crate::interpret::methods::{Call, refusal};
use crate::interpret::value::Value;
use crate::syntax::nalgebra::length;

/// Returns whether a method returns a part of a vector or matrix or runs a closure for each entry,
/// and arrays have no such method. A method whose size is a generic argument counts only if
/// `has_generics`.
pub(in crate::interpret) fn is_method(name: &str, has_generics: bool) -> bool {
    match name {
        "fixed_rows" | "fixed_columns" | "fixed_view" => has_generics,
        "rows" | "columns" | "nrows" | "ncols" | "column_iter" | "row_iter" | "zip_map" => true,
        _ => false,
    }
}

/// Returns whether a method is more useful for matrices than for vectors.
pub(in crate::interpret) fn is_of_matrices(name: &str) -> bool {
    matches!(
        name,
        "fixed_columns" | "fixed_view" | "columns" | "ncols" | "column_iter" | "row_iter"
    )
}

pub(in crate::interpret) fn columns(call: &Call<'_>) -> Value {
    let matrix = call.matrix();
    let columns = (0..matrix.ty.columns).map(|i| Value::Matrix(matrix.column(i)));
    Value::Sequence(columns.collect())
}

pub(in crate::interpret) fn rows(call: &Call<'_>) -> Value {
    let matrix = call.matrix();
    let rows = (0..matrix.ty.rows).map(|i| Value::Matrix(matrix.row(i)));
    Value::Sequence(rows.collect())
}

/// Evaluates `rows(from, count)`, `fixed_rows::<COUNT>(from)` and similar methods: the submatrix of
/// a range of rows and columns.
pub(in crate::interpret) fn part(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (syntax, matrix) = (call.syntax, call.matrix());
    let (given, ty) = (&call.given.counts, matrix.ty);
    let name = syntax.method.to_string();
    let lengths = match name.as_str() {
        "rows" | "columns" => vec![given[1]],
        _ => {
            let lengths = generic_lengths(syntax).filter(|all| all.len() == given.len());
            let Some(lengths) = lengths else {
                return x.refuse(&syntax.method, refusal(&name, Some(ty.kind)));
            };
            let lengths = lengths.iter().map(|length| x.index_value(length));
            lengths.collect::<Option<_>>()?
        }
    };
    let (of_rows, of_columns) = match name.as_str() {
        "rows" | "fixed_rows" => (Some(0), None),
        "columns" | "fixed_columns" => (None, Some(0)),
        _ => (Some(0), Some(1)),
    };
    let mut within = |argument: Option<usize>, bound: usize, what: &str| {
        let Some(at) = argument else {
            return Some((0, bound));
        };
        let (from, count) = (given[at], lengths[at]);
        if from.saturating_add(count) <= bound {
            return Some((from, count));
        }
        let message =
            format!("{count} {what} from {from} on are not within the {bound} that there are");
        x.refuse(&syntax.args[at], message)
    };
    let rows = within(of_rows, ty.rows, "rows");
    let columns = within(of_columns, ty.columns, "columns");
    let ((row, height), (column, width)) = rows.zip(columns)?;
    let size = MatrixType::matrix(height, width);
    if let Some(message) = size.unusable() {
        return x.refuse(&syntax.method, message);
    }
    x.work(size.len(), syntax)?;
    Some(Value::Matrix(matrix.part((row, column), size)))
}

/// Returns the generic arguments of a call, which are lengths.
fn generic_lengths(call: &ExprMethodCall) -> Option<Vec<Syntax>> {
    let arguments = call.turbofish.iter().flat_map(|generics| &generics.args);
    arguments.map(length).collect()
}

/// Returns the vector of the components that a name lists: `v.xy()`, `v.zx()`, `v.xyz()`.
pub(in crate::interpret) fn components(matrix: &Matrix<Value>, name: &str) -> Option<Value> {
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

//! Vectors, matrices and rotations of nalgebra: a size and the entries.
//!
//! Invariant: a [`Matrix`] has rows × columns entries, stored by columns as in nalgebra. The size of a matrix is always known. A
//! parameter of unknown type gets its size from its use or from a type annotation.

mod closures;
mod constructors;
mod formulas;
mod methods;
mod operators;
mod refused;
mod rotations;
mod table;
mod views;

use std::fmt;

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{ExprMethodCall, GenericArgument, Member};

use super::calls::Argument;
use super::fields::FieldPath;
use super::value::Value;
use super::{Lowering, floats, sequences};
use crate::algebra::{Arena, Expr};
pub(super) use crate::syntax::nalgebra::Kind;

/// Names of the components of vectors.
pub(super) const COMPONENTS: [&str; 6] = ["x", "y", "z", "w", "a", "b"];

/// Largest number of entries of a matrix, since products of matrices are unrolled.
const ENTRIES: usize = 4096;

/// A type of nalgebra with its sizes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct MatrixType {
    pub(super) kind: Kind,
    pub(super) rows: usize,
    pub(super) columns: usize,
}

impl MatrixType {
    pub(super) const fn matrix(rows: usize, columns: usize) -> Self {
        Self {
            kind: Kind::Matrix,
            rows,
            columns,
        }
    }

    pub(super) const fn vector(rows: usize) -> Self {
        Self::matrix(rows, 1)
    }

    /// Returns the number of entries.
    pub(super) fn len(self) -> usize {
        self.rows.saturating_mul(self.columns)
    }

    pub(super) fn is_vector(self) -> bool {
        self.columns == 1
    }

    /// Returns the reason why matrices of this size are not supported; `None` if they are.
    pub(super) fn unusable(self) -> Option<String> {
        match self.len() {
            0 => Some("a matrix without entries is not understood".to_owned()),
            1..=ENTRIES => None,
            _ => Some(format!(
                "a `{self}` has too many entries to unroll: the limit is {ENTRIES}"
            )),
        }
    }

    fn is_square(self) -> bool {
        self.rows == self.columns
    }

    fn has_size_of(self, other: Self) -> bool {
        (self.rows, self.columns) == (other.rows, other.columns)
    }

    /// Returns the type of a plain matrix of this size.
    fn plain(self) -> Self {
        Self::matrix(self.rows, self.columns)
    }

    /// Returns the index of an entry in storage; `None` if there is no such entry.
    pub(super) fn place(self, row: usize, column: usize) -> Option<usize> {
        (row < self.rows && column < self.columns).then(|| column * self.rows + row)
    }

    /// Returns the index in storage of an entry with a name, such as `.x` or `.m21`.
    pub(super) fn place_of(self, member: &Member) -> Option<usize> {
        let Member::Named(name) = member else {
            return None;
        };
        let name = name.to_string();
        if self.rows.min(self.columns) == 1 {
            let at = COMPONENTS.iter().position(|component| *component == name)?;
            return (at < self.len() && self.len() <= COMPONENTS.len()).then_some(at);
        }
        let (row, column) = row_and_column(&name)?;
        self.place(row, column)
    }

    /// Returns the names of the entries, for messages.
    pub(super) fn entry_names(self) -> String {
        if self.rows.min(self.columns) != 1 {
            let (row, column) = (self.rows.saturating_sub(1), self.columns.saturating_sub(1));
            return format!("`[(0, 0)]` to `[({row}, {column})]`");
        }
        if self.len() > COMPONENTS.len() {
            return "`[0]`, `[1]`, …".to_owned();
        }
        let names: Vec<String> = COMPONENTS[..self.len()]
            .iter()
            .map(|name| format!("`.{name}`"))
            .collect();
        names.join(", ")
    }
}

/// Returns row and column of an entry with a name such as `m21`.
pub(super) fn row_and_column(name: &str) -> Option<(usize, usize)> {
    let digits: Vec<usize> = name
        .strip_prefix('m')?
        .chars()
        .filter_map(|c| c.to_digit(10).map(|digit| digit as usize))
        .collect();
    match digits.as_slice() {
        &[row, column] if name.len() == 3 && row > 0 && column > 0 => Some((row - 1, column - 1)),
        _ => None,
    }
}

impl fmt::Display for MatrixType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rows, columns) = (self.rows, self.columns);
        let is_named = (1..=6).contains(&rows) && (1..=6).contains(&columns);
        match (self.kind, is_named) {
            (Kind::Rotation, _) => write!(f, "Rotation{rows}<f64>"),
            (Kind::Unit, _) => write!(f, "Unit<{}>", self.plain()),
            (_, true) if columns == 1 => write!(f, "Vector{rows}<f64>"),
            (_, true) if rows == 1 => write!(f, "RowVector{columns}<f64>"),
            (_, true) if rows == columns => write!(f, "Matrix{rows}<f64>"),
            (_, true) => write!(f, "Matrix{rows}x{columns}<f64>"),
            _ if columns == 1 => write!(f, "SVector<f64, {rows}>"),
            _ => write!(f, "SMatrix<f64, {rows}, {columns}>"),
        }
    }
}

/// A vector, matrix or rotation.
#[derive(Clone)]
pub(super) struct Matrix<T> {
    pub(super) ty: MatrixType,
    /// The entries, by columns.
    pub(super) entries: Vec<T>,
}

impl<T: Clone> Matrix<T> {
    /// Makes a matrix from a function of row and column.
    fn from_fn(ty: MatrixType, mut entry: impl FnMut(usize, usize) -> T) -> Self {
        let places = (0..ty.columns).flat_map(|column| (0..ty.rows).map(move |row| (row, column)));
        let entries = places.map(|(row, column)| entry(row, column)).collect();
        Self { ty, entries }
    }

    /// Returns an entry.
    fn at(&self, row: usize, column: usize) -> T {
        self.entries[column * self.ty.rows + row].clone()
    }

    fn transposed(&self) -> Self {
        let ty = MatrixType {
            kind: self.ty.kind,
            rows: self.ty.columns,
            columns: self.ty.rows,
        };
        Self::from_fn(ty, |row, column| self.at(column, row))
    }

    /// Returns the submatrix of a size that begins at a row and a column.
    fn part(&self, (row, column): (usize, usize), size: MatrixType) -> Self {
        Self::from_fn(size, |i, j| self.at(row + i, column + j))
    }

    fn with_kind(mut self, kind: Kind) -> Self {
        self.ty.kind = kind;
        self
    }
}

impl Matrix<Value> {
    /// Returns the matrix of the entries of a parameter.
    pub(super) fn of_field(path: &FieldPath, ty: MatrixType) -> Self {
        Self::from_fn(ty, |row, column| {
            Value::Field(entry_of_field(path, ty, row, column))
        })
    }
}

/// Returns the path by which generated code reads an entry of a parameter.
pub(super) fn entry_of_field(
    path: &FieldPath,
    ty: MatrixType,
    row: usize,
    column: usize,
) -> FieldPath {
    let is_row_or_column = ty.rows.min(ty.columns) == 1 && ty.kind != Kind::Rotation;
    if path.is_converted() {
        // arrays have neither `.x` nor `[(row, column)]`
        return if is_row_or_column {
            path.index(row + column)
        } else {
            path.pair(row, column)
        };
    }
    let entry = match COMPONENTS.get(row + column) {
        Some(name) if is_row_or_column && ty.len() <= COMPONENTS.len() => path.component(name),
        _ if is_row_or_column => path.index(row + column),
        _ => path.pair(row, column),
    };
    entry.entry_of(ty)
}

impl From<Matrix<Expr>> for Value {
    fn from(matrix: Matrix<Expr>) -> Self {
        Self::Matrix(Matrix {
            ty: matrix.ty,
            entries: matrix.entries.into_iter().map(Value::Scalar).collect(),
        })
    }
}

impl Lowering<'_> {
    /// Returns the vector or matrix of a parameter whose type an earlier execution found; other values as they are.
    pub(super) fn typed(&self, value: Value) -> Value {
        let Value::Field(path) = &value else {
            return value;
        };
        if self.known_types.is_empty() || path.is_converted() {
            return value;
        }
        match self.known_types.get(&path.access().to_string()) {
            Some(&ty) => Value::Matrix(Matrix::of_field(path, ty)),
            None => value,
        }
    }

    /// Calls a method of a vector or matrix; `None` if the receiver is neither, or is a parameter and no such method exists.
    pub(super) fn matrix_method(
        &mut self,
        call: &ExprMethodCall,
        receiver: &Argument,
    ) -> Option<Value> {
        let name = call.method.to_string();
        let at = call.method.span();
        let matrix = match &receiver.value {
            Value::Matrix(matrix) => matrix,
            Value::Field(path) if !path.is_self() && !sequences::is_method(&name) => {
                return self.method_of_field(call, path, at);
            }
            Value::Scalar(_)
                if methods::is_method(&name) && floats::other_name(&name).is_none() =>
            {
                let message = self.no_method_of_number(&name);
                return Some(self.refuse(&at, message));
            }
            _ => return None,
        };
        if matches!(name.as_str(), "clone" | "to_owned" | "into") && call.args.is_empty() {
            return Some(receiver.value.clone());
        }
        if !self.work(matrix.entries.len(), call) {
            return Some(Value::Poison);
        }
        if let Some(value) = self.view_method(call, matrix) {
            return Some(value);
        }
        if let Some(value) = self.closure_method(call, matrix) {
            return Some(value);
        }
        let arguments: Vec<Argument> = call.args.iter().map(|a| self.argument(a)).collect();
        if name == "tr_mul" {
            return Some(self.transposed_product(matrix, &arguments, at));
        }
        let value = self.tabled_method(call, matrix, &arguments, receiver.at);
        Some(
            value
                .unwrap_or_else(|| self.refuse(&at, refused::refusal(&name, Some(matrix.ty.kind)))),
        )
    }

    /// Evaluates `a.tr_mul(&b)`, the product of the transpose of `a` and `b`.
    fn transposed_product(&mut self, a: &Matrix<Value>, arguments: &[Argument], at: Span) -> Value {
        let [
            Argument {
                value: Value::Matrix(b),
                ..
            },
        ] = arguments
        else {
            return self.refuse(&at, "`tr_mul` takes a vector or matrix");
        };
        let (Some(a), Some(b)) = (self.numbers(a, &at), self.numbers(b, &at)) else {
            return Value::Poison;
        };
        match self.product(&a.transposed(), &b, &at) {
            Ok(Some(product)) => self.computed_matrix(product, &at),
            Ok(None) => Value::Poison,
            Err(message) => self.refuse(&at, message),
        }
    }

    /// Adds the vectors or matrices among the items of an iterator; `None` if the items are numbers.
    pub(super) fn sum_of_matrices(
        &mut self,
        call: &ExprMethodCall,
        items: &[Value],
    ) -> Option<Value> {
        let written = call
            .turbofish
            .as_ref()
            .and_then(|turbofish| match turbofish.args.first() {
                Some(GenericArgument::Type(ty)) => self.matrix_type(ty),
                _ => None,
            });
        let found = items.iter().find_map(|item| match item {
            Value::Matrix(matrix) => Some(matrix.ty.plain()),
            _ => None,
        });
        let ty = written.or(found)?;
        if !self.work(ty.len().saturating_mul(items.len()), call) {
            return Some(Value::Poison);
        }
        let zero = self.arena.constant(0.0);
        let mut total: Option<Matrix<Expr>> = None;
        for item in items {
            let argument = Argument {
                value: item.clone(),
                at: call.receiver.span(),
            };
            let Some(term) = self.matrix_argument(&argument, ty, "sum") else {
                return Some(Value::Poison);
            };
            total = Some(match total {
                Some(total) => formulas::entrywise(self.arena, &total, &term, Arena::add),
                None => term,
            });
        }
        let total = total.unwrap_or_else(|| Matrix::from_fn(ty, |_, _| zero));
        Some(self.computed_matrix(total, &call.method))
    }

    /// Returns the expressions of a matrix, or reports an error at `at`.
    fn numbers(&mut self, matrix: &Matrix<Value>, at: &impl Spanned) -> Option<Matrix<Expr>> {
        let mut entries = Vec::with_capacity(matrix.entries.len());
        for entry in &matrix.entries {
            entries.push(self.scalar(entry, at)?);
        }
        Some(Matrix {
            ty: matrix.ty,
            entries,
        })
    }

    /// Returns the value of a computed matrix, or reports an error if a constant overflows.
    fn computed_matrix(&mut self, matrix: Matrix<Expr>, at: &impl Spanned) -> Value {
        if matrix
            .entries
            .iter()
            .all(|&entry| self.arena.is_finite(entry))
        {
            matrix.into()
        } else {
            self.refuse(at, "the constants here overflow an `f64`")
        }
    }

    /// Returns the value of a computed number, or reports an error if a constant overflows.
    fn computed_number(&mut self, number: Expr, at: &impl Spanned) -> Value {
        if self.arena.is_finite(number) {
            Value::Scalar(number)
        } else {
            self.refuse(at, "the constants here overflow an `f64`")
        }
    }

    /// Computes `a₁ b₁ + a₂ b₂ + …`.
    fn inner_product(&mut self, a: &[Expr], b: &[Expr]) -> Expr {
        let products: Vec<Expr> = a
            .iter()
            .zip(b)
            .map(|(&a, &b)| self.arena.mul(a, b))
            .collect();
        sum(self.arena, &products)
    }
}

/// Adds numbers, from the first to the last.
fn sum(arena: &mut Arena, terms: &[Expr]) -> Expr {
    let mut terms = terms.iter().copied();
    let Some(first) = terms.next() else {
        return arena.constant(0.0);
    };
    terms.fold(first, |sum, term| arena.add(sum, term))
}

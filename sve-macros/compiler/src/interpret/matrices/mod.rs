//! Vectors, matrices and rotations of nalgebra: a size and the entries.
//!
//! Invariant: a [`Matrix`] has rows × columns entries, stored by columns as in nalgebra. The size
//! of a matrix is always known. A parameter of unknown type gets its size from its use or from a
//! type annotation.

mod constructors;
pub(super) mod formulas;
mod operators;
mod rotations;
pub(super) mod views;

use std::fmt;

use syn::spanned::Spanned;
use syn::{ExprMethodCall, GenericArgument, Member};

use super::calls::Argument;
use super::fields::FieldPath;
use super::methods::Call;
use super::value::Value;
use super::{Lowering, OVERFLOW};
use crate::algebra::{Arena, Expr};
pub(super) use crate::syntax::nalgebra::Kind;
pub(super) use constructors::Constructor;
use formulas::MAX_DETERMINANT;

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

    pub(super) fn is_square(self) -> bool {
        self.rows == self.columns
    }

    pub(super) fn has_size_of(self, other: Self) -> bool {
        (self.rows, self.columns) == (other.rows, other.columns)
    }

    /// Returns the type of a plain matrix of this size.
    pub(super) fn plain(self) -> Self {
        Self::matrix(self.rows, self.columns)
    }

    fn transposed(self) -> Self {
        Self {
            kind: self.kind,
            rows: self.columns,
            columns: self.rows,
        }
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

    /// Returns the names of the entries, as messages show them.
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

/// Returns the row and column of an entry with a name such as `m21`.
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
    /// Creates a matrix from a function of row and column.
    pub(super) fn from_fn(ty: MatrixType, mut entry: impl FnMut(usize, usize) -> T) -> Self {
        let places = (0..ty.columns).flat_map(|column| (0..ty.rows).map(move |row| (row, column)));
        let entries = places.map(|(row, column)| entry(row, column)).collect();
        Self { ty, entries }
    }

    /// Returns an entry.
    fn at(&self, row: usize, column: usize) -> T {
        self.entries[column * self.ty.rows + row].clone()
    }

    pub(super) fn transposed(&self) -> Self {
        Self::from_fn(self.ty.transposed(), |row, column| self.at(column, row))
    }

    /// Returns the submatrix of the given size that begins at a row and a column.
    fn part(&self, (row, column): (usize, usize), size: MatrixType) -> Self {
        Self::from_fn(size, |i, j| self.at(row + i, column + j))
    }

    pub(super) fn row(&self, row: usize) -> Self {
        self.part((row, 0), MatrixType::matrix(1, self.ty.columns))
    }

    pub(super) fn column(&self, column: usize) -> Self {
        self.part((0, column), MatrixType::vector(self.ty.rows))
    }

    /// Returns the matrix of a rotation or a unit vector.
    pub(super) fn unwrapped(&self) -> Self {
        self.clone().with_kind(Kind::Matrix)
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

/// Evaluates `map` and `zip_map` of a vector or matrix.
pub(super) fn map(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let function = call.given.functions[0];
    let Matrix { ty, entries } = call.matrix();
    let mut others = call.given.matrices.iter().flat_map(|other| &other.entries);
    let lists = entries.into_iter().map(|entry| {
        let other = others.next().map(|&other| Value::Scalar(other));
        [entry].into_iter().chain(other).collect()
    });
    let entries = x.mapped_lists(lists, function)?;
    let ty = ty.plain();
    let numbers = x.numbers(&Matrix { ty, entries }, function)?;
    Some(numbers.into())
}

pub(super) fn determinant(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let matrix = call.matrix();
    if matrix.ty.rows > MAX_DETERMINANT {
        let message = format!(
            "the determinant of a `{}` is too long a formula: the limit is {MAX_DETERMINANT} rows",
            matrix.ty
        );
        return x.refuse(&call.syntax.method, message);
    }
    let matrix = x.numbers(&matrix, &call.receiver.at)?;
    let number = formulas::determinant(x.arena, &matrix);
    x.finite(number, &call.syntax.method)
}

/// Evaluates `a.tr_mul(&b)`, the product of the transpose of `a` and `b`.
pub(super) fn transposed_product(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let at = call.syntax.method.span();
    let Value::Matrix(b) = &call.given.values[0].value else {
        return x.refuse(&at, "`tr_mul` takes a vector or matrix");
    };
    let a = x.numbers(&call.matrix(), &at)?;
    let b = x.numbers(b, &at)?;
    match x.product(&a.transposed(), &b, &at) {
        Ok(product) => x.finite_matrix(product?, &at),
        Err(message) => x.refuse(&at, message),
    }
}

/// Evaluates `a.lerp(&b, share)`, which is (1 − share) a + share b.
pub(super) fn lerp(x: &mut Lowering<'_>, call: &Call<'_>) -> Option<Value> {
    let (other, share) = (&call.given.matrices[0], call.given.numbers[0]);
    let matrix = x.numbers(&call.matrix(), &call.receiver.at)?;
    let one = x.arena.constant(1.0);
    let rest = x.arena.sub(one, share);
    let [a, b] = [(&matrix, rest), (other, share)]
        .map(|(m, part)| formulas::each(x.arena, m, part, Arena::mul));
    let sum = formulas::entrywise(x.arena, &a, &b, Arena::add);
    x.finite_matrix(sum, &call.syntax.method)
}

impl Lowering<'_> {
    /// Returns the type of a sum of vectors or matrices; `None` if the items are numbers.
    pub(super) fn type_of_sum(
        &mut self,
        call: &ExprMethodCall,
        items: &[Value],
    ) -> Option<MatrixType> {
        let generics = call.turbofish.as_ref().and_then(|all| all.args.first());
        let written = match generics {
            Some(GenericArgument::Type(ty)) => self.matrix_type(ty),
            _ => None,
        };
        let mut types = items.iter().filter_map(|item| match item {
            Value::Matrix(matrix) => Some(matrix.ty.plain()),
            _ => None,
        });
        written.or_else(|| types.next())
    }

    /// Adds the vectors or matrices among the items of an iterator.
    pub(super) fn sum_of_matrices(
        &mut self,
        call: &ExprMethodCall,
        items: &[Value],
        ty: MatrixType,
    ) -> Option<Value> {
        self.work(ty.len().saturating_mul(items.len()), call)?;
        let mut total: Option<Matrix<Expr>> = None;
        for item in items {
            let argument = Argument {
                value: item.clone(),
                at: call.receiver.span(),
            };
            let term = self.matrix_argument(&argument, ty, "sum")?;
            total = Some(match total {
                Some(total) => formulas::entrywise(self.arena, &total, &term, Arena::add),
                None => term,
            });
        }
        let zero = self.arena.constant(0.0);
        let total = total.unwrap_or_else(|| Matrix::from_fn(ty, |_, _| zero));
        self.finite_matrix(total, &call.method)
    }

    /// Returns the expressions of a matrix, or reports an error at `at`.
    pub(super) fn numbers(
        &mut self,
        matrix: &Matrix<Value>,
        at: &impl Spanned,
    ) -> Option<Matrix<Expr>> {
        let mut entries = Vec::with_capacity(matrix.entries.len());
        for entry in &matrix.entries {
            entries.push(self.scalar(entry, at)?);
        }
        Some(Matrix {
            ty: matrix.ty,
            entries,
        })
    }

    /// Returns a computed matrix, or reports an error if a constant overflows.
    pub(super) fn finite_matrix(
        &mut self,
        matrix: Matrix<Expr>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let mut entries = matrix.entries.iter();
        if entries.all(|&entry| self.arena.is_finite(entry)) {
            Some(matrix.into())
        } else {
            self.refuse(at, OVERFLOW)
        }
    }
}

//! Functions that make vectors, matrices and rotations: `Vector3::new(…)`, `SMatrix::<f64, 2, 3>::zeros()`, `Rotation2::new(…)`.

use proc_macro2::Span;
use syn::spanned::Spanned;

use super::{COMPONENTS, Kind, Matrix, MatrixType};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::floats::{are, plural};
use crate::interpret::integers::Integer;
use crate::interpret::value::Value;
use crate::syntax::nalgebra::Written;

/// A type whose sizes may follow from the arguments of its constructor.
#[derive(Clone, Copy)]
pub(super) struct PartialType {
    pub(super) kind: Kind,
    pub(super) rows: Option<usize>,
    pub(super) columns: Option<usize>,
}

impl PartialType {
    /// The type, if both sizes are known.
    fn ty(self) -> Option<MatrixType> {
        Some(MatrixType {
            kind: self.kind,
            rows: self.rows?,
            columns: self.columns?,
        })
    }
}

/// The message for a size that is not written.
const NO_SIZE: &str =
    "the size is not written here: write it, as in `SVector::<f64, 3>` or `SMatrix::<f64, 2, 3>`";

/// The part of a message that lists the constructors.
const UNDERSTOOD: &str = "vectors and matrices are made by `new`, `zeros`, `repeat`, `identity`, `from_diagonal`, `from_columns`, `from_rows`, `from_row_slice`, `from` and `from_fn`, axes by `x()` and `x_axis()`, rotations by `Rotation2::new`, `Rotation3::from_euler_angles` and `from_axis_angle`";

impl Lowering<'_> {
    /// Calls an associated function of a type of nalgebra; `None` if the path is not such a function.
    pub(in crate::interpret) fn construct(
        &mut self,
        path: &syn::ExprPath,
        arguments: &[Argument],
    ) -> Option<Value> {
        let mut of = path.path.clone();
        let function = of.segments.pop()?;
        of.segments.pop_punct();
        let written = Written::of_path(&of).filter(|_| path.qself.is_none())?;
        if written.has_floats == Some(false) {
            return Some(self.refuse(&of, "every number of a body is an `f64`"));
        }
        if arguments
            .iter()
            .any(|argument| matches!(argument.value, Value::Poison))
        {
            return Some(Value::Poison);
        }
        let [rows, columns] = [&written.rows, &written.columns].map(|size| self.size(size));
        let made = PartialType {
            kind: written.kind,
            rows: rows.ok()?,
            columns: columns.ok()?,
        };
        let name = function.ident.to_string();
        let at = function.ident.span();
        if let Some(message) = made.ty().and_then(MatrixType::unusable) {
            return Some(self.refuse(&at, message));
        }
        let value = match made.kind {
            Kind::Matrix => self.new_matrix(made, &name, at, arguments),
            Kind::Rotation => self.new_rotation(made, &name, at, arguments),
            Kind::Unit => self.new_unit(&name, at, arguments),
        };
        Some(match value {
            Ok(Some(value)) => value,
            Ok(None) => Value::Poison,
            Err(message) => self.refuse(&at, message),
        })
    }

    /// Makes a vector or matrix. Returns `None` after a reported error, and `Err` with the message if the call itself is wrong.
    fn new_matrix(
        &mut self,
        made: PartialType,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Result<Option<Value>, String> {
        let matrix = match (name, arguments) {
            ("zeros", []) => self.diagonal_matrix(made, 0.0)?,
            ("identity", []) => self.diagonal_matrix(made, 1.0)?,
            ("new", arguments) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                return self.matrix_of_rows(ty, name, arguments, at);
            }
            ("repeat" | "from_element", [x]) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                let Some(x) = self.scalar(&x.value, &x.at) else {
                    return Ok(None);
                };
                Matrix::from_fn(ty, |_, _| x)
            }
            ("from_diagonal_element", [x]) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                let Some(x) = self.scalar(&x.value, &x.at) else {
                    return Ok(None);
                };
                let zero = self.arena.constant(0.0);
                Matrix::from_fn(ty, |i, j| if i == j { x } else { zero })
            }
            ("from_diagonal", [diagonal]) => return self.matrix_of_diagonal(made, diagonal),
            ("from_columns", [list]) => return self.joined(made, list, true),
            ("from_rows", [list]) => return self.joined(made, list, false),
            ("from_row_slice" | "from_column_slice", [list]) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                let Some(items) = self.items_of_slice(list) else {
                    return Ok(None);
                };
                if name == "from_row_slice" {
                    return self.matrix_of_rows(ty, name, &items, at);
                }
                let transposed = MatrixType::matrix(ty.columns, ty.rows);
                let value = self.matrix_of_rows(transposed, name, &items, at)?;
                return Ok(value.map(|value| match value {
                    Value::Matrix(matrix) => Value::Matrix(matrix.transposed()),
                    other => other,
                }));
            }
            ("from", [argument]) => {
                let ty = made.ty();
                return Ok(self.converted_matrix(&argument.value, ty, &argument.at));
            }
            ("from_fn", [function]) => return self.matrix_of_closure(made, function),
            (axis, []) => return self.axis(made, axis),
            _ => return Err(not_understood(name)),
        };
        Ok(Some(matrix.into()))
    }

    /// Makes a matrix with a number on the diagonal and 0 elsewhere.
    pub(super) fn diagonal_matrix(
        &mut self,
        made: PartialType,
        diagonal: f64,
    ) -> Result<Matrix<Expr>, String> {
        let ty = made.ty().ok_or(NO_SIZE)?;
        let [zero, diagonal] = [0.0, diagonal].map(|x| self.arena.constant(x));
        Ok(Matrix::from_fn(
            ty,
            |i, j| if i == j { diagonal } else { zero },
        ))
    }

    /// Makes a matrix from its numbers, by rows.
    fn matrix_of_rows(
        &mut self,
        ty: MatrixType,
        name: &str,
        arguments: &[Argument],
        at: Span,
    ) -> Result<Option<Value>, String> {
        if arguments.len() != ty.len() {
            let numbers = plural(ty.len(), "number");
            return Err(format!(
                "`{name}` of a `{ty}` takes {numbers}, here {}",
                are(arguments.len())
            ));
        }
        if !self.work(ty.len(), &at) {
            return Ok(None);
        }
        // evaluates all arguments before it returns, so that the mistakes in each are reported
        let numbers: Vec<Option<Expr>> = arguments
            .iter()
            .map(|argument| self.scalar(&argument.value, &argument.at))
            .collect();
        let Some(numbers) = numbers.into_iter().collect::<Option<Vec<Expr>>>() else {
            return Ok(None);
        };
        Ok(Some(
            Matrix::from_fn(ty, |i, j| numbers[i * ty.columns + j]).into(),
        ))
    }

    fn matrix_of_diagonal(
        &mut self,
        made: PartialType,
        diagonal: &Argument,
    ) -> Result<Option<Value>, String> {
        let rows = match (&diagonal.value, made.rows.or(made.columns)) {
            (_, Some(rows)) => rows,
            (Value::Matrix(matrix), None) => matrix.ty.rows,
            _ => return Err(NO_SIZE.to_owned()),
        };
        let Some(vector) =
            self.matrix_argument(diagonal, MatrixType::vector(rows), "from_diagonal")
        else {
            return Ok(None);
        };
        let zero = self.arena.constant(0.0);
        let square = MatrixType::matrix(rows, rows);
        if let Some(message) = square.unusable() {
            return Err(message);
        }
        let matrix = Matrix::from_fn(square, |i, j| if i == j { vector.at(i, 0) } else { zero });
        Ok(Some(matrix.into()))
    }

    /// Makes a matrix from its columns or its rows.
    fn joined(
        &mut self,
        made: PartialType,
        list: &Argument,
        by_columns: bool,
    ) -> Result<Option<Value>, String> {
        let Some(items) = self.items_of_slice(list) else {
            return Ok(None);
        };
        let written = if by_columns { made.rows } else { made.columns };
        let found = items.iter().find_map(|item| match &item.value {
            Value::Matrix(matrix) => Some(matrix.ty.len()),
            _ => None,
        });
        let length = written.or(found).ok_or(NO_SIZE)?;
        let expected = if by_columns { made.columns } else { made.rows };
        if expected.is_some_and(|count| count != items.len()) {
            let count = expected.unwrap_or_default();
            let what = if by_columns { "column" } else { "row" };
            return Err(format!(
                "this matrix has {}, here {}",
                plural(count, what),
                are(items.len())
            ));
        }
        let (part, whole, name) = if by_columns {
            (
                MatrixType::vector(length),
                MatrixType::matrix(length, items.len()),
                "from_columns",
            )
        } else {
            (
                MatrixType::matrix(1, length),
                MatrixType::matrix(items.len(), length),
                "from_rows",
            )
        };
        if let Some(message) = whole.unusable() {
            return Err(message);
        }
        let mut parts = Vec::new();
        for item in &items {
            let Some(part) = self.matrix_argument(item, part, name) else {
                return Ok(None);
            };
            parts.push(part.entries);
        }
        let entry = |i: usize, j: usize| if by_columns { parts[j][i] } else { parts[i][j] };
        Ok(Some(Matrix::from_fn(whole, entry).into()))
    }

    /// Returns the items of an array as arguments.
    fn items_of_slice(&mut self, list: &Argument) -> Option<Vec<Argument>> {
        match &list.value {
            Value::Array(items) => Some(
                items
                    .iter()
                    .map(|value| Argument {
                        value: value.clone(),
                        at: list.at,
                    })
                    .collect(),
            ),
            other => {
                let message = format!("expected an array, `&[a, b]`, found {}", other.kind());
                self.refuse(&list.at, message);
                None
            }
        }
    }

    /// Evaluates `from`: an array of numbers becomes a vector, an array of arrays the columns of a matrix.
    pub(in crate::interpret) fn converted_matrix(
        &mut self,
        value: &Value,
        ty: Option<MatrixType>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let columns: Vec<Vec<Value>> = match (value, ty) {
            (Value::Matrix(matrix), _) => {
                return Some(Value::Matrix(matrix.clone().with_kind(Kind::Matrix)));
            }
            (Value::Field(path), Some(ty)) if !ty.is_vector() => {
                let entry = |i, j| Value::Field(path.index(j).index(i));
                return Some(Value::Matrix(Matrix::from_fn(ty.plain(), entry)));
            }
            (Value::Field(_) | Value::Array(_), Some(ty)) if ty.is_vector() => {
                vec![self.array_of(value, ty.rows)?]
            }
            (Value::Array(items), _)
                if items.iter().all(|item| matches!(item, Value::Array(_))) =>
            {
                items
                    .iter()
                    .filter_map(|item| match item {
                        Value::Array(column) => Some(column.clone()),
                        _ => None,
                    })
                    .collect()
            }
            (Value::Array(items), _) => vec![items.clone()],
            _ => Vec::new(),
        };
        let rows = columns.first().map_or(0, Vec::len);
        let found = MatrixType::matrix(rows, columns.len());
        let fits = columns.iter().all(|column| column.len() == rows);
        if fits && found.unusable().is_none() && ty.is_none_or(|ty| ty.has_size_of(found)) {
            return Some(Value::Matrix(Matrix {
                ty: found,
                entries: columns.into_iter().flatten().collect(),
            }));
        }
        let expected = ty.map_or_else(|| "a vector or matrix".to_owned(), |ty| format!("a `{ty}`"));
        let message = format!("expected {expected}, found {}", value.kind());
        self.refuse(at, message);
        None
    }

    /// Returns the numbers of an array, and the first `length` entries of a field.
    fn array_of(&mut self, value: &Value, length: usize) -> Option<Vec<Value>> {
        let argument = Argument {
            value: value.clone(),
            at: Span::call_site(),
        };
        self.items(&argument, Some(length))
    }

    /// Evaluates `from_fn(|i, j| …)`.
    fn matrix_of_closure(
        &mut self,
        made: PartialType,
        function: &Argument,
    ) -> Result<Option<Value>, String> {
        let ty = made.ty().ok_or(NO_SIZE)?;
        let Value::Closure(closure) = &function.value else {
            return Err("`from_fn` takes a closure of row and column, `|i, j| …`".to_owned());
        };
        let mistakes = self.errors.count();
        let mut entries = Vec::new();
        for (row, column) in
            (0..ty.columns).flat_map(|column| (0..ty.rows).map(move |row| (row, column)))
        {
            let indices = [row, column].map(|index| Argument {
                value: Value::Int(Integer::count(index)),
                at: function.at,
            });
            let value = self.call_closure(closure, indices.into(), &function.at);
            if self.errors.count() > mistakes || !self.tick(&function.at) {
                return Ok(None);
            }
            entries.push(value);
        }
        let matrix = Matrix { ty, entries };
        Ok(self.numbers(&matrix, &function.at).map(Value::from))
    }

    /// Makes the unit vector along an axis: `Vector3::x()`, or as a `Unit`, `Vector3::x_axis()`.
    fn axis(&mut self, made: PartialType, name: &str) -> Result<Option<Value>, String> {
        let letter = name.strip_suffix("_axis").unwrap_or(name);
        let at = COMPONENTS.iter().position(|component| *component == letter);
        let (Some(at), Some(ty)) = (at, made.ty()) else {
            return Err(not_understood(name));
        };
        if !ty.is_vector() || at >= ty.rows {
            return Err(format!("a `{ty}` has no axis `{letter}`"));
        }
        let [zero, one] = [0.0, 1.0].map(|x| self.arena.constant(x));
        let kind = if letter == name {
            Kind::Matrix
        } else {
            Kind::Unit
        };
        let axis = Matrix::from_fn(ty, |i, _| if i == at { one } else { zero });
        Ok(Some(axis.with_kind(kind).into()))
    }
}

pub(super) fn not_understood(name: &str) -> String {
    format!("`{name}` of a type of nalgebra is not understood: {UNDERSTOOD}")
}

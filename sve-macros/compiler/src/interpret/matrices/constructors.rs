//! Functions that make vectors, matrices and rotations: `Vector3::new(…)`, `SMatrix::<f64, 2, 3>::zeros()`, `Rotation2::new(…)`.

use proc_macro2::Span;
use syn::spanned::Spanned;

use super::methods::normalized;
use super::{COMPONENTS, Kind, Matrix, MatrixType};
use crate::algebra::{Expr, Function};
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::floats::{are, plural};
use crate::interpret::integers::Integer;
use crate::interpret::value::Value;
use crate::syntax::nalgebra::Written;

/// A type whose sizes may be left to the arguments.
#[derive(Clone, Copy)]
struct Made {
    kind: Kind,
    rows: Option<usize>,
    columns: Option<usize>,
}

impl Made {
    /// The type, if both sizes are known.
    fn ty(self) -> Option<MatrixType> {
        Some(MatrixType {
            kind: self.kind,
            rows: self.rows?,
            columns: self.columns?,
        })
    }
}

/// What to say of a size that is not written.
const NO_SIZE: &str =
    "the size is not written here: write it, as in `SVector::<f64, 3>` or `SMatrix::<f64, 2, 3>`";

/// The functions that make values of nalgebra.
const UNDERSTOOD: &str = "vectors and matrices are made by `new`, `zeros`, `repeat`, `identity`, `from_diagonal`, `from_columns`, `from_rows`, `from_row_slice`, `from` and `from_fn`, axes by `x()` and `x_axis()`, rotations by `Rotation2::new`, `Rotation3::from_euler_angles` and `from_axis_angle`";

impl Lowering<'_> {
    /// Calls a function of a type of nalgebra; nothing if the path names none.
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
        let made = Made {
            kind: written.kind,
            rows: rows.ok()?,
            columns: columns.ok()?,
        };
        let name = function.ident.to_string();
        let at = function.ident.span();
        if made.ty().is_some_and(|ty| ty.len() > super::ENTRIES) {
            let message = made.ty().map(super::too_large).unwrap_or_default();
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

    /// A vector or matrix; nothing after an error, and what to say of this call as an error.
    fn new_matrix(
        &mut self,
        made: Made,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Result<Option<Value>, String> {
        let matrix = match (name, arguments) {
            ("zeros", []) => self.diagonal_matrix(made, 0.0)?,
            ("identity", []) => self.diagonal_matrix(made, 1.0)?,
            ("new", arguments) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                return self.from_rows_of(ty, name, arguments, at);
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
            ("from_diagonal", [diagonal]) => return self.from_diagonal(made, diagonal),
            ("from_columns", [list]) => return self.joined(made, list, true),
            ("from_rows", [list]) => return self.joined(made, list, false),
            ("from_row_slice" | "from_column_slice", [list]) => {
                let ty = made.ty().ok_or(NO_SIZE)?;
                let Some(items) = self.items_of_slice(list) else {
                    return Ok(None);
                };
                if name == "from_row_slice" {
                    return self.from_rows_of(ty, name, &items, at);
                }
                let transposed = MatrixType::matrix(ty.columns, ty.rows);
                let value = self.from_rows_of(transposed, name, &items, at)?;
                return Ok(value.map(|value| match value {
                    Value::Matrix(matrix) => Value::Matrix(matrix.transposed()),
                    other => other,
                }));
            }
            ("from", [argument]) => {
                let ty = made.ty();
                return Ok(self.converted_matrix(&argument.value, ty, &argument.at));
            }
            ("from_fn", [function]) => return self.from_closure(made, function),
            (axis, []) => return self.axis(made, axis),
            _ => return Err(not_understood(name)),
        };
        Ok(Some(matrix.into()))
    }

    /// A matrix with this number on the diagonal, 0 elsewhere.
    fn diagonal_matrix(&mut self, made: Made, diagonal: f64) -> Result<Matrix<Expr>, String> {
        let ty = made.ty().ok_or(NO_SIZE)?;
        let [zero, diagonal] = [0.0, diagonal].map(|x| self.arena.constant(x));
        Ok(Matrix::from_fn(
            ty,
            |i, j| if i == j { diagonal } else { zero },
        ))
    }

    /// A matrix from its numbers, one row after the other.
    fn from_rows_of(
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
        // all arguments, for the mistakes in each
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

    fn from_diagonal(&mut self, made: Made, diagonal: &Argument) -> Result<Option<Value>, String> {
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
        if square.len() > super::ENTRIES {
            return Err(super::too_large(square));
        }
        let matrix = Matrix::from_fn(square, |i, j| if i == j { vector.at(i, 0) } else { zero });
        Ok(Some(matrix.into()))
    }

    /// A matrix from its columns or its rows.
    fn joined(
        &mut self,
        made: Made,
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
        if whole.len() > super::ENTRIES {
            return Err(super::too_large(whole));
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

    /// The items of an array.
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

    /// `from`: numbers become a vector, arrays of numbers the columns of a matrix.
    pub(in crate::interpret) fn converted_matrix(
        &mut self,
        value: &Value,
        ty: Option<MatrixType>,
        at: &impl Spanned,
    ) -> Option<Value> {
        let columns: Vec<Vec<Value>> = match value {
            Value::Matrix(matrix) => {
                return Some(Value::Matrix(matrix.clone().with_kind(Kind::Matrix)));
            }
            Value::Field(path) if let Some(ty) = ty.filter(|ty| !ty.is_vector()) => {
                let entry = |i, j| Value::Field(path.index(j).index(i));
                return Some(Value::Matrix(Matrix::from_fn(ty.plain(), entry)));
            }
            Value::Field(_) | Value::Array(_) if let Some(ty) = ty.filter(|ty| ty.is_vector()) => {
                vec![self.array_of(value, ty.rows)?]
            }
            Value::Array(items) if items.iter().all(|item| matches!(item, Value::Array(_))) => {
                items
                    .iter()
                    .filter_map(|item| match item {
                        Value::Array(column) => Some(column.clone()),
                        _ => None,
                    })
                    .collect()
            }
            Value::Array(items) => vec![items.clone()],
            _ => Vec::new(),
        };
        let rows = columns.first().map_or(0, Vec::len);
        let found = MatrixType::matrix(rows, columns.len());
        let fits = columns.iter().all(|column| column.len() == rows);
        if fits
            && found.len() > 0
            && found.len() <= super::ENTRIES
            && ty.is_none_or(|ty| ty.has_size_of(found))
        {
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

    /// The numbers of an array; those of a field are as many as `length`.
    fn array_of(&mut self, value: &Value, length: usize) -> Option<Vec<Value>> {
        let argument = Argument {
            value: value.clone(),
            at: Span::call_site(),
        };
        self.items(&argument, Some(length))
    }

    /// `from_fn(|i, j| …)`.
    fn from_closure(&mut self, made: Made, function: &Argument) -> Result<Option<Value>, String> {
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

    /// `Vector3::x()`, a vector of length 1, and `Vector3::x_axis()`, the same as a `Unit`.
    fn axis(&mut self, made: Made, name: &str) -> Result<Option<Value>, String> {
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

    fn new_rotation(
        &mut self,
        made: Made,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Result<Option<Value>, String> {
        let size = made.rows.unwrap_or(2);
        let matrix = match (name, size, arguments) {
            ("identity", _, []) => self.diagonal_matrix(made, 1.0)?,
            ("new", 2, [angle]) => {
                let Some(angle) = self.scalar(&angle.value, &angle.at) else {
                    return Ok(None);
                };
                let [sin, cos] = self.sin_cos(angle);
                let minus_sin = self.arena.neg(sin);
                let rows = [[cos, minus_sin], [sin, cos]];
                Matrix::from_fn(MatrixType::matrix(2, 2), |i, j| rows[i][j])
            }
            ("from_euler_angles", 3, [roll, pitch, yaw]) => {
                let angles = [roll, pitch, yaw].map(|angle| self.scalar(&angle.value, &angle.at));
                let [Some(roll), Some(pitch), Some(yaw)] = angles else {
                    return Ok(None);
                };
                self.euler_rotation([roll, pitch, yaw])
            }
            ("from_axis_angle", 3, [axis, angle]) => {
                let axis = self.matrix_argument(axis, MatrixType::vector(3), name);
                let angle = self.scalar(&angle.value, &angle.at);
                let Some((axis, angle)) = axis.zip(angle) else {
                    return Ok(None);
                };
                self.axis_rotation(&axis, angle)
            }
            ("from_matrix_unchecked", _, [matrix]) => {
                let Some(matrix) =
                    self.matrix_argument(matrix, MatrixType::matrix(size, size), name)
                else {
                    return Ok(None);
                };
                matrix
            }
            ("new" | "from_scaled_axis", 3, [_]) => {
                return Err(format!(
                    "`{name}` divides by the angle, which may be 0: write `Rotation3::from_axis_angle(&Vector3::z_axis(), angle)`"
                ));
            }
            _ => return Err(not_understood(name)),
        };
        Ok(Some(
            self.computed_matrix(matrix.with_kind(Kind::Rotation), &at),
        ))
    }

    fn sin_cos(&mut self, angle: Expr) -> [Expr; 2] {
        [Function::Sin, Function::Cos].map(|function| self.arena.call(function, angle))
    }

    /// Rotations about x, then y, then z, as nalgebra composes them.
    fn euler_rotation(&mut self, angles: [Expr; 3]) -> Matrix<Expr> {
        let [[sr, cr], [sp, cp], [sy, cy]] = angles.map(|angle| self.sin_cos(angle));
        let arena = &mut *self.arena;
        let mut product = |factors: &[Expr]| {
            let factors: Vec<(Expr, i32)> = factors.iter().map(|&factor| (factor, 1)).collect();
            arena.product(&factors)
        };
        let both = [
            [product(&[cy, sp, sr]), product(&[sy, cr])],
            [product(&[cy, sp, cr]), product(&[sy, sr])],
            [product(&[sy, sp, sr]), product(&[cy, cr])],
            [product(&[sy, sp, cr]), product(&[cy, sr])],
        ];
        let single = [[cy, cp], [sy, cp], [cp, sr], [cp, cr]].map(|factors| product(&factors));
        let rows = [
            [
                single[0],
                arena.sub(both[0][0], both[0][1]),
                arena.add(both[1][0], both[1][1]),
            ],
            [
                single[1],
                arena.add(both[2][0], both[2][1]),
                arena.sub(both[3][0], both[3][1]),
            ],
            [arena.neg(sp), single[2], single[3]],
        ];
        Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| rows[i][j])
    }

    /// cos θ 1 + sin θ [u] + (1 − cos θ) u uᵀ (Rodrigues) for a unit vector u.
    fn axis_rotation(&mut self, axis: &Matrix<Expr>, angle: Expr) -> Matrix<Expr> {
        let [sin, cos] = self.sin_cos(angle);
        let arena = &mut *self.arena;
        let one = arena.constant(1.0);
        let rest = arena.sub(one, cos);
        Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| {
            if i == j {
                let square = arena.pow(axis.entries[i], 2);
                let complement = arena.sub(one, square);
                let turned = arena.mul(complement, cos);
                return arena.add(square, turned);
            }
            // the third axis, positive where i, j, k are in cyclic order
            let along = arena.mul(axis.entries[3 - i - j], sin);
            let product = arena.product(&[(axis.entries[i], 1), (axis.entries[j], 1), (rest, 1)]);
            if (i + 1) % 3 == j {
                arena.sub(product, along)
            } else {
                arena.add(product, along)
            }
        })
    }

    fn new_unit(
        &mut self,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Result<Option<Value>, String> {
        let ("new_normalize" | "new_unchecked", [vector]) = (name, arguments) else {
            return Err(not_understood(name));
        };
        let ty = match &vector.value {
            Value::Matrix(matrix) => matrix.ty,
            Value::Field(path) => return Err(super::unknown_type(path)),
            other => {
                return Err(format!(
                    "`{name}` takes a vector, and this is {}",
                    other.kind()
                ));
            }
        };
        let Some(vector) = self.matrix_argument(vector, ty, name) else {
            return Ok(None);
        };
        let vector = match name {
            "new_normalize" => normalized(self.arena, &vector),
            _ => vector,
        };
        Ok(Some(
            self.computed_matrix(vector.with_kind(Kind::Unit), &at),
        ))
    }
}

fn not_understood(name: &str) -> String {
    format!("`{name}` of a type of nalgebra is not understood: {UNDERSTOOD}")
}

//! Functions that create vectors, matrices and rotations: `Vector3::new(…)`,
//! `SMatrix::<f64, 2, 3>::zeros()`, `Rotation2::new(…)`.

use proc_macro2::Span;
use syn::spanned::Spanned;

use super::{COMPONENTS, Kind, Matrix, MatrixType};
use crate::algebra::Expr;
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::floats::{are, plural};
use crate::interpret::value::Value;
use crate::syntax::nalgebra::Written;

/// A type of nalgebra in the path of an associated function.
pub(in crate::interpret) struct Constructor {
    path: syn::Path,
    written: Written,
}

impl Constructor {
    /// Reads a path. Returns the type and the name of the function; `None` if the path is not a
    /// function of a type of nalgebra.
    pub(in crate::interpret) fn of(path: &syn::ExprPath) -> Option<(Self, syn::Ident)> {
        let mut of = path.path.clone();
        let function = of.segments.pop()?;
        of.segments.pop_punct();
        let written = Written::of_path(&of).filter(|_| path.qself.is_none())?;
        Some((Self { path: of, written }, function.ident))
    }
}

/// A type whose sizes may follow from the arguments of its constructor.
#[derive(Clone, Copy)]
pub(super) struct PartialType {
    kind: Kind,
    pub(super) rows: Option<usize>,
    columns: Option<usize>,
}

impl PartialType {
    /// Returns the type, if both sizes are known.
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
    /// Calls an associated function of a type of nalgebra.
    pub(in crate::interpret) fn construct(
        &mut self,
        Constructor { path, written }: Constructor,
        name: &syn::Ident,
        arguments: &[Argument],
    ) -> Option<Value> {
        if written.has_floats == Some(false) {
            return self.refuse(&path, "every number of a body is an `f64`");
        }
        let mut values = arguments.iter().map(|argument| &argument.value);
        if values.any(|value| matches!(value, Value::Poison)) {
            return None;
        }
        let [rows, columns] = [&written.rows, &written.columns].map(|size| self.size(size));
        let made = PartialType {
            kind: written.kind,
            rows: rows.ok()?,
            columns: columns.ok()?,
        };
        let (name, at) = (name.to_string(), name.span());
        if let Some(message) = made.ty().and_then(MatrixType::unusable) {
            return self.refuse(&at, message);
        }
        match made.kind {
            Kind::Matrix => self.new_matrix(made, &name, at, arguments),
            Kind::Rotation => self.new_rotation(made, &name, at, arguments),
            Kind::Unit => self.new_unit(&name, at, arguments),
        }
    }

    /// Creates a vector or matrix.
    fn new_matrix(
        &mut self,
        made: PartialType,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Option<Value> {
        match (name, arguments) {
            ("from_diagonal", [diagonal]) => return self.matrix_of_diagonal(made, diagonal, at),
            ("from_columns" | "from_rows", [list]) => return self.joined(made, name, list, at),
            ("from", [argument]) => {
                return self.converted_matrix(&argument.value, made.ty(), &argument.at);
            }
            ("zeros" | "identity", [])
            | ("new", _)
            | (
                "repeat"
                | "from_element"
                | "from_diagonal_element"
                | "from_row_slice"
                | "from_column_slice"
                | "from_fn",
                [_],
            ) => {}
            (axis, []) => return self.axis(made, axis, at),
            _ => return self.no_constructor(name, at),
        }
        let Some(ty) = made.ty() else {
            return self.refuse(&at, NO_SIZE);
        };
        let matrix = match (name, arguments) {
            ("from_row_slice" | "from_column_slice", [list]) => {
                let items = self.items_of_slice(list)?;
                if name == "from_row_slice" {
                    self.matrix_of_rows(ty, name, &items, at)?
                } else {
                    let transposed = MatrixType::matrix(ty.columns, ty.rows);
                    self.matrix_of_rows(transposed, name, &items, at)?
                        .transposed()
                }
            }
            ("from_fn", [function]) => self.matrix_of_closure(ty, function, at)?,
            ("new", _) => self.matrix_of_rows(ty, name, arguments, at)?,
            ("repeat" | "from_element", [x]) => {
                let x = self.scalar(&x.value, &x.at)?;
                Matrix::from_fn(ty, |_, _| x)
            }
            ("from_diagonal_element", [x]) => {
                let x = self.scalar(&x.value, &x.at)?;
                self.diagonal_matrix(ty, |_| x)
            }
            _ => {
                let x = f64::from(u8::from(name == "identity"));
                let x = self.arena.constant(x);
                self.diagonal_matrix(ty, |_| x)
            }
        };
        Some(matrix.into())
    }

    /// Creates a matrix with these numbers on the diagonal and 0 elsewhere.
    pub(super) fn diagonal_matrix(
        &mut self,
        ty: MatrixType,
        diagonal: impl Fn(usize) -> Expr,
    ) -> Matrix<Expr> {
        let zero = self.arena.constant(0.0);
        Matrix::from_fn(ty, |i, j| if i == j { diagonal(i) } else { zero })
    }

    /// Creates a matrix from its numbers, row by row.
    fn matrix_of_rows(
        &mut self,
        ty: MatrixType,
        name: &str,
        arguments: &[Argument],
        at: Span,
    ) -> Option<Matrix<Expr>> {
        if arguments.len() != ty.len() {
            let message = format!(
                "`{name}` of a `{ty}` takes {}, here {}",
                plural(ty.len(), "number"),
                are(arguments.len())
            );
            return self.refuse(&at, message);
        }
        self.work(ty.len(), &at)?;
        let numbers = self.scalars(arguments)?;
        Some(Matrix::from_fn(ty, |i, j| numbers[i * ty.columns + j]))
    }

    fn matrix_of_diagonal(
        &mut self,
        made: PartialType,
        diagonal: &Argument,
        at: Span,
    ) -> Option<Value> {
        let rows = match (&diagonal.value, made.rows.or(made.columns)) {
            (_, Some(rows)) => rows,
            (Value::Matrix(matrix), None) => matrix.ty.rows,
            _ => return self.refuse(&at, NO_SIZE),
        };
        let vector = self.matrix_argument(diagonal, MatrixType::vector(rows), "from_diagonal")?;
        let square = MatrixType::matrix(rows, rows);
        if let Some(message) = square.unusable() {
            return self.refuse(&at, message);
        }
        Some(self.diagonal_matrix(square, |i| vector.entries[i]).into())
    }

    /// Creates a matrix from its columns or its rows.
    fn joined(
        &mut self,
        made: PartialType,
        name: &str,
        list: &Argument,
        at: Span,
    ) -> Option<Value> {
        let items = self.items_of_slice(list)?;
        let by_columns = name == "from_columns";
        let (length, count, noun) = if by_columns {
            (made.rows, made.columns, "column")
        } else {
            (made.columns, made.rows, "row")
        };
        let found = items.iter().find_map(|item| match &item.value {
            Value::Matrix(matrix) => Some(matrix.ty.len()),
            _ => None,
        });
        let Some(length) = length.or(found) else {
            return self.refuse(&at, NO_SIZE);
        };
        if let Some(count) = count.filter(|&count| count != items.len()) {
            let message = format!(
                "this matrix has {}, here {}",
                plural(count, noun),
                are(items.len())
            );
            return self.refuse(&at, message);
        }
        let part = if by_columns {
            MatrixType::vector(length)
        } else {
            MatrixType::matrix(1, length)
        };
        let ty = MatrixType::matrix(length, items.len());
        let whole = if by_columns { ty } else { ty.transposed() };
        if let Some(message) = whole.unusable() {
            return self.refuse(&at, message);
        }
        let mut entries = Vec::new();
        for item in &items {
            entries.extend(self.matrix_argument(item, part, name)?.entries);
        }
        let matrix = Matrix { ty, entries };
        Some(
            if by_columns {
                matrix
            } else {
                matrix.transposed()
            }
            .into(),
        )
    }

    /// Returns the items of an array as arguments.
    fn items_of_slice(&mut self, list: &Argument) -> Option<Vec<Argument>> {
        let Value::Array(items) = &list.value else {
            let kind = list.value.kind();
            return self.refuse(
                &list.at,
                format!("expected an array, `&[a, b]`, found {kind}"),
            );
        };
        let at = list.at;
        let items = items.iter().cloned();
        Some(items.map(|value| Argument { value, at }).collect())
    }

    /// Evaluates `from`. An array of numbers becomes a vector; the arrays in an array of arrays
    /// become the columns of a matrix.
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
            (Value::Field(path), Some(ty)) if ty.is_vector() => {
                vec![(0..ty.rows).map(|i| Value::Field(path.index(i))).collect()]
            }
            (Value::Field(path), Some(ty)) => {
                let entry = |i, j| Value::Field(path.index(j).index(i));
                return Some(Value::Matrix(Matrix::from_fn(ty.plain(), entry)));
            }
            (Value::Array(items), Some(ty)) if ty.is_vector() => vec![items.clone()],
            (Value::Array(items), _)
                if items.iter().all(|item| matches!(item, Value::Array(_))) =>
            {
                items.iter().map(|item| item.items().to_vec()).collect()
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
        self.refuse(at, message)
    }

    /// Evaluates `from_fn(|i, j| …)`.
    fn matrix_of_closure(
        &mut self,
        ty: MatrixType,
        function: &Argument,
        at: Span,
    ) -> Option<Matrix<Expr>> {
        let Value::Closure(closure) = &function.value else {
            let message = "`from_fn` takes a closure of row and column, `|i, j| …`";
            return self.refuse(&at, message);
        };
        let indices = Matrix::from_fn(ty, |row, column| vec![row, column]).entries;
        let indices = indices.into_iter();
        let indices = indices.map(|pair| pair.into_iter().map(Value::count).collect());
        let entries = self.called(closure, indices, function.at)?;
        self.numbers(&Matrix { ty, entries }, &function.at)
    }

    /// Creates the unit vector along an axis: `Vector3::x()`, or as a `Unit`, `Vector3::x_axis()`.
    fn axis(&mut self, made: PartialType, name: &str, at: Span) -> Option<Value> {
        let letter = name.strip_suffix("_axis").unwrap_or(name);
        let place = COMPONENTS.iter().position(|component| *component == letter);
        let (Some(place), Some(ty)) = (place, made.ty()) else {
            return self.no_constructor(name, at);
        };
        if !ty.is_vector() || place >= ty.rows {
            return self.refuse(&at, format!("a `{ty}` has no axis `{letter}`"));
        }
        let [zero, one] = [0.0, 1.0].map(|x| self.arena.constant(x));
        let kind = if letter == name {
            Kind::Matrix
        } else {
            Kind::Unit
        };
        let axis = Matrix::from_fn(ty, |i, _| if i == place { one } else { zero });
        Some(axis.with_kind(kind).into())
    }

    pub(super) fn no_constructor<T>(&mut self, name: &str, at: Span) -> Option<T> {
        let message = format!("`{name}` of a type of nalgebra is not understood: {UNDERSTOOD}");
        self.refuse(&at, message)
    }
}

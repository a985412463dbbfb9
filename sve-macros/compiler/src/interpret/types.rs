//! Types that the source annotates: of arguments, results, variables and constants.

use syn::spanned::Spanned;
use syn::{Expr as Syntax, Ident, Type};

use super::Lowering;
use super::fields::unseen;
use super::matrices::{Kind, Matrix, MatrixType};
use super::value::Value;
use crate::model::configuration::Factor;
use crate::syntax::nalgebra::{Size, Written};
use crate::syntax::parse::is_f64;
use crate::syntax::signature::is_rotation;
use crate::syntax::{bare, readable};

/// The type of an argument or result: `f64`, a vector, or arrays of these.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Scalar,
    Vector(MatrixType),
    Array(usize, Box<Shape>),
}

impl Shape {
    /// Returns the number of `f64` in a value of this shape.
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Scalar => 1,
            Self::Vector(ty) => ty.len(),
            Self::Array(n, inner) => n * inner.len(),
        }
    }

    /// Returns the length of the outermost array.
    pub(super) fn outer_length(&self) -> usize {
        match self {
            Self::Array(n, _) => *n,
            other => other.len(),
        }
    }

    /// Returns whether the shape is or contains a vector of nalgebra.
    pub(super) fn has_vectors(&self) -> bool {
        match self {
            Self::Scalar => false,
            Self::Vector(_) => true,
            Self::Array(_, inner) => inner.has_vectors(),
        }
    }

    /// Returns the shape of the velocities of a configuration of this shape. A rotation has a
    /// vector as its velocity.
    pub(super) fn velocity(&self) -> Self {
        match self {
            Self::Vector(ty) if ty.kind == Kind::Rotation => Self::Vector(MatrixType::vector(3)),
            Self::Array(n, inner) => Self::Array(*n, Box::new(inner.velocity())),
            other => other.clone(),
        }
    }

    /// Appends the factors of the configuration space of this shape.
    pub(super) fn factors(&self, to: &mut Vec<Factor>) {
        match self {
            Self::Vector(ty) if ty.kind == Kind::Rotation => to.push(Factor::Rotation),
            Self::Array(n, inner) if inner.has_rotations() => {
                (0..*n).for_each(|_| inner.factors(to));
            }
            other => to.push(Factor::Vector(other.len())),
        }
    }

    /// Returns whether the shape is or contains a rotation.
    pub(super) fn has_rotations(&self) -> bool {
        match self {
            Self::Scalar => false,
            Self::Vector(ty) => ty.kind == Kind::Rotation,
            Self::Array(_, inner) => inner.has_rotations(),
        }
    }

    /// Returns a value of this shape with entries from `next`, in memory order.
    pub(super) fn fill(&self, next: &mut dyn FnMut() -> Value) -> Value {
        match self {
            Self::Scalar => next(),
            Self::Vector(ty) => Value::Matrix(Matrix {
                ty: *ty,
                entries: (0..ty.len()).map(|_| next()).collect(),
            }),
            Self::Array(n, inner) => Value::Array((0..*n).map(|_| inner.fill(next)).collect()),
        }
    }
}

/// Largest number of coordinates of a system, since the step is unrolled.
const COORDINATES: usize = 512;

impl Lowering<'_> {
    /// Returns the shape of a type of configurations, which may be rotations, or reports an error
    /// at the type.
    pub(super) fn configuration_shape(&mut self, ty: &Type) -> Option<Shape> {
        let ty = bare(ty);
        match ty {
            Type::Array(array) if is_rotation(&array.elem) => {
                let inner = self.configuration_shape(&array.elem)?;
                let n = self.length(&array.len)?;
                if n.saturating_mul(inner.len()) <= COORDINATES {
                    return Some(Shape::Array(n, Box::new(inner)));
                }
                let message = format!(
                    "{n} rotations have more than {COORDINATES} entries, which are too many to unroll"
                );
                self.refuse(&array.len, message)
            }
            _ if is_rotation(ty) => {
                let written = Written::of_type(ty)?;
                let is_spatial = matches!(written.rows, Size::Known(3));
                if is_spatial && written.has_floats == Some(true) {
                    return Some(Shape::Vector(MatrixType {
                        kind: Kind::Rotation,
                        ..MatrixType::matrix(3, 3)
                    }));
                }
                let message = format!(
                    "`{}` is not a type of configurations: rotations are `Rotation3<f64>`, by value; a rotation in the plane is its angle, `f64`",
                    readable(ty)
                );
                self.refuse(ty, message)
            }
            _ => self.shape(ty),
        }
    }

    /// Returns the shape of a type, or reports an error at the type.
    pub(super) fn shape(&mut self, ty: &Type) -> Option<Shape> {
        let shape = self.shape_within(ty)?;
        self.check_size(shape.len(), ty)?;
        Some(shape)
    }

    /// Reports an error at `at` if a system may not have this number of coordinates.
    fn check_size(&mut self, size: usize, at: &impl Spanned) -> Option<()> {
        if size <= COORDINATES {
            return Some(());
        }
        let message = format!("{size} numbers are too many to unroll; the limit is {COORDINATES}");
        self.refuse(at, message)
    }

    fn shape_within(&mut self, ty: &Type) -> Option<Shape> {
        let ty = bare(ty);
        match ty {
            _ if is_f64(ty) => Some(Shape::Scalar),
            Type::Array(array) => {
                let inner = self.shape_within(&array.elem)?;
                let n = self.length(&array.len)?;
                self.check_size(n, &array.len)?;
                Some(Shape::Array(n, Box::new(inner)))
            }
            _ => {
                if let Some(written) = Written::of_type(ty) {
                    return self.vector_shape(ty, &written);
                }
                let written = readable(ty);
                let words = ["Rotation", "Quaternion"];
                let expected = if words.iter().any(|word| written.contains(word)) {
                    "a rotation is written `Rotation3<f64>`, by value, and its velocity and momentum `Vector3<f64>`"
                } else {
                    "write `f64`, `[f64; N]` or a vector such as `Vector3<f64>`, by value"
                };
                let message = format!("`{written}` is not a type of coordinates: {expected}");
                self.refuse(ty, message)
            }
        }
    }

    /// Returns the shape of a vector of nalgebra, or reports an error.
    fn vector_shape(&mut self, ty: &Type, written: &Written) -> Option<Shape> {
        if !written.is_vector() || written.has_floats != Some(true) {
            let message = format!(
                "`{}` is not a type of coordinates: of nalgebra's types write `Vector3<f64>` or `SVector<f64, N>`, by value",
                readable(ty)
            );
            return self.refuse(ty, message);
        }
        let Some(rows) = self.size(&written.rows).ok()? else {
            let message = "the number of entries is not written: write `SVector<f64, N>`";
            return self.refuse(ty, message);
        };
        self.check_size(rows, ty)?;
        Some(Shape::Vector(MatrixType::vector(rows)))
    }

    /// Evaluates a size; `None` if the size is to be inferred. Reports an error and returns `Err`
    /// if the size is unknown.
    pub(super) fn size(&mut self, size: &Size) -> Result<Option<usize>, ()> {
        match size {
            Size::Known(n) => Ok(Some(*n)),
            Size::Omitted => Ok(None),
            Size::Written(expr) => self.length(expr).map(Some).ok_or(()),
        }
    }

    fn length(&mut self, expr: &Syntax) -> Option<usize> {
        if let Some(name) = bare_name(expr) {
            let message = if self.constant_named(&name.to_string()).is_some() {
                format!("a constant of this block is written `Self::{name}`")
            } else {
                unseen(&name.to_string(), &name.to_string())
            };
            return self.refuse(name, message);
        }
        let message = match self.scoped(|this| this.eval(expr))? {
            Value::Int(n) if n.value >= 0 => return usize::try_from(n.value).ok(),
            other => other.unseen().unwrap_or_else(|| {
                format!("the length must be an integer known here, a literal or a constant of this block; found {}", other.kind())
            }),
        };
        self.refuse(expr, message)
    }
}

/// Returns a name without a path in a length.
fn bare_name(expr: &Syntax) -> Option<&Ident> {
    match expr {
        Syntax::Path(path) => path.path.get_ident(),
        Syntax::Binary(binary) => bare_name(&binary.left).or_else(|| bare_name(&binary.right)),
        Syntax::Paren(inner) => bare_name(&inner.expr),
        Syntax::Cast(cast) => bare_name(&cast.expr),
        _ => None,
    }
}

impl Lowering<'_> {
    /// Converts a value to its annotated type. A field of the user's struct gets its length or size
    /// from the type. If Rust converts between arrays and vectors (`into`), the value is converted.
    pub(super) fn ascribed(&mut self, value: Value, ty: &Type) -> Value {
        let value = self.awaited(value, ty, ty);
        let ty = bare(ty);
        match (value, ty) {
            (value, Type::Reference(reference)) => self.ascribed(value, &reference.elem),
            (Value::Field(path), Type::Array(array)) => {
                let Some(n) = self.length_of_type(&array.len) else {
                    return Value::Field(path);
                };
                let entries = (0..n).map(|i| Value::Field(path.index(i)));
                Value::Array(
                    entries
                        .map(|entry| self.ascribed(entry, &array.elem))
                        .collect(),
                )
            }
            (Value::Field(path), ty) if is_f64(ty) => Value::Field(path.as_number()),
            (Value::Matrix(matrix), Type::Array(array)) => Value::Array(match &*array.elem {
                Type::Array(_) => matrix
                    .entries
                    .chunks(matrix.ty.rows.max(1))
                    .map(|column| Value::Array(column.to_vec()))
                    .collect(),
                _ => matrix.entries,
            }),
            (Value::Array(values), Type::Array(array)) => Value::Array(
                values
                    .into_iter()
                    .map(|value| self.ascribed(value, &array.elem))
                    .collect(),
            ),
            (Value::Tuple(values), Type::Tuple(types)) if values.len() == types.elems.len() => {
                let pairs = values.into_iter().zip(&types.elems);
                Value::Tuple(pairs.map(|(value, ty)| self.ascribed(value, ty)).collect())
            }
            (value @ (Value::Field(_) | Value::Array(_)), Type::Path(_)) => {
                match (value, self.matrix_type(ty)) {
                    (Value::Field(path), Some(ty)) => Value::Matrix(Matrix::of_field(&path, ty)),
                    (value, Some(matrix)) => self
                        .converted_matrix(&value, Some(matrix), ty)
                        .unwrap_or(Value::Poison),
                    (value, None) => value,
                }
            }
            (value, _) => value,
        }
    }

    /// Returns the type of nalgebra that the source annotates, if its size is known. Reports no
    /// errors, since the compiler of Rust checks types.
    pub(super) fn matrix_type(&mut self, ty: &Type) -> Option<MatrixType> {
        let written = Written::of_type(ty).filter(|written| written.has_floats == Some(true))?;
        let mut size = |size: &Size| match size {
            Size::Known(n) => Some(*n),
            Size::Written(expr) => self.length_of_type(expr),
            Size::Omitted => None,
        };
        let (rows, columns) = size(&written.rows).zip(size(&written.columns))?;
        let ty = MatrixType {
            kind: written.kind,
            rows,
            columns,
        };
        ty.unusable().is_none().then_some(ty)
    }

    /// Evaluates a length made of literals and constants of the block; `None` for other lengths.
    /// Reports no errors, since the compiler of Rust checks types.
    fn length_of_type(&mut self, length: &Syntax) -> Option<usize> {
        let errors = std::mem::take(&mut self.errors);
        let broken = self.calls.broken.clone();
        let value = self.eval(length);
        self.errors = errors;
        self.calls.broken = broken;
        let Value::Int(n) = value? else { return None };
        let n = usize::try_from(n.value).ok()?;
        self.work(n, length)?;
        Some(n)
    }
}

//! What functions with roles return: numbers and rows of numbers, as expressions; errors where a result has another type than its role.

use syn::Type;
use syn::spanned::Spanned;

use super::Lowering;
use super::matrices::Matrix;
use super::roles::Space;
use super::types::Shape;
use super::value::Value;
use crate::algebra::Expr;
use crate::syntax::parse::RoleFunction;
use crate::syntax::readable;

impl Lowering<'_> {
    pub(super) fn scalar_result(&mut self, function: &RoleFunction, value: &Value) -> Option<Expr> {
        if self.shape(&function.output)? != Shape::Scalar {
            self.errors.push(
                function.output.span(),
                format!("`{}` must return `f64`, one number: the energy of motion less that of position", function.name),
            );
            return None;
        }
        self.result(function, value)
    }

    /// Returns the expression of the value that a function returns, or reports an error at its last expression.
    pub(super) fn result(&mut self, function: &RoleFunction, value: &Value) -> Option<Expr> {
        let outer = self.errors.enter(&function.name.to_string());
        let result = match function.item.block.stmts.last() {
            Some(syn::Stmt::Expr(_, Some(semicolon))) => self.scalar(value, semicolon),
            Some(last) => self.scalar(value, last),
            None => self.scalar(value, &function.name),
        };
        self.errors.leave(outer);
        result
    }

    /// Returns the components of a vector of the shape of the coordinates, or reports an error.
    pub(super) fn vector_result(
        &mut self,
        function: &RoleFunction,
        value: &Value,
        space: &Space,
    ) -> Option<Vec<Expr>> {
        let arguments = &function.arguments[usize::from(function.is_timed)..];
        let shapes = space.shapes.iter().chain(&space.velocities);
        if !arguments.len().is_multiple_of(space.shapes.len())
            || arguments
                .iter()
                .zip(shapes)
                .any(|((_, ty), shape)| self.configuration_shape(ty).as_ref() != Some(shape))
        {
            // the argument has been reported
            return None;
        }
        let [shape] = space.velocities.as_slice() else {
            return self.pair_result(function, value, space);
        };
        if self.symbols.configuration.has_rotations() {
            if self.configuration_shape(&function.output)? != *shape {
                self.report_other_result(function);
                return None;
            }
        } else if self.shape(&function.output)? != *shape {
            let coordinates = self.block.coordinates();
            self.errors.push(
                function.output.span(),
                format!(
                    "`{}` must return a vector like the coordinates, `{}`",
                    function.name,
                    readable(coordinates)
                ),
            );
            return None;
        }
        let mut entries = Vec::new();
        self.entries(value, shape, &function.name, &mut entries)?;
        Some(entries)
    }

    /// Returns the components of a tuple of two vectors, those of a vector and those of a rotation, or reports an error.
    pub(super) fn pair_result(
        &mut self,
        function: &RoleFunction,
        value: &Value,
        space: &Space,
    ) -> Option<Vec<Expr>> {
        let Type::Tuple(types) = &function.output else {
            self.report_other_result(function);
            return None;
        };
        for (index, shape) in space.velocities.iter().enumerate() {
            let found = types.elems.get(index).and_then(|ty| self.shape(ty));
            if found.as_ref() != Some(shape) || types.elems.len() != space.velocities.len() {
                self.report_other_result(function);
                return None;
            }
        }
        let mut entries = Vec::new();
        match value {
            Value::Tuple(values) if values.len() == space.velocities.len() => {
                for (value, shape) in values.iter().zip(&space.velocities) {
                    self.entries(value, shape, &function.name, &mut entries)?;
                }
            }
            Value::Poison => return None,
            _ => {
                self.report_other_result(function);
                return None;
            }
        }
        Some(entries)
    }

    /// Reports a result of another type than a field of directions has in a system with rotations.
    pub(super) fn report_other_result(&mut self, function: &RoleFunction) {
        let expected = function.role.signature_with_rotations(function.parts);
        let message = format!(
            "`{}` must return a vector for each part, and that of a rotation is a `Vector3<f64>` in the body frame: expected `{expected}`",
            function.name
        );
        self.errors.push(function.output.span(), message);
    }

    /// Reports an argument of another type than its place has in a system with rotations.
    pub(super) fn report_other_part(&mut self, ty: &Type) {
        let parts: Vec<String> = self.block.configuration().map(readable).collect();
        let parts = parts.join("`, `");
        let message = format!(
            "`{}` does not fit the configuration `{parts}` of `lagrangian`: the velocity and the momentum of a `Rotation3<f64>` are a `Vector3<f64>` in the body frame, those of a vector are of its type, and all functions have the arguments of all parts",
            readable(ty)
        );
        self.errors.push(ty.span(), message);
    }

    /// Appends the numbers of a value of a known shape to `out`, in memory order.
    pub(super) fn entries(
        &mut self,
        value: &Value,
        shape: &Shape,
        at: &impl Spanned,
        out: &mut Vec<Expr>,
    ) -> Option<()> {
        match (shape, value) {
            (Shape::Scalar, value) => out.push(self.scalar(value, at)?),
            (Shape::Vector(ty), Value::Field(path)) => {
                for entry in &Matrix::of_field(path, *ty).entries {
                    out.push(self.scalar(entry, at)?);
                }
            }
            (Shape::Vector(ty), Value::Matrix(matrix)) if matrix.ty == *ty => {
                for entry in &matrix.entries {
                    out.push(self.scalar(entry, at)?);
                }
            }
            (Shape::Array(n, inner), Value::Field(path)) => {
                for i in 0..*n {
                    self.entries(&Value::Field(path.index(i)), inner, at, out)?;
                }
            }
            (Shape::Array(n, inner), Value::Array(values)) if values.len() == *n => {
                for value in values {
                    self.entries(value, inner, at, out)?;
                }
            }
            (_, Value::Poison) => return None,
            (shape, other) => {
                let expected = match shape {
                    Shape::Vector(ty) => format!("a `{ty}`"),
                    shape => format!("an array of {}", shape.outer_length()),
                };
                let message = format!("expected {expected}, found {}", other.kind());
                self.errors.push(at.span(), message);
                return None;
            }
        }
        Some(())
    }
}

/// Why a value has no components.
pub(super) enum Mismatch {
    /// A mistake in it has been reported.
    Reported,
    /// It is not a number or a row of numbers.
    Shape,
}

/// Returns the numbers that a function returns, each with its name: `f`, or `f[0]`, `f[1]`, ….
pub(super) fn components(
    function: &RoleFunction,
    shape: &Shape,
    value: Value,
) -> Result<Vec<(String, Value)>, Mismatch> {
    let indexed = |values: Vec<Value>| {
        let named = |(i, value)| (format!("{}[{i}]", function.name), value);
        values.into_iter().enumerate().map(named).collect()
    };
    match (shape, value) {
        (_, Value::Poison) => Err(Mismatch::Reported),
        (Shape::Scalar, value) => Ok(vec![(function.name.to_string(), value)]),
        (Shape::Array(_, inner), Value::Array(values)) if **inner == Shape::Scalar => {
            Ok(indexed(values))
        }
        (Shape::Vector(ty), Value::Matrix(matrix)) if matrix.ty == *ty => {
            Ok(indexed(matrix.entries))
        }
        _ => Err(Mismatch::Shape),
    }
}

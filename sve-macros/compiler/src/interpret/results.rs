//! Results of functions with roles: numbers and rows of numbers, as expressions. A result whose
//! type differs from the type of its role is an error.

use proc_macro2::Span;
use syn::spanned::Spanned;
use syn::{Stmt, Type};

use super::Lowering;
use super::matrices::Matrix;
use super::names;
use super::roles::Space;
use super::types::Shape;
use super::value::Value;
use crate::algebra::Expr;
use crate::syntax::parse::RoleFunction;
use crate::syntax::readable;
use crate::syntax::roles::Role;

impl Lowering<'_> {
    pub(super) fn scalar_result(&mut self, function: &RoleFunction, value: &Value) -> Option<Expr> {
        if self.shape(&function.output)? == Shape::Scalar {
            return self.result(function, value);
        }
        let what = match function.role {
            Role::TimeScale => "the time that passes in a unit of τ",
            _ => "the energy of motion less that of position",
        };
        let message = format!("`{}` must return `f64`, one number: {what}", function.name);
        self.refuse(&function.output, message)
    }

    /// Returns the expression of the value that a function returns, or reports an error at its last
    /// expression.
    pub(super) fn result(&mut self, function: &RoleFunction, value: &Value) -> Option<Expr> {
        let outer = self.errors.enter(&function.name.to_string());
        let result = self.scalar(value, &end(function));
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
        let has_rotations = self.symbols.configuration.has_rotations();
        let found = if has_rotations {
            self.configuration_shape(&function.output)?
        } else {
            self.shape(&function.output)?
        };
        if found != *shape {
            if has_rotations {
                return self.other_result(function);
            }
            let coordinates = readable(self.block.coordinates());
            let message = format!(
                "`{}` must return a vector like the coordinates, `{coordinates}`",
                function.name
            );
            return self.refuse(&function.output, message);
        }
        let mut entries = Vec::new();
        self.entries(value, shape, &function.name, &mut entries)?;
        Some(entries)
    }

    /// Returns the components of a tuple of two vectors, one for a vector and one for a rotation,
    /// or reports an error.
    fn pair_result(
        &mut self,
        function: &RoleFunction,
        value: &Value,
        space: &Space,
    ) -> Option<Vec<Expr>> {
        let shapes = &space.velocities;
        let types: Vec<&Type> = match &function.output {
            Type::Tuple(types) if types.elems.len() == shapes.len() => types.elems.iter().collect(),
            _ => return self.other_result(function),
        };
        for (ty, shape) in types.into_iter().zip(shapes) {
            if self.shape(ty).as_ref() != Some(shape) {
                return self.other_result(function);
            }
        }
        let values = match value {
            Value::Tuple(values) if values.len() == shapes.len() => values,
            Value::Poison => return None,
            _ => return self.other_result(function),
        };
        let mut entries = Vec::new();
        for (value, shape) in values.iter().zip(shapes) {
            self.entries(value, shape, &function.name, &mut entries)?;
        }
        Some(entries)
    }

    /// Reports a result whose type differs from the type of a field of directions in a system with
    /// rotations.
    fn other_result<T>(&mut self, function: &RoleFunction) -> Option<T> {
        let expected = function.role.signature_with_rotations(function.parts);
        let message = format!(
            "`{}` must return a vector for each part, and that of a rotation is a `Vector3<f64>` in the body frame: expected `{expected}`",
            function.name
        );
        self.refuse(&function.output, message)
    }

    /// Reports an argument whose type differs from the type of its place in a system with
    /// rotations.
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
                let matrix = self.numbers(&Matrix::of_field(path, *ty), at)?;
                out.extend(matrix.entries);
            }
            (Shape::Vector(ty), Value::Matrix(matrix)) if matrix.ty == *ty => {
                out.extend(self.numbers(matrix, at)?.entries);
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
                return self.refuse(at, message);
            }
        }
        Some(())
    }

    /// Returns the numbers that a function returns in the order of memory, each with its name: `f`,
    /// or `f[0]`, `f[1]`, …, or the other names of coordinates of this shape.
    pub(super) fn named_results(
        &mut self,
        function: &RoleFunction,
        shape: &Shape,
        value: &Value,
    ) -> Vec<(String, Expr)> {
        let (mut names, mut numbers) = (Vec::new(), Vec::new());
        let name = function.name.to_string();
        names::entries(&name, shape, &mut names);
        let outer = self.errors.enter(&name);
        self.entries(value, shape, &end(function), &mut numbers);
        self.errors.leave(outer);
        names.into_iter().zip(numbers).collect()
    }
}

/// Returns the place of the value that a function returns: its last expression.
fn end(function: &RoleFunction) -> Span {
    match function.item.block.stmts.last() {
        Some(Stmt::Expr(_, Some(semicolon))) => semicolon.span(),
        Some(last) => last.span(),
        None => function.name.span(),
    }
}

//! Functions that make rotations and unit vectors, with the formulas of nalgebra.

use proc_macro2::Span;

use super::constructors::{PartialType, not_understood};
use super::formulas::normalized;
use super::{Kind, Matrix, MatrixType};
use crate::algebra::{Expr, Function};
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::value::Value;

impl Lowering<'_> {
    /// Makes a rotation. Returns `None` after a reported error, and `Err` with the message if the call itself is wrong.
    pub(super) fn new_rotation(
        &mut self,
        made: PartialType,
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

    /// Returns the rotation about x, then y, then z, in the convention of nalgebra.
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

    /// Returns the rotation by θ about a unit vector u, by Rodrigues' formula cos θ 1 + sin θ [u]ₓ + (1 − cos θ) u uᵀ.
    fn axis_rotation(&mut self, axis: &Matrix<Expr>, angle: Expr) -> Matrix<Expr> {
        let [sin, cos] = self.sin_cos(angle);
        let arena = &mut *self.arena;
        let one = arena.constant(1.0);
        let rest = arena.sub(one, cos);
        Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| {
            if i == j {
                let square = arena.pow(axis.entries[i], 2);
                let complement = arena.sub(one, square);
                let scaled = arena.mul(complement, cos);
                return arena.add(square, scaled);
            }
            // the entry of [u]ₓ: the component along the third axis, whose sign depends on the order of i and j
            let along = arena.mul(axis.entries[3 - i - j], sin);
            let product = arena.product(&[(axis.entries[i], 1), (axis.entries[j], 1), (rest, 1)]);
            if (i + 1) % 3 == j {
                arena.sub(product, along)
            } else {
                arena.add(product, along)
            }
        })
    }

    /// Makes a unit vector.
    pub(super) fn new_unit(
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
            Value::Field(path) => {
                return Err(super::refused::unknown_type(
                    path,
                    &self.example_of_type(None),
                ));
            }
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

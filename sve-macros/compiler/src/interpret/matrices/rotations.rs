//! Functions that create rotations and unit vectors, with the formulas of nalgebra.

use proc_macro2::Span;

use super::constructors::PartialType;
use super::formulas::normalized;
use super::{Kind, Matrix, MatrixType};
use crate::algebra::{Expr, Function};
use crate::interpret::Lowering;
use crate::interpret::calls::Argument;
use crate::interpret::methods::unknown_type;
use crate::interpret::value::Value;

impl Lowering<'_> {
    /// Creates a rotation.
    pub(super) fn new_rotation(
        &mut self,
        made: PartialType,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Option<Value> {
        let size = made.rows.unwrap_or(2);
        let matrix = match (name, size, arguments) {
            ("identity", _, []) => {
                let one = self.arena.constant(1.0);
                self.diagonal_matrix(MatrixType::matrix(size, size), |_| one)
            }
            ("new", 2, [angle]) => {
                let angle = self.scalar(&angle.value, &angle.at)?;
                let [sin, cos] = self.sin_cos(angle);
                let minus_sin = self.arena.neg(sin);
                let rows = [[cos, minus_sin], [sin, cos]];
                Matrix::from_fn(MatrixType::matrix(2, 2), |i, j| rows[i][j])
            }
            ("from_euler_angles", 3, angles @ [_, _, _]) => {
                let angles = self.scalars(angles)?;
                self.euler_rotation([angles[0], angles[1], angles[2]])
            }
            ("from_axis_angle", 3, [axis, angle]) => {
                let axis = self.matrix_argument(axis, MatrixType::vector(3), name);
                let (axis, angle) = axis.zip(self.scalar(&angle.value, &angle.at))?;
                self.axis_rotation(&axis, angle)
            }
            ("from_matrix_unchecked", _, [matrix]) => {
                self.matrix_argument(matrix, MatrixType::matrix(size, size), name)?
            }
            ("new" | "from_scaled_axis", 3, [_]) => {
                let message = format!(
                    "`{name}` divides by the angle, which may be 0: write `Rotation3::from_axis_angle(&Vector3::z_axis(), angle)`"
                );
                return self.refuse(&at, message);
            }
            _ => return self.no_constructor(name, at),
        };
        self.finite_matrix(matrix.with_kind(Kind::Rotation), &at)
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

    /// Returns the rotation by θ about a unit vector u, by Rodrigues' formula cos θ 1 + sin θ
    /// [u]ₓ + (1 − cos θ) u uᵀ.
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
            // the entry of [u]ₓ: the component along the third axis, whose sign depends on the
            // order of i and j
            let along = arena.mul(axis.entries[3 - i - j], sin);
            let product = arena.product(&[(axis.entries[i], 1), (axis.entries[j], 1), (rest, 1)]);
            if (i + 1) % 3 == j {
                arena.sub(product, along)
            } else {
                arena.add(product, along)
            }
        })
    }

    /// Creates a unit vector.
    pub(super) fn new_unit(
        &mut self,
        name: &str,
        at: Span,
        arguments: &[Argument],
    ) -> Option<Value> {
        let ("new_normalize" | "new_unchecked", [vector]) = (name, arguments) else {
            return self.no_constructor(name, at);
        };
        let message = match &vector.value {
            Value::Matrix(matrix) => {
                let vector = self.numbers(matrix, &vector.at)?;
                let vector = match name {
                    "new_normalize" => normalized(self.arena, &vector),
                    _ => vector,
                };
                return self.finite_matrix(vector.with_kind(Kind::Unit), &at);
            }
            Value::Field(path) => unknown_type(path, &self.example_of_vector()),
            other => format!("`{name}` takes a vector, and this is {}", other.kind()),
        };
        self.refuse(&at, message)
    }
}

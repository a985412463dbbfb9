//! Construction, parts and products of matrices.

use sve_models::language::{check, close};
use sve_runtime::nalgebra as na;
use sve_runtime::nalgebra::{Matrix2, Matrix2x3, Matrix3, Matrix3x2, SMatrix, Vector2, Vector3};
use sve_runtime::prelude::*;
use sve_runtime::system::System;

/// Matrices: construction, parts, products, and parameters whose types are written.
struct Matrices {
    inertia: Matrix2<f64>,
    coupling: SMatrix<f64, 2, 3>,
    stiffness: [[f64; 2]; 2],
    scale: f64,
}

#[variational(midpoint)]
impl Matrices {
    const SHEAR: Matrix2<f64> = Matrix2::new(1.0, 0.5, -0.25, 2.0);

    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let inertia: Matrix2<f64> = self.inertia;
        let mass = inertia + Self::metric(&q) * self.scale;
        0.5 * v.dot(&(mass * v)) + self.made(q, v) + self.taken_apart(q, v)
            - mass.determinant() / mass.trace()
            + (v.transpose() * self.inertia() * q)[(0, 0)]
            + self.inertia[(0, 1)] * q.x
    }

    fn inertia(&self) -> Matrix2<f64> {
        self.inertia
    }

    fn metric(q: &Vector2<f64>) -> Matrix2<f64> {
        Matrix2::identity() + q * q.transpose() + Matrix2::from_diagonal(&q.map(|x| x * x))
    }

    fn made(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let (a, b) = (q.x, v.y);
        let wide = Matrix2x3::new(a, b, 1.0, 2.0, a * b, 3.0);
        let tall = Matrix3x2::from_columns(&[Vector3::new(a, b, 1.0), Vector3::repeat(b)]);
        let stacked = Matrix2::from_rows(&[q.transpose(), v.transpose()]);
        let rows = Matrix2::from_row_slice(&[a, b, 1.0, 2.0]);
        let columns = Matrix2::from_column_slice(&[a, b, 1.0, 2.0]);
        let nested = Matrix2::from([[a, b], [1.0, 2.0]]);
        let stiffness = Matrix2::from(self.stiffness);
        let computed = SMatrix::<f64, 2, 2>::from_fn(|i, j| (i as f64 + 1.0) * a + j as f64 * b);
        let coupling: SMatrix<f64, 2, 3> = self.coupling;
        (wide * tall).determinant()
            + stacked.norm()
            + (rows * columns - nested).component_mul(&stiffness).sum()
            + (computed * Self::SHEAR * 0.5)[(1, 0)]
            + (coupling * tall).trace()
            + (na::Matrix3::from_diagonal_element(a) * Matrix3::identity()).determinant()
    }

    fn taken_apart(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        let mut m = Matrix3::new(q.x, q.y, 1.0, v.x, v.y, 2.0, q.x * v.y, 0.5, q.y * v.x);
        m[(0, 2)] += m.m21;
        m[1] *= 2.0;
        m.m33 = m[(0, 0)] - m[7];
        let mut sum = m.determinant() + m.transpose().diagonal().norm_squared();
        for column in m.column_iter() {
            sum += column.norm();
        }
        for row in m.row_iter() {
            sum -= row[0] * row[2];
        }
        for (i, x) in m.iter().enumerate() {
            sum += x * i as f64;
        }
        let block = m.fixed_view::<2, 2>(1, 0);
        let big = SMatrix::<f64, 4, 4>::from_fn(|i, j| {
            if i == j {
                1.0 + q.x
            } else {
                q.y / (i + j) as f64
            }
        });
        sum + (block * v).dot(&q) + m.row(1).dot(&m.column(2).transpose()) + big.determinant()
    }
}

#[test]
fn matrices_have_the_derivatives_of_the_users_functions() {
    let system = Matrices {
        inertia: Matrix2::new(2.0, 0.3, 0.3, 1.5),
        coupling: Matrix2x3::new(0.5, 1.0, -1.0, 2.0, 0.25, 0.75),
        stiffness: [[1.0, -0.5], [0.25, 3.0]],
        scale: 0.7,
    };
    check(&system, |_, q, v| {
        system.lagrangian(Vector2::from(*q), Vector2::from(*v))
    });
}

/// The type of the stiffness is written in the noise alone, and holds where L multiplies by it.
struct TypedOnce {
    stiffness: Matrix2<f64>,
    scale: f64,
}

#[variational(midpoint)]
impl TypedOnce {
    fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
        0.5 * v.norm_squared() - 0.5 * q.dot(&(self.stiffness * q)) - self.scale * q.x.powi(4)
    }

    #[gamma]
    fn push(&self, q: Vector2<f64>) -> f64 {
        let stiffness: Matrix2<f64> = self.stiffness;
        (stiffness * q).y
    }
}

#[test]
fn the_type_of_a_matrix_holds_in_the_whole_block() {
    let system = TypedOnce {
        stiffness: Matrix2::new(2.0, 0.3, -0.4, 1.5),
        scale: 0.7,
    };
    check(&system, |_, q, v| {
        system.lagrangian(Vector2::from(*q), Vector2::from(*v))
    });
    let [noise] = system.noise_jets(0.0, &[0.5, 0.2], &[0.0, 0.0]);
    close("by x", noise.dq[0], 0.4, 1e-15);
    close("by y", noise.dq[1], -1.5, 1e-15);
}

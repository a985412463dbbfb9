//! Every operation on vectors, matrices and rotations has the expressions of its entries written
//! out.

use crate::algebra::{Arena, Expr};
use crate::model::Model;

use super::model;
use crate::tests::rows;

/// Returns all expressions of a model.
fn expressions(model: &Model) -> Vec<Expr> {
    let mut all = vec![model.lagrangian];
    all.extend(model.noises.iter().map(|noise| noise.hamiltonian));
    all.extend(model.force.iter().flatten());
    all.extend(model.symmetries.iter().flat_map(|s| &s.field));
    all
}

/// Asserts that two blocks have the same expressions.
fn assert_same(vectors: &str, arrays: &str) {
    let mut arena = Arena::new();
    // the order in which expressions are made must not matter, so the arrays come first
    let plain = model(arrays, &mut arena).unwrap_or_else(|e| panic!("{arrays}: {e:?}"));
    let found = model(vectors, &mut arena).unwrap_or_else(|e| panic!("{vectors}: {e:?}"));
    let (plain, found) = (expressions(&plain), expressions(&found));
    assert_eq!(plain.len(), found.len(), "{vectors}");
    for (plain, found) in plain.into_iter().zip(found) {
        let show = |expr| format!("{:?}", arena.node(expr));
        assert_eq!(
            found,
            plain,
            "{vectors}: {} is not {}",
            show(found),
            show(plain)
        );
    }
}

/// Expressions of two vectors a and b of length 3, a matrix m, and numbers x and y; and the equal
/// expressions with arrays.
const OPERATIONS: &str = r"
a.dot(&b) → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
(&a + &b).norm_squared() → (a[0] + b[0]).powi(2) + (a[1] + b[1]).powi(2) + (a[2] + b[2]).powi(2)
(a - b).norm() → ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
a.metric_distance(&b) → ((a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2)).sqrt()
(-a).sum() → -a[0] - a[1] - a[2]
(a * x - 2.0 * b / y).z → a[2] * x - 2.0 * b[2] / y
a.cross(&b).x → a[1] * b[2] - a[2] * b[1]
a.cross(&b).y → a[2] * b[0] - a[0] * b[2]
a.cross(&b)[2] → a[0] * b[1] - a[1] * b[0]
(a.cross_matrix() * b).y → a[2] * b[0] - a[0] * b[2]
a.component_mul(&b).sum() → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
a.component_div(&b)[1] → a[1] / b[1]
a.scale(x).unscale(y).add_scalar(1.0).y → a[1] * x / y + 1.0
a.normalize().x → a[0] / (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
a.mean() → (a[0] + a[1] + a[2]) / 3.0
a.product() → a[0] * a[1] * a[2]
a.lerp(&b, x).y → a[1] * (1.0 - x) + b[1] * x
a.map(|s| s.sin() * x).z → a[2].sin() * x
a.zip_map(&b, |s, t| s / t).x → a[0] / b[0]
a.fold(y, |s, t| s * 2.0 + t) → ((y * 2.0 + a[0]) * 2.0 + a[1]) * 2.0 + a[2]
a.iter().zip(b.iter()).map(|(s, t)| s * t.exp()).sum::<f64>() → a[0] * b[0].exp() + a[1] * b[1].exp() + a[2] * b[2].exp()
a.iter().enumerate().map(|(i, s)| s * i as f64).sum::<f64>() → a[1] + a[2] * 2.0
a.fixed_rows::<2>(1).norm_squared() → a[1] * a[1] + a[2] * a[2]
a.rows(0, 2).dot(&b.xy()) → a[0] * b[0] + a[1] * b[1]
a.xy().perp(&b.xy()) → a[0] * b[1] - a[1] * b[0]
(a.zx()).x → a[2]
(a.transpose() * b)[(0, 0)] → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
(a.transpose() * b).to_scalar() → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
a.tr_mul(&b).x → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
(a * b.transpose())[(2, 0)] → a[2] * b[0]
(a * b.transpose()).trace() → a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
a.len() as f64 * x → 3.0 * x
// matrices: `new` takes rows, storage and `iter` are in columns
(m * a).y → m[1][0] * a[0] + m[1][1] * a[1] + m[1][2] * a[2]
a.dot(&(m * b)) → a[0] * (m[0][0] * b[0] + m[0][1] * b[1] + m[0][2] * b[2]) + a[1] * (m[1][0] * b[0] + m[1][1] * b[1] + m[1][2] * b[2]) + a[2] * (m[2][0] * b[0] + m[2][1] * b[1] + m[2][2] * b[2])
(m * m)[(0, 1)] → m[0][0] * m[0][1] + m[0][1] * m[1][1] + m[0][2] * m[2][1]
m.transpose()[(0, 2)] → m[2][0]
m[1] + m.m12 + m.m33 → m[1][0] + m[0][1] + m[2][2]
m.iter().skip(3).take(1).sum::<f64>() → m[0][1]
m.row(1)[2] * m.column(0).x → m[1][2] * m[0][0]
(m.row(1) * a).x → m[1][0] * a[0] + m[1][1] * a[1] + m[1][2] * a[2]
m.column_iter().map(|c| c.dot(&a)).sum::<f64>() → m[0][0] * a[0] + m[1][0] * a[1] + m[2][0] * a[2] + (m[0][1] * a[0] + m[1][1] * a[1] + m[2][1] * a[2]) + (m[0][2] * a[0] + m[1][2] * a[1] + m[2][2] * a[2])
m.row_iter().map(|r| r[0]).sum::<f64>() → m[0][0] + m[1][0] + m[2][0]
m.trace() → m[0][0] + m[1][1] + m[2][2]
m.diagonal().y → m[1][1]
m.fixed_view::<2, 2>(1, 0).determinant() → m[1][0] * m[2][1] - m[2][0] * m[1][1]
m.determinant() → m[0][0] * (m[1][1] * m[2][2] - m[2][1] * m[1][2]) - m[1][0] * (m[0][1] * m[2][2] - m[2][1] * m[0][2]) + m[2][0] * (m[0][1] * m[1][2] - m[1][1] * m[0][2])
(m * 2.0 + Matrix3::identity()).trace() → 2.0 * m[0][0] + 1.0 + (2.0 * m[1][1] + 1.0) + (2.0 * m[2][2] + 1.0)
m.nrows() as f64 * m.ncols() as f64 * x → 9.0 * x
// constructors
Vector3::x().dot(&a) + Vector3::y_axis().dot(&b) → a[0] + b[1]
Vector3::<f64>::repeat(x).dot(&a) → x * a[0] + x * a[1] + x * a[2]
(a + nalgebra::Vector3::zeros()).x → a[0]
na::Vector2::from([x, y]).y → y
Vector3::from_row_slice(&[x, y, 1.0]).y → y
SVector::<f64, 4>::from_fn(|i, _| x * i as f64).w → x * 3.0
SMatrix::<f64, 2, 3>::new(x, y, 1.0, 2.0, 3.0, 4.0)[(0, 1)] → y
Matrix2::new(x, y, 1.0, 2.0)[1] + Matrix2::from([[x, y], [1.0, 2.0]])[(1, 0)] → 1.0 + y
Matrix2::from_row_slice(&[x, y, 1.0, 2.0])[(0, 1)] + Matrix2::from_column_slice(&[x, y, 1.0, 2.0])[(0, 1)] → y + 1.0
(Matrix3::from_diagonal(&a) * b).y → a[1] * b[1]
Matrix3x2::from_columns(&[a, b])[(2, 1)] → b[2]
Matrix2x3::from_rows(&[a.transpose(), b.transpose()])[(1, 0)] → b[0]
Matrix2::from_diagonal_element(x).trace() → x + x
// rotations
(Rotation2::new(x) * a.xy()).x → x.cos() * a[0] - x.sin() * a[1]
(Rotation2::new(x).inverse() * a.xy()).y → -x.sin() * a[0] + x.cos() * a[1]
Rotation2::new(x).transform_vector(&a.xy()).y → x.sin() * a[0] + x.cos() * a[1]
Rotation2::new(x).inverse_transform_vector(&a.xy()).x → x.cos() * a[0] + x.sin() * a[1]
(Rotation3::from_axis_angle(&Vector3::z_axis(), x) * a).y → x.sin() * a[0] + x.cos() * a[1]
(Rotation3::from_axis_angle(&Vector3::y_axis(), x).inverse() * a).x → x.cos() * a[0] - x.sin() * a[2]
Rotation3::from_euler_angles(x, y, 0.0)[(0, 2)] → y.sin() * x.cos()
(Rotation3::from_euler_angles(0.0, 0.0, x) * Vector3::x()).y → x.sin()
Rotation3::identity().matrix().trace() * x → 3.0 * x
Unit::new_normalize(Vector2::new(x, y)).into_inner().x → x / (x * x + y * y).sqrt()
";

#[test]
fn operations_are_those_of_their_entries() {
    for [vectors, arrays] in rows(OPERATIONS) {
        let vectors = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{
                let (a, b, x, y) = (q, v, self.x, self.y);
                let m = Matrix3::new(self.m[0][0], x, y, q.x, q.y, q.z, v.x, v.y, v.z);
                {vectors}
            }}"
        );
        let arrays = format!(
            "fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {{
                let (a, b, x, y) = (q, v, self.x, self.y);
                let m = [[self.m[0][0], x, y], q, v];
                {arrays}
            }}"
        );
        let touch = "+ 0.0 * (self.x + self.y + self.m[0][0])";
        // the parameters are named in the same order in both
        let first = |text: &str| text.replacen("{\n", &format!("{{ let _ = 0.0 {touch};\n"), 1);
        assert_same(&first(&vectors), &first(&arrays));
    }
}

//! Mistakes in bodies, and the tokens at which they are reported.

use crate::algebra::Arena;

use super::model;
use crate::tests::rows;

/// Bodies with one mistake: the token at which it is reported, and a part of the message.
const MISTAKES: &str = r"
// what is not smooth
q.abs().sum() → abs → no derivative at 0
q.max() → max → not smooth in the entries
q.amax() → amax → not smooth in the entries
q.argmax().1 → argmax → not smooth in the entries
q.angle(&v) → angle → atan2(a.dot(&b))
q.slerp(&v, 0.5).x → slerp → v.normalize()
// what is not understood
m.lu().determinant() → lu → a factorisation is no formula
m.try_inverse().unwrap().trace() → try_inverse → a factorisation is no formula
let mut a = q; a.normalize_mut(); a.x → normalize_mut → assign to it
let mut a = q; a.copy_from(&v); a.x → copy_from → assign to it
q.sin().x → sin → v.map(|x| x.sin(…))
q.powi(2) → powi → v.norm_squared()
q.dott(&v) → dott → did you mean `dot`?
q.shape().0 → shape → sizes are in the types
self.m.lu().determinant() → lu → a factorisation is no formula
self.m.determinant() → determinant → `let m: Matrix3<f64> = self.m;`
self.m.row(0).sum() → row → `let m: Matrix3<f64> = self.m;`
(self.m * 2.0).trace() → trace → `let m: Matrix3<f64> = self.m;`
q.fixed_rows(1).x → fixed_rows → fixed_rows::<3>(0)
Rotation3::new(q).matrix().trace() → new → divides by the angle
Vector3::from_vec(vec).x → vec → not known here
Vector3::new_random().x → new_random → vectors and matrices are made by
SVector::zeros().x → zeros → the size is not written here
Vector3::<f32>::zeros().x → Vector3::<f32> → every number of a body is an `f64`
SMatrix::<f64, 100, 100>::zeros().trace() → zeros → too many entries
// sizes and operators
(q + q.xy()).x → + → a `Vector3<f64>` and a `Vector2<f64>` have no sum
(q + 1.0).x → + → v.add_scalar(x)
(q * v).x → * → a.dot(&b)
(m * q.xy()).x → * → the columns of the first
(1.0 / q).x → / → component_div
(q / m).x → / → nothing is divided by a matrix
(q % 2.0).x → % → not continuous
(q / 0.0).x → 0.0 → divides by zero
(2 * q).x → 2 → write `2.0`
(q.x + q) → + → have no sum
q.dot(&m) → &m → `dot` takes a `Vector3<f64>` here, and this is a `Matrix3<f64>`
q.dot() → dot → `dot` takes 1 argument, here are none
q.scale(v).x → v → expected an `f64`, found a `Vector3<f64>`: take an entry
q.xy().cross(&v.xy()).x → cross → vectors of length 3
Matrix2x3::zeros().determinant() → determinant → square matrices
q[3] → 3 → index 3 is out of range: a `Vector3<f64>` has the entries `.x`, `.y`, `.z`
m[(3, 0)] → (3, 0) → index (3, 0) is out of range
m.row(3)[0] → 3 → there are 3 rows
q.w → w → has no such entry: its entries are `.x`, `.y`, `.z`
m.m14 → m14 → has no such entry
q.fixed_rows::<3>(1).x → 1 → 3 rows from 1 on are not within the 3
Vector3::new(1.0, 2.0).x → new → `new` of a `Vector3<f64>` takes 3 numbers, here are 2
Vector3::new(1, 2.0, 3.0).x → 1 → write `1.0`
Matrix2::from_columns(&[q.xy()]).trace() → from_columns → this matrix has 2 columns, here is 1
Vector3::from([1.0, 2.0]).x → [1.0, 2.0] → expected a `Vector3<f64>`, found an array of 2
Vector2::z().x → z → has no axis `z`
-Rotation2::new(q.x) * v.xy() → - → a rotation has no negative
(2.0 * Rotation2::new(q.x)).matrix().trace() → * → into_inner
q → q → expected an `f64`, found a `Vector3<f64>`: take an entry
// parameters whose type is not seen
self.g.norm() → norm → the type of `self.g` is not known to the macro: name it, `let g: Vector3<f64> = self.g;`
self.a.dot(&self.b) → dot → the type of `self.a` is not known
self.g.fixed_rows::<2>(0).norm_squared() → fixed_rows → the type of `self.g` is not known to the macro: name it, `let g: Vector3<f64> = self.g;`
self.g.fixed_view::<2, 2>(0, 0).trace() → fixed_view → name it, `let g: Matrix3<f64> = self.g;`
self.g.zip_map(&q, |a, b| a * b).sum() → zip_map → the type of `self.g` is not known
use physics::consts; q.x → consts → imported within this body
self.g.map(|x| x * x).sum() → map → of a vector write `let g: Vector3<f64> = self.g;`
(Rotation2::new(q.x) * self.g).x → self.g → the type of `self.g` is not known
(self.k * self.g).dot(&q) → dot → taken for one
(self.k * self.g + q).x → + → `self.g` is taken for a number
(-self.g + q).x → + → `self.g` is taken for a number
let g: f64 = self.g; g.dot(&q) → dot → this is a number
q.x.dot(&v) → dot → this is a number
";

#[test]
fn mistakes_are_reported_at_their_tokens() {
    let mut wrong = Vec::new();
    for [body, at, part] in rows(MISTAKES) {
        let members = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{
                let m = Matrix3::from_columns(&[q, v, q.cross(&v)]);
                {body}
            }}"
        );
        let found = model(&members, &mut Arena::new()).err().unwrap_or_default();
        let is_reported = |(text, message): &(String, String)| text == at && message.contains(part);
        if found.len() != 1 || !found.iter().all(is_reported) {
            wrong.push(format!("{body}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

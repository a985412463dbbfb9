//! The macro does not see the types of fields: types of nalgebra follow from how a body uses a
//! field.

use crate::algebra::Arena;
use crate::model::Meaning;

use super::model;
use crate::tests::rows;

/// Each body, with the entries of parameters that generated code reads.
#[test]
fn types_of_parameters_follow_from_their_uses() {
    check(
        r"
// beside a vector in a sum, as an argument or receiver, and by components
(q - self.g).norm_squared() → self.g.x, self.g.y, self.g.z
q.dot(&self.g) → self.g.x, self.g.y, self.g.z
self.g.dot(&q) → self.g.x, self.g.y, self.g.z
self.g.cross(&self.h).norm() + q.x → self.g.x, self.g.y, self.g.z, self.h.x, self.h.y, self.h.z
self.g.z * q.z → self.g.z
self.m[(0, 1)] * q.x → self.m[(0,1)]
self.a[1].dot(&q) → self.a[1].x, self.a[1].y, self.a[1].z
self.a.iter().zip([q, v]).map(|(a, b)| (a - b).x).sum::<f64>() → self.a[0].x, self.a[1].x
let mut a = q; a += self.g; a.y → self.g.y
// in products a number
(self.k * q).x + (q / self.l).y + (v * self.m).z → self.k, self.l, self.m
let k: f64 = self.k; (k * Matrix3::identity() * q).x → self.k
// by the type that is written
let m: Matrix2<f64> = self.m; m.trace() + q.x → self.m[(0,0)], self.m[(1,1)]
let m: &na::Matrix3<f64> = &self.m; (m * q).y → self.m[(1,0)], self.m[(1,1)], self.m[(1,2)]
let r: Rotation3<f64> = self.r; (r * q).x → self.r[(0,0)], self.r[(0,1)], self.r[(0,2)]
let g: SVector<f64, 7> = self.g; g[6] * q.x → self.g[6]
let (g, a): (Vector2<f64>, [Vector2<f64>; 2]) = (self.g, self.a); g.dot(&a[1]) + q.x → self.g.x, self.a[1].x, self.g.y, self.a[1].y
Self::length(self.g) + q.x → self.g.x, self.g.y
self.arm().y + q.x → self.arm.y
Vector2::from(self.w).y + q.x → self.w[1]
Matrix2::from(self.w)[(0, 1)] + q.x → self.w[1][0]
WIND.dot(&q) → WIND.x, WIND.y, WIND.z
",
    );
}

/// The type that is known from one use holds for the uses before and after it.
#[test]
fn types_of_parameters_hold_in_the_whole_block() {
    check(
        r"
let m: Matrix2<f64> = self.m; (self.m * Vector2::y()).x + m[(1, 1)] * q.x → self.m[(0,1)], self.m[(1,1)]
(self.m * Vector2::y()).x + { let m: Matrix2<f64> = self.m; m[(1, 1)] } * q.x → self.m[(0,1)], self.m[(1,1)]
(self.m.transpose() * Vector2::y()).x + Self::corner(self.m) + q.x → self.m[(1,0)], self.m[(1,1)]
self.g.norm() + q.x * { let g: Vector2<f64> = self.g; g.y } → self.g.x, self.g.y
",
    );
}

/// Checks the entries of parameters that generated code reads for each body.
fn check(bodies: &str) {
    let mut wrong = Vec::new();
    for [body, reads] in rows(bodies) {
        let members = format!(
            "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {{ {body} }}
            fn length(x: Vector2<f64>) -> f64 {{ x.norm() }}
            fn corner(m: Matrix2<f64>) -> f64 {{ m[(1, 1)] }}
            fn arm(&self) -> Vector3<f64> {{ self.arm }}"
        );
        let mut arena = Arena::new();
        let model = match model(&members, &mut arena) {
            Ok(model) => model,
            Err(mistakes) => {
                wrong.push(format!("{body}: {mistakes:?}"));
                continue;
            }
        };
        let access = |symbol| match model.symbols.meaning(symbol) {
            Meaning::Parameter { access, .. } if arena.contains(model.lagrangian, symbol) => {
                Some(access.to_string().replace(' ', ""))
            }
            _ => None,
        };
        let mut found: Vec<String> = model.symbols.parameters().filter_map(access).collect();
        let mut reads: Vec<&str> = reads.split(", ").collect();
        found.sort_unstable();
        reads.sort_unstable();
        if found != reads {
            wrong.push(format!("{body}: {found:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

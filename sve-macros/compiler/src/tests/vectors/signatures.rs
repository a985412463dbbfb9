//! Vectors in signatures and constants, and the code that is emitted after a mistake in them.

use crate::algebra::Arena;

use super::model;
use crate::tests::{expand_members, rows};

/// Signatures with vectors in every role are accepted.
#[test]
fn signatures_have_vectors() {
    let free = "fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 { v.norm_squared() }";
    for members in [
        "fn lagrangian(&self, q: na::Vector1<f64>, v: nalgebra::Vector1<f64>) -> f64 { v.x * v.x }".to_owned(),
        "const N: usize = 9; fn lagrangian(&self, q: SVector<f64, { Self::N }>, v: SVector<f64, 9>) -> f64 { v.norm_squared() }".to_owned(),
        "fn lagrangian(&self, t: f64, q: [SVector<f64, 2>; 3], v: [Vector2<f64>; 3]) -> f64 { t * v.iter().map(|v| v.dot(v)).sum::<f64>() }".to_owned(),
        format!("{free} #[gamma] fn a(&self, q: Vector3<f64>) -> Vector2<f64> {{ q.xy() }} #[gamma] fn b(&self, q: SVector<f64, 3>) -> [f64; 2] {{ [q.x, q.y] }}"),
        format!("{free} #[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {{ self.pull }} #[symmetry] fn b(&self, q: Vector3<f64>) -> Vector3<f64> {{ Vector3::x() }}"),
    ] {
        let found = model(&members, &mut Arena::new()).err();
        assert!(found.is_none(), "{members}: {found:?}");
    }
}

/// Types of coordinates and velocities: the type at which a mistake is reported, and a part of the
/// message.
const COORDINATES: &str = "
Vector3<f64> → Vector2<f64> → Vector2<f64> → must be of the same type: here `Vector2<f64>`, there `Vector3<f64>`
[f64; 3] → Vector3<f64> → Vector3<f64> → must be of the same type: here `Vector3<f64>`, there `[f64; 3]`
Vector3<f64> → [f64; 3] → [f64; 3] → must be of the same type
Vector3<f32> → Vector3<f32> → Vector3<f32> → not a type of coordinates
Matrix2<f64> → Matrix2<f64> → Matrix2<f64> → `Vector3<f64>` or `SVector<f64, N>`
&Vector3<f64> → &Vector3<f64> → &Vector3<f64> → by value
Vector3 → Vector3 → Vector3 → write `Vector3<f64>`
SVector<f64> → SVector<f64> → SVector<f64> → write `SVector<f64, N>`
SVector<f64, N> → SVector<f64, N> → N → outside of this `impl` block
SVector<f64, 600> → SVector<f64, 600> → SVector<f64, 600> → too many to unroll
SVector<f64, 0> → SVector<f64, 0> → SVector<f64, 0> → at least one coordinate
";

/// Functions with a role beside coordinates of type `Vector3<f64>`.
const ROLES: &str = "
#[gamma] fn a(&self, q: Vector2<f64>) -> f64 { q.x } → Vector2<f64> → of the same type
#[gamma] fn a(&self, q: Vector3<f64>) -> RowVector2<f64> { q.xy().transpose() } → RowVector2<f64> → not a type of coordinates
#[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> [f64; 3] { v.into() } → [f64; 3] → a vector like the coordinates, `Vector3<f64>`
#[force] fn a(&self, q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> { v.xy() } → a → expected a `Vector3<f64>`, found a `Vector2<f64>`
";

#[test]
fn wrong_signatures_are_errors_at_their_types() {
    let lagrangian = |q: &str, v: &str, body: &str| {
        format!("fn lagrangian(&self, q: {q}, v: {v}) -> f64 {{ {body} }}")
    };
    let of_coordinates = |[q, v, at, part]: [&'static str; 4]| (lagrangian(q, v, "1.0"), at, part);
    let free = lagrangian("Vector3<f64>", "Vector3<f64>", "v.norm_squared()");
    let of_role = |[role, at, part]: [&'static str; 3]| (format!("{free} {role}"), at, part);
    let coordinates = rows(COORDINATES).into_iter().map(of_coordinates);
    for (members, at, part) in coordinates.chain(rows(ROLES).into_iter().map(of_role)) {
        let found = model(&members, &mut Arena::new()).err().unwrap_or_default();
        assert!(
            !found.is_empty() && found[0].0 == at && found[0].1.contains(part),
            "{members}: {found:?}"
        );
    }
}

/// Returns the block that is emitted after its errors, with the mistakes replaced.
fn block_after_errors(members: &str) -> String {
    let output = expand_members("midpoint", members).to_string();
    let from = output.find("impl P").expect("the block");
    let to = output
        .find("# [automatically_derived]")
        .expect("implementations");
    output[from..to].to_owned()
}

/// The code that is emitted after a mistake has no type errors.
#[test]
fn wrong_constants_and_lengths_are_replaced() {
    let block = block_after_errors(
        "const G: Vector2<f64> = Vector2::new(0.0, 3);
        fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 { v.dot(&v) + Self::G.x }
        fn other(&self, x: Vector2<f64>) -> f64 { x.dot(&Self::G) }",
    );
    assert!(
        block.contains("< Vector2 < f64 > > :: new (0.0 , 0.0)"),
        "{block}"
    );
    assert!(block.contains("x . dot"), "{block}");
    let block = block_after_errors(
        "const N: usize = 2;
        fn lagrangian(&self, q: SVector<f64, N>, v: na::SVector<f64, N>) -> f64 { v.dot(&v) }",
    );
    assert_eq!(
        block.matches("SVector < f64 , { Self :: N } >").count(),
        2,
        "{block}"
    );
}

//! The solution of the equations of rotations.

use crate::tests::{expand, tokens};

fn expansion(block: &str) -> String {
    expand(&tokens("midpoint"), &tokens(block)).to_string()
}

/// Returns the body of `increment`.
fn increment(expansion: &str) -> &str {
    let body = expansion.split("fn increment ").nth(1).expect("a step");
    let ends = ["fn increment_lanes", "type Unknowns"];
    let end = ends.iter().filter_map(|end| body.find(end)).min();
    &body[..end.unwrap_or(body.len())]
}

#[test]
fn a_rotation_is_solved_by_cofactors_from_a_guess_of_two_stages() {
    let body = expansion(
        "impl Body {
            fn lagrangian(&self, _r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
                0.5 * (self.i[0] * w.x * w.x + self.i[1] * w.y * w.y + self.i[2] * w.z * w.z)
            }
        }",
    );
    let step = increment(&body);
    assert_eq!(step.matches("Cofactors").count(), 1);
    assert_eq!(step.matches("let refinement_rhs_0").count(), 2);
    // solves with the inertia at zero step, whose matrix is diagonal: in the guess with its stages,
    // in the fallback, and in the bounds
    assert_eq!(step.matches(":: Diagonal (").count(), 5);
    let three = expansion(
        "impl Three {
            fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
                0.5 * v.norm_squared() - 0.25 * q.norm_squared().powi(2)
            }
        }",
    );
    assert!(!three.contains("Cofactors"));
    assert_eq!(increment(&three).matches("let refinement_rhs_0").count(), 1);
}

/// Paths that are rarely taken read the entries of the rotation again, so that the step computes
/// only the entries that it reads.
#[test]
fn entries_of_a_rotation_are_read_where_they_are_used() {
    let top = expansion(
        "impl Top {
            fn lagrangian(&self, r: Rotation3<f64>, w: Vector3<f64>) -> f64 {
                0.5 * w.norm_squared() - self.g * r[(2, 2)]
            }
        }",
    );
    for function in ["fn fallback_0", "fn rounding_0"] {
        let after = top.split(function).nth(1).expect("a function");
        let (_, body) = after.split_once('{').expect("a body");
        let state = body.find("let state =").expect("entries");
        assert!(state < 100, "{function} {state}");
    }
}

//! The place at which the matrix of a guess is factored.

use proc_macro2::TokenStream;

use super::costs::compare;
use crate::tests::{expand, tokens};

/// A full mass matrix of parameters with a quartic potential: `prepare` factors it, and the step
/// has only substitutions before its iteration.
#[test]
fn a_constant_mass_matrix_is_factored_in_prepare() {
    let block = |mass: &str| {
        format!(
            "impl Coupled {{
                fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {{
                    let mut l = 0.0;
                    for i in 0..3 {{
                        l += 0.5 * self.m * v[i] * v[i] - 0.25 * self.a * q[i].powi(4);
                        for j in 0..i {{ l += {mass} * v[i] * v[j] - 0.1 * q[i] * q[j]; }}
                    }}
                    l
                }}
            }}"
        )
    };
    let expand = |mass: &str| expand(&tokens("initial_point, midpoint"), &tokens(&block(mass)));
    let constant = expand("self.c");
    compare("constant", &constant);
    let calls = |expansion: &TokenStream, name: &str| {
        let text = expansion.to_string();
        ["fn prepare", "fn increment ", "fn increment_lanes"].map(|function| {
            let parts = text.split(function).skip(1);
            let of_part = |part: &str| {
                let end = part.find(" fn ").unwrap_or(part.len());
                part[..end].matches(name).count()
            };
            parts.map(of_part).collect::<Vec<_>>()
        })
    };
    // once in `prepare` and once before the loops over lanes; the step has the solve of its
    // fallback
    assert_eq!(
        calls(&constant, ":: factored ("),
        [[1, 1], [0, 0], [1, 1]].map(Vec::from)
    );
    let varying = expand("self.c * q[0].cos()");
    compare("varying", &varying);
    assert_eq!(
        calls(&varying, ":: factored ("),
        [[0, 0], [1, 1], [0, 0]].map(Vec::from)
    );
}

//! A step tests exactly those properties of its start that can fail.

use quote::ToTokens;
use syn::Item;

use crate::tests::{expand_members, items};

/// Returns the items of the expansion that implement a trait for a system.
fn implementations(attribute: &str, members: &str, of: &str) -> Vec<String> {
    let expansion = expand_members(attribute, members);
    let implementations = items(expansion).into_iter().filter_map(|item| match item {
        Item::Impl(item) => Some(item),
        _ => None,
    });
    let wanted = implementations.filter(|item| {
        let path = item.trait_.as_ref().map(|(path, _)| path);
        path.is_some_and(|path| path.to_token_stream().to_string().contains(of))
    });
    wanted
        .map(|item| item.to_token_stream().to_string())
        .collect()
}

/// Returns the test of the start, as text.
fn start(members: &str) -> String {
    let mut found = implementations("midpoint", members, "StartOfStep");
    assert_eq!(found.len(), 1);
    found.swap_remove(0)
}

/// Returns the parts of the mass matrix that are tested for singularity, once and in each step.
fn blocks(members: &str) -> [usize; 2] {
    let text = start(members);
    assert!(!text.contains("TESTS_VELOCITY"), "{text}");
    let count = |constant: &str, function: &str| {
        let Some(at) = text.find(function) else {
            assert!(!text.contains(constant), "{text}");
            return 0;
        };
        assert!(text.contains(constant), "{text}");
        let body = text[at..].split("inline").next().unwrap_or_default();
        body.matches(":: is_regular (").count()
    };
    [
        count("TESTS_PARAMETERS", "fn parameters_give_regular_mass"),
        count("TESTS_STATE", "fn state_gives_regular_mass"),
    ]
}

#[test]
fn masses_of_numbers_need_no_test() {
    for l in [
        "0.5 * v[0] * v[0] + v[1] * v[1] - self.k * q[0] * q[1]",
        "0.5 * v[0] * v[0] + 0.3 * v[0] * v[1] + v[1] * v[1] + q[0] * v[1]",
    ] {
        let members = format!("fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {{ {l} }}");
        assert_eq!(blocks(&members), [0, 0], "{l}");
    }
}

#[test]
fn equal_parts_are_tested_once() {
    let members = "fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        0.5 * self.m[0] * (v[0] * v[0] + v[1] * v[1]) + 0.5 * self.m[1] * v[2] * v[2] + 0.5 * v[3] * v[3] - q[0] * q[3]
    }";
    assert_eq!(blocks(members), [2, 0]);
}

#[test]
fn parts_with_the_state_are_tested_in_each_step() {
    let members = "fn lagrangian(&self, t: f64, q: [f64; 4], v: [f64; 4]) -> f64 {
        0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) + 0.5 * self.m * v[2] * v[2] + 0.5 * (1.0 + t) * v[3] * v[3]
    }";
    assert_eq!(blocks(members), [1, 2]);
    let coupled = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m * v[0] * v[0] + 0.5 * v[1] * v[1] + q[0] * v[0] * v[1]
    }";
    assert_eq!(blocks(coupled), [0, 1]);
}

#[test]
fn velocities_are_looked_for_where_the_momentum_is_not_affine() {
    let members = "fn lagrangian(&self, q: f64, v: f64) -> f64 { (1.0 + v * v).sqrt() - q }";
    assert!(start(members).contains("TESTS_VELOCITY : bool = true"));
}

#[test]
fn constraints_and_degenerate_systems_have_definitions_of_their_own() {
    for members in [
        "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 { 0.5 * self.m * (v[0] * v[0] + v[1] * v[1]) }
         #[constraint]
         fn circle(&self, q: [f64; 2]) -> f64 { q[0] * q[0] + q[1] * q[1] - 1.0 }",
        "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 { self.b * q[1] * v[0] - 0.5 * (q[0] * q[0] + q[1] * q[1]) }",
    ] {
        assert_eq!(blocks(members), [0, 0], "{members}");
    }
}

#[test]
fn steps_whose_bounds_contain_the_start_need_no_test() {
    let polar = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) - q[0] * q[0]
    }";
    let proves = |rule: &str| {
        let found = implementations(rule, polar, ":: StepEquations <");
        assert_eq!(found.len(), 1);
        found[0].contains("PROVES_START : bool = true")
    };
    assert!(proves("midpoint"));
    // the angular velocity is explicit
    assert!(!proves("endpoint"));
    assert!(!proves("gauss(4)"));
}

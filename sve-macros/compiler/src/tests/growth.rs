//! The growth of the output with a system, in numbers of tokens: linear for a chain, at most
//! quadratic if all coordinates are coupled. The residual costs a few times L, as a gradient does
//! (Baur and Strassen 1983: at most about 4).
//!
//! The scenes come from `benches/expansion`, which measures times.

#[path = "../../benches/expansion/scenes.rs"]
#[allow(dead_code)] // the program around a scene is for the benchmark
pub(super) mod scenes;

use proc_macro2::{TokenStream, TokenTree};

use crate::Operations;
use crate::tests::{expand, tokens};
use scenes::Scene;

/// Returns the number of tokens, including tokens within groups.
fn count(code: TokenStream) -> u32 {
    let (mut open, mut sum) = (vec![code], 0);
    while let Some(stream) = open.pop() {
        for tree in stream {
            sum += 1;
            if let TokenTree::Group(group) = tree {
                open.push(group.stream());
            }
        }
    }
    sum
}

/// Returns the number of tokens of the expansion.
fn length(rule: &str, scene: Scene, n: usize) -> f64 {
    count(expand(&tokens(rule), &tokens(&scene.block(n)))).into()
}

/// Returns the exponent of growth from one size to its double.
fn exponent(rule: &str, scene: Scene, n: usize) -> f64 {
    (length(rule, scene, 2 * n) / length(rule, scene, n)).log2()
}

/// A mechanism that is written out in every expansion is paid by every crate of a user. With line
/// breaks the expansion has some 375 lines.
#[test]
fn the_expansion_of_a_pendulum_is_short() {
    let pendulum = "impl Pendulum {
        fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * self.m * v * v + self.k * q.cos() }
    }";
    let length = count(expand(&tokens("midpoint"), &tokens(pendulum)));
    assert!(length < 6000, "{length}");
}

#[test]
fn code_of_a_chain_grows_linearly() {
    for rule in ["midpoint", "endpoint", "initial_point", "taylor2"] {
        let exponent = exponent(rule, Scene::Chain, 24);
        assert!(exponent < 1.05, "{rule}: {exponent}");
    }
}

#[test]
fn code_of_coupled_systems_grows_quadratically() {
    for scene in [Scene::Pendulum, Scene::Bodies] {
        let exponent = exponent("midpoint", scene, 6);
        assert!(exponent < 2.05, "{}: {exponent}", scene.name());
    }
}

#[test]
fn residuals_and_jacobians_cost_a_few_times_the_function() {
    for scene in Scene::ALL {
        for n in [1, 2, 3, 6, 12] {
            let count = Operations::count(&tokens(Scene::RULE), &tokens(&scene.block(n)));
            let count = count.expect("a system");
            let ratio = count.residual as f64 / count.lagrangian as f64;
            assert!(ratio > 0.0 && ratio < 4.0, "{} {n}: {ratio}", scene.name());
            // at most as many entries as pairs in L, each entry from one term
            let ratio = count.jacobian as f64 / count.residual as f64;
            assert!(ratio > 0.0 && ratio < 4.0, "{} {n}: {ratio}", scene.name());
        }
    }
}

/// The compiler of Rust overflows its stack at about 2,500 `let` statements that are in scope
/// together, if debug information is written.
const SCOPES: usize = 1500;

/// Returns the largest number of `let` statements that are in scope together. The statements of a
/// closure count together with the surrounding ones.
fn scopes(code: TokenStream) -> usize {
    let (mut open, mut deepest) = (0, 0);
    for tree in code {
        match tree {
            TokenTree::Ident(word) => open += usize::from(word == "let"),
            TokenTree::Group(group) => {
                let inner = scopes(group.stream());
                // a function is not in the scope of earlier statements
                deepest = deepest.max(open + inner);
            }
            _ => {}
        }
        deepest = deepest.max(open);
    }
    deepest
}

/// The documented sizes are accepted: `tests/sizes` compiles and runs them. The next larger ones
/// are refused.
#[test]
fn limits_are_those_of_the_documentation() {
    for (scene, next) in [(Scene::Pendulum, 34), (Scene::Bodies, 50)] {
        let refused = expand(&tokens("midpoint"), &tokens(&scene.block(next))).to_string();
        assert_eq!(refused.matches("compile_error").count(), 1, "{next}");
        assert!(refused.contains("which is the limit"), "{next}");
    }
}

#[test]
fn explicit_steps_of_coupled_systems_grow_quadratically() {
    let exponent = exponent("stormer_verlet", Scene::Bodies, 12);
    assert!(exponent < 2.05, "{exponent}");
}

#[test]
fn scopes_do_not_nest_in_long_chains() {
    for rule in ["midpoint", "endpoint", "stormer_verlet"] {
        let expansion = expand(&tokens(rule), &tokens(&Scene::Chain.block(160)));
        let deepest = scopes(expansion);
        assert!(deepest < SCOPES, "{rule}: {deepest}");
    }
}

//! A step contains only the code that its system needs: a term that the system lacks leaves no
//! trace, and neither does the derivation of the step without structure.

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::{ImplItem, Item};

use crate::tests::{expand, expand_compared, items};

const RULES: [&str; 3] = ["initial_point", "endpoint", "midpoint"];

type Expand = fn(&TokenStream, &TokenStream) -> TokenStream;

fn expansion(expand: Expand, attribute: &str, members: &str) -> TokenStream {
    let item = format!("impl P {{ {members} }}");
    let parse = |text: &str| text.parse::<TokenStream>().expect("tokens");
    expand(&parse(attribute), &parse(&item))
}

/// Returns the functions of a step and the additional functions, each as text: `prepare`,
/// `increment`, `increment_lanes`, `linearise`, `fallback_0`.
fn step(attribute: &str, members: &str) -> Vec<String> {
    step_of(expansion(expand, attribute, members))
}

fn step_of(expansion: TokenStream) -> Vec<String> {
    assert!(
        !expansion.to_string().contains("compile_error"),
        "{expansion}"
    );
    let (mut derived, mut code) = (None, Vec::new());
    for item in items(expansion) {
        match item {
            Item::Impl(item) if derived.is_none() && is_step(&item) => derived = Some(item),
            Item::Fn(function) => code.push(function.to_token_stream().to_string()),
            _ => {}
        }
    }
    let items = derived.expect("a step").items.into_iter();
    code.extend(items.filter_map(|item| match item {
        ImplItem::Fn(mut function) => {
            function.attrs.clear();
            Some(function.to_token_stream().to_string())
        }
        _ => None,
    }));
    code
}

/// Returns whether an item implements `StepEquations` for a rule itself.
fn is_step(item: &syn::ItemImpl) -> bool {
    let Some((path, _)) = &item.trait_ else {
        return false;
    };
    let text = path.to_token_stream().to_string();
    text.contains(":: StepEquations <") && !text.contains("Unstructured")
}

/// Returns the body of `increment`.
fn increment(attribute: &str, members: &str) -> String {
    let step = step(attribute, members);
    let found = step.into_iter().find(|f| f.contains("fn increment ("));
    let found = found.expect("an increment");
    let (_, body) = found.split_once('{').expect("a body");
    body.to_owned()
}

const PENDULUM: &str =
    "fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }";

/// Checks that members with another Lagrangian or other terms have the same step.
fn same(members: &str, others: &str) {
    for rule in RULES {
        assert_eq!(step(rule, members), step(rule, others), "{rule}: {others}");
    }
}

#[test]
fn terms_with_coefficient_zero_are_no_terms() {
    let lagrangian = "fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos() + 0.0 * (self.g * q.powi(4) + v * q.exp())
    }";
    same(PENDULUM, lagrangian);
    let noise = |body: &str| {
        format!("{PENDULUM} #[h1] fn shake(&self, q: f64, p: f64) -> f64 {{ {body} }}")
    };
    same(
        &noise("self.s * q * p"),
        &noise("self.s * q * p + 0.0 * (q.sin() + p.powi(3))"),
    );
}

#[test]
fn a_force_that_vanishes_is_none() {
    let force = |body: &str| {
        format!("{PENDULUM} #[force] fn drag(&self, q: f64, v: f64) -> f64 {{ {body} }}")
    };
    same(PENDULUM, &force("0.0 * self.g * v"));
    let one = force("-self.nu * v");
    let more = "#[force] fn none(&self, q: f64, v: f64) -> f64 { 0.0 }";
    same(&one, &format!("{one} {more}"));
}

/// A noise that moves nothing would still cost its increments: it is refused.
#[test]
fn a_noise_that_vanishes_is_refused() {
    for noise in [
        "#[gamma] fn none(&self, q: f64) -> f64 { 0.0 }",
        "#[gamma] fn none(&self, q: f64) -> f64 { 0.0 * q.sin() }",
        "#[gamma] fn half(&self, q: f64) -> [f64; 2] { [self.s * q, 0.0 * q] }",
        "#[h1] fn none(&self, q: f64, p: f64) -> f64 { 0.0 * q * p }",
    ] {
        let text = expansion(expand, "midpoint", &format!("{PENDULUM} {noise}")).to_string();
        assert!(text.contains("compile_error"), "{noise}");
    }
}

/// An H₁ that depends on q alone equals −γ and has the same step, without a momentum part or a
/// correction.
#[test]
fn an_h1_without_momentum_costs_what_a_gamma_does() {
    let gamma = "#[gamma] fn shake(&self, q: f64) -> f64 { self.s * q.sin() }";
    let h1 = "#[h1] fn shake(&self, q: f64, p: f64) -> f64 { -self.s * q.sin() }";
    same(&format!("{PENDULUM} {gamma}"), &format!("{PENDULUM} {h1}"));
}

/// A symmetry adds a function and does not change the step.
#[test]
fn symmetries_leave_the_step_alone() {
    let free = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m * (v[0] * v[0] + v[1] * v[1]) + (q[0] - q[1]).cos()
    }";
    let symmetry = "#[symmetry] fn shift(&self, _q: [f64; 2]) -> [f64; 2] { [1.0, 1.0] }";
    same(free, &format!("{free} {symmetry}"));
}

#[test]
fn without_noise_or_time_neither_is_read() {
    let noise = "#[gamma] fn shake(&self, q: f64) -> f64 { self.s * q.sin() }";
    let timed = "fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 { 0.5 * v * v + t * q.cos() }";
    for rule in RULES {
        let reads = |members: &str, word: &str| {
            let body = increment(rule, members);
            body.split(|c: char| !c.is_alphanumeric())
                .any(|w| w == word)
        };
        assert!(!reads(PENDULUM, "dw"), "{rule}");
        assert!(!reads(PENDULUM, "time"), "{rule}");
        assert!(reads(&format!("{PENDULUM} {noise}"), "dw"), "{rule}");
        assert!(reads(timed, "time"), "{rule}");
    }
}

/// The step without structure is derived in addition and does not change the step.
#[test]
fn the_comparison_leaves_the_step_alone() {
    let noise = "#[h1] fn turn(&self, q: f64, p: f64) -> f64 { self.s * q.sin() * p }";
    let noisy = format!("{PENDULUM} {noise}");
    for members in [PENDULUM, &noisy] {
        for rule in RULES {
            let both = expansion(expand_compared, rule, members);
            let text = both.to_string();
            assert!(text.contains(":: Unstructured <"), "{text}");
            assert_eq!(step(rule, members), step_of(both), "{rule}");
        }
    }
}

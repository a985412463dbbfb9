//! The derivation of a rule does not depend on the other rules of the list.

use std::collections::BTreeSet;

use proc_macro2::TokenStream;
use quote::ToTokens;
use syn::punctuated::Punctuated;
use syn::{Meta, Token};

use super::costs;
use super::models::models;
use crate::tests::{expand, expand_compared, tokens};

/// Returns the rules of an attribute.
fn rules(attribute: TokenStream) -> Vec<String> {
    let parser = Punctuated::<Meta, Token![,]>::parse_terminated;
    let listed = syn::parse::Parser::parse2(parser, attribute).expect("a list of rules");
    (listed.iter())
        .map(|rule| rule.to_token_stream().to_string())
        .collect()
}

/// Returns the items of an expansion.
fn items(expansion: TokenStream) -> BTreeSet<String> {
    let file: syn::File = syn::parse2(expansion).expect("items");
    let items = file.items.iter();
    items
        .map(|item| item.to_token_stream().to_string())
        .collect()
}

/// Checks that the items of each rule alone are among the items of the whole list.
fn compare(name: &str, rules: &[String], together: TokenStream, block: &TokenStream) {
    let together = items(together);
    for rule in rules {
        let alone = items(expand(&tokens(rule), block));
        let others: Vec<_> = alone.difference(&together).collect();
        assert!(others.is_empty(), "{name}, `{rule}` alone: {others:?}");
    }
}

/// The list is derived without structure too, which leaves the other items alone. In both forms the
/// plans tell the operations.
#[test]
fn each_rule_of_each_model_expands_alone_as_in_its_list() {
    let (models, mut plans) = (models(), 0);
    assert!(models.len() > 40, "{}", models.len());
    for model in models {
        let block = model.block.to_token_stream();
        let together = expand_compared(&model.attribute, &block);
        plans += costs::compare(&model.name, &together).0;
        compare(&model.name, &rules(model.attribute), together, &block);
    }
    assert!(plans > 120, "{plans}");
}

fn compare_list(name: &str, rules: &[&str], block: &str) {
    let block = tokens(block);
    let together = expand(&tokens(&rules.join(", ")), &block);
    let rules: Vec<String> = rules.iter().map(|&rule| rule.to_owned()).collect();
    compare(name, &rules, together, &block);
}

/// A charge in a magnetic field about a centre, with a mass that depends on the velocity. In a
/// common arena six of its eleven steps depend on the list.
#[test]
fn each_rule_of_a_magnetic_kepler_problem_expands_alone_as_in_its_list() {
    let block = "impl Charge {
        fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
            let r = (q[0] * q[0] + q[1] * q[1] + q[2] * q[2]).sqrt();
            let speed = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            0.5 * self.m * speed * (1.0 + self.a * speed / r) + self.b * (q[0] * v[1] - q[1] * v[0]) / r + self.k / r
        }
        #[gamma] fn kicks(&self, q: [f64; 3]) -> [f64; 2] { [self.s * q[0].sin(), self.s * q[1] * q[2]] }
    }";
    let rules = [
        "initial_point",
        "endpoint",
        "midpoint",
        "stormer_verlet",
        "gauss(2)",
        "gauss(4)",
    ];
    compare_list("Charge", &rules, block);
}

#[test]
fn rules_with_options_expand_alone_as_in_their_list() {
    let block = "impl Kubo {
        fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v / (2.0 * self.a) - self.a / 2.0 * q * q * (1.0 + q * q) }
        #[gamma] fn kick(&self, q: f64) -> f64 { self.s * (q + q.sin()) }
    }";
    let rules = [
        "midpoint",
        "midpoint(weak2)",
        "gauss(2)",
        "gauss(2, weak2)",
        "gauss(2, stage_noise)",
        "stormer_verlet(weak2)",
        "endpoint",
    ];
    compare_list("Kubo", &rules, block);
}

//! The readable parts of an expansion: its documentation, and the names of its temporaries.

use std::fmt::Write;

use proc_macro2::{Delimiter, TokenStream, TokenTree};
use quote::ToTokens;

use crate::tests::{expand, items, tokens};

/// Returns a block of anharmonic springs between `n` masses.
fn chain(n: usize) -> String {
    let mut text = "impl Chain { ".to_owned();
    write!(
        text,
        "fn lagrangian(&self, q: [f64; {n}], v: [f64; {n}]) -> f64 {{
            let mut l = 0.0;
            for i in 0..{n} {{ l += 0.5 * self.m[i] * v[i] * v[i]; }}
            for i in 1..{n} {{ let s = q[i] - q[i - 1]; l -= 0.5 * self.k * s * s + 0.1 * (s * s + 1.0).sqrt(); }}
            l
        }}
        #[gamma] fn shake(&self, q: [f64; {n}]) -> [f64; {n}] {{
            let mut g = [0.0; {n}];
            for i in 0..{n} {{ g[i] = self.s * q[i].sin(); }}
            g
        }} }}"
    )
    .expect("a string can be written to");
    text
}

const PENDULUM: &str = "impl Pendulum {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = self.m;
        let swing = 0.5 * (m1 + m2) * v[0].powi(2) + 0.5 * m2 * v[1].powi(2) + m2 * v[0] * v[1] * (q[0] - q[1]).cos();
        swing + (m1 + m2) * self.q * q[0].cos() * (self.h * t).sin() + m2 * self.c1 * q[1].cos() * q[0].sin()
    }
    #[h1] fn turn(&self, q: [f64; 2], p: [f64; 2]) -> f64 { self.body.r#type * p[0] * p[1] * (q[0] - q[1]).sin() * self.0 }
}";

const ROTATION: &str = "impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 { v * v / (2.0 * self.a) - self.a / 2.0 * q * q }
    #[h1] fn jitter(&self, q: f64, p: f64) -> f64 { self.s / 2.0 * (q * q + p * p) }
}";

fn expansions() -> Vec<TokenStream> {
    let rules = tokens("initial_point, endpoint, midpoint");
    let mut all: Vec<TokenStream> = [PENDULUM, ROTATION, &chain(3)]
        .iter()
        .map(|item| expand(&rules, &tokens(item)))
        .collect();
    let smooth = PENDULUM.split("#[h1]").next().expect("a part");
    all.push(expand(&tokens("taylor2"), &tokens(&format!("{smooth}}}"))));
    for expansion in &all {
        assert!(!expansion.to_string().contains("compile_error"));
    }
    all
}

/// Returns, for each implementation, its trait, and its documentation with the documentation of its
/// functions.
fn documentation(expansion: &TokenStream) -> Vec<(String, String)> {
    let all = items(expansion.clone());
    let lines = |attributes: &[syn::Attribute]| {
        let mut text = String::new();
        for attribute in attributes {
            if let syn::Meta::NameValue(pair) = &attribute.meta
                && pair.path.is_ident("doc")
                && let syn::Expr::Lit(literal) = &pair.value
                && let syn::Lit::Str(line) = &literal.lit
            {
                text.push_str(&line.value());
                text.push('\n');
            }
        }
        text
    };
    let implementations = all.iter().filter_map(|item| match item {
        syn::Item::Impl(item) => Some(item),
        _ => None,
    });
    implementations
        .filter_map(|item| {
            let (name, ..) = item.trait_.as_ref()?;
            let mut text = lines(&item.attrs);
            for part in &item.items {
                if let syn::ImplItem::Fn(function) = part {
                    text.push_str(&lines(&function.attrs));
                }
            }
            Some((name.to_token_stream().to_string(), text))
        })
        // markers, such as `Separable`, have no formulas
        .filter(|(_, text)| !text.is_empty())
        .collect()
}

#[test]
fn implementations_document_what_was_derived() {
    let expansion = expand(&tokens("midpoint"), &tokens(ROTATION));
    let documentation = documentation(&expansion);
    let [(system, of_system), (step, of_step)] = documentation.as_slice() else {
        panic!("two implementations, not {}", documentation.len());
    };
    assert!(system.ends_with("System") && step.contains("Midpoint"));
    for line in [
        " L = v²/(2·a) − a·q²/2",
        " H₁ jitter = s·(q² + p²)/2",
        " dq = v dt + s·p ∘ dW",
        " dp = −a·q dt − s·q ∘ dW",
    ] {
        assert!(
            of_system.lines().any(|l| l == line),
            "{line} in {of_system}"
        );
    }
    for line in [
        " S = h·L(q̄, v) + p·(q₁ − q₀ − h·v) − H₁(q̄, p)·ΔW",
        "   q₁ = q₀ + h·v + s·ΔW·v/a",
    ] {
        assert!(of_step.lines().any(|l| l == line), "{line} in {of_step}");
    }
    // formulas are neither markdown nor tests
    for text in [of_system, of_step] {
        let mut inside = false;
        for line in text.lines() {
            match line {
                " ```text" | " ```" => {
                    assert_eq!(inside, line == " ```");
                    inside = !inside;
                }
                _ => assert!(
                    inside || !line.contains(" = ") || line.contains('`'),
                    "{line}"
                ),
            }
        }
        assert!(!inside);
    }
}

#[test]
fn parameters_are_told_from_the_notation() {
    let expansion = expand(&tokens("midpoint"), &tokens(PENDULUM));
    let text: String = documentation(&expansion).into_iter().map(|d| d.1).collect();
    for name in [
        "self.q·",
        "self.h·t",
        "body.type·",
        "·self.0",
        "m[1]·",
        "·c1·",
    ] {
        assert!(text.contains(name), "{name} in {text}");
    }
    assert!(!text.contains(" c1 = "), "{text}");
}

/// The length of the documentation does not grow with the system.
#[test]
fn texts_are_short() {
    let mut lengths = Vec::new();
    for n in [6, 24] {
        let expansion = expand(&tokens("endpoint, midpoint"), &tokens(&chain(n)));
        let documentation = documentation(&expansion);
        assert_eq!(documentation.len(), 3);
        let longest = documentation.iter().map(|d| d.1.chars().count()).max();
        lengths.push(longest.expect("three"));
        let cut = documentation.iter().filter(|d| d.1.contains('…')).count();
        assert_eq!(cut, 3);
    }
    assert!(
        lengths[1] <= 5000 && lengths[1] <= lengths[0] + 200,
        "{lengths:?}"
    );
}

/// Checks the scope of every `let`. `outer` has the names that are in scope at the start.
fn check_scope(stream: TokenStream, outer: &[String], count: &mut usize) {
    let mut names = outer.to_vec();
    let trees: Vec<TokenTree> = stream.into_iter().collect();
    let mut pending: Vec<String> = Vec::new();
    for (at, tree) in trees.iter().enumerate() {
        match tree {
            TokenTree::Group(group) if group.delimiter() == Delimiter::Brace => {
                check_scope(group.stream(), &names, count);
            }
            TokenTree::Group(group) => check_scope(group.stream(), &names, count),
            TokenTree::Ident(word) if word == "let" => {
                let is_mut = |t: &TokenTree| matches!(t, TokenTree::Ident(word) if word == "mut");
                let pattern = at + 1 + usize::from(trees.get(at + 1).is_some_and(is_mut));
                pending = match trees.get(pattern) {
                    Some(TokenTree::Ident(name)) => vec![name.to_string()],
                    Some(TokenTree::Group(pair)) if pair.delimiter() == Delimiter::Parenthesis => {
                        let parts = pair.stream().into_iter();
                        parts.map(|t| t.to_string()).filter(|t| t != ",").collect()
                    }
                    // the unknowns of a block, which become known one after the other
                    _ => continue,
                };
            }
            // the names are in scope after the statement
            TokenTree::Punct(mark) if mark.as_char() == ';' => {
                for name in pending.drain(..) {
                    assert!(!names.contains(&name) || name == "_", "`{name}` twice");
                    *count += 1;
                    names.push(name);
                }
            }
            _ => {}
        }
    }
}

#[test]
fn no_temporary_hides_another() {
    let mut count = 0;
    for expansion in expansions() {
        for item in items(expansion) {
            match item {
                syn::Item::Impl(item) if item.trait_.is_some() => {
                    for part in &item.items {
                        if let syn::ImplItem::Fn(function) = part {
                            check_scope(function.block.to_token_stream(), &[], &mut count);
                        }
                    }
                }
                syn::Item::Fn(function) => {
                    check_scope(function.block.to_token_stream(), &[], &mut count);
                }
                _ => {}
            }
        }
    }
    assert!(count > 1000, "{count}");
}

#[test]
fn temporaries_are_called_by_what_they_are() {
    let all = expansions();
    let pendulum = all[0].to_string();
    for name in [
        "residual_0",
        "jacobian_0_1",
        "mass_0_0",
        "magnitude_1",
        "dq_1",
        "dp_0",
        "sin_q0_0",
        "dqq_0_1",
        "noise_0_dp_0",
        "matrix_0_1",
        "rhs_0",
        "t_node",
    ] {
        assert!(
            pendulum.contains(&format!("let {name} =")) || pendulum.contains(&format!("({name} ,")),
            "{name}"
        );
    }
    let springs = all[2].to_string();
    assert!(springs.contains("let q_node_"));
    let rotation = all[1].to_string();
    for name in ["map_0_1", "q1_0", "v_0_squared"] {
        assert!(rotation.contains(&format!("let {name} =")), "{name}");
    }
}

#[test]
fn entries_of_a_band_are_called_by_their_place() {
    let expansion = expand(&tokens("midpoint"), &tokens(&chain(12))).to_string();
    let mut found = 0;
    let words = expansion.split(|c: char| !c.is_alphanumeric() && c != '_');
    for name in words.filter_map(|word| word.strip_prefix("jacobian_")) {
        let place: Vec<i32> = name.split('_').filter_map(|i| i.parse().ok()).collect();
        let &[i, j] = place.as_slice() else {
            panic!("{name}")
        };
        assert!((i - j).abs() <= 1, "{name}");
        found += 1;
    }
    assert!(found > 12, "{found}");
}

/// The plan calls a step a matrix times the state exactly if it is computed in this way.
#[test]
fn only_affine_steps_are_said_to_be_a_matrix_times_the_state() {
    let says = |rule: &str, item: &str| {
        let text = expand(&tokens(rule), &tokens(item)).to_string();
        assert!(!text.contains("compile_error"), "{text}");
        text.contains("computed as a matrix times the state")
    };
    let damped = "impl Well {
        fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - self.a * (1.0 - q * q).powi(2) }
        #[force] fn friction(&self, q: f64, v: f64) -> f64 { -2.0 * self.nu * v }
    }";
    assert!(!says("initial_point", damped));
    assert!(says("midpoint", ROTATION));
    let still = ROTATION.split("#[h1]").next().expect("a part");
    assert!(says("midpoint", &format!("{still}}}")));
}

//! Inputs that are deep, long or large: understood, or refused in bounded time.

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

use crate::tests::robustness::{expand_body, expanded};
use crate::tests::tokens;

/// Returns `open (open (… inner …))`.
fn nested(delimiter: Delimiter, depth: usize, inner: &str) -> TokenStream {
    (0..depth).fold(tokens(inner), |stream, _| {
        TokenTree::from(Group::new(delimiter, stream)).into()
    })
}

pub(super) fn with_body(body: TokenStream) -> TokenStream {
    with_coordinates("[f64; 2]", body)
}

pub(super) fn with_coordinates(ty: &str, body: TokenStream) -> TokenStream {
    let block: TokenTree = Group::new(Delimiter::Brace, body).into();
    let signature = tokens(&format!("fn lagrangian(&self, q: {ty}, v: {ty}) -> f64"));
    let function: TokenStream = signature.into_iter().chain([block]).collect();
    let block: TokenTree = Group::new(Delimiter::Brace, function).into();
    tokens("impl P").into_iter().chain([block]).collect()
}

#[test]
fn deep_nesting() {
    let midpoint = tokens("midpoint");
    for depth in [20, 50, 100, 300, 1_000, 10_000] {
        for delimiter in [
            Delimiter::Parenthesis,
            Delimiter::Bracket,
            Delimiter::Brace,
            Delimiter::None,
        ] {
            expanded(&midpoint, &with_body(nested(delimiter, depth, "v[0]")));
        }
        for prefix in [
            "-",
            "!",
            "&",
            "*",
            "return",
            "if",
            "|",
            "else",
            "<",
            "x =",
            "&mut",
            "if x {} else",
            "let x =",
            "x as",
            "|x|",
            "x ..",
            "a ?",
            "-> fn()",
        ] {
            let body: TokenStream = std::iter::repeat_n(tokens(prefix), depth)
                .chain([tokens("v[0]")])
                .collect();
            expanded(&midpoint, &with_body(body));
        }
        for suffix in [
            "+ v[0]", "* v[0]", ".sin()", "[0]", "?", "= v", "as f64", ".0", "(0)", "; v[0]",
            "+ 1.0;",
        ] {
            let body: TokenStream = [tokens("v[0]")]
                .into_iter()
                .chain(std::iter::repeat_n(tokens(suffix), depth))
                .collect();
            expanded(&midpoint, &with_body(body));
        }
        let ty: TokenStream = std::iter::repeat_n(tokens("&"), depth)
            .chain([tokens("f64")])
            .collect();
        let item = quote::quote!(impl P { fn lagrangian(&self, q: #ty, v: #ty) -> f64 { 0.0 } });
        expanded(&midpoint, &item);
        let attribute = nested(Delimiter::Parenthesis, depth, "midpoint");
        expanded(&attribute, &item);
    }
}

#[test]
fn long_sums_are_understood() {
    let sum = vec!["0.5 * v[0] * v[0] + v[1] * v[1]"; 400].join(" + ");
    let output = expand_body(&sum);
    assert!(!output.contains("compile_error"), "{output}");
}

#[test]
fn too_much_work() {
    for body in [
        "let mut s = 0.0; for i in 0..1000000000 { s += v[0]; } s",
        "let mut s = 0.0; for i in 0..9223372036854775807 { s += v[0]; } s",
        "let mut s = 0.0; for i in 0..=9223372036854775807 { s += v[0]; } s",
        "for i in -9223372036854775807..9223372036854775807 {} v[0]",
        "let mut s = 0.0; for i in 0..1000 { for j in 0..1000 { for k in 0..1000 { s += q[0].sin(); } } } s",
        "let mut s = v[0]; for i in 0..1900000 { s = s.sin(); } s",
        "let mut s = v[0]; for i in 0..60000 { s = s.sin() * s + q[0]; } s",
        "let mut s = v[0]; for i in 0..100 { s = s * s; } s",
        "let mut s = v[0]; for i in 0..10 { s = s.powi(1000); } s",
        "let mut s = v[0]; for i in 0..10 { s = s.sqrt().powi(1023); } s",
        "let mut s = v[0].powi(1000).powi(1000); for i in 0..5000 { s = s * v[0].powi(1000).powi(1000); } s",
        "let a = [[[[[0.0; 10000]; 10000]; 10000]; 10000]; 10000]; v[0]",
        "let a = [0.0; 9223372036854775807]; v[0]",
        "let mut a = [v[0]]; for i in 0..1000000 { a = [a]; } v[0]",
        "let mut a = [v[0]]; for i in 0..1000000 { a = [a, a]; } v[0]",
        "let a = [v[0]; 50000]; let mut s = 0.0; for i in 0..50000 { s += a[i]; } s",
        "let mut a = [v[0]; 50000]; for i in 0..50000 { a[i] += q[0]; } v[0]",
        "let i = -9223372036854775807 - 1; let j = -i; q[j]",
        "let i = (-9223372036854775807 - 1) / -1; v[0]",
        "let i = (-9223372036854775807 - 1) % -1; v[0]",
        "v[0].powi(-9223372036854775807 - 1)",
        "1e308 * v[0] * 1e308 * q[0] - 1e308 * v[0] * 1e308 * q[0]",
        "v[0].powi(1000) * 1e308 + v[1].powi(2)",
        "1e308 * v[0].powi(2) * 10.0",
        "v[0].powi(2) / 1e-320 + v[1].powi(2)",
        "v[0] / (q[0] - q[0])",
        "(q[0] - q[0]).ln() + (q[1] - q[1]).powf(-0.5) + (q[1] - q[1]).recip()",
        "(q[0] - q[0]).powi(-3) + (q[0] - q[0]).sqrt().powi(-3)",
        "1e200.powi(2) * v[0]",
        "let mut p = 1.0; for i in 0..40 { p *= (q[0] + i as f64).sin(); } 0.3 * p * v[0] * v[0] + 0.3 * p * v[1] * v[1]",
        "let x = q[0].powi(1000); 0.3 * x * v[0] * v[0] + 0.3 * x * v[1] * v[1]",
    ] {
        expand_body(body);
    }
}

#[test]
fn large_types() {
    for ty in [
        "f64; 0",
        "f64; 513",
        "f64; 1000000000000",
        "[f64; 0]; 1000000000000",
        "[[f64; 512]; 512]; 512",
        "f64; -1",
        "f64; 99999999999999999999",
        "f64; 1.5",
        "f64; Self::N",
        "f64; N",
        "f64; 60",
        "f32; 3",
    ] {
        let item = format!(
            "impl P {{ fn lagrangian(&self, q: [{ty}], v: [{ty}]) -> f64 {{ let mut s = 0.0; for i in 0..60 {{ s += v[i] * v[i] - q[i] * q[(i + 1) % 60]; }} s }} }}"
        );
        expanded(&tokens("midpoint"), &tokens(&item));
    }
}

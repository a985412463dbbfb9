//! Energies in lanes: the systems that have the loop, and that the loop has neither branches nor
//! calls of the library.

use crate::Settings;
use crate::tests::{items, tokens};

/// Returns the function `energy_lanes` of a system, if there is one.
fn energy_lanes(lagrangian: &str, settings: Settings) -> Option<String> {
    let block = tokens(&format!("impl P {{ {lagrangian} }}"));
    let expansion = crate::expand(&tokens("midpoint"), &block, settings);
    let parts = items(expansion).into_iter().filter_map(|item| match item {
        syn::Item::Impl(item) => Some(item.items),
        _ => None,
    });
    let function = parts.flatten().find_map(|item| match item {
        syn::ImplItem::Fn(function) if function.sig.ident == "energy_lanes" => Some(function),
        _ => None,
    });
    function.map(|function| quote::ToTokens::to_token_stream(&function).to_string())
}

#[test]
fn the_loop_calls_functions_of_lanes_only() {
    let pendulum = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] + 0.5 * q[0].exp() * v[1] * v[1] + v[0] * v[1] * q[1].cos() + q[0].ln()
    }";
    let code = energy_lanes(pendulum, Settings::default()).expect("a loop");
    for function in ["exp", "cos", "ln"] {
        assert!(!code.contains(&format!("f64 :: {function}")), "{code}");
        assert!(code.contains(&format!("lane :: {function}")), "{code}");
    }
    assert!(code.contains("lane :: solve ("), "{code}");
    assert!(!code.contains(" if ") && !code.contains("match"), "{code}");
}

#[test]
fn systems_without_a_formula_have_no_loop() {
    let of = |lagrangian: &str, settings| energy_lanes(lagrangian, settings);
    let plain = "fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }";
    assert!(of(plain, Settings::default()).is_some());
    assert!(
        of(
            plain,
            Settings {
                lanes: false,
                ..Settings::default()
            }
        )
        .is_none()
    );
    let relativistic =
        "fn lagrangian(&self, q: f64, v: f64) -> f64 { -(1.0 - v * v).sqrt() - q * q }";
    assert!(of(relativistic, Settings::default()).is_none());
    let degenerate = "fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 { q[1] * v[0] - q[0] * q[0] - q[1] * q[1] }";
    assert!(of(degenerate, Settings::default()).is_none());
}

//! Tests of the pipeline as a whole.

mod absent;
mod catalogue;
mod costs;
mod energy;
mod entries;
mod euler;
mod factors;
mod floors;
mod growth;
mod large_input;
mod limits;
mod lists;
mod messages;
mod mistakes;
mod models;
mod readable;
mod robustness;
mod rotations;
mod scheme;
mod starts;
mod vectors;
mod zero;

use proc_macro2::TokenStream;

use crate::Settings;

/// The expansion with steps in lanes.
pub(crate) fn expand(attribute: &TokenStream, item: &TokenStream) -> TokenStream {
    crate::expand(attribute, item, Settings::default())
}

/// The lines of code in the documentation of this package are these.
#[test]
fn the_example_of_the_documentation_expands() {
    let attribute = "midpoint".parse().expect("tokens");
    let block =
        "impl P { fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() } }";
    let expansion = crate::expand(
        &attribute,
        &block.parse().expect("tokens"),
        Settings::default(),
    );
    assert!(expansion.to_string().contains("StepEquations"));

    // but for line breaks and the name of this package
    let plain = |text: &str| {
        let text: String = text.split_whitespace().collect();
        text.replace(",)", ")").replace("sve_compiler::", "crate::")
    };
    let example = include_str!("../lib.rs").split("//! ```").nth(1);
    let example = example.expect("an example").replace("//!", "");
    let test = include_str!("mod.rs").replace("Settings::", "crate::Settings::");
    assert!(plain(&test).contains(&plain(&example)), "{example}");
}

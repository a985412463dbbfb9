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
mod time_scale;
mod vectors;
mod zero;

use proc_macro2::TokenStream;

use crate::Settings;

/// Returns the expansion with steps in lanes.
pub(crate) fn expand(attribute: &TokenStream, item: &TokenStream) -> TokenStream {
    crate::expand(attribute, item, Settings::default())
}

/// Returns the expansion with each rule derived a second time, without its structure.
pub(crate) fn expand_compared(attribute: &TokenStream, item: &TokenStream) -> TokenStream {
    let settings = Settings {
        unstructured: true,
        ..Settings::default()
    };
    crate::expand(attribute, item, settings)
}

/// Returns the expansion of a block with these members.
pub(crate) fn expand_members(attribute: &str, members: &str) -> TokenStream {
    let block = format!("impl P {{ {members} }}");
    expand(&tokens(attribute), &tokens(&block))
}

/// Reads a text as tokens.
pub(crate) fn tokens(text: &str) -> TokenStream {
    text.parse().expect("tokens")
}

/// Returns the items of an expansion. The items of a step with additional functions stand in a
/// block, which is opened.
pub(crate) fn items(expansion: TokenStream) -> Vec<syn::Item> {
    let file: syn::File = syn::parse2(expansion).expect("items");
    let mut items = Vec::new();
    for item in file.items {
        match item {
            syn::Item::Const(block) if matches!(*block.expr, syn::Expr::Block(_)) => {
                let syn::Expr::Block(block) = *block.expr else {
                    continue;
                };
                items.extend(block.block.stmts.into_iter().filter_map(|part| match part {
                    syn::Stmt::Item(item) => Some(item),
                    _ => None,
                }));
            }
            item => items.push(item),
        }
    }
    items
}

/// Returns the rows of a table: lines with columns that ` → ` separates, beside remarks.
pub(crate) fn rows<const COLUMNS: usize>(table: &str) -> Vec<[&str; COLUMNS]> {
    let mut rows = Vec::new();
    for line in table.lines().map(str::trim) {
        if !line.is_empty() && !line.starts_with("//") {
            let columns: Vec<&str> = line.split(" → ").collect();
            rows.push(columns.try_into().unwrap_or_else(|_| panic!("{line}")));
        }
    }
    rows
}

/// The lines of code in the documentation of this package are the ones tested here.
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

    // equal except for line breaks and the name of this package
    let plain = |text: &str| {
        let text: String = text.split_whitespace().collect();
        text.replace(",)", ")").replace("sve_compiler::", "crate::")
    };
    let example = include_str!("../lib.rs").split("//! ```").nth(1);
    let example = example.expect("an example").replace("//!", "");
    let test = include_str!("mod.rs").replace("Settings::", "crate::Settings::");
    assert!(plain(&test).contains(&plain(&example)), "{example}");
}

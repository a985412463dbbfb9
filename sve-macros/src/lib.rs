//! The procedural macro of [sve](https://docs.rs/sve-runtime): from a Lagrangian to a specialised variational step.
//!
//! Use it through `sve-runtime`, which re-exports it.

mod action;
mod compile;
mod emit;
mod equations;
mod errors;
mod lower;
mod mechanics;
mod model;
mod nesting;
mod parse;
mod regular;
#[cfg(test)]
mod robustness;
mod rule;
mod schedule;
#[cfg(test)]
mod schedule_tests;
mod structure;
mod symbolic;

use proc_macro::TokenStream;

/// Derives variational integrators from the Lagrangian and the noise terms of an `impl` block.
#[proc_macro_attribute]
pub fn variational(attribute: TokenStream, item: TokenStream) -> TokenStream {
    compile::expand(&attribute.into(), &item.into()).into()
}

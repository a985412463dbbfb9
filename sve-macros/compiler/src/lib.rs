//! The compiler of [sve](https://docs.rs/sve-runtime): from the tokens of an annotated `impl` block
//! to the tokens of its derived steps.
//!
//! Programs use it through the attribute `#[variational]` of `sve-runtime`. Other programs, tests
//! and benchmarks can call it as a library. The pipeline is in `driver.rs`, one line for each
//! stage; each stage is a folder.
//!
//! ```
//! let attribute = "midpoint".parse().expect("tokens");
//! let block =
//!     "impl P { fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() } }";
//! let expansion = sve_compiler::expand(
//!     &attribute,
//!     &block.parse().expect("tokens"),
//!     sve_compiler::Settings::default(),
//! );
//! assert!(expansion.to_string().contains("StepEquations"));
//! ```

mod algebra;
mod backend;
mod catalogue;
mod derivation;
mod discretise;
mod driver;
mod errors;
mod explain;
mod interpret;
mod linearise;
mod model;
mod operations;
mod program;
mod rules;
mod scene;
mod settings;
mod structure;
mod syntax;
mod system;
#[cfg(test)]
mod tests;

pub use driver::expand;
pub use operations::{CALL, Operations};
pub use settings::{Derivatives, Settings};

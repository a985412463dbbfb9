//! Compositions: a step of a higher order as a sequence of steps of derived rules with fractions of h and of the increments.
//!
//! | file | part |
//! | --- | --- |
//! | `coefficients.rs` | the fractions, with their sources |
//! | `composed.rs` | [`Composed`]: substeps of one symmetric rule |
//! | `split.rs` | [`Split`]: substeps that alternate between the initial-point and the endpoint rule |
//! | `sequence.rs`, `implement.rs` | a step as a sequence of substeps, common to both |
//! | `lanes.rs` | substeps in lanes, and tangent vectors along them |
//!
//! Invariant: a step that fails at a substep leaves the state unchanged.

mod coefficients;
mod composed;
mod implement;
mod lanes;
pub mod sequence;
mod split;

pub use coefficients::{BlanesMoan4, BlanesMoanRkn6, KahanLi8};
pub use composed::{Composed, Composition, Symmetric};
pub use split::{Coefficients, QuadraticKineticEnergy, Separable, Split, Splitting};

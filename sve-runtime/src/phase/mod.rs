//! Points of phase space: states, the types of their `q`, states in lanes, tangent vectors.
//!
//! | file | part |
//! | --- | --- |
//! | `state.rs` | time, configuration and momentum |
//! | `configuration.rs` | the types that the `q` of a state can have |
//! | `lanes.rs`, `tangents.rs` | states and tangent vectors of many lanes |
//! | `field.rs` | tangent vectors |
//! | `dual.rs` | numbers and states with a derivative in one direction |
//! | `serialise.rs` | configurations for serde |

pub(crate) mod configuration;
pub(crate) mod dual;
mod field;
pub(crate) mod lanes;
#[cfg(feature = "serde")]
pub(crate) mod serialise;
pub(crate) mod state;
pub(crate) mod tangents;

pub use field::Field;

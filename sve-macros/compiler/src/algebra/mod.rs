//! A small algebra library: it knows neither syntax trees nor code generation.
//!
//! Expressions live in an [`Arena`] and are named by [`Expr`]. Construction applies local rules
//! only (`simplify`), so equal expressions mostly have equal names; equalities that these rules
//! miss are decided numerically (`zero`). Before they are computed, expressions are put into forms
//! that do not cancel (`stable`).

mod budget;
mod diff;
mod display;
#[cfg(test)]
mod display_tests;
#[allow(dead_code, unreachable_pub)] // the integration tests compile it too
mod double_double;
mod elementary;
mod expr;
mod functions;
mod hash;
pub(crate) mod intervals;
mod number;
#[cfg(test)]
mod reader;
mod sharp;
mod simplify;
mod stable;
#[cfg(test)]
pub(crate) mod tests;
mod zero;

pub(crate) use display::{Notation, Sum, Text};
pub(crate) use expr::{Arena, Bits, Expr, Identity, Node, Symbol};
pub(crate) use functions::{Binary, BinaryBound, Bound, Domain, Function, Sign};
pub(crate) use hash::Map;
pub(crate) use sharp::{Sharp, Verdict};
pub(crate) use stable::Purpose;
pub(crate) use zero::{Vanishing, coordinate as random_coordinate};

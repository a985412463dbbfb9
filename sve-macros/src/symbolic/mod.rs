//! A small algebra library: it knows neither syntax trees nor code generation.
//!
//! Expressions live in an [`Arena`] and are named by [`Expr`]. Construction applies local rules only (`simplify`), so that
//! equal expressions are mostly equal names; what these rules miss is decided numerically (`zero`). Before they are computed,
//! expressions are put into forms that do not cancel (`stable`).

mod budget;
mod diff;
mod display;
mod expr;
mod hash;
mod simplify;
mod stable;
#[cfg(test)]
pub(crate) mod tests;
mod zero;

pub(crate) use expr::{Arena, Binary, Expr, Function, Node, Symbol};
pub(crate) use hash::Map;
pub(crate) use stable::Purpose;

//! The discretisation rules as discrete actions, one file each, with their textbook forms. The
//! catalogue has their names, orders and the systems that they take.
//!
//! To add a rule, add a row to the catalogue, its action here, and its type in the runtime.

pub(crate) mod action;
pub(crate) mod constraints;
pub(crate) mod correction;
pub(crate) mod degenerate;
pub(crate) mod gauss;
mod one_node;
pub(crate) mod rotations;
mod stormer_verlet;
mod taylor2;
pub(crate) mod textbook;
pub(crate) mod weak2;

use crate::catalogue::{Nodes, Rule};
use action::{Discrete, Variables};
use textbook::{Features, Point, Textbook};

/// The action of a rule.
pub(crate) trait Discretisation {
    /// Returns the discrete action, with the variables in which it is stationary and the work of
    /// the force.
    fn action(&self, variables: &mut Variables<'_>) -> Discrete;
    /// Returns the notation of a node of the rule.
    fn point(&self, node: usize) -> Point;
    /// Returns the letters of the rule's own variables. Parameters of the same name are printed
    /// with other letters.
    fn letters(&self) -> &'static [&'static str] {
        &[]
    }
    /// Returns the action with L, γ, H₁ and F as functions.
    fn textbook(&self, system: &Features) -> Textbook;
}

/// Returns the action of a rule.
pub(crate) fn discretisation(rule: Rule) -> Box<dyn Discretisation> {
    match rule.nodes {
        Nodes::One { c } => Box::new(one_node::OneNode { place: c }),
        Nodes::Ends => Box::new(stormer_verlet::StormerVerlet),
        Nodes::Gauss { stages } => Box::new(gauss::Gauss { stages }),
        Nodes::Taylor => Box::new(taylor2::Taylor2),
    }
}

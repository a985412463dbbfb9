//! The discretisation rules as discrete actions, a file each, with their textbook forms. Their names, orders and what they take are in the
//! catalogue.
//!
//! A new rule is a row of the catalogue, its action here, and its type in the runtime.

pub(crate) mod action;
pub(crate) mod constraints;
pub(crate) mod degenerate;
pub(crate) mod gauss;
mod one_node;
mod stormer_verlet;
mod taylor2;
pub(crate) mod weak2;

use crate::catalogue::{Nodes, Rule};
use crate::model::NodeQuantity;
use action::{Discrete, Variables};

/// The action of a rule.
pub(crate) trait Discretisation {
    /// The discrete action, with the variables in which it is stationary and the work of the force.
    fn action(&self, variables: &mut Variables<'_>) -> Discrete;
    /// How a quantity at a node of the rule is written, without its component: `q̄`.
    fn notation(&self, node: usize, quantity: NodeQuantity) -> &'static str;
    /// Whether the position of a node is q₁.
    fn is_end(&self, node: usize) -> bool;
    /// Letters of the rule's own variables, which parameters of the same name do not get.
    fn letters(&self) -> &'static [&'static str] {
        &[]
    }
    /// The action with L, γ, H₁ and F as functions.
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

/// What of a system shows in the textbook form of an action.
pub(crate) struct Features {
    pub(crate) degrees_of_freedom: usize,
    /// Whether L or a noise depends on time.
    pub(crate) is_timed: bool,
    /// Whether the force depends on time, where there is one.
    pub(crate) force_is_timed: Option<bool>,
    /// ½κ of the option `weak2`, if the action has its term.
    pub(crate) potential: Option<f64>,
    /// Whether each process has an increment for each stage.
    pub(crate) has_stage_noise: bool,
    /// Numbers of γ and of H₁.
    pub(crate) gammas: usize,
    pub(crate) hamiltonians: usize,
    /// Whether some noise moves q and some noise moves p.
    pub(crate) moves_both: bool,
}

/// An action in its textbook form.
pub(crate) struct Textbook {
    /// `S = …`
    pub(crate) action: String,
    /// What the symbols in it stand for.
    pub(crate) notation: Vec<String>,
    /// The virtual work of the force for a step of unit length.
    pub(crate) work: String,
}

impl Features {
    /// `p·(x)`, or `⟨p, x⟩` of vectors.
    fn pairing(&self, p: &str, x: &str) -> String {
        if self.degrees_of_freedom == 1 {
            format!("{p}·({x})")
        } else {
            format!("⟨{p}, {x}⟩")
        }
    }

    /// The term of the option `weak2` in an action, ` − h·|h|·(K(q₀) + K(q₁))/16` for the factor `h·|h|` and the sum `K(q₀) + K(q₁)` over two nodes of equal weight.
    pub(crate) fn potential(&self, factor: &str, sum: &str, nodes: u32) -> String {
        match self.potential {
            // κ is one over an integer
            Some(half) => format!(" − {factor}·{sum}/{}", (f64::from(nodes) / half).round()),
            None => String::new(),
        }
    }

    /// The weight of a stage and the increment, whose product is the increment at the stage.
    pub(crate) fn increment_at_stage(&self) -> (&'static str, &'static str) {
        if self.has_stage_noise {
            ("", "ωᵢ")
        } else {
            ("bᵢ·", "ΔW")
        }
    }

    /// The virtual work of the force at a point.
    fn work(&self, t: &str, q: &str, v: &str) -> String {
        let t = if self.force_is_timed == Some(true) {
            format!("{t}, ")
        } else {
            String::new()
        };
        if self.degrees_of_freedom == 1 {
            format!("F({t}{q}, {v})·δ{q}")
        } else {
            format!("⟨F({t}{q}, {v}), δ{q}⟩")
        }
    }
}

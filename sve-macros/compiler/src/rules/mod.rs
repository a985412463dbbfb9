//! The discretisation rules, a file each: action, names, orders, what a rule takes, its textbook form.
//!
//! A new rule is a file here, a line in [`Rule::ALL`], and its type in the runtime.

pub(crate) mod action;
mod endpoint;
pub(crate) mod gauss;
mod initial_point;
mod midpoint;
mod one_node;
mod stormer_verlet;
mod taylor2;

use std::fmt;
use std::ops::Deref;

use crate::system::model::NodeQuantity;
use action::{Discrete, Variables};

/// A discretisation rule.
#[derive(Clone, Copy)]
pub(crate) struct Rule(&'static (dyn Discretisation + Sync));

impl Rule {
    /// All rules, in the order in which messages list them. A rule with a parameter stands here once for each of its values.
    pub(crate) const ALL: [Self; 12] = [
        Self(&initial_point::INITIAL_POINT),
        Self(&endpoint::ENDPOINT),
        Self(&midpoint::MIDPOINT),
        Self(&stormer_verlet::StormerVerlet),
        Self(&gauss::GAUSS[0]),
        Self(&gauss::GAUSS[1]),
        Self(&gauss::GAUSS[2]),
        Self(&gauss::GAUSS[3]),
        Self(&gauss::GAUSS[4]),
        Self(&gauss::GAUSS[5]),
        Self(&gauss::GAUSS[6]),
        Self(&taylor2::Taylor2),
    ];

    /// The rule of a name in the attribute.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|rule| rule.attribute_name() == name)
    }

    /// The names, for messages.
    pub(crate) fn listed() -> String {
        let names = Self::ALL.map(|rule| format!("`{}`", rule.attribute_name()));
        names.join(", ")
    }
}

/// What a rule is.
pub(crate) trait Discretisation {
    /// The rule's name in the attribute.
    fn attribute_name(&self) -> &'static str;
    /// The rule's type in the runtime.
    fn type_name(&self) -> &'static str;
    /// The number of stages of a rule whose stages are solved together by the runtime; nothing of one whose action is unrolled.
    fn stages(&self) -> Option<usize> {
        None
    }
    /// Order of convergence without noise.
    fn deterministic_order(&self) -> u32;
    /// Strong order of convergence with noise.
    fn strong_order(&self, noises_commute: bool) -> StrongOrder;
    /// Whether the rule is for systems with noise.
    fn takes_noise(&self) -> bool;
    /// Whether the rule is for systems with a force.
    fn takes_force(&self) -> bool;
    /// The discrete action, with the variables in which it is stationary and the work of the force.
    fn action(&self, variables: &mut Variables<'_>) -> Discrete;
    /// How a quantity at a node of the rule is written, without its component: `q̄`.
    fn notation(&self, node: usize, quantity: NodeQuantity) -> &'static str;
    /// Whether the position of a node is q₁.
    fn is_end(&self, node: usize) -> bool;
    /// Letters of the rule's own variables, which parameters of the same name do not get.
    fn letters(&self) -> &'static [&'static str];
    /// The action with L, γ, H₁ and F as functions.
    fn textbook(&self, system: &Features) -> Textbook;
}

/// An order of strong convergence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum StrongOrder {
    Half,
    One,
}

/// What of a system shows in the textbook form of an action.
pub(crate) struct Features {
    pub(crate) degrees_of_freedom: usize,
    /// Whether L or a noise depends on time.
    pub(crate) is_timed: bool,
    /// Whether the force depends on time, where there is one.
    pub(crate) force_is_timed: Option<bool>,
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

impl Deref for Rule {
    type Target = dyn Discretisation + Sync;

    fn deref(&self) -> &Self::Target {
        self.0
    }
}

impl PartialEq for Rule {
    fn eq(&self, other: &Self) -> bool {
        self.attribute_name() == other.attribute_name()
    }
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.attribute_name())
    }
}

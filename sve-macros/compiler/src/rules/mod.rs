//! The discretisation rules, a file each: action, names, orders, what a rule takes, its textbook form.
//!
//! A new rule is a file here, a line in [`Rule::all`], and its type in the runtime. A rule has a number of stages if it is a member of a family, and
//! options if its file says so; rules that differ in these are different rules.

pub(crate) mod action;
pub(crate) mod applicable;
pub(crate) mod constraints;
pub(crate) mod degenerate;
mod endpoint;
pub(crate) mod gauss;
mod initial_point;
mod midpoint;
mod one_node;
mod options;
mod stormer_verlet;
mod taylor2;
pub(crate) mod weak2;

use std::fmt;
use std::ops::Deref;

use crate::model::NodeQuantity;
use action::{Discrete, Variables};
pub(crate) use options::{Options, RuleOption};
pub(crate) use weak2::Weak2;

/// A rule without its options, as its file defines it.
type Base = &'static (dyn Discretisation + Sync);

/// A discretisation rule: a base rule, of a number of stages where its name is that of a family, with options.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    base: Base,
    pub(crate) options: Options,
}

impl Rule {
    /// All rules without options, in the order in which messages list them. A family of rules stands here with each number of stages, in
    /// ascending order.
    pub(crate) fn all() -> Vec<Self> {
        let first: [Base; 4] = [
            &initial_point::INITIAL_POINT,
            &endpoint::ENDPOINT,
            &midpoint::MIDPOINT,
            &stormer_verlet::StormerVerlet,
        ];
        let gauss = gauss::GAUSS.iter().map(|rule| rule as Base);
        let last: [Base; 1] = [&taylor2::Taylor2];
        let rules = first.into_iter().chain(gauss).chain(last);
        rules.map(Self::plain).collect()
    }

    /// All rules with all sets of options that they take.
    pub(crate) fn all_with_options() -> Vec<Self> {
        let all = Self::all().into_iter();
        all.flat_map(|rule| {
            let sets = Options::subsets(rule.base.options()).into_iter();
            sets.map(move |options| Self { options, ..rule })
        })
        .collect()
    }

    /// A rule without options.
    pub(crate) fn plain(base: Base) -> Self {
        Self {
            base,
            options: Options::NONE,
        }
    }

    /// The rule with one more option.
    #[must_use]
    pub(crate) fn with(self, option: RuleOption) -> Self {
        Self {
            options: self.options.with(option),
            ..self
        }
    }

    /// The rule with one option less.
    #[must_use]
    pub(crate) fn without(self, option: RuleOption) -> Self {
        Self {
            options: self.options.without(option),
            ..self
        }
    }

    /// The rule as the attribute writes it: `midpoint`, `gauss(3, weak2)`.
    pub(crate) fn name(&self) -> String {
        let stages = self.stages().map(|stages| stages.to_string());
        let options = self.options.iter().map(|option| option.name().to_owned());
        let arguments: Vec<String> = stages.into_iter().chain(options).collect();
        written(self.attribute_name(), &arguments)
    }
}

/// A rule with arguments as the attribute writes it.
pub(crate) fn written(name: &str, arguments: &[String]) -> String {
    match arguments {
        [] => name.to_owned(),
        arguments => format!("{name}({})", arguments.join(", ")),
    }
}

/// The names of rules, for messages. A family is one entry.
pub(crate) fn names(rules: &[Rule]) -> Vec<String> {
    let families = rules.chunk_by(|a, b| a.attribute_name() == b.attribute_name());
    let names = families.map(|family| match family {
        [first, .., last] => format!("`{}` to `{}`", first.name(), last.name()),
        one => format!("`{}`", one[0].name()),
    });
    names.collect()
}

/// What a rule is.
pub(crate) trait Discretisation {
    /// The rule's name in the attribute, without arguments.
    fn attribute_name(&self) -> &'static str;
    /// The place c of the node `q₀ + c (q₁ − q₀)` of a rule with one node.
    fn node(&self) -> Option<f64> {
        None
    }
    /// Number of stages of a member of a family, which the attribute writes after the name: `gauss(4)`. The order is twice this number.
    fn stages(&self) -> Option<usize> {
        None
    }
    /// Attribute name of the rule that the family with one stage would be.
    fn with_one_stage(&self) -> Option<&'static str> {
        None
    }
    /// The options that the rule takes.
    fn options(&self) -> &'static [RuleOption] {
        &[]
    }
    /// What the rule says of the option `weak2`, beside other options; nothing if the rule does not take it.
    fn weak2(&self, _: Options) -> Option<Weak2> {
        None
    }
    /// The rule's type in the runtime, which is generic in the number of stages of a family.
    fn type_name(&self) -> &'static str;
    /// Order of convergence without noise.
    fn deterministic_order(&self) -> u32;
    /// Strong order of convergence with noise.
    fn strong_order(&self, noises_commute: bool) -> StrongOrder;
    /// Whether the rule is for systems with noise.
    fn takes_noise(&self) -> bool;
    /// Whether the rule is for systems with a force.
    fn takes_force(&self) -> bool;
    /// Whether the rule, with these options, is for configurations with rotations.
    fn takes_rotations(&self, _: Options) -> bool {
        false
    }
    /// Whether the rule is for systems with constraints.
    fn takes_constraints(&self) -> bool {
        false
    }
    /// Whether the action has a Stratonovich correction.
    fn has_correction(&self) -> bool {
        false
    }
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

impl Deref for Rule {
    type Target = dyn Discretisation + Sync;

    fn deref(&self) -> &Self::Target {
        self.base
    }
}

impl PartialEq for Rule {
    fn eq(&self, other: &Self) -> bool {
        let identity = |rule: &Self| (rule.attribute_name(), rule.stages(), rule.options);
        identity(self) == identity(other)
    }
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name())
    }
}

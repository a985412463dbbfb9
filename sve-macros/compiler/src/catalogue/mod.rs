//! The catalogue of rules: their names in the attribute, their orders, the systems that they take,
//! and their options.
//!
//! The parser, the refusals and the plan read the table [`RULES`]; a test compares the tables of
//! the documentation with it. The discrete action of a rule is in `rules/`. Rules that differ in
//! the number of stages or in options are different rules.

mod options;

use std::fmt;
use std::ops::Deref;

pub(crate) use options::{Options, RuleOption};

/// A row of the catalogue: a rule without options. A family of rules has a row for each number of
/// stages.
#[derive(Debug)]
pub(crate) struct Entry {
    /// The name in the attribute, without arguments.
    pub(crate) attribute_name: &'static str,
    /// The type in the runtime, which is generic in the number of stages of a family.
    pub(crate) type_name: &'static str,
    pub(crate) nodes: Nodes,
    /// The order of convergence without noise. The strong order with noise is 1 if the noises
    /// commute, else ½.
    pub(crate) order: u32,
    pub(crate) takes: Takes,
}

/// The nodes at which the action of a rule evaluates L.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Nodes {
    /// One node, at `q₀ + c (q₁ − q₀)`.
    One { c: f64 },
    /// Both ends of the step, with one velocity.
    Ends,
    /// The nodes of Gauss quadrature. The attribute writes their number after the name: `gauss(4)`.
    Gauss { stages: usize },
    /// The start, and the end that a Taylor expansion predicts.
    Taylor,
}

/// The systems that a rule takes, beside systems without noise, force and constraints on vectors.
#[derive(Clone, Copy, Debug)]
#[allow(clippy::struct_excessive_bools)] // columns of a table
pub(crate) struct Takes {
    pub(crate) noise: bool,
    pub(crate) force: bool,
    pub(crate) constraints: bool,
    /// True if the rule without options takes rotations in the configuration.
    pub(crate) rotations: bool,
    pub(crate) options: &'static [RuleOption],
}

/// The properties of a rule with the option `weak2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weak2 {
    /// κ, the factor of the potential.
    pub(crate) factor: f64,
    /// True if the term raises the weak order also with noise that moves the position.
    pub(crate) takes_h1: bool,
}

/// All rules without options, in the order in which messages list them; the members of a family in
/// ascending numbers of stages.
pub(crate) static RULES: [Entry; 12] = [
    one_node("initial_point", "InitialPoint", 0.0),
    one_node("endpoint", "Endpoint", 1.0),
    Entry {
        order: 2,
        takes: Takes {
            rotations: true,
            options: &[RuleOption::Weak2],
            ..EVERYTHING
        },
        ..one_node("midpoint", "Midpoint", 0.5)
    },
    Entry {
        attribute_name: "stormer_verlet",
        type_name: "StormerVerlet",
        nodes: Nodes::Ends,
        order: 2,
        takes: Takes {
            rotations: true,
            options: &[RuleOption::Weak2],
            ..EVERYTHING
        },
    },
    gauss(2),
    gauss(3),
    gauss(4),
    gauss(5),
    gauss(6),
    gauss(7),
    gauss(8),
    Entry {
        attribute_name: "taylor2",
        type_name: "Taylor2",
        nodes: Nodes::Taylor,
        order: 2,
        takes: Takes {
            noise: false,
            constraints: false,
            ..EVERYTHING
        },
    },
];

/// Noise, force and constraints.
const EVERYTHING: Takes = Takes {
    noise: true,
    force: true,
    constraints: true,
    rotations: false,
    options: &[],
};

const fn one_node(attribute_name: &'static str, type_name: &'static str, c: f64) -> Entry {
    Entry {
        attribute_name,
        type_name,
        nodes: Nodes::One { c },
        order: 1,
        takes: EVERYTHING,
    }
}

const fn gauss(stages: usize) -> Entry {
    Entry {
        attribute_name: "gauss",
        type_name: "Gauss",
        nodes: Nodes::Gauss { stages },
        order: 2 * stages as u32,
        takes: Takes {
            constraints: false,
            options: &[RuleOption::StageNoise, RuleOption::Weak2],
            ..EVERYTHING
        },
    }
}

impl Entry {
    /// Returns the place c of the node of a rule with one node.
    pub(crate) fn node(&self) -> Option<f64> {
        match self.nodes {
            Nodes::One { c } => Some(c),
            _ => None,
        }
    }

    /// Returns the number of stages of a member of a family.
    pub(crate) fn stages(&self) -> Option<usize> {
        match self.nodes {
            Nodes::Gauss { stages } => Some(stages),
            _ => None,
        }
    }

    /// Returns whether the action has a Stratonovich correction.
    pub(crate) fn has_correction(&self) -> bool {
        self.node().is_some_and(|c| c != 0.5)
    }
}

/// A rule with options.
#[derive(Clone, Copy)]
pub(crate) struct Rule {
    entry: &'static Entry,
    pub(crate) options: Options,
}

impl Rule {
    /// All rules without options.
    pub(crate) fn all() -> Vec<Self> {
        RULES.iter().map(Self::plain).collect()
    }

    /// All rules with all sets of options that they take.
    pub(crate) fn all_with_options() -> Vec<Self> {
        let all = Self::all().into_iter();
        all.flat_map(|rule| {
            let sets = Options::subsets(rule.takes.options).into_iter();
            sets.map(move |options| Self { options, ..rule })
        })
        .collect()
    }

    /// Returns a rule without options.
    pub(crate) fn plain(entry: &'static Entry) -> Self {
        Self {
            entry,
            options: Options::NONE,
        }
    }

    /// Returns the rule with one more option.
    #[must_use]
    pub(crate) fn with(self, option: RuleOption) -> Self {
        Self {
            options: self.options.with(option),
            ..self
        }
    }

    /// Returns the rule with one option less.
    #[must_use]
    pub(crate) fn without(self, option: RuleOption) -> Self {
        Self {
            options: self.options.without(option),
            ..self
        }
    }

    /// Returns the rule as the attribute spells it: `midpoint`, `gauss(3, weak2)`.
    pub(crate) fn name(&self) -> String {
        let stages = self.stages().map(|stages| stages.to_string());
        let options = self.options.iter().map(|option| option.name().to_owned());
        let arguments: Vec<String> = stages.into_iter().chain(options).collect();
        written(self.attribute_name, &arguments)
    }

    /// Returns the properties of the rule with the option `weak2` and its other options; `None` if
    /// the rule does not take the option.
    pub(crate) fn weak2(&self) -> Option<Weak2> {
        let is_taken = self.takes.options.contains(&RuleOption::Weak2);
        let has_stage_noise = self.options.contain(RuleOption::StageNoise);
        let weak2 = match self.stages() {
            None => Weak2 {
                factor: 0.25,
                takes_h1: false,
            },
            Some(stages) if has_stage_noise => Weak2 {
                factor: 1.0 / (4 * (2 * stages - 1)) as f64,
                takes_h1: false,
            },
            Some(_) => Weak2 {
                factor: 1.0 / 6.0,
                takes_h1: true,
            },
        };
        is_taken.then_some(weak2)
    }

    /// Returns whether the rule takes configurations with rotations.
    pub(crate) fn takes_rotations(&self) -> bool {
        self.takes.rotations && self.options == Options::NONE
    }
}

/// Returns a rule with arguments as the attribute spells it.
pub(crate) fn written(name: &str, arguments: &[String]) -> String {
    match arguments {
        [] => name.to_owned(),
        arguments => format!("{name}({})", arguments.join(", ")),
    }
}

/// Returns the names of rules, for messages. A family is one entry.
pub(crate) fn names(rules: &[Rule]) -> Vec<String> {
    let families = rules.chunk_by(|a, b| a.attribute_name == b.attribute_name);
    let names = families.map(|family| match family {
        [first, .., last] => format!("`{}` to `{}`", first.name(), last.name()),
        one => format!("`{}`", one[0].name()),
    });
    names.collect()
}

impl Deref for Rule {
    type Target = Entry;

    fn deref(&self) -> &Entry {
        self.entry
    }
}

impl PartialEq for Rule {
    fn eq(&self, other: &Self) -> bool {
        let identity = |rule: &Self| (rule.attribute_name, rule.stages(), rule.options);
        identity(self) == identity(other)
    }
}

impl fmt::Debug for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name())
    }
}

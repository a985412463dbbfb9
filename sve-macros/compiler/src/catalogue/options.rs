//! The options of rules, which the attribute lists after the number of stages:
//! `gauss(3, stage_noise, weak2)`.

use std::fmt;

/// A variation of a rule, in the order in which names of rules list the options.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum RuleOption {
    /// An increment of each process for each stage.
    StageNoise,
    /// The potential that gives weak order 2.
    Weak2,
}

impl RuleOption {
    pub(crate) const ALL: [Self; 2] = [Self::StageNoise, Self::Weak2];

    /// Returns the option with a name in the attribute.
    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|option| option.name() == name)
    }

    /// Returns the name in the attribute.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::StageNoise => "stage_noise",
            Self::Weak2 => "weak2",
        }
    }

    /// Returns the type in the runtime that wraps the rule.
    pub(crate) fn type_name(self) -> &'static str {
        match self {
            Self::StageNoise => "StageNoise",
            Self::Weak2 => "Weak2",
        }
    }
}

/// A set of options.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Options(u8);

impl Options {
    pub(crate) const NONE: Self = Self(0);

    /// Returns the set with one more option.
    #[must_use]
    pub(crate) fn with(self, option: RuleOption) -> Self {
        Self(self.0 | 1 << option as u8)
    }

    /// Returns the set with one option less.
    #[must_use]
    pub(crate) fn without(self, option: RuleOption) -> Self {
        Self(self.0 & !(1 << option as u8))
    }

    pub(crate) fn contain(self, option: RuleOption) -> bool {
        self.0 & 1 << option as u8 != 0
    }

    /// Returns the options in the set, in the order of [`RuleOption`].
    pub(crate) fn iter(self) -> impl Iterator<Item = RuleOption> {
        let all = RuleOption::ALL.into_iter();
        all.filter(move |&option| self.contain(option))
    }

    /// All subsets of these options.
    pub(crate) fn subsets(options: &[RuleOption]) -> Vec<Self> {
        options.iter().fold(vec![Self::NONE], |sets, &option| {
            let with = sets.iter().map(|set| set.with(option)).collect::<Vec<_>>();
            [sets, with].concat()
        })
    }
}

impl fmt::Debug for Options {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.iter()).finish()
    }
}

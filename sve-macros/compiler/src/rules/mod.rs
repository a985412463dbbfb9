//! The discretisation rules: their names and orders. What they do is in `action`.

pub(crate) mod action;

/// A discretisation rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
    InitialPoint,
    Endpoint,
    Midpoint,
    Taylor2,
}

impl Rule {
    pub(crate) const ALL: [Self; 4] = [
        Self::InitialPoint,
        Self::Endpoint,
        Self::Midpoint,
        Self::Taylor2,
    ];

    /// The rule's name in the attribute.
    pub(crate) const fn attribute_name(self) -> &'static str {
        match self {
            Self::InitialPoint => "initial_point",
            Self::Endpoint => "endpoint",
            Self::Midpoint => "midpoint",
            Self::Taylor2 => "taylor2",
        }
    }

    /// The rule's type in the runtime.
    pub(crate) const fn type_name(self) -> &'static str {
        match self {
            Self::InitialPoint => "InitialPoint",
            Self::Endpoint => "Endpoint",
            Self::Midpoint => "Midpoint",
            Self::Taylor2 => "Taylor2",
        }
    }

    /// Order of convergence without noise.
    pub(crate) const fn deterministic_order(self) -> u32 {
        match self {
            Self::InitialPoint | Self::Endpoint => 1,
            Self::Midpoint | Self::Taylor2 => 2,
        }
    }

    pub(crate) fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|rule| rule.attribute_name() == name)
    }

    /// The names, for messages.
    pub(crate) fn listed() -> String {
        let names: Vec<String> = Self::ALL
            .iter()
            .map(|r| format!("`{}`", r.attribute_name()))
            .collect();
        names.join(", ")
    }
}

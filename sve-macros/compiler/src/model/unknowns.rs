//! The unknowns of a step.

use super::Meaning;

/// An unknown of the step: its family, and the coordinate to which it belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Unknown {
    pub(crate) family: Family,
    pub(crate) index: usize,
}

/// The kinds of unknowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Family {
    /// `q₁ − q₀`.
    Displacement,
    Velocity,
    /// The velocity of a path at a stage, in addition to the velocity at which L is evaluated.
    StageVelocity,
    Momentum,
    Acceleration,
    /// The multiplier of the equation that defines the velocity of `taylor2`. It is a momentum.
    VelocityMultiplier,
    /// The multiplier of the equation that defines the acceleration of `taylor2`.
    AccelerationMultiplier,
    /// The multiplier of a constraint at the start of the step. It is an impulse.
    StartMultiplier,
    /// The multiplier of a constraint at the end of the step.
    EndMultiplier,
    /// The velocity that belongs to p₁ at q₁.
    EndVelocity,
    /// The distance of a coordinate at the node from q₀, if it is a variable of the node.
    NodeDisplacement,
    /// The multiplier that keeps p = α(q) at the end of the step: a displacement of both ends.
    Projection,
}

impl Family {
    pub(crate) fn is_multiplier_of_constraint(self) -> bool {
        matches!(self, Self::StartMultiplier | Self::EndMultiplier)
    }

    /// Returns whether the unknown is the distance from a point, which vanishes in the limit of no
    /// noise and h → 0.
    pub(crate) fn is_displacement(self) -> bool {
        matches!(
            self,
            Self::Displacement | Self::NodeDisplacement | Self::Projection
        )
    }
}

impl Unknown {
    /// Returns the meaning of each symbol of a family, for [`Symbols::declare_all`].
    pub(crate) fn of(family: Family) -> impl Fn(usize) -> Meaning {
        move |index| Meaning::Unknown(Self { family, index })
    }
}

impl std::fmt::Display for Unknown {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let letter = match self.family {
            Family::Displacement => "d",
            Family::Velocity => "v",
            Family::StageVelocity => "u",
            Family::Momentum => "p",
            Family::Acceleration => "a",
            Family::VelocityMultiplier | Family::EndMultiplier => "mu",
            Family::AccelerationMultiplier => "nu",
            Family::StartMultiplier | Family::Projection => "lambda",
            Family::EndVelocity => "v1",
            Family::NodeDisplacement => "e",
        };
        write!(f, "{letter}_{}", self.index)
    }
}

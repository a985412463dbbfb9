//! [`Rule`] as a bound of the system: `S: Variational<R>`, `S: ConstraintImpulses<R>`.

use super::{Rule, TellsImpulses};
use crate::system::equations::Memory;
use crate::system::{IncrementsOf, System};

/// A system with the step of the rule `R`, which takes one increment for each Wiener process. This
/// is the bound `R: Rule<S::Itself, Increments = IncrementsOf<S>>`.
///
/// All rules take one increment for each process, except the rules with stage noise. The bound
/// holds for references to the system too.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{R}` with one increment a process has been derived for `{Self}`",
    label = "this rule is not in the attribute of the `impl` block, or takes the increments of stages",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`"
)]
pub trait Variational<R>:
    System
    + Is<
        R,
        Type: Rule<
            Self::Itself,
            Increments = IncrementsOf<Self>,
            Prepared = <Self as Variational<R>>::Prepared,
            Memory = <Self as Variational<R>>::Memory,
        >,
    >
{
    /// Values that depend on parameters and step size only.
    type Prepared: Clone;
    /// The numbers that a trajectory carries from step to step.
    type Memory: Memory;
}

impl<S, R> Variational<R> for S
where
    S: System,
    R: Rule<S::Itself, Increments = IncrementsOf<S>>,
{
    type Prepared = R::Prepared;
    type Memory = R::Memory;
}

/// A system with a step of the rule `R` that gives the impulses of its constraints: every derived
/// rule, and no composition.
pub trait ConstraintImpulses<R>: Is<R, Type: TellsImpulses> {}

impl<S, R: TellsImpulses> ConstraintImpulses<R> for S {}

/// Names the type `R` as an associated type. A bound by the trait implies the bounds of associated
/// types in its list of supertraits, but not the bounds in a `where` clause.
#[doc(hidden)]
pub trait Is<R>: Same<R, Type = R> {}

impl<S, R> Is<R> for S {}

#[doc(hidden)]
pub trait Same<R> {
    /// The type `R`.
    type Type;
}

impl<S, R> Same<R> for S {
    type Type = R;
}

//! Rules: a step of a system as a walk over steps of derived rules.
//!
//! | file | part |
//! | --- | --- |
//! | `rules.rs` | the rules that the macro derives, of one substep each |
//! | `composed.rs` | [`Composed`]: substeps of one symmetric rule |
//! | `split.rs` | [`Split`]: alternating substeps of the initial-point and the endpoint rule |
//! | `coefficients.rs` | fractions of the step in compositions and splittings, with sources |
//! | `sequence.rs` | code shared by compositions and splittings |
//! | `shears.rs` | the step of a scene: a list of kicks and drifts |
//! | `variational.rs` | a rule as a bound of the system |
//!
//! A rule determines the substeps, and a [`Mode`] the operation in each substep. The modes are in
//! `integrator/`. Rules and modes do not know one another, so a new rule has all modes, and a new
//! mode all rules.

mod coefficients;
mod composed;
mod rules;
mod sequence;
mod shears;
mod split;
mod variational;

pub use coefficients::{BlanesMoan4, BlanesMoanRkn6, KahanLi8};
pub use composed::{Composed, Composition, Symmetric};
pub use rules::{
    Endpoint, Gauss, InitialPoint, Midpoint, StageNoise, StormerVerlet, Taylor2, Unstructured,
    Weak2,
};
pub use shears::{Shear, StepShear, shears};
pub use split::{Coefficients, QuadraticKineticEnergy, Separable, Split, Splitting};
pub use variational::{ConstraintImpulses, Variational};

use core::borrow::Borrow;
use core::marker::PhantomData;

use crate::solve::newton::Newton;
use crate::system::AnyIncrements;
use crate::system::equations::{Memory, StepEquations};
use crate::system::plan::Plan;
use crate::system::start::Tested;

/// A rule with a step for the system `S`: a rule that the attribute of the system lists, a
/// composition, or a splitting.
///
/// Code for all rules of a system asks for this trait, `R: Rule<Pendulum>`. Code for all systems
/// too asks for `S: Variational<R>`, or for `R: Rule<S::Itself>`, where
/// [`Itself`](crate::system::System::Itself) is the type behind a reference: an integrator makes
/// the same steps whether it owns the system or borrows it.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{Self}` has been derived for `{S}`",
    label = "this rule is not in the attribute of the `impl` block",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`; \
            the attribute names are `initial_point`, `endpoint`, `midpoint`, `stormer_verlet`, `gauss(2)` to `gauss(8)`, `taylor2`"
)]
pub trait Rule<S>: Sized {
    /// The increments of a step: one number for each process, or for each process and stage.
    type Increments: AnyIncrements + ?Sized;
    /// Values that depend on parameters and step size only.
    type Prepared: Clone;
    /// The numbers that a trajectory carries from step to step.
    type Memory: Memory;
    /// Number of increments of a process in a step: 1, or the number of stages of a rule with stage
    /// noise.
    const STAGES: usize;
    /// Number of steps of derived rules in a step.
    const SUBSTEPS: usize;
    /// The plan of the step.
    const PLAN: &'static Plan;
    /// True if each substep adds an increment to the state, so that its rounding errors can be
    /// compensated.
    const HAS_INCREMENTS: bool;

    /// Computes the values that depend on parameters and step size only.
    fn prepare(system: &S, h: f64) -> Self::Prepared;

    /// Walks over the substeps of a step of length `h`, with the values that
    /// [`prepare`](Self::prepare) returned for the same `h`.
    ///
    /// # Errors
    /// The error of the first substep that fails. `memory` is then empty.
    #[doc(hidden)]
    fn walk<M: Mode<S, Self::Increments>>(
        walker: Walker<'_, S, Self>,
        prepared: &Self::Prepared,
        memory: &mut Self::Memory,
        h: f64,
        dw: &M::Increments,
        mode: &mut M,
    ) -> Result<(), M::Failure>;
}

/// The operation in each substep of a step: the substep is made, in one of several ways, or
/// differentiated. `I` is the type of the increments of the rule.
#[doc(hidden)]
pub trait Mode<S, I: ?Sized> {
    /// The increments of a step: `I`, or the increments of all lanes, or a fraction.
    type Increments: ?Sized;
    /// The increments of a substep.
    type Part: Borrow<Self::Increments>;
    /// The reason why the walk ends before the last substep.
    type Failure;
    /// The data of the start of a sequence that its end needs.
    type Start;
    /// True if the walk goes from the last substep to the first.
    const IS_BACKWARD: bool = false;

    /// Makes a substep of length `h`.
    ///
    /// # Errors
    /// The failure of the substep.
    fn substep<R>(
        &mut self,
        walker: Walker<'_, S, R>,
        prepared: &Tested<S::Prepared>,
        memory: &mut S::Memory,
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), Self::Failure>
    where
        S: StepEquations<R, Increments = I>;

    /// Makes the shears of a substep of length `h` of a scene, which has no equations to solve.
    ///
    /// # Errors
    /// The failure of the substep.
    fn shears(
        &mut self,
        shears: &[Shear],
        h: f64,
        dw: &Self::Increments,
    ) -> Result<(), Self::Failure> {
        let _ = (shears, h, dw);
        unreachable!("a mode for systems of fixed sizes walks over steps of equations")
    }

    /// Begins a sequence of substeps.
    fn begin(&mut self) -> Self::Start;

    /// Ends a sequence of substeps, whose lengths add up to `h`. It is not called if a substep
    /// fails.
    fn end(&mut self, start: Self::Start, h: f64);

    /// Returns the increments of a substep, which is this fraction of a step.
    fn part(dw: &Self::Increments, part: f64) -> Self::Part;
}

/// A system with the rule that makes its steps, and the options of Newton's method.
#[doc(hidden)]
#[derive(Debug)]
pub struct Walker<'a, S, R> {
    /// The system, behind all references.
    pub system: &'a S,
    pub(crate) newton: &'a Newton,
    rule: PhantomData<R>,
}

impl<S, R> Clone for Walker<'_, S, R> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<S, R> Copy for Walker<'_, S, R> {}

impl<'a, S, R> Walker<'a, S, R> {
    /// Returns a walker over steps of a system.
    #[inline(always)]
    pub fn new(system: &'a S, newton: &'a Newton) -> Self {
        Self {
            system,
            newton,
            rule: PhantomData,
        }
    }

    /// Returns the same walker with the rule of a substep.
    #[inline(always)]
    fn by<T>(self) -> Walker<'a, S, T> {
        Walker::new(self.system, self.newton)
    }
}

/// A rule whose step gives the impulses of constraints: every derived rule, and no composition.
#[diagnostic::on_unimplemented(
    message = "the step of the rule `{Self}` tells no forces of constraints",
    label = "a composition has forces in each of its substeps",
    note = "ask an integrator with one of the rules of the attribute"
)]
#[doc(hidden)]
pub trait TellsImpulses {}

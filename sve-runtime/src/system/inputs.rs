//! Systems with inputs: values that are held over a step and given to it, like increments.
//!
//! The macro derives the steps of a system whose functions have the argument `u` for a type that
//! holds the values beside the system. So all that a system has, a system with held inputs has too,
//! and the inputs are parameters of it.

use super::{AnySystem, Dimensions, Kind, System};
use crate::phase::configuration::FixedSize;

/// A system whose functions have the argument `u`; `#[variational]` implements this trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no inputs",
    note = "a system has inputs if the last argument of a function of its block is called `u`, as in `fn lagrangian(&self, q: f64, v: f64, u: f64) -> f64`; without them, leave `inputs` and the `u` of the step out"
)]
pub trait WithInputs: AnySystem<Kind = Inputs, Configuration: FixedSize> {
    /// The type of `u`.
    type Input;
    /// The numbers in `u`, `[f64; K]`.
    type Numbers: AsRef<[f64]>;
    /// The sizes of the system.
    type Sizes: Dimensions<Configuration = <Self as AnySystem>::Configuration>;
    /// The system while its inputs are held.
    type Held<'a>: System<Dims = Self::Sizes, Itself = Self::Held<'a>>
    where
        Self: 'a;
    /// Returns the numbers in `u`.
    fn numbers(u: &Self::Input) -> Self::Numbers;
    /// Returns the system while the inputs have these values.
    fn held(&self, u: &Self::Input) -> Self::Held<'_>;
}

/// The kind of systems with inputs, whose steps need their values.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct Inputs;

impl Kind for Inputs {
    type Cache = ();
}

#[diagnostic::do_not_recommend]
impl<'b, S: WithInputs> WithInputs for &'b S
where
    &'b S: AnySystem<Kind = Inputs, Configuration = S::Configuration>,
{
    type Input = S::Input;
    type Numbers = S::Numbers;
    type Sizes = S::Sizes;
    type Held<'a>
        = S::Held<'a>
    where
        Self: 'a;

    fn numbers(u: &S::Input) -> S::Numbers {
        S::numbers(u)
    }

    fn held(&self, u: &S::Input) -> S::Held<'_> {
        (**self).held(u)
    }
}

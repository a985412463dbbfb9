//! The members that all systems have, whether their sizes are known when the program is compiled or
//! when it runs.

use super::{Dimensions, System};
use crate::phase::configuration::Configuration;

/// A system of any size: a [`System`], whose sizes are known when the program is compiled, or a
/// scene, a system whose `q` is a slice, so that its length is the length of the state, or a system
/// with inputs, which steps while their values are held.
///
/// Implemented for every [`System`], and by `#[variational(…)]` for scenes and systems with inputs.
/// Integrators and trajectories ask for this trait.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a mechanical system",
    note = "put `#[variational(midpoint)]` on the `impl` block that holds its `lagrangian`"
)]
pub trait AnySystem {
    /// The configuration of the system, the type of `q` in its state.
    type Configuration: Configuration;
    /// The system for which steps are derived: for a system its own type, for a reference the type
    /// behind it.
    type Target: AnySystem<
            Configuration = Self::Configuration,
            Target = Self::Target,
            Kind = Self::Kind,
            StateLanes = Self::StateLanes,
        >;
    /// The type for which rules are derived: the target, or for a system with inputs the type that
    /// holds their values.
    type Stepped;
    #[doc(hidden)]
    /// The kind of the system, which determines how an integrator makes its steps.
    type Kind: Kind;
    #[doc(hidden)]
    /// A state in each lane; `()` for a scene.
    type StateLanes: Clone;
    /// The names of the numbers of a state and of the parameters.
    const NAMES: Names = <Self::Target as AnySystem>::NAMES;
    #[doc(hidden)]
    /// A hash of the formulas of L, the noises and the force.
    const FORMULAS_HASH: u64 = <Self::Target as AnySystem>::FORMULAS_HASH;
    /// Returns the system, behind all references.
    fn target(&self) -> &Self::Target;
    /// Visits the values of the parameters.
    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.target().visit_parameters(visit);
    }
}

/// The names of the numbers of a state and of the parameters of a system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Names {
    /// The parameters; empty for a scene, whose fields have any length.
    pub parameters: &'static [&'static str],
    /// The coordinates that a state stores; for a scene the coordinates of one site.
    pub coordinates: &'static [&'static str],
    /// The momenta, in the same form.
    pub momenta: &'static [&'static str],
}

/// A kind of systems: systems of fixed sizes, scenes, or systems with inputs.
#[doc(hidden)]
pub trait Kind {
    /// The data that an integrator keeps between steps: tables and work vectors, which a step
    /// computes again if they are not there.
    type Cache: Clone + Default + Send + Sync;
}

/// The kind of systems whose sizes are known when the program is compiled.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct FixedSizes;

impl Kind for FixedSizes {
    type Cache = ();
}

#[diagnostic::do_not_recommend]
impl<S: System> AnySystem for S {
    type Configuration = <S::Dims as Dimensions>::Configuration;
    type Target = S::Itself;
    type Stepped = S::Itself;
    type Kind = FixedSizes;
    type StateLanes = <S::Dims as Dimensions>::StateLanes;
    const NAMES: Names = Names {
        parameters: S::PARAMETERS,
        coordinates: S::COORDINATES,
        momenta: S::MOMENTA,
    };
    const FORMULAS_HASH: u64 = S::FORMULAS;

    #[inline(always)]
    fn target(&self) -> &S::Itself {
        self.itself()
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.parameters(visit);
    }
}

//! The interface for code for any system: the trait that `#[variational]` implements, and the types
//! that belong to a system.
//!
//! A function for all systems asks for `S: System`, or for `I: Method` with the system `I::System`,
//! and calls the state [`StateOf<S>`](StateOf). One for systems with given sizes, such as a plane
//! problem with one noise, asks for `S: System<Dims = Dims<2, 1>>`:
//!
//! ```
//! use sve_runtime::prelude::*;
//! use sve_runtime::system::{Dims, System};
//!
//! /// Returns ∂L/∂q at a state, and so the force of a potential.
//! fn pull<S: System<Dims = Dims<2, 0>>>(system: &S, state: &State<[f64; 2]>) -> Result<[f64; 2], StepError> {
//!     let v = system.velocity(state)?;
//!     Ok(system.lagrangian_jet(state.t, &state.q, &v).dq)
//! }
//!
//! struct Springs;
//!
//! #[variational(midpoint)]
//! impl Springs {
//!     fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
//!         0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (q[0] * q[0] + 4.0 * q[1] * q[1])
//!     }
//! }
//! assert_eq!(pull(&Springs, &State::new([1.0, 1.0], [0.0, 0.0])).unwrap(), [-1.0, -4.0]);
//! ```
//!
//! [`AnySystem`] has what all systems have, also those whose `q` is a slice. Integrators and
//! trajectories ask for it; the rest of the library asks for [`System`].
//!
//! Everything that depends on the number of coordinates goes through one associated type,
//! [`System::Dims`], so that `Integrator<S, R>` needs no constants in its type. The rest of the
//! folder is the interface of generated code, in `__private`.

pub(crate) mod aliases;
pub(crate) mod any;
pub(crate) mod equations;
pub(crate) mod euler;
pub(crate) mod inputs;
pub(crate) mod jets;
pub(crate) mod linearisation;
pub(crate) mod plan;
pub(crate) mod sizes;
pub(crate) mod start;

pub use aliases::{IncrementsOf, StateOf};
pub use any::{AnySystem, Names};
pub use inputs::WithInputs;
pub use jets::{ConstraintJet, CoordinateRole, ForceJet, LagrangianJet, NoiseJet};
pub use sizes::Dims;

pub(crate) use aliases::{
    ConfigurationOf, DualStateOf, FlatOf, FlatStateOf, IncrementLanesOf, MomentumOf, StateLanesOf,
    TangentLanesOf, VectorOf,
};
pub(crate) use any::{FixedSizes, Kind};
pub(crate) use sizes::{AnyIncrements, Dimensions, Increments};

use crate::lanes::Lane;
use crate::system::euler::EulerIncrement;

/// A mechanical system: the derivatives of its Lagrangian, of its noise Hamiltonians and of its
/// force.
///
/// Implemented by `#[variational(…)]`. [`Mechanics`](crate::Mechanics) has the functions for users.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a mechanical system",
    note = "put `#[variational(midpoint)]` on the `impl` block that holds its `lagrangian`",
    note = "a system with inputs, an argument `u`, steps by `step_with(&mut state, h, &dw, &u)` and has trajectories with `.inputs(|step, state| …)`; `holding(&u)` has everything else",
    note = "a system whose `q` is a slice has integrators with single steps and trajectories, so far"
)]
pub trait System:
    AnySystem<
        Configuration = <<Self as System>::Dims as Dimensions>::Configuration,
        Target = <Self as System>::Itself,
        Stepped = <Self as System>::Itself,
        Kind = FixedSizes,
        StateLanes = <<Self as System>::Dims as Dimensions>::StateLanes,
    >
{
    /// The sizes and the configuration of the system, `Dims<N, M, Q>`.
    type Dims: Dimensions;
    /// The system for which steps are derived: for a system its own type, for a reference the type
    /// behind it.
    type Itself: System<Dims = Self::Dims, Itself = Self::Itself>;
    /// Returns the system, behind all references.
    fn itself(&self) -> &Self::Itself;
    /// True if `∂L/∂v` is affine in `v`, so that one linear solve inverts the Legendre transform.
    const AFFINE_MOMENTUM: bool;
    /// The role of each coordinate, if L does not determine every velocity; empty for a regular L.
    const ROLES: &'static [CoordinateRole] = &[];
    /// True if the system has a force.
    const FORCED: bool = false;
    /// True if a noise is a force.
    const NOISE_FORCED: bool = false;
    /// True if a noise is a force that depends on velocities.
    const NOISE_READS_VELOCITY: bool = false;
    /// The number of inputs, which are the first parameters.
    const INPUTS: usize = 0;
    /// The names of the parameters in the source: `m`, `l[0]`, `body.mass`.
    const PARAMETERS: &'static [&'static str] = &[];
    /// The names in L of the coordinates that a state stores: `q`, `q[0]`, `q.x`, or `x` and `y`
    /// after `let [x, y] = q`. A rotation has the components of its quaternion, `r.w` to `r.k`.
    const COORDINATES: &'static [&'static str] = &[];
    /// The names of the momenta, in the same form: `p`, `p[0]`, `p.x`, `p_x`, `pi.x`.
    const MOMENTA: &'static [&'static str] = &[];
    /// The names of the functions of the constraints: `rod`, `rods[0]`.
    const CONSTRAINTS: &'static [&'static str] = &[];
    #[doc(hidden)]
    /// A hash of the formulas of L, the noises and the force, which identifies the system of shards
    /// and checkpoints of ensembles.
    const FORMULAS: u64 = 0;
    /// Visits the values of the parameters, in the order of [`PARAMETERS`](Self::PARAMETERS).
    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        let _ = visit;
    }
    #[doc(hidden)]
    /// Numbers for [`euler_increment`](Self::euler_increment) that depend on the parameters and the
    /// step size alone.
    type EulerNumbers: Copy + core::fmt::Debug;
    #[doc(hidden)]
    /// True if [`euler_increment`](Self::euler_increment) is implemented for this system.
    const HAS_EULER_INCREMENT: bool = false;
    /// Largest number of stages of a method that is stepped in lanes; 0 if
    /// [`euler_increment_in_lane`](Self::euler_increment_in_lane) is not implemented.
    #[doc(hidden)]
    const EULER_STAGES_IN_LANES: usize = 0;
    #[doc(hidden)]
    /// Returns the numbers for [`euler_increment`](Self::euler_increment) in steps of length `h`;
    /// `None` if a constant mass matrix is singular.
    #[inline]
    fn euler_numbers(&self, h: f64) -> Option<Self::EulerNumbers> {
        let _ = h;
        None
    }
    #[doc(hidden)]
    /// Returns the increment of Euler's method over a step from a state. Where the increment has no
    /// value, the result is not finite, or `None`.
    #[inline]
    fn euler_increment(
        &self,
        prepared: &Self::EulerNumbers,
        t: f64,
        q: &FlatOf<Self>,
        p: &VectorOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
    ) -> Option<EulerIncrement<VectorOf<Self>>> {
        let _ = (prepared, t, q, p, h, dw);
        None
    }
    /// Returns the same increment in a loop over lanes, by functions without branches.
    #[doc(hidden)]
    #[inline(always)]
    fn euler_increment_in_lane(
        &self,
        prepared: &Self::EulerNumbers,
        t: f64,
        q: &FlatOf<Self>,
        p: &VectorOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
    ) -> Option<EulerIncrement<VectorOf<Self>>> {
        let _ = (prepared, t, q, p, h, dw);
        None
    }
    /// Returns `L` and its first and second derivatives.
    fn lagrangian_jet(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::LagrangianJet;
    /// Returns every noise Hamiltonian (`−γᵢ` or `H₁ⱼ`, in the order of `dw`) with its first and
    /// second derivatives; zero for noises that are forces.
    fn noise_jets(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        p: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::NoiseJets;
    /// Returns the force F with its first derivatives; zero for a system without a force.
    #[inline]
    fn force_jet(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::ForceJet {
        let _ = (t, q, v);
        <Self::Dims as Dimensions>::NO_FORCE
    }
    /// Returns the force of every noise with its first derivatives, in the order of `dw`; zero for
    /// noise Hamiltonians.
    #[inline]
    fn noise_force_jets(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::NoiseForceJets {
        let _ = (t, q, v);
        <Self::Dims as Dimensions>::NO_NOISE_FORCES
    }
    /// Visits the constraints with their first derivatives, in the order of
    /// [`CONSTRAINTS`](Self::CONSTRAINTS).
    fn constraint_jets(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        visit: &mut dyn FnMut(<Self::Dims as Dimensions>::ConstraintJet),
    ) {
        let _ = (t, q, visit);
    }
    /// Writes the energy of each lane to `energies`. Where a loop without branches cannot compute
    /// it, writes a number that is not finite, as the default implementation does for every lane.
    #[doc(hidden)]
    #[inline(always)]
    fn energy_lanes(&self, states: &StateLanesOf<Self>, energies: &mut Lane) {
        let _ = states;
        energies.fill(f64::NAN);
    }
    /// Visits the second time derivatives of the constraints in motion with velocity `v` and
    /// without acceleration, in the order of [`CONSTRAINTS`](Self::CONSTRAINTS).
    fn constraint_curvatures(
        &self,
        t: f64,
        q: &FlatOf<Self>,
        v: &VectorOf<Self>,
        visit: &mut dyn FnMut(f64),
    ) {
        let _ = (t, q, v, visit);
    }
}

#[diagnostic::do_not_recommend]
impl<S: System> System for &S {
    type Dims = S::Dims;
    type Itself = S::Itself;
    const AFFINE_MOMENTUM: bool = S::AFFINE_MOMENTUM;
    const ROLES: &'static [CoordinateRole] = S::ROLES;
    const FORCED: bool = S::FORCED;
    const NOISE_FORCED: bool = S::NOISE_FORCED;
    const NOISE_READS_VELOCITY: bool = S::NOISE_READS_VELOCITY;
    const INPUTS: usize = S::INPUTS;
    const PARAMETERS: &'static [&'static str] = S::PARAMETERS;
    const COORDINATES: &'static [&'static str] = S::COORDINATES;
    const MOMENTA: &'static [&'static str] = S::MOMENTA;
    const CONSTRAINTS: &'static [&'static str] = S::CONSTRAINTS;
    const FORMULAS: u64 = S::FORMULAS;
    type EulerNumbers = S::EulerNumbers;
    const HAS_EULER_INCREMENT: bool = S::HAS_EULER_INCREMENT;
    const EULER_STAGES_IN_LANES: usize = S::EULER_STAGES_IN_LANES;

    #[inline(always)]
    fn itself(&self) -> &S::Itself {
        (**self).itself()
    }

    #[inline]
    fn euler_numbers(&self, h: f64) -> Option<S::EulerNumbers> {
        (**self).euler_numbers(h)
    }

    #[inline(always)]
    fn euler_increment(
        &self,
        prepared: &S::EulerNumbers,
        t: f64,
        q: &FlatOf<S>,
        p: &VectorOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Option<EulerIncrement<VectorOf<S>>> {
        (**self).euler_increment(prepared, t, q, p, h, dw)
    }

    #[inline(always)]
    fn euler_increment_in_lane(
        &self,
        prepared: &S::EulerNumbers,
        t: f64,
        q: &FlatOf<S>,
        p: &VectorOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
    ) -> Option<EulerIncrement<VectorOf<S>>> {
        (**self).euler_increment_in_lane(prepared, t, q, p, h, dw)
    }

    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        (**self).parameters(visit);
    }

    #[inline]
    fn lagrangian_jet(
        &self,
        t: f64,
        q: &FlatOf<S>,
        v: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::LagrangianJet {
        (**self).lagrangian_jet(t, q, v)
    }

    #[inline]
    fn noise_jets(
        &self,
        t: f64,
        q: &FlatOf<S>,
        p: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::NoiseJets {
        (**self).noise_jets(t, q, p)
    }

    #[inline]
    fn force_jet(
        &self,
        t: f64,
        q: &FlatOf<S>,
        v: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::ForceJet {
        (**self).force_jet(t, q, v)
    }

    #[inline]
    fn noise_force_jets(
        &self,
        t: f64,
        q: &FlatOf<S>,
        v: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::NoiseForceJets {
        (**self).noise_force_jets(t, q, v)
    }

    fn constraint_jets(
        &self,
        t: f64,
        q: &FlatOf<S>,
        visit: &mut dyn FnMut(<S::Dims as Dimensions>::ConstraintJet),
    ) {
        (**self).constraint_jets(t, q, visit);
    }

    #[inline(always)]
    fn energy_lanes(&self, states: &StateLanesOf<S>, energies: &mut Lane) {
        (**self).energy_lanes(states, energies);
    }

    fn constraint_curvatures(
        &self,
        t: f64,
        q: &FlatOf<S>,
        v: &VectorOf<S>,
        visit: &mut dyn FnMut(f64),
    ) {
        (**self).constraint_curvatures(t, q, v, visit);
    }
}

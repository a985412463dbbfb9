//! The traits that `#[variational]` implements: the interface between generated code and the runtime.
//!
//! Everything that depends on the number of coordinates goes through one associated type,
//! [`System::Dims`], so that `Integrator<S, R>` needs no constants in its type.

use core::marker::PhantomData;

pub use crate::jets::{ForceJet, LagrangianJet, NoiseJet};

use crate::configuration::{Configuration, Coordinates, FixedSize};
use crate::lanes::{ALL, Lane, Mask, StateLanes};
use crate::linearisation::Linearisation;
use crate::plan::Plan;
use crate::solve::SolveError;
use crate::solve::newton::{BlockSolver, Newton};
use crate::state::State;

/// The fixed sizes of a system, `N` degrees of freedom and `M` Wiener processes, and its type of configurations.
#[derive(Clone, Copy, Debug)]
pub struct Dims<const N: usize, const M: usize, Q = [f64; N]>(PhantomData<Q>);

/// The types that belong to the sizes and the configuration of a system. Implemented by [`Dims`] alone.
///
/// Generated code computes with rows of `N` coordinates; the runtime converts them from and to the configuration.
pub trait Dimensions {
    /// The configuration, `Q`.
    type Configuration: FixedSize;
    /// A row of coordinates, `[f64; N]`.
    type Vector: Copy + core::fmt::Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// The increments of the Wiener processes over a step, `[f64; M]`.
    type Increments: Copy + core::fmt::Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// The state in coordinates, [`State<[f64; N]>`](State).
    type FlatState: Clone + core::fmt::Debug;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// A state in each lane, [`StateLanes<N>`](StateLanes).
    type StateLanes: Clone + core::fmt::Debug;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// The increments of each lane, `[Lane; M]`.
    type IncrementLanes: Copy + core::fmt::Debug + AsRef<[Lane]> + AsMut<[Lane]>;
    /// [`LagrangianJet<N>`](LagrangianJet).
    type LagrangianJet;
    /// `[NoiseJet<N>; M]`.
    type NoiseJets;
    /// [`ForceJet<N>`](ForceJet).
    type ForceJet;
    /// All increments zero.
    const NO_INCREMENTS: Self::Increments;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// All increments of all lanes zero.
    const NO_INCREMENT_LANES: Self::IncrementLanes;
    /// No force.
    const NO_FORCE: Self::ForceJet;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// The same state in each lane.
    fn splat(state: &State<Self::Configuration>) -> Self::StateLanes;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// The state of a lane.
    fn get(lanes: &Self::StateLanes, lane: usize) -> State<Self::Configuration>;
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// Replaces the state of a lane.
    fn set(lanes: &mut Self::StateLanes, lane: usize, state: &State<Self::Configuration>);
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    /// The times of the lanes.
    fn times(lanes: &mut Self::StateLanes) -> &mut Lane;
}

impl<const N: usize, const M: usize, Q: Coordinates<N>> Dimensions for Dims<N, M, Q> {
    type Configuration = Q;
    type Vector = [f64; N];
    type Increments = [f64; M];
    type FlatState = State<[f64; N]>;
    type StateLanes = StateLanes<N>;
    type IncrementLanes = [Lane; M];
    type LagrangianJet = LagrangianJet<N>;
    type NoiseJets = [NoiseJet<N>; M];
    type ForceJet = ForceJet<N>;
    const NO_FORCE: ForceJet<N> = ForceJet {
        value: [0.0; N],
        dq: [[0.0; N]; N],
        dv: [[0.0; N]; N],
        dt: [0.0; N],
    };
    const NO_INCREMENTS: [f64; M] = [0.0; M];
    const NO_INCREMENT_LANES: [Lane; M] = [[0.0; crate::lanes::LANES]; M];
    fn splat(state: &State<Q>) -> StateLanes<N> {
        StateLanes::splat(&state.to_coordinates())
    }
    #[inline(always)]
    fn get(lanes: &StateLanes<N>, lane: usize) -> State<Q> {
        State::from_coordinates(&lanes.get(lane))
    }
    #[inline(always)]
    fn set(lanes: &mut StateLanes<N>, lane: usize, state: &State<Q>) {
        lanes.set(lane, &state.to_coordinates());
    }
    #[inline(always)]
    fn times(lanes: &mut StateLanes<N>) -> &mut Lane {
        &mut lanes.t
    }
}

/// `[f64; N]` of a system.
pub type VectorOf<S> = <<S as System>::Dims as Dimensions>::Vector;
/// `[f64; M]` of a system.
pub type IncrementsOf<S> = <<S as System>::Dims as Dimensions>::Increments;
/// The configuration of a system, the type of `q` in its state.
pub type ConfigurationOf<S> = <<S as System>::Dims as Dimensions>::Configuration;
/// The momentum of a system, the type of `p` in its state; velocities have it too.
pub type MomentumOf<S> = <ConfigurationOf<S> as Configuration>::Momentum;
/// The state of a system.
pub type StateOf<S> = State<ConfigurationOf<S>>;
/// The state of a system in coordinates, `State<[f64; N]>`.
pub type FlatStateOf<S> = <<S as System>::Dims as Dimensions>::FlatState;
/// `StateLanes<N>` of a system.
pub type StateLanesOf<S> = <<S as System>::Dims as Dimensions>::StateLanes;
/// `[Lane; M]` of a system.
pub type IncrementLanesOf<S> = <<S as System>::Dims as Dimensions>::IncrementLanes;

/// A mechanical system: the derivatives of its Lagrangian, of its noise Hamiltonians and of its force.
///
/// Implemented by `#[variational(…)]`; what users call is in [`Mechanics`](crate::Mechanics).
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a mechanical system",
    note = "put `#[variational(midpoint)]` on the `impl` block that holds its `lagrangian`"
)]
pub trait System {
    /// Its sizes and its configuration, `Dims<N, M, Q>`.
    type Dims: Dimensions;
    /// Whether `∂L/∂v` is affine in `v`, so that the Legendre transform is inverted by one linear solve.
    const AFFINE_MOMENTUM: bool;
    /// Whether there is a force.
    const FORCED: bool = false;
    /// The parameters, as the source has them: `m`, `l[0]`, `body.mass`.
    const PARAMETERS: &'static [&'static str] = &[];
    /// A hash of the formulas of L, the noises and the force, by which shards and checkpoints of ensembles are recognised.
    const FORMULAS: u64 = 0;
    /// Visits the values of the parameters, in the order of [`PARAMETERS`](Self::PARAMETERS).
    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        let _ = visit;
    }
    /// `L` and its first and second derivatives.
    fn lagrangian_jet(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::LagrangianJet;
    /// Every noise Hamiltonian (`−γᵢ` or `H₁ⱼ`, in the order of `dw`) with its first and second derivatives.
    fn noise_jets(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        p: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::NoiseJets;
    /// The force F with its first derivatives; zero where there is none.
    #[inline]
    fn force_jet(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::ForceJet {
        let _ = (t, q, v);
        <Self::Dims as Dimensions>::NO_FORCE
    }
}

/// What the increment of a step is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Returns {
    /// `q₁ − q₀` and `p₁ − p₀`.
    Increment,
    /// `q₁` and `p₁`: a matrix that differs from step to step times the state, and an offset. Adding an increment would only lengthen
    /// the chain of operations.
    State,
    /// `q₁ − q₀` and `p₁ − p₀` as a matrix, the same in all steps, times the state, and an offset.
    MatrixTimesState,
}

impl Returns {
    /// Whether the state at the end is returned, and not what is added to the one at the start.
    pub(crate) const fn is_state(self) -> bool {
        matches!(self, Self::State)
    }
}

/// A system for which the rule `R` has been derived.
#[diagnostic::on_unimplemented(
    message = "no step of the rule `{R}` has been derived for `{Self}`",
    label = "this rule is not in the attribute of the `impl` block",
    note = "list the rule in the attribute, for example `#[variational(midpoint, endpoint)]`; \
            the attribute names are `initial_point`, `endpoint`, `midpoint`, `stormer_verlet`, `taylor2`"
)]
pub trait Variational<R>: System {
    /// Values that depend on parameters and step size only.
    type Prepared: Clone;
    /// The unknowns of all blocks, `[f64; K]`.
    type Unknowns: Copy + AsRef<[f64]> + AsMut<[f64]>;
    /// The conditions of the domain: where the functions in L and in the noises are defined, as text.
    const DOMAIN: &'static [&'static str] = &[];
    /// The plan of the step.
    const PLAN: &'static Plan;
    /// What [`increment`](Self::increment) returns.
    const RETURNS: Returns;
    /// Computes the values that depend on parameters and step size only.
    fn prepare(&self, h: f64) -> Self::Prepared;
    /// Returns the unknowns of all blocks in the limit of no noise and h → 0, from velocity and acceleration at the start of the
    /// step.
    fn start(
        &self,
        state: &FlatStateOf<Self>,
        velocity: &VectorOf<Self>,
        acceleration: &VectorOf<Self>,
    ) -> Self::Unknowns;
    /// Solves one step. Returns `(q₁ − q₀, p₁ − p₀)` or `(q₁, p₁)`, see [`RETURNS`](Self::RETURNS), and the unknowns of all blocks.
    ///
    /// # Errors
    /// A [`SolveError`] if an implicit equation of the step cannot be solved.
    fn increment(
        &self,
        prepared: &Self::Prepared,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
        newton: &BlockSolver<'_>,
    ) -> Result<StepOf<Self, R>, SolveError>;
    /// Advances every lane on the fast path and writes the result to `next`. Returns the mask of lanes that the fast path could not solve; their
    /// states are copied unchanged, and the caller steps them with [`increment`](Self::increment). Times in `next` are not written.
    #[cfg_attr(not(feature = "ensemble"), doc(hidden))]
    #[inline(always)]
    fn increment_lanes(
        &self,
        prepared: &Self::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self>,
        newton: &Newton,
    ) -> Mask {
        let _ = (prepared, h, dw, newton);
        next.clone_from(states);
        ALL
    }
    /// Linearises the step's equations and results around a solved step.
    fn linearise(
        &self,
        state: &FlatStateOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
        unknowns: &Self::Unknowns,
    ) -> Linearisation;
}

/// The result of [`Variational::increment`].
pub type StepOf<S, R> = (VectorOf<S>, VectorOf<S>, <S as Variational<R>>::Unknowns);

/// A rule that has been derived for the system `S`.
///
/// [`Integrator::new`](crate::Integrator::new) requires this trait and not `S: Variational<R>`: with a single derived rule the compiler would
/// expect that rule, and report a type mismatch for any other one.
pub trait DerivedFor<S> {}

impl<S: Variational<R>, R> DerivedFor<S> for R {}

#[diagnostic::do_not_recommend]
impl<S: System> System for &S {
    type Dims = S::Dims;
    const AFFINE_MOMENTUM: bool = S::AFFINE_MOMENTUM;
    const FORCED: bool = S::FORCED;
    const PARAMETERS: &'static [&'static str] = S::PARAMETERS;
    const FORMULAS: u64 = S::FORMULAS;

    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        (**self).parameters(visit);
    }

    #[inline]
    fn lagrangian_jet(
        &self,
        t: f64,
        q: &VectorOf<S>,
        v: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::LagrangianJet {
        (**self).lagrangian_jet(t, q, v)
    }

    #[inline]
    fn noise_jets(
        &self,
        t: f64,
        q: &VectorOf<S>,
        p: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::NoiseJets {
        (**self).noise_jets(t, q, p)
    }

    #[inline]
    fn force_jet(
        &self,
        t: f64,
        q: &VectorOf<S>,
        v: &VectorOf<S>,
    ) -> <S::Dims as Dimensions>::ForceJet {
        (**self).force_jet(t, q, v)
    }
}

#[diagnostic::do_not_recommend]
impl<S: Variational<R>, R> Variational<R> for &S {
    type Prepared = S::Prepared;
    type Unknowns = S::Unknowns;
    const PLAN: &'static Plan = S::PLAN;
    const RETURNS: Returns = S::RETURNS;
    const DOMAIN: &'static [&'static str] = S::DOMAIN;

    #[inline]
    fn prepare(&self, h: f64) -> S::Prepared {
        (**self).prepare(h)
    }

    fn start(
        &self,
        state: &FlatStateOf<S>,
        velocity: &VectorOf<S>,
        acceleration: &VectorOf<S>,
    ) -> S::Unknowns {
        (**self).start(state, velocity, acceleration)
    }

    #[inline]
    fn increment(
        &self,
        prepared: &S::Prepared,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
        newton: &BlockSolver<'_>,
    ) -> Result<StepOf<S, R>, SolveError> {
        (**self).increment(prepared, state, h, dw, newton)
    }

    #[inline(always)]
    fn increment_lanes(
        &self,
        prepared: &S::Prepared,
        states: &StateLanesOf<S>,
        next: &mut StateLanesOf<S>,
        h: f64,
        dw: &IncrementLanesOf<S>,
        newton: &Newton,
    ) -> Mask {
        (**self).increment_lanes(prepared, states, next, h, dw, newton)
    }

    #[inline]
    fn linearise(
        &self,
        state: &FlatStateOf<S>,
        h: f64,
        dw: &IncrementsOf<S>,
        unknowns: &S::Unknowns,
    ) -> Linearisation {
        (**self).linearise(state, h, dw, unknowns)
    }
}

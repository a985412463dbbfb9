//! The fixed sizes of a system, and the types with these sizes.

use core::borrow::BorrowMut;
use core::fmt::Debug;
use core::marker::PhantomData;

use super::jets::{ConstraintJet, ForceJet, LagrangianJet, NoiseJet};
use crate::lanes::{LANES, Lane};
use crate::phase::Field;
use crate::phase::configuration::{Coordinates, FixedSize, FlatConfiguration};
use crate::phase::dual::{Dual, DualState};
use crate::phase::lanes::LaneStates;
use crate::phase::state::State;
use crate::phase::tangents::{FieldLanes, TangentLanes};

/// The fixed sizes of a system, `N` degrees of freedom and `M` Wiener processes, and its type of
/// configurations.
#[derive(Clone, Copy, Debug)]
pub struct Dims<const N: usize, const M: usize, Q = [f64; N]>(PhantomData<Q>);

/// The increments of the Wiener processes over a step, of any number: an array or a slice.
pub trait AnyIncrements:
    ToOwned<Owned: BorrowMut<Self> + AsRef<[f64]> + AsMut<[f64]>> + AsRef<[f64]> + AsMut<[f64]> + Debug
{
    /// The memory that a trajectory keeps for the increments of its steps.
    type Buffer: Clone + Debug + Default;
    /// The increments of each lane, `[Lane; M]`; empty for a slice, which has no steps in lanes.
    type Lanes: Copy + Debug + AsRef<[Lane]> + AsMut<[Lane]>;
    /// Returns increments for a source to fill. Takes the memory from `buffer`; if it is empty,
    /// `processes` gives the length of a slice.
    ///
    /// # Errors
    /// The error of `processes`.
    fn take<E>(
        buffer: &mut Self::Buffer,
        processes: impl FnOnce() -> Result<usize, E>,
    ) -> Result<Self::Owned, E>;
    /// Gives the memory of increments back.
    fn give(buffer: &mut Self::Buffer, increments: Self::Owned);
    /// Returns these increments times a factor.
    #[must_use]
    fn times(&self, factor: f64) -> Self::Owned;
}

impl<const M: usize> AnyIncrements for [f64; M] {
    type Buffer = ();
    type Lanes = [Lane; M];

    #[inline(always)]
    fn take<E>((): &mut (), _: impl FnOnce() -> Result<usize, E>) -> Result<Self, E> {
        Ok([0.0; M])
    }

    #[inline(always)]
    fn give((): &mut (), _: Self) {}

    #[inline]
    fn times(&self, factor: f64) -> Self {
        self.map(|w| factor * w)
    }
}

impl AnyIncrements for [f64] {
    type Buffer = Option<Vec<f64>>;
    type Lanes = [Lane; 0];

    fn take<E>(
        buffer: &mut Option<Vec<f64>>,
        processes: impl FnOnce() -> Result<usize, E>,
    ) -> Result<Vec<f64>, E> {
        match buffer.take() {
            Some(increments) => Ok(increments),
            None => Ok(vec![0.0; processes()?]),
        }
    }

    fn give(buffer: &mut Option<Vec<f64>>, increments: Vec<f64>) {
        *buffer = Some(increments);
    }

    fn times(&self, factor: f64) -> Vec<f64> {
        self.iter().map(|w| factor * w).collect()
    }
}

/// The increments of the Wiener processes over a step of a system of fixed sizes: an array.
pub trait Increments: AnyIncrements<Owned = Self, Buffer = ()> + Copy {
    /// The increments that are all zero.
    const NONE: Self;
    /// Increments of all lanes that are zero.
    const NO_LANES: Self::Lanes;
    /// Number of increments: of Wiener processes, or of processes and stages of a rule with stage
    /// noise.
    const COUNT: usize;
    /// Returns the increments of a lane.
    fn of_lane(lanes: &Self::Lanes, lane: usize) -> Self;
    /// Returns the increments of all lanes if there is a single increment.
    fn of_only(increments: &Lane) -> Option<&Self::Lanes>;
}

impl<const M: usize> Increments for [f64; M] {
    const NONE: Self = [0.0; M];
    const NO_LANES: [Lane; M] = [[0.0; LANES]; M];
    const COUNT: usize = M;

    #[inline(always)]
    fn of_lane(lanes: &[Lane; M], lane: usize) -> Self {
        lanes.map(|increments| increments[lane])
    }

    #[inline(always)]
    fn of_only(increments: &Lane) -> Option<&[Lane; M]> {
        core::slice::from_ref(increments).try_into().ok()
    }
}

/// The types that belong to the sizes and the configuration of a system. Only [`Dims`] implements
/// it.
///
/// Generated code computes with rows of `N` coordinates; the runtime converts them from and to the
/// configuration.
pub trait Dimensions {
    /// The configuration, `Q`.
    type Configuration: FixedSize;
    /// A row of coordinates, `[f64; N]`.
    type Vector: Copy + Debug + AsRef<[f64]> + AsMut<[f64]>;
    /// The increments of the Wiener processes over a step, `[f64; M]`.
    type Increments: Increments;
    /// The configuration in the form in which steps compute with it: `[f64; N]` in a vector space.
    type Flat: Copy + Debug;
    /// The state in this form: [`State<[f64; N]>`](State) in a vector space.
    type FlatState: Clone + Debug;
    /// A state in each lane: `StateLanes<N>` in a vector space.
    type StateLanes: Clone + Copy + Debug;
    /// A tangent vector in each lane.
    type TangentLanes: FieldLanes<Self::Vector>;
    /// [`LagrangianJet<N>`](LagrangianJet).
    type LagrangianJet;
    /// `[NoiseJet<N>; M]`.
    type NoiseJets;
    /// [`ForceJet<N>`](ForceJet).
    type ForceJet;
    /// `[ForceJet<N>; M]`.
    type NoiseForceJets;
    /// [`ConstraintJet<N>`](ConstraintJet).
    type ConstraintJet;
    /// A row of zeros.
    const ZERO: Self::Vector;
    /// A state in dual numbers, [`DualState<N>`](crate::DualState) in a vector space.
    type DualState<'a>;
    /// The force zero with its derivatives.
    const NO_FORCE: Self::ForceJet;
    /// No force of any noise.
    const NO_NOISE_FORCES: Self::NoiseForceJets;
    /// Returns the same state in each lane.
    fn splat(state: &State<Self::Configuration>) -> Self::StateLanes;
    /// Returns the state of a lane.
    fn get(lanes: &Self::StateLanes, lane: usize) -> State<Self::Configuration>;
    /// Replaces the state of a lane.
    fn set(lanes: &mut Self::StateLanes, lane: usize, state: &State<Self::Configuration>);
    /// Returns the times of the lanes.
    fn times(lanes: &mut Self::StateLanes) -> &mut Lane;
    /// Returns a state that varies along a direction; `parameter` returns the parameters.
    fn dual_state<'a>(
        state: &State<Self::Configuration>,
        direction: &Field<Self::Vector>,
        parameter: &'a dyn Fn(&str) -> Dual,
    ) -> Self::DualState<'a>;
}

impl<const N: usize, const M: usize, Q: Coordinates<N>> Dimensions for Dims<N, M, Q> {
    type Configuration = Q;
    type Vector = [f64; N];
    type Increments = [f64; M];
    type Flat = Q::Flat;
    type FlatState = State<Q::Flat>;
    type StateLanes = <Q::Flat as FlatConfiguration<N>>::Lanes;
    type TangentLanes = TangentLanes<N>;
    type LagrangianJet = LagrangianJet<N>;
    type NoiseJets = [NoiseJet<N>; M];
    type ForceJet = ForceJet<N>;
    type ConstraintJet = ConstraintJet<N>;
    const ZERO: [f64; N] = [0.0; N];
    type DualState<'a> = DualState<'a, N, Q::Dual>;
    type NoiseForceJets = [ForceJet<N>; M];
    const NO_FORCE: ForceJet<N> = ForceJet::NONE;
    const NO_NOISE_FORCES: [ForceJet<N>; M] = [ForceJet::NONE; M];
    fn splat(state: &State<Q>) -> Self::StateLanes {
        LaneStates::splat(&state.to_coordinates())
    }
    #[inline(always)]
    fn get(lanes: &Self::StateLanes, lane: usize) -> State<Q> {
        State::from_coordinates(&lanes.get(lane))
    }
    #[inline(always)]
    fn set(lanes: &mut Self::StateLanes, lane: usize, state: &State<Q>) {
        lanes.set(lane, &state.to_coordinates());
    }
    #[inline(always)]
    fn times(lanes: &mut Self::StateLanes) -> &mut Lane {
        lanes.times()
    }
    fn dual_state<'a>(
        state: &State<Q>,
        direction: &Field<[f64; N]>,
        parameter: &'a dyn Fn(&str) -> Dual,
    ) -> DualState<'a, N, Q::Dual> {
        DualState::along(state, direction, parameter)
    }
}

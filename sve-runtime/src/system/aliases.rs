//! Names of the types that belong to a system: short forms of the associated types of
//! [`Dimensions`].

use super::{AnyIncrements, AnySystem, Dimensions, System};
use crate::phase::configuration::Configuration;
use crate::phase::state::State;

/// The state of a system.
pub type StateOf<S> = State<ConfigurationOf<S>>;
/// The increments of the Wiener processes of a system over a step, `[f64; M]`.
pub type IncrementsOf<S> = <<S as System>::Dims as Dimensions>::Increments;
/// The type `[f64; N]` of a system.
pub type VectorOf<S> = <<S as System>::Dims as Dimensions>::Vector;
/// The configuration of a system, the type of `q` in its state.
pub type ConfigurationOf<S> = <S as AnySystem>::Configuration;
/// The momentum of a system, the type of `p` in its state and of velocities.
pub type MomentumOf<S> = <ConfigurationOf<S> as Configuration>::Momentum;
/// The configuration of a system as steps compute with it, `[f64; N]` in a vector space.
pub type FlatOf<S> = <<S as System>::Dims as Dimensions>::Flat;
/// The state of a system in coordinates, `State<[f64; N]>` in a vector space.
pub type FlatStateOf<S> = <<S as System>::Dims as Dimensions>::FlatState;
/// The type `StateLanes<N>` of a system.
pub type StateLanesOf<S> = <S as AnySystem>::StateLanes;
/// Increments in each lane, `[Lane; M]` for increments `[f64; M]`.
pub type IncrementLanesOf<D> = <D as AnyIncrements>::Lanes;
/// A state of a system in dual numbers: [`DualState<N>`](crate::DualState) in a vector space.
pub type DualStateOf<'a, S> = <<S as System>::Dims as Dimensions>::DualState<'a>;
/// A tangent vector of a system in each lane.
pub type TangentLanesOf<S> = <<S as System>::Dims as Dimensions>::TangentLanes;

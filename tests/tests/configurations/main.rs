//! A state of any type of configurations is stepped, recorded and stored with the bits of the state
//! in coordinates.

mod ensembles;
mod mechanics;
mod noises;
mod states;
mod steps;

use sve_models::configured::Configured;
use sve_models::models::Charges;
use sve_models::oracle::charges;
use sve_runtime::__private::{Field, VectorCoordinates};
use sve_runtime::prelude::*;

pub(crate) const H: f64 = 0.05;
pub(crate) const DW: [f64; 3] = [0.1, -0.2, 0.05];

/// Two charges with configurations of the type `Q`.
pub(crate) fn system<Q>() -> Configured<Charges, Q> {
    Configured::new(charges().0)
}

/// Where the charges start, in coordinates.
pub(crate) const START: State<[f64; 6]> = State::at(
    0.25,
    [0.7, 0.1, -0.2, -0.6, 0.2, 0.3],
    [0.1, 0.5, 0.2, -0.2, -0.4, -0.1],
);

pub(crate) fn state<Q: VectorCoordinates<N>, const N: usize>(flat: &State<[f64; N]>) -> State<Q> {
    State::at(
        flat.t,
        Q::from_coordinates(&flat.q),
        Q::from_components(&flat.p),
    )
}

pub(crate) fn flat<Q: VectorCoordinates<N>, const N: usize>(state: &State<Q>) -> State<[f64; N]> {
    State::at(state.t, state.q.coordinates(), Q::components(&state.p))
}

pub(crate) fn flat_field<V, const N: usize>(field: &Field<V>) -> Field<[f64; N]>
where
    V: VectorCoordinates<N, Momentum = V>,
{
    Field {
        q: field.q.coordinates(),
        p: field.p.coordinates(),
    }
}

/// Instantiates a function for every type of configurations with six coordinates.
macro_rules! every_type {
    ($function:ident) => {
        $function::<[f64; 6]>();
        $function::<SVector<f64, 6>>();
        $function::<[[f64; 3]; 2]>();
        $function::<[Vector3<f64>; 2]>();
        $function::<[[[f64; 1]; 3]; 2]>();
    };
}
pub(crate) use every_type;

/// The properties of a configuration of six coordinates that are tested here.
pub(crate) trait Six:
    VectorCoordinates<6, Momentum: VectorCoordinates<6, Momentum = Self::Momentum>>
{
}

impl<Q: VectorCoordinates<6, Momentum: VectorCoordinates<6, Momentum = Self::Momentum>>> Six for Q {}

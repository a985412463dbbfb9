//! Configurations in a vector space: rows `[f64; N]` and the vectors of nalgebra. An increment is
//! added to the coordinates.

use nalgebra::SVector;

use super::{Configuration, Coordinates, FixedSize, add, largest};
use crate::phase::dual::Dual;
use crate::phase::state::State;

/// A configuration in a vector space: an increment is added to its coordinates. Implemented for all
/// configurations without rotations.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has rotations, and this is only for systems without them",
    note = "rotations are for `Integrator::new(system, Midpoint)` and its compositions"
)]
pub trait VectorSpace: FixedSize {}

impl<const N: usize> VectorSpace for [f64; N] {}

impl<const N: usize> VectorSpace for SVector<f64, N> {}

impl<Q: VectorSpace, const B: usize> VectorSpace for [Q; B] {}

/// A configuration in a vector space of `N` dimensions. Implemented for every [`VectorSpace`].
#[diagnostic::on_unimplemented(
    message = "`{Self}` has rotations, and this is only for systems without them",
    note = "rotations are for `Integrator::new(system, Midpoint)` and its compositions"
)]
pub trait VectorCoordinates<const N: usize>: VectorSpace + Coordinates<N, Flat = [f64; N]> {}

impl<Q: VectorSpace + Coordinates<N, Flat = [f64; N]>, const N: usize> VectorCoordinates<N> for Q {}

impl<const N: usize> Configuration for [f64; N] {
    type Momentum = Self;

    fn degrees_of_freedom(&self) -> usize {
        N
    }

    fn stored_values(&self) -> usize {
        N
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        values.copy_from_slice(self);
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        self.copy_from_slice(values);
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        add(self, increment);
    }
}

impl<const N: usize> FixedSize for [f64; N] {
    const DEGREES_OF_FREEDOM: usize = N;
    const STORED_VALUES: usize = N;
    type FlatForm<Whole: FixedSize, const D: usize> = [f64; D];
    type DualPart = [Dual; N];

    fn dual_part(&self, along: &[f64]) -> [Dual; N] {
        core::array::from_fn(|i| Dual::varying(self[i], along[i]))
    }

    #[inline(always)]
    fn origin() -> Self {
        [0.0; N]
    }

    #[inline(always)]
    fn no_momentum() -> Self {
        [0.0; N]
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        self.iter().sum()
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        largest(self.iter().copied())
    }
}

impl<const N: usize> Coordinates<N> for [f64; N] {
    type Flat = Self;
    type Dual = [Dual; N];

    fn dual(&self, along: &[f64; N]) -> [Dual; N] {
        self.dual_part(along)
    }

    #[inline(always)]
    fn coordinates(&self) -> [f64; N] {
        *self
    }

    #[inline(always)]
    fn from_coordinates(coordinates: &[f64; N]) -> Self {
        *coordinates
    }

    #[inline(always)]
    fn components(momentum: &Self) -> [f64; N] {
        *momentum
    }

    #[inline(always)]
    fn from_components(components: &[f64; N]) -> Self {
        *components
    }

    #[inline(always)]
    fn in_coordinates<T>(
        state: &mut State<Self>,
        change: impl FnOnce(&mut State<[f64; N]>) -> T,
    ) -> T {
        change(state)
    }
}

impl<const N: usize> Configuration for SVector<f64, N> {
    type Momentum = Self;

    fn degrees_of_freedom(&self) -> usize {
        N
    }

    fn stored_values(&self) -> usize {
        N
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        values.copy_from_slice(self.as_slice());
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        self.copy_from_slice(values);
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        add(self.as_mut_slice(), increment);
    }
}

impl<const N: usize> FixedSize for SVector<f64, N> {
    const DEGREES_OF_FREEDOM: usize = N;
    const STORED_VALUES: usize = N;
    type FlatForm<Whole: FixedSize, const D: usize> = [f64; D];
    type DualPart = [Dual; N];

    fn dual_part(&self, along: &[f64]) -> [Dual; N] {
        core::array::from_fn(|i| Dual::varying(self[i], along[i]))
    }

    #[inline(always)]
    fn origin() -> Self {
        Self::zeros()
    }

    #[inline(always)]
    fn no_momentum() -> Self {
        Self::zeros()
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        self.iter().sum()
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        largest(self.iter().copied())
    }
}

impl<const N: usize> Coordinates<N> for SVector<f64, N> {
    type Flat = [f64; N];
    type Dual = [Dual; N];

    fn dual(&self, along: &[f64; N]) -> [Dual; N] {
        self.dual_part(along)
    }

    #[inline(always)]
    fn coordinates(&self) -> [f64; N] {
        self.data.0[0]
    }

    #[inline(always)]
    fn from_coordinates(coordinates: &[f64; N]) -> Self {
        Self::from(*coordinates)
    }

    #[inline(always)]
    fn components(momentum: &Self) -> [f64; N] {
        momentum.data.0[0]
    }

    #[inline(always)]
    fn from_components(components: &[f64; N]) -> Self {
        Self::from(*components)
    }
}

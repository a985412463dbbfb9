//! Configurations: the types that the `q` of a state can have.
//!
//! Input: a point of a configuration space. Output: its number of degrees of freedom, the values by
//! which it is stored, and the point to which an increment moves it. Invariant: `restore` after
//! `store` gives the same bits.
//!
//! The sizes in [`Configuration`] are methods of a value, so that a type may hold any number of
//! coordinates. [`FixedSize`] is for types whose sizes are constants. [`Coordinates`] converts such
//! a type to and from the array of coordinates that generated code computes with.

use core::fmt::Debug;

pub(crate) use flat::two_sum;
pub use flat::{FlatConfiguration, Flatten};
pub use reduced::Reduced;
pub use rotations::WithRotations;
pub use sites::Site;
pub use vectors::{VectorCoordinates, VectorSpace};

use crate::phase::state::State;

mod bodies;
mod flat;
mod pairs;
mod reduced;
mod rotations;
mod sites;
mod vectors;

/// A point of a configuration space, the `q` of a [`State`].
///
/// Implemented for `[f64; N]`, for the vectors of nalgebra (`Vector2<f64>`, `Vector3<f64>`,
/// `SVector<f64, N>`), and for arrays of configurations, such as `[[f64; 3]; 4]` or
/// `[Vector3<f64>; 4]`. In a vector space, momenta have the type of the configuration, and
/// increments are added. A `UnitQuaternion<f64>` is a rotation, whose increments are rotation
/// vectors in the body frame. A pair `(Q, R)` combines two configurations.
///
/// The configuration of a scene, whose `q` is a slice, is a vector of sites: `Vec<f64>`,
/// `Vec<[f64; D]>` or `Vec<SVector<f64, D>>`.
///
/// ```
/// use sve_runtime::Configuration;
/// use sve_runtime::prelude::*;
///
/// let mut q = [Vector3::new(1.0, 2.0, 3.0), Vector3::new(4.0, 5.0, 6.0)];
/// assert_eq!((q.degrees_of_freedom(), q.stored_values()), (6, 6));
/// q.retract(&[0.0, 0.0, 0.5, -1.0, 0.0, 0.0]);
/// assert_eq!(q, [Vector3::new(1.0, 2.0, 3.5), Vector3::new(3.0, 5.0, 6.0)]);
/// let mut values = [0.0; 6];
/// q.store(&mut values);
/// assert_eq!(values, [1.0, 2.0, 3.5, 3.0, 5.0, 6.0]);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a configuration",
    label = "a state does not consist of this type",
    note = "a configuration is `[f64; N]`, a vector such as `Vector3<f64>`, a rotation `UnitQuaternion<f64>`, an array of those, or a pair; a single coordinate is `[f64; 1]`"
)]
pub trait Configuration: Clone + Debug + PartialEq + Send + Sync + 'static {
    /// The type of momenta, and of velocities: elements of a vector space.
    type Momentum: Configuration<Momentum = Self::Momentum>;
    /// Returns the number of independent directions in which the configuration can move: the length
    /// of an increment.
    fn degrees_of_freedom(&self) -> usize;
    /// Returns the number of values by which the configuration is stored.
    fn stored_values(&self) -> usize;
    /// Writes the configuration to `values`, which has the length
    /// [`stored_values`](Self::stored_values).
    ///
    /// # Panics
    /// If `values` has another length.
    fn store(&self, values: &mut [f64]);
    /// Reads the configuration from the `values` that [`store`](Self::store) wrote.
    ///
    /// # Panics
    /// If `values` has another length than [`stored_values`](Self::stored_values).
    fn restore(&mut self, values: &[f64]);
    /// Moves the configuration by a tangent increment of length
    /// [`degrees_of_freedom`](Self::degrees_of_freedom).
    ///
    /// # Panics
    /// If `increment` has another length.
    fn retract(&mut self, increment: &[f64]);
}

/// A configuration whose size is a constant of its type.
pub trait FixedSize: Configuration<Momentum: Copy> + Copy {
    /// Number of degrees of freedom of every value: the length of an increment, and the number of
    /// values of a momentum.
    const DEGREES_OF_FREEDOM: usize;
    /// Number of stored values of every value.
    const STORED_VALUES: usize;
    /// Returns the configuration from which others are measured: zero in a vector space.
    fn origin() -> Self;
    /// Number of entries of every value, see [`entries`](Self::entries).
    const ENTRIES: usize = Self::STORED_VALUES;
    /// True if the configuration has rotations, so that an increment is not added to the stored
    /// values.
    const HAS_ROTATIONS: bool = false;
    /// The form in which a step computes with the configuration `Whole`, if all its parts have this
    /// type: a row of coordinates in a vector space.
    type FlatForm<Whole: FixedSize, const N: usize>: FlatConfiguration<N> + Flatten<Whole, N>;
    /// The configuration in dual numbers, as a part of a larger configuration.
    type DualPart;
    /// Returns the configuration in dual numbers that vary with an increment of length
    /// [`DEGREES_OF_FREEDOM`](Self::DEGREES_OF_FREEDOM).
    ///
    /// # Panics
    /// If `along` has another length.
    fn dual_part(&self, along: &[f64]) -> Self::DualPart;
    /// Returns the momentum zero.
    fn no_momentum() -> Self::Momentum;
    /// Writes the entries that a Lagrangian reads to `values`, which has the length
    /// [`ENTRIES`](Self::ENTRIES): the coordinates in a vector space, and the nine entries of the
    /// matrix of a rotation, by columns.
    ///
    /// # Panics
    /// If `values` has another length.
    #[inline(always)]
    fn entries(&self, values: &mut [f64]) {
        self.store(values);
    }
    /// Adds the change of the momentum by its transport with a velocity: nothing in a vector space,
    /// and `Π × ω` for the body momentum of a rotation.
    #[inline(always)]
    fn add_transport(momentum: &[f64], velocity: &[f64], to: &mut [f64]) {
        let _ = (momentum, velocity, to);
    }
    /// Returns the square of the largest angle of a rotation in an increment; 0 in a vector space.
    #[inline(always)]
    fn turn_square(increment: &[f64]) -> f64 {
        let _ = increment;
        0.0
    }
    /// Returns the sum of the stored values, which is finite only if all of them are.
    fn sum_of_stored_values(&self) -> f64;
    /// Returns the largest magnitude of a stored value.
    fn largest_stored_value(&self) -> f64;
}

/// A configuration with `N` degrees of freedom, in the form in which generated code computes with
/// it.
pub trait Coordinates<const N: usize>: FixedSize {
    /// The form in which generated code computes with the configuration: `[f64; N]` in a vector
    /// space.
    type Flat: FlatConfiguration<N> + Flatten<Self, N>;
    /// The configuration in dual numbers, as differentiated functions read it: a row in a vector
    /// space.
    type Dual;

    /// Returns the configuration in dual numbers that vary with an increment.
    fn dual(&self, along: &[f64; N]) -> Self::Dual;

    /// Returns the coordinates of this configuration.
    #[inline(always)]
    fn coordinates(&self) -> Self::Flat {
        Self::Flat::of(self)
    }

    /// Returns the configuration with these coordinates.
    #[inline(always)]
    fn from_coordinates(coordinates: &Self::Flat) -> Self {
        coordinates.whole()
    }

    /// Returns the components of a momentum or a velocity.
    #[inline(always)]
    fn components(momentum: &Self::Momentum) -> [f64; N] {
        const {
            assert!(
                Self::DEGREES_OF_FREEDOM == N,
                "another number of components"
            );
        }
        let mut components = [0.0; N];
        momentum.store(&mut components);
        components
    }

    /// Returns the momentum or the velocity with these components.
    #[inline(always)]
    fn from_components(components: &[f64; N]) -> Self::Momentum {
        const {
            assert!(
                Self::DEGREES_OF_FREEDOM == N,
                "another number of components"
            );
        }
        let mut momentum = Self::no_momentum();
        momentum.restore(components);
        momentum
    }

    /// Calls `change` with the state in coordinates and stores the changed state. If the
    /// configuration is `[f64; N]`, nothing is copied.
    #[doc(hidden)]
    #[inline(always)]
    fn in_coordinates<T>(
        state: &mut State<Self>,
        change: impl FnOnce(&mut State<Self::Flat>) -> T,
    ) -> T {
        let mut flat = state.to_coordinates();
        let result = change(&mut flat);
        *state = State::from_coordinates(&flat);
        result
    }
}

/// Returns the largest magnitude.
#[inline]
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, |most, value| most.max(value.abs()))
}

/// Adds an increment to the coordinates in a vector space.
#[inline(always)]
fn add(to: &mut [f64], increment: &[f64]) {
    assert_eq!(to.len(), increment.len(), "an increment of another length");
    for (x, dx) in to.iter_mut().zip(increment) {
        *x += dx;
    }
}

//! Bodies without their attitude: the configuration of a reduced system, whose state is the body
//! momentum alone.
//!
//! A reduced system makes the steps of the rotation, started from any attitude: if a Lagrangian
//! does not depend on the attitude, neither do the steps.
//! [`Integrator::step_with_attitude`](crate::Integrator::step_with_attitude) computes the attitude
//! along a path.

use core::marker::PhantomData;

use nalgebra::UnitQuaternion;

use super::{Configuration, Coordinates, FixedSize, Flatten, WithRotations};
use crate::phase::state::State;

/// Marks the place of an attitude of type `Q`, which the state of a reduced system,
/// `#[variational(midpoint, reduced)]`, does not contain.
///
/// ```
/// use sve_runtime::Reduced;
/// use sve_runtime::prelude::*;
///
/// struct Body { i: Vector3<f64>, s: f64 }
///
/// #[variational(midpoint, reduced)]
/// impl Body {
///     fn lagrangian(&self, w: Vector3<f64>) -> f64 {
///         0.5 * w.dot(&self.i.component_mul(&w))
///     }
///     #[h1]
///     fn tremor(&self, pi: Vector3<f64>) -> f64 {
///         self.s * pi.x
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let body = Integrator::new(Body { i: Vector3::new(1.0, 2.0, 3.0), s: 0.1 }, Midpoint);
/// let mut state = State::<Reduced>::from_momentum(Vector3::new(0.1, 2.0, 0.1));
/// let mut attitude = UnitQuaternion::identity();
/// let spatial = attitude * state.p;
/// for step in 0..100 {
///     let dw = [Wiener::new(1).increment(step, 0, 0.01)];
///     body.step_with_attitude(&mut state, &mut attitude, 0.01, &dw)?;
/// }
/// assert!((attitude * state.p - spatial).norm() < 1e-13);
/// # Ok(())
/// # }
/// ```
pub struct Reduced<Q = UnitQuaternion<f64>>(PhantomData<Q>);

impl<Q> Reduced<Q> {
    const PLACE: Self = Self(PhantomData);
}

impl<Q> Clone for Reduced<Q> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<Q> Copy for Reduced<Q> {}

impl<Q> PartialEq for Reduced<Q> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<Q> core::fmt::Debug for Reduced<Q> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str("Reduced")
    }
}

impl<Q: FixedSize> Configuration for Reduced<Q> {
    type Momentum = Q::Momentum;

    fn degrees_of_freedom(&self) -> usize {
        Q::DEGREES_OF_FREEDOM
    }

    fn stored_values(&self) -> usize {
        0
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        assert!(values.is_empty(), "a reduced configuration has no values");
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        assert!(values.is_empty(), "a reduced configuration has no values");
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        assert_eq!(
            increment.len(),
            Q::DEGREES_OF_FREEDOM,
            "an increment of another length"
        );
    }
}

impl<Q: FixedSize> FixedSize for Reduced<Q> {
    const DEGREES_OF_FREEDOM: usize = Q::DEGREES_OF_FREEDOM;
    const STORED_VALUES: usize = 0;
    const HAS_ROTATIONS: bool = Q::HAS_ROTATIONS;
    type FlatForm<Whole: FixedSize, const N: usize> = WithRotations<Whole, N>;
    type DualPart = ();

    fn dual_part(&self, _: &[f64]) {}

    #[inline(always)]
    fn origin() -> Self {
        Self::PLACE
    }

    #[inline(always)]
    fn no_momentum() -> Q::Momentum {
        Q::no_momentum()
    }

    #[inline(always)]
    fn add_transport(momentum: &[f64], velocity: &[f64], to: &mut [f64]) {
        Q::add_transport(momentum, velocity, to);
    }

    #[inline(always)]
    fn turn_square(increment: &[f64]) -> f64 {
        Q::turn_square(increment)
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        0.0
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        0.0
    }
}

impl<Q: FixedSize, const N: usize> Coordinates<N> for Reduced<Q> {
    type Flat = WithRotations<Q, N>;
    type Dual = ();

    fn dual(&self, _: &[f64; N]) {}
}

impl<Q: FixedSize, const N: usize> Flatten<Reduced<Q>, N> for WithRotations<Q, N> {
    #[inline(always)]
    fn of(_: &Reduced<Q>) -> Self {
        Self::at(Q::origin())
    }

    #[inline(always)]
    fn whole(&self) -> Reduced<Q> {
        Reduced::PLACE
    }
}

impl<Q: FixedSize> State<Reduced<Q>> {
    /// Returns the state of a reduced system with a body momentum, at `t = 0`.
    pub const fn from_momentum(p: Q::Momentum) -> Self {
        Self::new(Reduced::PLACE, p)
    }
}

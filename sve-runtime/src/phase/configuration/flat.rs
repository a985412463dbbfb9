//! The form in which steps compute with a configuration.
//!
//! Input: a configuration and increments of its `N` degrees of freedom. Output: the configuration
//! after the increments. The form of vector spaces is a row `[f64; N]`, the form of configurations
//! with rotations is [`WithRotations`](super::WithRotations).

use super::{Configuration, FixedSize, largest};
use crate::phase::dual::Dual;
use crate::phase::lanes::{LaneStates, StateLanes};
use crate::phase::state::State;

/// The form in which steps compute with a configuration of `N` degrees of freedom. Its momenta are
/// rows of `N` numbers.
pub trait FlatConfiguration<const N: usize>: Configuration<Momentum = [f64; N]> + Copy {
    /// A state in each lane.
    type Lanes: LaneStates<Self>;
    /// The configuration in dual numbers: a row in a vector space.
    type Dual;
    /// True if rounding errors of the configuration can be carried from step to step.
    const HAS_LOW_PARTS: bool;
    /// Returns the configuration in dual numbers that vary with an increment.
    fn dual(&self, along: &[f64; N]) -> Self::Dual;
    /// Returns the configuration that a row of coordinates describes: the increment from the
    /// origin.
    fn of_row(coordinates: &[f64; N]) -> Self;
    /// Returns configuration and momenta after an increment.
    fn moved(state: &State<Self>, dq: &[f64; N], dp: &[f64; N]) -> (Self, [f64; N]);
    /// Returns configuration and momenta after an increment to which the low parts of the state are
    /// added, and writes the rounding errors to `low`. A configuration without low parts is moved
    /// without compensation.
    fn moved_with_low_parts(
        state: &State<Self>,
        low: &mut State<Self>,
        dq: &[f64; N],
        dp: &[f64; N],
    ) -> (Self, [f64; N]);
    /// Returns the sum of all stored values and momenta, which is finite only if all of them are.
    fn sum_with(&self, p: &[f64; N]) -> f64;
    /// Returns the largest magnitude of a stored value.
    fn size(&self) -> f64;
    /// Returns the stored values, for messages.
    fn values(&self) -> Vec<f64> {
        let mut values = vec![0.0; self.stored_values()];
        self.store(&mut values);
        values
    }
    /// Returns the square of the largest angle of a rotation in an increment, see
    /// [`FixedSize::turn_square`].
    fn turn_square(increment: &[f64; N]) -> f64;
    /// Adds the change of the momentum by its transport with a velocity, see
    /// [`FixedSize::add_transport`].
    fn add_transport(momentum: &[f64; N], velocity: &[f64; N], to: &mut [f64; N]);
}

/// Conversions between a configuration and the form in which steps compute with it.
pub trait Flatten<Whole, const N: usize>: Sized {
    /// Returns the form of a configuration.
    fn of(whole: &Whole) -> Self;
    /// Returns the configuration.
    fn whole(&self) -> Whole;
}

impl<const N: usize> FlatConfiguration<N> for [f64; N] {
    type Lanes = StateLanes<N>;
    type Dual = [Dual; N];
    const HAS_LOW_PARTS: bool = true;

    fn dual(&self, along: &[f64; N]) -> [Dual; N] {
        self.dual_part(along)
    }

    #[inline]
    fn size(&self) -> f64 {
        largest(self.iter().copied())
    }

    #[inline(always)]
    fn of_row(coordinates: &[f64; N]) -> Self {
        *coordinates
    }

    #[inline(always)]
    fn moved(state: &State<Self>, dq: &[f64; N], dp: &[f64; N]) -> (Self, [f64; N]) {
        let (mut q, mut p) = (state.q, state.p);
        for i in 0..N {
            q[i] += dq[i];
            p[i] += dp[i];
        }
        (q, p)
    }

    #[inline(always)]
    fn moved_with_low_parts(
        state: &State<Self>,
        low: &mut State<Self>,
        dq: &[f64; N],
        dp: &[f64; N],
    ) -> (Self, [f64; N]) {
        let (mut q, mut p) = (state.q, state.p);
        for i in 0..N {
            (q[i], low.q[i]) = two_sum(q[i], dq[i] + low.q[i]);
            (p[i], low.p[i]) = two_sum(p[i], dp[i] + low.p[i]);
        }
        (q, p)
    }

    #[inline(always)]
    fn sum_with(&self, p: &[f64; N]) -> f64 {
        let mut sum = 0.0;
        for i in 0..N {
            sum += self[i] + p[i];
        }
        sum
    }

    #[inline(always)]
    fn turn_square(_: &[f64; N]) -> f64 {
        0.0
    }

    #[inline(always)]
    fn add_transport(_: &[f64; N], _: &[f64; N], _: &mut [f64; N]) {}
}

impl<Whole: FixedSize, const N: usize> Flatten<Whole, N> for [f64; N] {
    #[inline(always)]
    fn of(whole: &Whole) -> Self {
        const { assert!(Whole::STORED_VALUES == N, "another number of coordinates") }
        let mut coordinates = [0.0; N];
        whole.store(&mut coordinates);
        coordinates
    }

    #[inline(always)]
    fn whole(&self) -> Whole {
        const { assert!(Whole::STORED_VALUES == N, "another number of coordinates") }
        let mut configuration = Whole::origin();
        configuration.restore(self);
        configuration
    }
}

/// Returns the sum of two numbers and its rounding error, exactly (Knuth's two-sum).
#[inline(always)]
pub(crate) fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let second = sum - a;
    (sum, (a - (sum - second)) + (b - second))
}

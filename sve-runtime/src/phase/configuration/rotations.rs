//! Rotations as configurations, alone, in arrays, and beside vectors.
//!
//! Input: a unit quaternion and the rotation vector x of an increment, an angle θ = |x| about an
//! axis. Output: the quaternion of R exp(x̂), `q ∘ (1 − T² θ², 2 T x)/(1 + T² θ²)` with
//! T = tan(θ/4)/θ. Invariant: the quaternion is normalised to rounding after each increment, and
//! continuous along a path.
//!
//! Source: Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006), section VII.5.3
//! (quaternions).

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::flat::two_sum;
use super::{Configuration, Coordinates, FixedSize, FlatConfiguration, Flatten, largest};
use crate::phase::dual::DualRotation;
use crate::phase::lanes::ScalarLanes;
use crate::phase::state::State;

/// A rotation with three degrees of freedom, stored as the quaternion `[w, x, y, z]`. Its momentum
/// is the body momentum.
///
/// ```
/// use sve_runtime::Configuration;
/// use sve_runtime::prelude::*;
///
/// let mut r = UnitQuaternion::identity();
/// // a quarter turn about the third axis
/// r.retract(&[0.0, 0.0, 90f64.to_radians()]);
/// assert!((r * Vector3::x() - Vector3::y()).norm() < 1e-15);
/// assert_eq!((r.degrees_of_freedom(), r.stored_values()), (3, 4));
/// ```
impl Configuration for UnitQuaternion<f64> {
    type Momentum = Vector3<f64>;

    fn degrees_of_freedom(&self) -> usize {
        3
    }

    fn stored_values(&self) -> usize {
        4
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        values.copy_from_slice(&[self.w, self.i, self.j, self.k]);
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        let [w, x, y, z] = *values else {
            panic!("a rotation has four stored values");
        };
        *self = Self::new_unchecked(Quaternion::new(w, x, y, z));
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        let [x, y, z] = *increment else {
            panic!("an increment of a rotation has three components");
        };
        let (w, a) = (self.w, [self.i, self.j, self.k]);
        let square = x * x + y * y + z * z;
        let t = quarter(square);
        let r = t * t * square;
        let half = [2.0 * t * x, 2.0 * t * y, 2.0 * t * z];
        // what a turn adds to the quaternion: small numbers keep their digits
        let turned = [
            w - (r * w + (a[0] * half[0] + a[1] * half[1] + a[2] * half[2])),
            a[0] + (w * half[0] + (a[1] * half[2] - a[2] * half[1]) - r * a[0]),
            a[1] + (w * half[1] + (a[2] * half[0] - a[0] * half[2]) - r * a[1]),
            a[2] + (w * half[2] + (a[0] * half[1] - a[1] * half[0]) - r * a[2]),
        ];
        // The length is 1 + r, and includes the rounding error of the quaternion before.
        let square = turned[0] * turned[0]
            + turned[1] * turned[1]
            + turned[2] * turned[2]
            + turned[3] * turned[3];
        let scale = 1.0 / square.sqrt();
        let [w, x, y, z] = turned.map(|component| scale * component);
        *self = Self::new_unchecked(Quaternion::new(w, x, y, z));
    }
}

/// Returns `tan(θ/4)/θ` for the square of an angle; within the limit of a step, by the Padé
/// approximant that the equations of steps contain.
#[inline(always)]
fn quarter(square: f64) -> f64 {
    if square > 16.0 {
        return quarter_of_large(square);
    }
    let s = square;
    let s2 = s * s;
    let dividend = (0.000_520_833_333_333_333_3 - s * 1.976_277_376_892_786e-6)
        + s2 * (1.406_828_457_026_933_2e-9 - s * 8.594_808_182_442_149e-17);
    let divisor = (1.0 - s * 0.029_092_071_611_253_197)
        + s2 * (0.000_097_953_583_607_355_99 - s * 6.754_809_644_035_987e-8);
    0.25 + 0.25 * s * (1.0 / 48.0 + s * (dividend / divisor))
}

#[cold]
fn quarter_of_large(square: f64) -> f64 {
    let angle = square.sqrt();
    // the tangent of a right angle is a large number
    (0.25 * angle).tan() / angle
}

impl FixedSize for UnitQuaternion<f64> {
    const DEGREES_OF_FREEDOM: usize = 3;
    const STORED_VALUES: usize = 4;
    const ENTRIES: usize = 9;
    const HAS_ROTATIONS: bool = true;
    type FlatForm<Whole: FixedSize, const N: usize> = WithRotations<Whole, N>;
    type DualPart = DualRotation;

    fn dual_part(&self, along: &[f64]) -> DualRotation {
        let [x, y, z] = *along else {
            panic!("an increment of a rotation has three components");
        };
        DualRotation::new(self, [x, y, z])
    }

    #[inline(always)]
    fn origin() -> Self {
        Self::new_unchecked(Quaternion::new(1.0, 0.0, 0.0, 0.0))
    }

    #[inline(always)]
    fn no_momentum() -> Vector3<f64> {
        Vector3::zeros()
    }

    #[inline(always)]
    fn entries(&self, values: &mut [f64]) {
        let (w, [x, y, z]) = (self.w, [self.i, self.j, self.k]);
        let (ww, xx, yy, zz) = (w * w, x * x, y * y, z * z);
        let [wx, wy, wz] = [x, y, z].map(|a| 2.0 * w * a);
        let (xy, xz, yz) = (2.0 * x * y, 2.0 * x * z, 2.0 * y * z);
        values.copy_from_slice(&[
            ww + xx - yy - zz,
            xy + wz,
            xz - wy,
            xy - wz,
            ww - xx + yy - zz,
            yz + wx,
            xz + wy,
            yz - wx,
            ww - xx - yy + zz,
        ]);
    }

    #[inline(always)]
    fn add_transport(momentum: &[f64], velocity: &[f64], to: &mut [f64]) {
        let (p, w) = (momentum, velocity);
        to[0] += p[1] * w[2] - p[2] * w[1];
        to[1] += p[2] * w[0] - p[0] * w[2];
        to[2] += p[0] * w[1] - p[1] * w[0];
    }

    #[inline(always)]
    fn turn_square(increment: &[f64]) -> f64 {
        increment.iter().map(|x| x * x).sum()
    }

    #[inline(always)]
    fn sum_of_stored_values(&self) -> f64 {
        self.w + self.i + self.j + self.k
    }

    #[inline]
    fn largest_stored_value(&self) -> f64 {
        largest(self.coords.iter().copied())
    }
}

impl Coordinates<3> for UnitQuaternion<f64> {
    type Flat = WithRotations<Self, 3>;
    type Dual = DualRotation;

    fn dual(&self, along: &[f64; 3]) -> DualRotation {
        DualRotation::new(self, *along)
    }
}

/// A configuration with rotations, as steps compute with it: an increment moves it by
/// [`retract`](Configuration::retract).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithRotations<Q, const N: usize>(Q);

impl<Q: FixedSize, const N: usize> WithRotations<Q, N> {
    /// Returns the form of a configuration.
    #[inline(always)]
    pub(super) const fn at(configuration: Q) -> Self {
        Self(configuration)
    }

    /// Returns the entries that a Lagrangian reads, see [`FixedSize::entries`].
    #[inline(always)]
    pub fn entries<const E: usize>(&self) -> [f64; E] {
        const { assert!(Q::ENTRIES == E, "another number of entries") }
        let mut entries = [0.0; E];
        self.0.entries(&mut entries);
        entries
    }
}

impl<Q: FixedSize, const N: usize> Configuration for WithRotations<Q, N> {
    type Momentum = [f64; N];

    fn degrees_of_freedom(&self) -> usize {
        N
    }

    fn stored_values(&self) -> usize {
        Q::STORED_VALUES
    }

    #[inline(always)]
    fn store(&self, values: &mut [f64]) {
        self.0.store(values);
    }

    #[inline(always)]
    fn restore(&mut self, values: &[f64]) {
        self.0.restore(values);
    }

    #[inline(always)]
    fn retract(&mut self, increment: &[f64]) {
        self.0.retract(increment);
    }
}

impl<Q: FixedSize, const N: usize> FlatConfiguration<N> for WithRotations<Q, N> {
    type Lanes = ScalarLanes<Self>;
    type Dual = Q::DualPart;
    const HAS_LOW_PARTS: bool = false;

    fn dual(&self, along: &[f64; N]) -> Q::DualPart {
        self.0.dual_part(along)
    }

    #[inline]
    fn size(&self) -> f64 {
        self.0.largest_stored_value()
    }

    #[inline(always)]
    fn of_row(coordinates: &[f64; N]) -> Self {
        let mut configuration = Self(Q::origin());
        configuration.retract(coordinates);
        configuration
    }

    #[inline(always)]
    fn moved(state: &State<Self>, dq: &[f64; N], dp: &[f64; N]) -> (Self, [f64; N]) {
        let (mut q, mut p) = (state.q, state.p);
        q.retract(dq);
        for i in 0..N {
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
        q.retract(dq);
        for i in 0..N {
            (p[i], low.p[i]) = two_sum(p[i], dp[i] + low.p[i]);
        }
        (q, p)
    }

    #[inline(always)]
    fn sum_with(&self, p: &[f64; N]) -> f64 {
        let mut sum = self.0.sum_of_stored_values();
        for p in p {
            sum += p;
        }
        sum
    }

    #[inline(always)]
    fn turn_square(increment: &[f64; N]) -> f64 {
        Q::turn_square(increment)
    }

    #[inline(always)]
    fn add_transport(momentum: &[f64; N], velocity: &[f64; N], to: &mut [f64; N]) {
        Q::add_transport(momentum, velocity, to);
    }
}

impl<Q: FixedSize, const N: usize> Flatten<Q, N> for WithRotations<Q, N> {
    #[inline(always)]
    fn of(whole: &Q) -> Self {
        const {
            assert!(
                Q::DEGREES_OF_FREEDOM == N,
                "another number of degrees of freedom"
            );
        }
        Self(*whole)
    }

    #[inline(always)]
    fn whole(&self) -> Q {
        self.0
    }
}

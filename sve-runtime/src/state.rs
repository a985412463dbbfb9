//! A point of phase space at a time.
//!
//! A state can have any numbers: every step checks that they are finite.

use crate::configuration::{
    Configuration, Coordinates, FixedSize, VectorCoordinates, WithRotations,
};
use crate::degenerate;
use crate::error::StepError;
use crate::legendre;
use crate::system::{Dims, System};

/// Time, configuration and momentum of a system.
///
/// `Q` is the type of `q` in the user's Lagrangian: `[f64; 2]` for two coordinates, `[[f64; 3]; B]` for `B` bodies in space. A Lagrangian
/// of a single number `q: f64` has the state `State<[f64; 1]>`. `P` follows from `Q`: in a vector space both are the same type. `q` and `p`
/// are in the units of the Lagrangian; `p = ∂L/∂v`.
///
/// ```
/// use sve_runtime::prelude::*;
/// let state = State::new([1.0], [0.0]);
/// assert_eq!((state.t, state.q[0], state.p[0]), (0.0, 1.0, 0.0));
/// ```
///
/// The type in the signature is the type in the state, and what follows from the Lagrangian has it too:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// Two bodies in a plane, joined by a spring.
/// struct Pair { k: f64 }
///
/// #[variational(midpoint)]
/// impl Pair {
///     fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
///         let mut l = 0.0;
///         for i in 0..2 {
///             l += 0.5 * (v[0][i] * v[0][i] + v[1][i] * v[1][i]);
///             l -= 0.5 * self.k * (q[1][i] - q[0][i]).powi(2);
///         }
///         l
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let pair = Integrator::new(Pair { k: 4.0 }, Midpoint);
/// let mut state = State::new([[0.0, 0.0], [1.0, 0.0]], [[0.0, -0.5], [0.0, 0.5]]);
/// pair.step(&mut state, 0.01, &[])?;
/// let [first, second] = state.q;
/// assert!((first[0] + second[0] - 1.0).abs() < 1e-15);
/// let start: State<[[f64; 2]; 2]> = State::at(1.0, [[0.0, 0.0], [1.0, 0.0]], [[0.0; 2]; 2]);
/// assert_eq!(pair.system().drift(&start)?.p, [[4.0, 0.0], [-4.0, 0.0]]);
/// # Ok(())
/// # }
/// ```
///
/// For a rotation `r: Rotation3<f64>` of the Lagrangian `q` is a [`UnitQuaternion`](nalgebra::UnitQuaternion), and `p` the angular momentum in the body frame. A body
/// that moves in space has a position beside its attitude, `State::new((q, r), (p, pi))`, with the parts `.q.0`, `.q.1`, `.p.0` and `.p.1`:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A falling body.
/// struct Body { m: f64, i: Vector3<f64>, g: f64 }
///
/// #[variational(midpoint)]
/// impl Body {
///     fn lagrangian(&self, q: Vector3<f64>, _r: Rotation3<f64>, v: Vector3<f64>, w: Vector3<f64>) -> f64 {
///         0.5 * self.m * v.norm_squared() + 0.5 * w.dot(&self.i.component_mul(&w)) - self.m * self.g * q.z
///     }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let body = Integrator::new(Body { m: 2.0, i: Vector3::new(1.0, 2.0, 3.0), g: 9.8 }, Midpoint);
/// let (at, attitude) = (Vector3::zeros(), UnitQuaternion::identity());
/// let start = State::new((at, attitude), (Vector3::zeros(), Vector3::new(0.1, 2.0, 0.1)));
/// let mut state = start;
/// for _ in 0..100 {
///     body.step(&mut state, 0.01, &[])?;
/// }
/// assert!((state.q.0.z + 4.9).abs() < 1e-12);
/// // the angular momentum in space stays
/// assert!((state.q.1 * state.p.1 - start.p.1).norm() < 1e-13);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound = "Q: crate::configuration::FixedSize + Configuration<Momentum = P>")
)]
// The type of `p` is a parameter, since rustc 1.95 fails on `State { q, ..start }` in a closure where a field has an associated type.
pub struct State<Q: Configuration, P = <Q as Configuration>::Momentum> {
    /// Time.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub t: f64,
    /// Configuration.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::configuration"))]
    pub q: Q,
    /// Momentum `∂L/∂v`.
    #[cfg_attr(
        feature = "serde",
        serde(
            serialize_with = "crate::floats::momentum::serialize::<Q, _>",
            deserialize_with = "crate::floats::momentum::deserialize::<Q, _>"
        )
    )]
    pub p: P,
}

impl<Q: Configuration> State<Q> {
    /// The state `(q, p)` at `t = 0`.
    pub const fn new(q: Q, p: Q::Momentum) -> Self {
        Self { t: 0.0, q, p }
    }

    /// The state `(q, p)` at time `t`.
    pub const fn at(t: f64, q: Q, p: Q::Momentum) -> Self {
        Self { t, q, p }
    }

    /// The state of a configuration at rest, at `t = 0`.
    ///
    /// For a degenerate Lagrangian momenta are functions of the configuration, p = α(q), so the configuration is the whole state. Coordinates that have a kinetic
    /// energy of their own are at rest, p = ∂L/∂v(q, 0); this is so for all coordinates of a regular Lagrangian. Coordinates whose velocities do not occur in L at
    /// all are solved for, ∂L/∂q = 0, from their values in `q`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// Point vortices in a plane: the coordinates of each are conjugate to each other.
    /// struct Vortices { gamma: [f64; 2] }
    ///
    /// #[variational(midpoint)]
    /// impl Vortices {
    ///     fn lagrangian(&self, q: [[f64; 2]; 2], v: [[f64; 2]; 2]) -> f64 {
    ///         let [a, b] = self.gamma;
    ///         let distance = (q[0][0] - q[1][0]).powi(2) + (q[0][1] - q[1][1]).powi(2);
    ///         a * q[0][1] * v[0][0] + b * q[1][1] * v[1][0] + a * b * distance.ln() / 2.0
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let vortices = Integrator::new(Vortices { gamma: [1.0, 2.0] }, Midpoint);
    /// let mut state = State::from_configuration(vortices.system(), [[0.0, 1.0], [0.0, -0.5]])?;
    /// assert_eq!(state.p, [[1.0, 0.0], [-1.0, 0.0]]);
    /// vortices.step(&mut state, 0.1, &[])?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A [`StepError`] if L is not defined at `q`, or no value of an algebraic coordinate is found.
    pub fn from_configuration<S, const N: usize, const M: usize>(
        system: &S,
        q: Q,
    ) -> Result<Self, StepError>
    where
        S: System<Dims = Dims<N, M, Q>> + ?Sized,
        Q: VectorCoordinates<N>,
    {
        let state = degenerate::state_at_rest(system, &q.coordinates())?;
        Ok(Self::from_coordinates(&state))
    }

    /// The state with a velocity, p = ∂L/∂v(q, v), at `t = 0`. If L depends on time, see [`from_velocity_at`](Self::from_velocity_at).
    ///
    /// `q` and `v` have the shape in which the Lagrangian has them: rows of numbers, vectors, bodies. Of a rotation, `q` is the attitude and `v` the angular velocity in
    /// the body frame.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// Two bodies of different masses in space, joined by a spring.
    /// struct Pair { m: [f64; 2], k: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pair {
    ///     fn lagrangian(&self, q: [Vector3<f64>; 2], v: [Vector3<f64>; 2]) -> f64 {
    ///         let kinetic = 0.5 * self.m[0] * v[0].norm_squared() + 0.5 * self.m[1] * v[1].norm_squared();
    ///         kinetic - 0.5 * self.k * (q[1] - q[0]).norm_squared()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pair = Integrator::new(Pair { m: [1.0, 2.0], k: 4.0 }, Midpoint);
    /// let start = State::from_velocity(pair.system(), [Vector3::zeros(), Vector3::x()], [Vector3::y(), Vector3::z()])?;
    /// assert_eq!(start.p, [Vector3::y(), 2.0 * Vector3::z()]);
    /// assert_eq!(pair.system().velocity(&start)?, [Vector3::y(), Vector3::z()]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// With constraints, [`consistent`](crate::Integrator::consistent) projects the state onto them. For a degenerate Lagrangian the velocities of coordinates without mass
    /// follow from the motion: the momenta of those coordinates are α(q), whatever is given for them, and [`from_configuration`](Self::from_configuration) needs no velocity.
    ///
    /// # Errors
    /// [`StepError::NonFiniteInput`]; [`StepError::NonFiniteResult`] if L is not defined there; [`StepError::Inconsistent`] if a coordinate whose velocity does not
    /// occur in L does not solve its equation.
    pub fn from_velocity<S, const N: usize, const M: usize>(
        system: &S,
        q: Q,
        v: Q::Momentum,
    ) -> Result<Self, StepError>
    where
        S: System<Dims = Dims<N, M, Q>> + ?Sized,
        Q: Coordinates<N>,
    {
        Self::from_velocity_at(system, 0.0, q, v)
    }

    /// The state with a velocity at time `t`; see [`from_velocity`](Self::from_velocity).
    ///
    /// # Errors
    /// As [`from_velocity`](Self::from_velocity).
    pub fn from_velocity_at<S, const N: usize, const M: usize>(
        system: &S,
        t: f64,
        q: Q,
        v: Q::Momentum,
    ) -> Result<Self, StepError>
    where
        S: System<Dims = Dims<N, M, Q>> + ?Sized,
        Q: Coordinates<N>,
    {
        let state = legendre::state_with_velocity(system, t, q.coordinates(), Q::components(&v))?;
        Ok(Self::from_coordinates(&state))
    }

    /// The same state in coordinates.
    #[allow(clippy::wrong_self_convention)] // a state can be large
    #[inline(always)]
    pub(crate) fn to_coordinates<const N: usize>(&self) -> State<Q::Flat>
    where
        Q: Coordinates<N>,
    {
        State {
            t: self.t,
            q: self.q.coordinates(),
            p: Q::components(&self.p),
        }
    }

    /// The state with these coordinates.
    #[inline(always)]
    pub(crate) fn from_coordinates<const N: usize>(flat: &State<Q::Flat>) -> Self
    where
        Q: Coordinates<N>,
    {
        Self {
            t: flat.t,
            q: Q::from_coordinates(&flat.q),
            p: Q::from_components(&flat.p),
        }
    }
}

/// A state in coordinates, for generated functions.
#[inline(always)]
pub fn in_coordinates<Q: Coordinates<N>, const N: usize>(state: &State<Q>) -> State<Q::Flat> {
    state.to_coordinates()
}

/// A state with the entries of its configuration in place of the configuration, for generated functions of systems with rotations.
#[inline(always)]
pub fn with_entries<Q: FixedSize, const E: usize, const N: usize>(
    state: &State<WithRotations<Q, N>>,
) -> State<[f64; E], [f64; N]> {
    State {
        t: state.t,
        q: state.q.entries(),
        p: state.p,
    }
}

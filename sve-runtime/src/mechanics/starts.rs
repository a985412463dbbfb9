//! States at rest, and states with a velocity.

use crate::error::StepError;
use crate::mechanics::{degenerate, legendre};
use crate::phase::configuration::{Configuration, Coordinates, VectorCoordinates};
use crate::phase::state::State;
use crate::system::{Dims, System};

impl<Q: Configuration> State<Q> {
    /// Returns the state of a configuration at rest, at `t = 0`.
    ///
    /// For a degenerate Lagrangian momenta are functions of the configuration, p = α(q), so the
    /// configuration is the whole state. Coordinates with a kinetic energy are at rest, p =
    /// ∂L/∂v(q, 0); these are all coordinates of a regular Lagrangian. If the velocity of a
    /// coordinate does not occur in L, the coordinate is solved for, ∂L/∂q = 0, starting from its
    /// value in `q`.
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

    /// Returns the state with a velocity, p = ∂L/∂v(q, v), at `t = 0`. If L depends on time, see
    /// [`from_velocity_at`](Self::from_velocity_at).
    ///
    /// `q` and `v` have the same shape as in the Lagrangian: rows of numbers, vectors, bodies. For
    /// a rotation, `q` is the attitude and `v` the angular velocity in the body frame.
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
    ///         let [a, b] = v.map(|v| 0.5 * v.norm_squared());
    ///         self.m[0] * a + self.m[1] * b - 0.5 * self.k * (q[1] - q[0]).norm_squared()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let pair = Integrator::new(Pair { m: [1.0, 2.0], k: 4.0 }, Midpoint);
    /// let (q, v) = ([Vector3::zeros(), Vector3::x()], [Vector3::y(), Vector3::z()]);
    /// let start = State::from_velocity(pair.system(), q, v)?;
    /// assert_eq!(start.p, [Vector3::y(), 2.0 * Vector3::z()]);
    /// assert_eq!(pair.system().velocity(&start)?, [Vector3::y(), Vector3::z()]);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// With constraints, [`consistent`](crate::Integrator::consistent) projects the state onto
    /// them. For a degenerate Lagrangian the velocities of coordinates without mass follow from the
    /// motion. The momenta of these coordinates are α(q) and do not depend on `v`, and
    /// [`from_configuration`](Self::from_configuration) needs no velocity.
    ///
    /// # Errors
    /// [`StepError::NonFiniteInput`] if a number is not finite; [`StepError::NonFiniteResult`] if L
    /// is not defined there; [`StepError::Inconsistent`] if the velocity of a coordinate does not
    /// occur in L and the coordinate does not solve its equation.
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

    /// Returns the state with a velocity at time `t`; see [`from_velocity`](Self::from_velocity).
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
}

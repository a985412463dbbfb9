//! A point of phase space at a time.
//!
//! A state can contain any numbers: every step checks that they are finite.

use crate::phase::configuration::{Configuration, Coordinates, FixedSize, WithRotations};

/// Time, configuration and momentum of a system.
///
/// `Q` is the type of `q` in the user's Lagrangian: `[f64; 2]` for two coordinates, `[[f64; 3]; B]`
/// for `B` bodies in space. A Lagrangian of a single number `q: f64` has the state
/// `State<[f64; 1]>`. If `q` is a slice, the state has a vector, as in `State<Vec<f64>>` or
/// `State<Vec<[f64; 3]>>`, and its length is that of the system. `P` follows from `Q`: in a vector
/// space both are the same type. `q` and `p`
/// are in the units of the Lagrangian; `p = ∂L/∂v`.
///
/// ```
/// use sve_runtime::prelude::*;
/// let state = State::new([1.0], [0.0]);
/// assert_eq!((state.t, state.q[0], state.p[0]), (0.0, 1.0, 0.0));
/// ```
///
/// The type of `q` in the signature is the type in the state, and momenta, drifts and fields have
/// the type that follows from it:
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
/// For a rotation `r: Rotation3<f64>` of the Lagrangian, `q` is a
/// [`UnitQuaternion`](nalgebra::UnitQuaternion), and `p` the angular momentum in the body frame. A
/// body that moves in space has a position beside its attitude, `State::new((q, r), (p, pi))`, with
/// the parts `.q.0`, `.q.1`, `.p.0` and `.p.1`:
///
/// ```
/// use sve_runtime::prelude::*;
///
/// /// A falling body.
/// struct Body { m: f64, i: Vector3<f64>, g: f64 }
///
/// #[variational(midpoint)]
/// impl Body {
///     fn lagrangian(
///         &self,
///         q: Vector3<f64>,
///         _r: Rotation3<f64>,
///         v: Vector3<f64>,
///         w: Vector3<f64>,
///     ) -> f64 {
///         let rotation = 0.5 * w.dot(&self.i.component_mul(&w));
///         0.5 * self.m * v.norm_squared() + rotation - self.m * self.g * q.z
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
    serde(bound = "Q: crate::phase::serialise::Serialised + Configuration<Momentum = P>")
)]
// The type of `p` is a parameter, since rustc 1.95 fails on `State { q, ..start }` in a closure
// where a field has an associated type.
pub struct State<Q: Configuration, P = <Q as Configuration>::Momentum> {
    /// Time.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub t: f64,
    /// Configuration.
    #[cfg_attr(
        feature = "serde",
        serde(serialize_with = "Q::write", deserialize_with = "Q::read")
    )]
    pub q: Q,
    /// Momentum `∂L/∂v`.
    #[cfg_attr(
        feature = "serde",
        serde(
            serialize_with = "Q::write_momentum",
            deserialize_with = "Q::read_momentum"
        )
    )]
    pub p: P,
}

impl<Q: Configuration> State<Q> {
    /// Returns the state `(q, p)` at `t = 0`.
    pub const fn new(q: Q, p: Q::Momentum) -> Self {
        Self { t: 0.0, q, p }
    }

    /// Returns the state `(q, p)` at time `t`.
    pub const fn at(t: f64, q: Q, p: Q::Momentum) -> Self {
        Self { t, q, p }
    }

    /// Returns the stored values of the configuration and of the momentum.
    pub(crate) fn stored(&self) -> [Vec<f64>; 2] {
        let (mut q, mut p) = (
            vec![0.0; self.q.stored_values()],
            vec![0.0; self.p.stored_values()],
        );
        self.q.store(&mut q);
        self.p.store(&mut p);
        [q, p]
    }

    /// Returns the same state in coordinates.
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

    /// Returns the state with these coordinates.
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

/// Returns a state in coordinates, for generated functions.
#[inline(always)]
pub fn in_coordinates<Q: Coordinates<N>, const N: usize>(state: &State<Q>) -> State<Q::Flat> {
    state.to_coordinates()
}

/// Returns a state with the entries of its configuration in place of the configuration, for
/// generated functions of systems with rotations.
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

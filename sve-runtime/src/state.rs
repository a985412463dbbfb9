//! A point of phase space at a time.
//!
//! Invariant: none is enforced here; every step checks that what it is given is finite.

/// Time, configuration and momentum of a system with `N` degrees of freedom.
///
/// `q` and `p` are in the units of the user's Lagrangian; `p = ∂L/∂v`.
///
/// ```
/// use sve_runtime::prelude::*;
/// let state = State::new([1.0], [0.0]);
/// assert_eq!((state.t, state.q[0], state.p[0]), (0.0, 1.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State<const N: usize> {
    /// Time.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
    pub t: f64,
    /// Configuration, one entry a coordinate.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::array"))]
    pub q: [f64; N],
    /// Momentum `∂L/∂v`, one entry a coordinate.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::array"))]
    pub p: [f64; N],
}

impl<const N: usize> State<N> {
    /// The state `(q, p)` at `t = 0`.
    pub const fn new(q: [f64; N], p: [f64; N]) -> Self {
        Self { t: 0.0, q, p }
    }

    /// The state `(q, p)` at time `t`.
    pub const fn at(t: f64, q: [f64; N], p: [f64; N]) -> Self {
        Self { t, q, p }
    }
}

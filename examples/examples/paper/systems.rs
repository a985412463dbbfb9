//! The three systems of the paper. All steps are derived from these definitions.

use sve_runtime::prelude::*;

/// A pendulum of unit mass and length: `H = p²/2 − g cos q`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pendulum {
    /// Acceleration of gravity.
    pub(crate) g: f64,
}

#[variational(taylor2)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// The stochastic linear oscillator: `dq = p dt`, `dp = −q dt + σ dW`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    /// Strength of the noise.
    pub(crate) sigma: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// The Kubo oscillator, a rotation whose speed is noisy: `dq = p (a dt + σ ∘ dW)`,
/// `dp = −q (a dt + σ ∘ dW)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kubo {
    /// Mean angular velocity.
    pub(crate) a: f64,
    /// Strength of the noise.
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

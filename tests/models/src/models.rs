//! The systems under test: the systems of the paper and some that stress one feature each.

mod banded;
mod constrained;
mod deterministic;
mod forced;
mod noisy;
mod small;
mod surfaces;
mod symmetric;

use sve_comparison::compared;

pub use banded::Rails;
pub use constrained::{OnSphere, TurnedSphere, TwoRods};
pub use deterministic::{
    HenonHeiles, Magnetic, PlanarDoublePendulum, Quartic, Relativistic, SphericalPendulum,
};
pub use forced::{Damped, Rubbed, Sail, Stirred, Towed};
pub use noisy::{Actions, Chain, Clashing, Driven, Mixed, OneMomentum, Polar, Synchrotron};
pub use small::{Bath, Comet, Kicked, Pushed, Rotor};
pub use surfaces::{Breathing, Curved, Ellipsoid, Saddle, Thermal, Torus};
pub use symmetric::{Central, Charges, Kepler, Stretched};

/// L = v²/2 + g cos q.
#[derive(Clone, Debug)]
pub struct Pendulum {
    /// Gravity over length.
    pub g: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Pendulum {
    /// L.
    pub fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0].powi(2) / 2.0 + self.g * q[0].cos()
    }
}

/// L = v²/2 − q²/2, γ = σq.
#[derive(Clone, Debug)]
pub struct Oscillator {
    /// Strength of the noise.
    pub sigma: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Oscillator {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// L = v²/(2a) − a q²/2, H₁ = σ(q²+p²)/2.
#[derive(Clone, Debug)]
pub struct Kubo {
    /// Frequency.
    pub a: f64,
    /// Strength of the noise.
    pub sigma: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Kubo {
    /// L.
    pub fn lagrangian(&self, q: [f64; 1], v: [f64; 1]) -> f64 {
        v[0].powi(2) / (2.0 * self.a) - self.a / 2.0 * q[0].powi(2)
    }

    /// H₁.
    #[h1]
    pub fn jitter(&self, q: [f64; 1], p: [f64; 1]) -> f64 {
        self.sigma / 2.0 * (q[0].powi(2) + p[0].powi(2))
    }
}

/// Angles from the downward vertical, γ = (s sin q₀, s cos q₁).
#[derive(Clone, Debug)]
pub struct DoublePendulum {
    /// Masses.
    pub m: [f64; 2],
    /// Lengths.
    pub l: [f64; 2],
    /// Gravity.
    pub g: f64,
    /// Strength of the noises.
    pub s: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl DoublePendulum {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = self.m;
        let [l1, l2] = self.l;
        let kinetic = 0.5 * (m1 + m2) * l1.powi(2) * v[0].powi(2)
            + 0.5 * m2 * l2.powi(2) * v[1].powi(2)
            + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + (m1 + m2) * self.g * l1 * q[0].cos() + m2 * self.g * l2 * q[1].cos()
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[1].cos()]
    }
}

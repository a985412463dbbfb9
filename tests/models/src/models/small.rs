//! Small systems that several tests use.

use sve_runtime::prelude::*;

/// L = ½v², γ = σq: a momentum that is a Brownian motion; a free particle for σ = 0.
#[derive(Clone, Copy, Debug)]
pub struct Kicked {
    /// Strength of the noise.
    pub sigma: f64,
}

#[variational(midpoint)]
impl Kicked {
    /// L.
    pub fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }

    /// γ.
    #[gamma]
    pub fn kicks(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// L = ½v² + g cos q, γ = sq: a pendulum that is pushed at random.
#[derive(Clone, Copy, Debug)]
pub struct Pushed {
    /// Gravity over length.
    pub g: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Pushed {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: f64) -> f64 {
        self.s * q
    }
}

/// L = ½v² + cos q, H₁ = sp⁴: for a large ΔW a step has no solution.
#[derive(Clone, Copy, Debug)]
pub struct Rotor {
    /// Strength of the noise.
    pub s: f64,
}

#[variational(midpoint)]
impl Rotor {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    /// H₁.
    #[h1]
    pub fn jitter(&self, _q: f64, p: f64) -> f64 {
        self.s * p.powi(4)
    }
}

/// L = ½v² − ½ω²q², F = −νv, γ = σq: an oscillator with friction in a bath.
#[derive(Clone, Copy, Debug)]
pub struct Bath {
    /// Frequency.
    pub omega: f64,
    /// Friction.
    pub nu: f64,
    /// Strength of the noise.
    pub sigma: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Bath {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.omega.powi(2) * q * q
    }

    /// F.
    #[force]
    pub fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    /// γ.
    #[gamma]
    pub fn bath(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// A body that is attracted by the origin, with steps in proportion to r^{3/2}.
#[derive(Clone, Copy, Debug)]
pub struct Comet {
    /// Strength of the attraction.
    pub mu: f64,
}

#[variational(
    midpoint,
    stormer_verlet,
    endpoint,
    initial_point,
    gauss(2),
    gauss(3),
    gauss(8)
)]
impl Comet {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.mu / q[0].hypot(q[1])
    }

    /// s.
    #[time_scale]
    pub fn scale(&self, q: [f64; 2]) -> f64 {
        q[0].hypot(q[1]).powf(1.5)
    }

    /// ξ.
    #[symmetry]
    pub fn turn(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

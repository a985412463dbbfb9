//! Systems with a force, for the rules that their noises allow.

use sve_comparison::compared;

/// A double well in a bath: `L = ½mv² − k(q²−1)²/4`, friction `F = −νmv`, `γ = σq`.
#[derive(Clone, Debug)]
pub struct Damped {
    /// Mass.
    pub m: f64,
    /// Depth of the wells.
    pub k: f64,
    /// Rate of friction.
    pub nu: f64,
    /// Strength of the noise.
    pub sigma: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Damped {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * self.m * v * v - 0.25 * self.k * (q * q - 1.0).powi(2)
    }

    /// F.
    #[force]
    pub fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * self.m * v
    }

    /// γ.
    #[gamma]
    pub fn bath(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// A particle that is dragged and stirred: a force that depends on time, place and, not linearly,
/// on velocity.
#[derive(Clone, Debug)]
pub struct Stirred {
    /// Drag.
    pub c: f64,
    /// Rate of stirring.
    pub w: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Stirred {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (1.0 + 0.3 * q[0].sin()) * v[0].powi(2) + 0.7 * v[1].powi(2)
            - 0.5 * (q[0] - q[1]).powi(2)
            - 0.25 * q[1].powi(4)
    }

    /// F, the drag.
    #[force]
    pub fn drag(&self, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let speed = (1.0 + v[0].powi(2) + v[1].powi(2)).sqrt();
        let c = self.c * (1.0 + 0.5 * q[1].cos());
        [-c * speed * v[0], -c * speed * v[1]]
    }

    /// F, the stirring.
    #[force]
    pub fn stir(&self, t: f64, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        [-self.w * q[1] * t.cos(), self.w * q[0]]
    }
}

/// A force beside noises in both positions and momenta and a mass that depends on q.
#[derive(Clone, Debug)]
pub struct Towed {
    /// Drag along each coordinate.
    pub c: [f64; 2],
    /// Strengths of the noises.
    pub s: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Towed {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let coupling = 0.2 * (q[0] + q[1]).cos() * v[0] * v[1];
        0.5 * (1.5 + q[1].sin()) * v[0].powi(2) + 0.5 * v[1].powi(2) + coupling
            - 0.5 * q[0].powi(2)
            - q[1].cosh()
    }

    /// F.
    #[force]
    pub fn tow(&self, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [
            0.3 - self.c[0] * v[0],
            -self.c[1] * v[1] * (1.0 + q[0].powi(2)),
        ]
    }

    /// H₁.
    #[h1]
    pub fn jitter(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.s[0] * (q[0].sin() * p[1] + 0.5 * p[0].powi(2))
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: [f64; 2]) -> f64 {
        self.s[1] * q[0] * q[1]
    }
}

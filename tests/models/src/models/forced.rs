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

/// A sail: gusts that no potential gives and that depend on time and on the velocity, beside noises
/// in positions and momenta, a force, and masses that depend on q.
#[derive(Clone, Debug)]
pub struct Sail {
    /// Drag.
    pub c: f64,
    /// Strengths of the noises.
    pub s: [f64; 3],
}

#[compared(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(3),
    gauss(4)
)]
impl Sail {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let coupling = 0.2 * (q[0] + q[1]).cos() * v[0] * v[1];
        0.5 * (1.5 + q[1].sin()) * v[0].powi(2) + 0.5 * v[1].powi(2) + coupling
            - 0.5 * q[0].powi(2)
            - q[1].cosh()
    }

    /// F.
    #[force]
    pub fn drag(&self, _q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [-self.c * v[0], -self.c * v[1].powi(3)]
    }

    /// f, the third noise.
    #[force(noise)]
    pub fn gust(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        let wind = self.s[2] * (1.0 + 0.3 * t.sin());
        [
            wind * (q[1] - v[0]),
            wind * (q[0] * v[1] - 0.5 * q[0].sin()),
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

/// An oscillator whose friction is noisy: `f = σp`, which commutes with itself, twice.
#[derive(Clone, Debug)]
pub struct Rubbed {
    /// Mass.
    pub m: f64,
    /// Strengths of the noises.
    pub s: [f64; 2],
}

#[compared(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(3),
    gauss(4)
)]
impl Rubbed {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * self.m * v * v - 0.5 * q * q
    }

    /// f of the first noise.
    #[force(noise)]
    pub fn rub(&self, _q: f64, v: f64) -> f64 {
        self.s[0] * self.m * v
    }

    /// f of the second noise.
    #[force(noise)]
    pub fn grind(&self, _q: f64, v: f64) -> f64 {
        self.s[1] * self.m * v
    }
}

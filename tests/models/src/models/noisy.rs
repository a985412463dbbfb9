//! Systems with noise, for the three one-node rules.

use sve_comparison::compared;

/// A coupled mass matrix that depends on q, with noises in momentum and in position.
#[derive(Clone, Debug)]
pub struct Mixed {
    /// Coupling of the masses.
    pub c: f64,
    /// Strengths of the noises.
    pub s: [f64; 3],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Mixed {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        let kinetic = 0.5 * (1.5 + y.sin()) * v[0].powi(2)
            + 0.5 * (1.0 + x.powi(2)) * v[1].powi(2)
            + self.c * (x + y).cos() * v[0] * v[1];
        kinetic - 0.5 * x.powi(2) - 0.25 * y.powi(4)
    }

    /// H₁ of two processes.
    #[h1]
    pub fn drag(&self, q: [f64; 2], p: [f64; 2]) -> [f64; 2] {
        [
            self.s[0] * (q[0].sin() * p[1] + 0.5 * p[0].powi(2)),
            self.s[1] * (p[0] * p[1] + q[1] * q[0]),
        ]
    }

    /// γ of one process.
    #[gamma]
    pub fn push(&self, q: [f64; 2]) -> f64 {
        self.s[2] * (q[0] * q[1] + q[1].cos())
    }
}

/// A planet in polar coordinates, whose units differ: `L = ½m(ṙ² + r²θ̇²) + k/r`,
/// `γ = σ₁ r cos θ`, `H₁ = σ₂ p_r p_θ / r`.
#[derive(Clone, Debug)]
pub struct Polar {
    /// Mass.
    pub m: f64,
    /// Attraction.
    pub k: f64,
    /// Strengths of the noises.
    pub sigma: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Polar {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m * (v[0].powi(2) + (q[0] * v[1]).powi(2)) + self.k / q[0]
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma[0] * q[0] * q[1].cos()
    }

    /// H₁.
    #[h1]
    pub fn turn(&self, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.sigma[1] * p[0] * p[1] / q[0]
    }
}

/// An oscillator with friction, L = eᶜᵗ(½v² − ½kq²) + b t q²v, and noises that depend on time.
#[derive(Clone, Debug)]
pub struct Driven {
    /// Friction.
    pub c: f64,
    /// Stiffness.
    pub k: f64,
    /// Strength of the term in v.
    pub b: f64,
    /// Strengths of the noises.
    pub sigma: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Driven {
    /// L.
    pub fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        (self.c * t).exp() * (0.5 * v * v - 0.5 * self.k * q * q) + self.b * t * q * q * v
    }

    /// γ.
    #[gamma]
    pub fn push(&self, t: f64, q: f64) -> f64 {
        self.sigma[0] * t.cos() * q.sin()
    }

    /// H₁.
    #[h1]
    pub fn jitter(&self, t: f64, q: f64, p: f64) -> f64 {
        self.sigma[1] * (1.0 + t.powi(2)).ln() * p * (q + 0.2 * p)
    }
}

/// Particles in a synchrotron (Seeßelberg et al. 1994): L = ½v² + ω² cos q, γ = (σ₁ sin q, σ₂ cos
/// q).
#[derive(Clone, Debug)]
pub struct Synchrotron {
    /// Frequency.
    pub omega: f64,
    /// Strengths of the noises.
    pub sigma: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Synchrotron {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v.powi(2) + self.omega.powi(2) * q.cos()
    }

    /// γ of one process.
    #[gamma]
    pub fn phase(&self, q: f64) -> f64 {
        self.sigma[0] * q.sin()
    }

    /// γ of another process.
    #[gamma]
    pub fn amplitude(&self, q: f64) -> f64 {
        self.sigma[1] * q.cos()
    }
}

/// H = aI with H₁ = (σ₁I, σ₂I²), I = (q² + p²)/2: two commuting noises, and an exact solution.
#[derive(Clone, Debug)]
pub struct Actions {
    /// Frequency.
    pub a: f64,
    /// Strengths of the noises.
    pub sigma: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Actions {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v.powi(2) / (2.0 * self.a) - self.a / 2.0 * q.powi(2)
    }

    fn action(q: f64, p: f64) -> f64 {
        0.5 * (q.powi(2) + p.powi(2))
    }

    /// H₁ of two processes.
    #[h1]
    pub fn jitter(&self, q: f64, p: f64) -> [f64; 2] {
        let action = Self::action(q, p);
        [self.sigma[0] * action, self.sigma[1] * action.powi(2)]
    }
}

/// Two noises that do not commute: L = ½v² − ½q², γ = σ₁ sin q, H₁ = σ₂qp.
#[derive(Clone, Debug)]
pub struct Clashing {
    /// Strengths of the noises.
    pub sigma: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Clashing {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v.powi(2) - 0.5 * q.powi(2)
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: f64) -> f64 {
        self.sigma[0] * q.sin()
    }

    /// H₁.
    #[h1]
    pub fn stretch(&self, q: f64, p: f64) -> f64 {
        self.sigma[1] * q * p
    }
}

/// A free chain of masses with anharmonic springs; spring 2 is shaken. Total momentum is conserved.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Masses.
    pub m: [f64; 6],
    /// Stiffness.
    pub k: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Chain {
    const LENGTH: usize = 6;
    const HARDENING: f64 = 0.3;

    fn spring(&self, stretch: f64) -> f64 {
        self.k * (0.5 * stretch.powi(2) + Self::HARDENING / 4.0 * stretch.powi(4))
    }

    /// L.
    pub fn lagrangian(&self, q: [f64; 6], v: [f64; 6]) -> f64 {
        let mut l = 0.0;
        for i in 0..Self::LENGTH {
            l += 0.5 * self.m[i] * v[i].powi(2);
        }
        for i in 1..Self::LENGTH {
            l -= self.spring(q[i] - q[i - 1]);
        }
        l
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: [f64; 6]) -> f64 {
        self.s * (q[3] - q[2]).sin()
    }

    /// ξ, the shift of the whole chain.
    #[symmetry]
    pub fn shift(&self, _q: [f64; 6]) -> [f64; 6] {
        [1.0; Self::LENGTH]
    }
}

/// Three coordinates. Only the momentum of one coordinate feels a noise.
#[derive(Clone, Debug)]
pub struct OneMomentum {
    /// Strengths of the noises.
    pub s: [f64; 2],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl OneMomentum {
    /// L.
    pub fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let [x, y, z] = q;
        0.5 * (v[0].powi(2) + 2.0 * v[1].powi(2) + 3.0 * v[2].powi(2)) + x.cos() * y.cos()
            - 0.5 * z.powi(2) * (1.0 + x.powi(2))
    }

    /// H₁.
    #[h1]
    pub fn drag(&self, q: [f64; 3], p: [f64; 3]) -> f64 {
        self.s[0] * p[1] * (q[0] + 0.5 * q[1].sin())
    }

    /// γ.
    #[gamma]
    pub fn push(&self, q: [f64; 3]) -> f64 {
        self.s[1] * q[2] * q[1]
    }
}

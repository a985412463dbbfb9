//! Systems for weak orders whose second moments obey linear equations, some after a change of
//! coordinates.

use sve_runtime::prelude::*;

/// An oscillator whose stiffness is noisy: γ = ½σq², the noise strength a function of time, with
/// friction.
#[derive(Clone)]
pub(crate) struct Parametric {
    pub(crate) sigma: f64,
    /// Part of the noise that oscillates in time.
    pub(crate) beat: f64,
    pub(crate) friction: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2),
    gauss(4, weak2),
    gauss(2, stage_noise),
    gauss(2, stage_noise, weak2)
)]
impl Parametric {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    pub(crate) fn stiffness(&self, t: f64, q: f64) -> f64 {
        0.5 * self.sigma * (1.0 + self.beat * (2.0 * t).sin()) * q * q
    }

    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -self.friction * v
    }
}

/// Two coordinates that the masses couple, with two noises: L = ½v₀² + v₁² + ½v₀v₁ − ½q₀² − q₁².
#[derive(Clone)]
pub(crate) struct Coupled {
    pub(crate) sigma: [f64; 2],
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2)
)]
impl Coupled {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * v[0] * v[0] + v[1] * v[1] + 0.5 * v[0] * v[1] - 0.5 * q[0] * q[0] - q[1] * q[1]
    }

    #[gamma]
    fn stiffness(&self, q: [f64; 2]) -> [f64; 2] {
        [
            0.5 * self.sigma[0] * q[0] * q[0],
            self.sigma[1] * q[1] * (q[0] - 0.5 * q[1]),
        ]
    }
}

/// H = ½wp² + ½kq² with H₁ = (½(aq² + bp²), cqp).
#[derive(Clone)]
pub(crate) struct Quadratic {
    pub(crate) w: f64,
    pub(crate) k: f64,
    pub(crate) noise: [f64; 3],
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Quadratic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v / self.w - 0.5 * self.k * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> [f64; 2] {
        let [a, b, c] = self.noise;
        [0.5 * (a * q * q + b * p * p), c * q * p]
    }
}

/// H = ½(p² + q²) with H₁ = σ(t)·½(aq² + bp²) for two σ, which commute with one another and not
/// with H.
#[derive(Clone)]
pub(crate) struct Squeezed {
    pub(crate) sigma: [f64; 2],
    pub(crate) a: f64,
    pub(crate) b: f64,
    /// Part of the first noise that oscillates in time.
    pub(crate) beat: f64,
}

#[variational(midpoint, gauss(2), gauss(2, weak2), gauss(3, weak2), gauss(4, weak2))]
impl Squeezed {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, t: f64, q: f64, p: f64) -> [f64; 2] {
        let invariant = 0.5 * (self.a * q * q + self.b * p * p);
        let [first, second] = self.strengths(t);
        [first * invariant, second * invariant]
    }

    pub(crate) fn strengths(&self, t: f64) -> [f64; 2] {
        [
            self.sigma[0] * (1.0 + self.beat * (2.0 * t).sin()),
            self.sigma[1],
        ]
    }
}

/// H = ½wp² + ½kq² with H₁ = ½(aq² + bp²) and the friction −νp.
#[derive(Clone)]
pub(crate) struct Damped {
    pub(crate) w: f64,
    pub(crate) k: f64,
    pub(crate) a: f64,
    pub(crate) b: f64,
    pub(crate) nu: f64,
}

#[variational(gauss(2))]
impl Damped {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v / self.w - 0.5 * self.k * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * (self.a * q * q + self.b * p * p)
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v / self.w
    }
}

/// The oscillator x with γ = ½σx², in the coordinate q whose mass is 1 + q²/4.
#[derive(Clone)]
pub(crate) struct Heavy {
    pub(crate) sigma: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2),
    gauss(2, stage_noise),
    gauss(2, stage_noise, weak2)
)]
impl Heavy {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (1.0 + 0.25 * q * q) * v * v - 0.5 * self.x(q).powi(2)
    }

    /// ∫√(1 + q²/4) dq.
    pub(crate) fn x(&self, q: f64) -> f64 {
        0.5 * q * (1.0 + 0.25 * q * q).sqrt() + (0.5 * q).asinh()
    }

    #[gamma]
    fn stiffness(&self, q: f64) -> f64 {
        0.5 * self.sigma * self.x(q).powi(2)
    }
}

impl Heavy {
    /// Second moments of x and its velocity.
    pub(crate) fn moments(&self, state: &State<[f64; 1]>) -> Vec<f64> {
        let x = self.x(state.q[0]);
        let velocity = state.p[0] / (1.0 + 0.25 * state.q[0].powi(2)).sqrt();
        products(&[x, velocity])
    }
}

/// Two oscillators x₀ = q₀ + ⅕q₁², x₁ = q₁ + ³⁄₁₀ sin q₀ with γ = ½σx₀(x₀ + x₁): in q the mass
/// matrix is full and depends on q.
#[derive(Clone)]
pub(crate) struct Bent {
    pub(crate) sigma: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    midpoint(weak2),
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2),
    gauss(2, weak2)
)]
impl Bent {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let velocity = [v[0] + 0.4 * q[1] * v[1], v[1] + 0.3 * q[0].cos() * v[0]];
        let x = self.x(q);
        0.5 * (velocity[0].powi(2) + velocity[1].powi(2)) - 0.5 * x[0].powi(2) - x[1].powi(2)
    }

    fn x(&self, q: [f64; 2]) -> [f64; 2] {
        [q[0] + 0.2 * q[1].powi(2), q[1] + 0.3 * q[0].sin()]
    }

    #[gamma]
    fn stiffness(&self, q: [f64; 2]) -> f64 {
        let x = self.x(q);
        0.5 * self.sigma * x[0] * (x[0] + x[1])
    }
}

impl Bent {
    /// Second moments of x and its velocity, which p = (∂x/∂q)ᵀ ẋ gives.
    pub(crate) fn moments(&self, state: &State<[f64; 2]>) -> Vec<f64> {
        let (q, p) = (state.q, state.p);
        let (a, b) = (0.4 * q[1], 0.3 * q[0].cos());
        let determinant = 1.0 - a * b;
        let velocity = [
            (p[0] - b * p[1]) / determinant,
            (p[1] - a * p[0]) / determinant,
        ];
        let x = self.x(q);
        products(&[x[0], x[1], velocity[0], velocity[1]])
    }
}

/// The oscillator with γ = ½σq² and the friction −νv³, whose potential the attribute would refuse:
/// the Lagrangian has it for steps of the size `h`.
#[derive(Clone)]
pub(crate) struct CubicFriction {
    pub(crate) sigma: f64,
    pub(crate) nu: f64,
    pub(crate) h: f64,
}

#[variational(midpoint)]
impl CubicFriction {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        let term = self.h / 8.0 * (self.sigma * q).powi(2);
        0.5 * v * v - 0.5 * q * q - term
    }

    #[gamma]
    fn stiffness(&self, q: f64) -> f64 {
        0.5 * self.sigma * q * q
    }

    #[force]
    fn drag(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v.powi(3)
    }
}

/// All products of two entries.
pub(crate) fn products(z: &[f64]) -> Vec<f64> {
    z.iter()
        .flat_map(|a| z.iter().map(move |b| a * b))
        .collect()
}

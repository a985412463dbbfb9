//! Systems of these tests, each with one feature that the equations of the stages have to treat.

use sve_comparison::compared_with_derivatives;
use sve_runtime::prelude::*;

/// L = v²/2 + g cos q: of second order.
#[derive(Clone, Debug)]
pub(crate) struct Pendulum {
    pub(crate) g: f64,
}

#[variational(gauss(2), gauss(3), gauss(4), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Angles from the downward vertical, γ = (s sin q₀, s cos q₁): masses that depend on the position.
#[derive(Clone, Debug)]
pub(crate) struct DoublePendulum {
    pub(crate) m: [f64; 2],
    pub(crate) l: [f64; 2],
    pub(crate) g: f64,
    pub(crate) s: f64,
}

#[variational(
    gauss(2),
    gauss(3),
    gauss(4),
    gauss(8),
    gauss(2, stage_noise),
    gauss(3, stage_noise),
    gauss(8, stage_noise)
)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m1, m2] = self.m;
        let [l1, l2] = self.l;
        let kinetic = 0.5 * (m1 + m2) * l1.powi(2) * v[0].powi(2)
            + 0.5 * m2 * l2.powi(2) * v[1].powi(2)
            + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + (m1 + m2) * self.g * l1 * q[0].cos() + m2 * self.g * l2 * q[1].cos()
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[1].cos()]
    }
}

/// L = v²/(2a) − a q²/2, H₁ = σ(q²+p²)/2: a noise that moves the position.
#[derive(Clone, Debug)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

#[variational(
    gauss(2),
    gauss(3),
    gauss(8),
    gauss(2, stage_noise),
    gauss(3, stage_noise),
    gauss(8, stage_noise)
)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

/// L = (1 + q²/4) v²/2 − q²/2 − q⁴/4: a mass that depends on the position.
#[derive(Clone, Debug)]
pub(crate) struct VariableMass;

#[variational(gauss(2), gauss(3), gauss(4), gauss(8))]
impl VariableMass {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * (1.0 + 0.25 * q * q) * v * v - 0.5 * q * q - 0.25 * q.powi(4)
    }
}

/// A relativistic particle in a trough: ∂L/∂v is not affine in v.
#[derive(Clone, Debug)]
pub(crate) struct Relativistic {
    pub(crate) m: f64,
    pub(crate) c: f64,
    pub(crate) k: f64,
}

#[variational(gauss(3), gauss(4))]
impl Relativistic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        let rest = self.m * self.c * self.c;
        -rest * (1.0 - v * v / (self.c * self.c)).sqrt() - 0.25 * self.k * q.powi(4)
    }
}

/// Everything at once: masses that depend on position and time, a magnetic term, a force with
/// friction, a γ and an H₁ that depend on time.
#[derive(Clone, Debug)]
pub(crate) struct Everything {
    pub(crate) m: f64,
    pub(crate) b: f64,
    pub(crate) k: f64,
    pub(crate) nu: f64,
    pub(crate) sigma: [f64; 2],
}

#[compared_with_derivatives(gauss(2), gauss(4))]
impl Everything {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mass = self.m * (1.0 + 0.1 * t.sin()) + 0.25 * q[1] * q[1];
        0.5 * mass * v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + 0.2 * v[0] * v[1]
            + self.b * (q[0] * v[1] - q[1] * v[0])
            - self.k * (q[0] * q[0] + (q[1] - 0.3 * q[0]).powi(4))
    }

    #[force]
    fn friction(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> [f64; 2] {
        [
            -self.nu * v[0] + 0.1 * t.cos(),
            -self.nu * v[1] * (1.0 + q[0] * q[0]),
        ]
    }

    #[gamma]
    fn push(&self, t: f64, q: [f64; 2]) -> f64 {
        self.sigma[0] * (q[0] + 0.5 * q[1] * q[1]) * (1.0 + 0.3 * t)
    }

    #[h1]
    fn drag(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> f64 {
        self.sigma[1] * (0.5 * p[0] * p[0] + p[1] * q[0].sin() * (1.0 - 0.2 * t))
    }
}

/// A body in a central field that is shaken along its radius: the angular momentum is conserved.
#[derive(Clone, Debug)]
pub(crate) struct Central {
    pub(crate) m: f64,
    pub(crate) s: f64,
}

#[variational(gauss(3), gauss(4))]
impl Central {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r2 = q[0] * q[0] + q[1] * q[1];
        0.5 * self.m * (v[0] * v[0] + v[1] * v[1]) * (1.0 + 0.1 * r2) + 1.0 / (0.1 + r2).sqrt()
    }

    #[gamma]
    fn shake(&self, q: [f64; 2]) -> f64 {
        self.s * (q[0] * q[0] + q[1] * q[1])
    }

    #[symmetry]
    pub(crate) fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

/// Two coupled wells with a force and a noise of the position alone: of second order, with a mass
/// matrix that is not diagonal.
#[derive(Clone, Debug)]
pub(crate) struct Wells {
    pub(crate) m: [f64; 3],
    pub(crate) sigma: f64,
}

#[compared_with_derivatives(gauss(4))]
impl Wells {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [m0, m1, m2] = self.m;
        0.5 * m0 * v[0] * v[0] + 0.5 * m1 * v[1] * v[1] + m2 * v[0] * v[1]
            - 0.25 * (q[0] * q[0] - 1.0).powi(2)
            - (1.0 + 0.1 * t) * (q[0] - q[1]).cosh()
    }

    #[force]
    fn wind(&self, t: f64, q: [f64; 2], _v: [f64; 2]) -> [f64; 2] {
        [0.2 * t.cos(), -0.1 * q[0]]
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0].sin() * q[1]
    }
}

/// A ring of 20 coupled pendulums: as many unknowns as the stages of a rule may have.
#[derive(Clone, Debug)]
pub(crate) struct Ring;

#[variational(gauss(8))]
impl Ring {
    fn lagrangian(&self, q: [f64; 20], v: [f64; 20]) -> f64 {
        let mut sum = 0.0;
        for i in 0..20 {
            sum += 0.5 * v[i] * v[i] + q[i].cos() + (q[i] - q[(i + 1) % 20]).cos();
        }
        sum
    }
}

/// L = v²/2 + ln q: defined for q > 0 only.
#[derive(Clone, Debug)]
pub(crate) struct Logarithmic;

#[variational(gauss(2), gauss(4))]
impl Logarithmic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.ln()
    }
}

impl Everything {
    pub(crate) fn with_parameters([m, b, k, nu, s0, s1]: [f64; 6]) -> Self {
        let sigma = [s0, s1];
        Self { m, b, k, nu, sigma }
    }
}

pub(crate) fn pendulum() -> Pendulum {
    Pendulum { g: 1.0 }
}

pub(crate) fn double_pendulum() -> DoublePendulum {
    DoublePendulum {
        m: [1.0, 0.5],
        l: [1.0, 0.7],
        g: 1.0,
        s: 0.3,
    }
}

pub(crate) fn wells() -> Wells {
    Wells {
        m: [1.2, 0.8, 0.3],
        sigma: 0.4,
    }
}

pub(crate) fn everything() -> Everything {
    Everything::with_parameters([1.3, 0.4, 0.8, 0.3, 0.5, 0.4])
}

//! Systems of these tests, each with one feature that the equations of the stages have to treat.

use sve_runtime::prelude::*;

/// L = v²/2 + g cos q: of second order.
#[derive(Clone, Debug)]
pub struct Pendulum {
    pub g: f64,
}

#[variational(gauss(2), gauss(3), gauss(4), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// Angles from the downward vertical, γ = (s sin q₀, s cos q₁): masses that depend on the position.
#[derive(Clone, Debug)]
pub struct DoublePendulum {
    pub m: [f64; 2],
    pub l: [f64; 2],
    pub g: f64,
    pub s: f64,
}

#[variational(gauss(2), gauss(3), gauss(4), gauss(8))]
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
pub struct Kubo {
    pub a: f64,
    pub sigma: f64,
}

#[variational(gauss(2), gauss(3), gauss(8))]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

//! Systems with the option `weak2` whose noise moves the position.

use sve_comparison::compared_with_derivatives;
use sve_runtime::prelude::*;

/// H = ½p²w + ½kq² with H₁ = ½(aq² + bp²).
#[derive(Clone)]
pub(crate) struct Quadratic {
    pub(crate) w: f64,
    pub(crate) k: f64,
    pub(crate) a: f64,
    pub(crate) b: f64,
}

#[variational(
    gauss(2),
    gauss(3),
    gauss(4),
    gauss(2, weak2),
    gauss(3, weak2),
    gauss(4, weak2)
)]
impl Quadratic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v / self.w - 0.5 * self.k * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * (self.a * q * q + self.b * p * p)
    }
}

/// Two functions of one invariant move position and momentum, with a mass that depends on the
/// position, a vector potential, and time.
#[derive(Clone)]
pub(crate) struct Stretched {
    pub(crate) s: [f64; 2],
    pub(crate) m: f64,
}

#[compared_with_derivatives(gauss(2, weak2), gauss(4, weak2))]
impl Stretched {
    fn lagrangian(&self, t: f64, q: f64, v: f64) -> f64 {
        0.5 * (self.m + 0.5 * q * q) * v * v + self.m * q * q * v + q.cos() * (1.0 + 0.2 * t)
    }

    #[h1]
    fn jitter(&self, t: f64, q: f64, p: f64) -> [f64; 2] {
        let invariant = q * p;
        [
            self.s[0] * (1.0 + 0.5 * t) * invariant,
            self.s[1] * invariant * invariant,
        ]
    }
}

/// The same with two coordinates and coupled masses.
#[derive(Clone)]
pub(crate) struct Moved {
    pub(crate) s: [f64; 2],
    pub(crate) m: f64,
}

#[variational(gauss(2, weak2), gauss(3, weak2), gauss(4, weak2))]
impl Moved {
    fn lagrangian(&self, t: f64, q: [f64; 2], v: [f64; 2]) -> f64 {
        let mass = self.m + 0.5 * q[0].sin();
        0.5 * mass * v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + 0.3 * v[0] * v[1]
            + self.m * q[1] * v[0]
            + q[0].cos() * (1.0 + 0.2 * t.sin())
            - 0.5 * q[1] * q[1]
    }

    #[h1]
    fn jitter(&self, t: f64, q: [f64; 2], p: [f64; 2]) -> [f64; 2] {
        let invariant = q[0] * p[1] - q[1] * p[0];
        [
            self.s[0] * (1.0 + 0.5 * t.sin()) * invariant,
            self.s[1] * invariant * invariant,
        ]
    }
}

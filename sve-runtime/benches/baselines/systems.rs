//! Systems of the benchmark, each with its field written by hand.

use sve_runtime::prelude::*;

/// The field of a system written by hand, for an increment of time and one of the noise.
pub(crate) trait Field<const D: usize>: Copy {
    /// Returns h f(z) + g(z) ΔW, in the sense of Stratonovich.
    fn euler(self, z: [f64; D], h: f64, dw: f64) -> [f64; D];
    /// Returns the Itô correction, times h.
    #[inline(always)]
    fn correction(self, _z: [f64; D], _h: f64) -> [f64; D] {
        [0.0; D]
    }
}

pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - 0.5 * self.a * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

#[derive(Clone, Copy)]
pub(crate) struct KuboByHand {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

impl Field<2> for KuboByHand {
    #[inline(always)]
    fn euler(self, [q, p]: [f64; 2], h: f64, dw: f64) -> [f64; 2] {
        let x = self.a * h + self.sigma * dw;
        [x * p, -x * q]
    }

    #[inline(always)]
    fn correction(self, [q, p]: [f64; 2], h: f64) -> [f64; 2] {
        let c = -0.5 * self.sigma * self.sigma * h;
        [c * q, c * p]
    }
}

pub(crate) struct HenonHeiles {
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y * y * y / 3.0
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0] * q[1]
    }
}

#[derive(Clone, Copy)]
pub(crate) struct HenonHeilesByHand {
    pub(crate) sigma: f64,
}

impl Field<4> for HenonHeilesByHand {
    #[inline(always)]
    fn euler(self, [x, y, u, w]: [f64; 4], h: f64, dw: f64) -> [f64; 4] {
        let s = self.sigma * dw;
        [
            h * u,
            h * w,
            h * (-x - 2.0 * x * y) + s * y,
            h * (y * y - y - x * x) + s * x,
        ]
    }
}

/// Two oscillators whose masses are coupled: a mass matrix that is constant and dense.
pub(crate) struct Coupled {
    pub(crate) m: [f64; 2],
    pub(crate) c: f64,
    pub(crate) k: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Coupled {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (self.m[0] * v[0] * v[0] + self.m[1] * v[1] * v[1]) + self.c * v[0] * v[1]
            - 0.5 * self.k * (q[0] * q[0] + q[1] * q[1])
            - 0.25 * q[0].powi(4)
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[0]
    }
}

#[derive(Clone, Copy)]
pub(crate) struct CoupledByHand {
    /// Entries of the inverse mass matrix.
    pub(crate) inverse: [f64; 3],
    pub(crate) k: f64,
    pub(crate) sigma: f64,
}

impl CoupledByHand {
    pub(crate) fn new(system: &Coupled) -> Self {
        let Coupled { m, c, k, sigma } = *system;
        let det = m[0] * m[1] - c * c;
        let inverse = [m[1] / det, -c / det, m[0] / det];
        Self { inverse, k, sigma }
    }
}

impl Field<4> for CoupledByHand {
    #[inline(always)]
    fn euler(self, [x, y, u, w]: [f64; 4], h: f64, dw: f64) -> [f64; 4] {
        let [a, b, c] = self.inverse;
        [
            h * (a * u + b * w),
            h * (b * u + c * w),
            h * (-self.k * x - x * x * x) + self.sigma * dw,
            -h * self.k * y,
        ]
    }
}

/// The double pendulum with rods and masses of unit size: a mass matrix that depends on q.
pub(crate) struct DoublePendulum {
    pub(crate) g: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + v[0] * v[1] * (q[0] - q[1]).cos()
            + self.g * (2.0 * q[0].cos() + q[1].cos())
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * (q[0] + q[1])
    }
}

/// The double pendulum without noise.
pub(crate) struct QuietPendulum {
    pub(crate) g: f64,
}

#[variational(midpoint)]
impl QuietPendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        v[0] * v[0]
            + 0.5 * v[1] * v[1]
            + v[0] * v[1] * (q[0] - q[1]).cos()
            + self.g * (2.0 * q[0].cos() + q[1].cos())
    }
}

#[derive(Clone, Copy)]
pub(crate) struct DoublePendulumByHand {
    pub(crate) g: f64,
    pub(crate) sigma: f64,
}

impl Field<4> for DoublePendulumByHand {
    #[inline(always)]
    fn euler(self, [a, b, p, r]: [f64; 4], h: f64, dw: f64) -> [f64; 4] {
        let (sin, cos) = (a - b).sin_cos();
        let inverse = 1.0 / (2.0 - cos * cos);
        let (v, w) = ((p - cos * r) * inverse, (2.0 * r - cos * p) * inverse);
        let coupling = v * w * sin;
        let kick = self.sigma * dw;
        [
            h * v,
            h * w,
            h * (-coupling - 2.0 * self.g * a.sin()) + kick,
            h * (coupling - self.g * b.sin()) + kick,
        ]
    }
}

/// A particle in polar coordinates: a diagonal mass matrix that depends on q.
pub(crate) struct Polar {
    pub(crate) m: f64,
    pub(crate) k: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Polar {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * self.m * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) - 0.5 * self.k * q[0] * q[0]
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        self.sigma * q[1]
    }
}

#[derive(Clone, Copy)]
pub(crate) struct PolarByHand {
    /// The inverse mass 1/m.
    pub(crate) inverse: f64,
    pub(crate) k: f64,
    pub(crate) sigma: f64,
}

impl Field<4> for PolarByHand {
    #[inline(always)]
    fn euler(self, [r, _, p, l]: [f64; 4], h: f64, dw: f64) -> [f64; 4] {
        let w = l * self.inverse / (r * r);
        [
            h * self.inverse * p,
            h * w,
            h * (l * w / r - self.k * r),
            self.sigma * dw,
        ]
    }
}

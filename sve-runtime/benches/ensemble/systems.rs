//! The systems of the tasks, derived.

use sve_runtime::prelude::*;

/// The linear oscillator of task A.
#[derive(Clone, Copy)]
pub(crate) struct Oscillator {
    pub(crate) sigma: f64,
}

#[variational(endpoint)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// The Kubo oscillator of task B.
#[derive(Clone, Copy)]
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

/// A pendulum without noise.
#[derive(Clone, Copy)]
pub(crate) struct Pendulum {
    pub(crate) g: f64,
}

#[variational(midpoint)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// A double pendulum without noise.
#[derive(Clone, Copy)]
pub(crate) struct DoublePendulum {
    pub(crate) m: [f64; 2],
    pub(crate) l: [f64; 2],
    pub(crate) g: f64,
}

#[variational(midpoint)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let ([m1, m2], [l1, l2], g) = (self.m, self.l, self.g);
        0.5 * (m1 + m2) * l1.powi(2) * v[0].powi(2)
            + 0.5 * m2 * l2.powi(2) * v[1].powi(2)
            + m2 * l1 * l2 * v[0] * v[1] * (q[0] - q[1]).cos()
            + (m1 + m2) * g * l1 * q[0].cos()
            + m2 * g * l2 * q[1].cos()
    }
}

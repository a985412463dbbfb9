//! Scenes that the tests of the runtime do not have: with friction, sums that enter formulas, drags
//! and H₁, and for the midpoint rule with noise.

use sve_runtime::prelude::*;

/// A chain of wells with masses of its own, and a noise at each site.
pub(crate) struct Chain {
    pub(crate) mass: Vec<f64>,
    pub(crate) sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Chain {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * self.mass[i] * v[i] * v[i] - 0.25 * (q[i] * q[i] - 1.0).powi(2);
        }
        for i in 1..q.len() {
            l -= 0.5 * (q[i] - q[i - 1]).powi(2);
        }
        l
    }
    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * (q + 0.1 * q * q)).collect()
    }
}

/// A ring with springs that are not linear, and a friction.
pub(crate) struct Ring {
    pub(crate) beta: f64,
    pub(crate) nu: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Ring {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            let d = q[(i + 1) % n] - q[i];
            l += 0.5 * v[i] * v[i] - 0.5 * d * d - 0.25 * self.beta * d.powi(4);
        }
        l
    }
    #[force]
    fn friction(&self, _q: &[f64], v: &[f64]) -> Vec<f64> {
        v.iter().map(|v| -self.nu * v).collect()
    }
}

/// Rotors that their mean turns, and a noise between neighbours.
pub(crate) struct Rotors {
    pub(crate) coupling: f64,
    pub(crate) sigma: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Rotors {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let x = q.iter().map(|q| q.cos()).sum::<f64>();
        let y = q.iter().map(|q| q.sin()).sum::<f64>();
        let field = 0.5 * self.coupling * (x * x + y * y) / q.len() as f64;
        v.iter().map(|v| 0.5 * v * v).sum::<f64>() + field
    }
    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        (1..q.len())
            .map(|i| self.sigma * (q[i] - q[i - 1]).sin())
            .collect()
    }
}

/// A chain with a drag between neighbours, and a noise that moves its sites.
pub(crate) struct Dragged {
    pub(crate) sigma: f64,
}

#[variational(stormer_verlet)]
impl Dragged {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let n = q.len();
        let mut l = 0.0;
        for i in 0..n {
            l += 0.5 * v[i] * v[i] - 0.25 * (q[(i + 1) % n] - q[i]).powi(2);
        }
        l
    }
    #[h1]
    fn shake(&self, q: &[f64], p: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| self.sigma * p[i] * q[i] / (1.0 + q[i] * q[i]))
            .collect()
    }
    #[force]
    fn drag(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        (0..q.len())
            .map(|i| {
                let d = v[(i + 1) % q.len()] - v[i];
                0.1 * d / (1.0 + d * d)
            })
            .collect()
    }
}

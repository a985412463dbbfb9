//! Scenes of each kind: with loops that are gathered and loops that are made as they are written,
//! with and without noise.

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

/// A lattice, open in one direction and periodic in the other.
pub(crate) struct Lattice {
    pub(crate) width: usize,
    pub(crate) k: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Lattice {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let height = q.len() / self.width;
        let mut l = 0.0;
        for i in 0..height {
            for j in 0..self.width {
                let c = i * self.width + j;
                let right = i * self.width + (j + 1) % self.width;
                l += 0.5 * v[c] * v[c] - 0.25 * q[c].powi(4);
                l -= 0.5 * self.k * (q[right] - q[c]).powi(2);
                if i + 1 < height {
                    l -= 0.3 * (q[c + self.width] - q[c]).powi(2);
                }
            }
        }
        l
    }
}

/// Molecules in a well, with a list of bonds that has runs, and a noise of each component.
pub(crate) struct Molecules {
    pub(crate) bonds: Vec<[usize; 2]>,
    pub(crate) sigma: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Molecules {
    fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
            l -= 0.01 * (q[i][0] * q[i][0] + q[i][1] * q[i][1]);
        }
        for k in 0..self.bonds.len() {
            let [i, j] = self.bonds[k];
            let (x, y) = (q[j][0] - q[i][0], q[j][1] - q[i][1]);
            l -= 0.5 * ((1.0 + x * x + y * y).sqrt() - 1.4).powi(2);
        }
        l
    }
    #[gamma]
    fn bath(&self, q: &[[f64; 2]]) -> Vec<[f64; 2]> {
        q.iter()
            .map(|q| [self.sigma * q[0], self.sigma * q[1]])
            .collect()
    }
}

/// Sites with a list of bonds without runs, and a noise at each site.
pub(crate) struct Bonds {
    pub(crate) bonds: Vec<[usize; 2]>,
    pub(crate) sigma: f64,
}

#[variational(endpoint, stormer_verlet)]
impl Bonds {
    fn lagrangian(&self, q: &[f64], v: &[f64]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * v[i] * v[i] - 0.5 * q[i] * q[i];
        }
        for k in 0..self.bonds.len() {
            let d = q[self.bonds[k][1]] - q[self.bonds[k][0]];
            l -= 0.5 * d * d + 0.1 * d.powi(4);
        }
        l
    }
    #[gamma]
    fn bath(&self, q: &[f64]) -> Vec<f64> {
        q.iter().map(|q| self.sigma * (q + 0.2 * q * q)).collect()
    }
}

/// Bodies with forces between all pairs.
pub(crate) struct AllPairs {
    pub(crate) depth: f64,
}

#[variational(endpoint, stormer_verlet)]
impl AllPairs {
    fn lagrangian(&self, q: &[[f64; 2]], v: &[[f64; 2]]) -> f64 {
        let mut l = 0.0;
        for i in 0..q.len() {
            l += 0.5 * (v[i][0] * v[i][0] + v[i][1] * v[i][1]);
            for j in 0..i {
                let (x, y) = (q[i][0] - q[j][0], q[i][1] - q[j][1]);
                l += self.depth / (0.5 + x * x + y * y).sqrt();
            }
        }
        l
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

//! Systems with holonomic constraints.

use sve_runtime::prelude::*;

/// A spherical pendulum in Cartesian coordinates: V = g z, γ = (s sin x, s y z).
#[derive(Clone, Debug)]
pub struct OnSphere {
    /// Gravity.
    pub g: f64,
    /// Strength of the noises.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl OnSphere {
    /// L.
    pub fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        0.5 * (v[0].powi(2) + v[1].powi(2) + v[2].powi(2)) - self.g * q[2]
    }

    /// γ of two processes.
    #[gamma]
    pub fn shakes(&self, q: [f64; 3]) -> [f64; 2] {
        [self.s * q[0].sin(), self.s * q[1] * q[2]]
    }

    /// The unit sphere.
    #[constraint]
    pub fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0].powi(2) + q[1].powi(2) + q[2].powi(2) - 1.0)
    }
}

/// A free particle on the unit sphere that is turned about an axis at random: H₁ = s ⟨q×p,
/// (1,−2,2)/3⟩.
#[derive(Clone, Debug)]
pub struct TurnedSphere {
    /// Strength of the noise.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl TurnedSphere {
    /// L.
    pub fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let _ = q;
        0.5 * (v[0].powi(2) + v[1].powi(2) + v[2].powi(2))
    }

    /// H₁.
    #[h1]
    pub fn turn(&self, q: [f64; 3], p: [f64; 3]) -> f64 {
        let [x, y, z] = q;
        let moment = [
            y * p[2] - z * p[1],
            z * p[0] - x * p[2],
            x * p[1] - y * p[0],
        ];
        self.s * (moment[0] - 2.0 * moment[1] + 2.0 * moment[2]) / 3.0
    }

    /// The unit sphere.
    #[constraint]
    pub fn sphere(&self, q: [f64; 3]) -> f64 {
        0.5 * (q[0].powi(2) + q[1].powi(2) + q[2].powi(2) - 1.0)
    }
}

/// A double pendulum of two rods in Cartesian coordinates, γ = (s x₂, s y₁).
#[derive(Clone, Debug)]
pub struct TwoRods {
    /// Masses.
    pub m: [f64; 2],
    /// Lengths.
    pub l: [f64; 2],
    /// Gravity.
    pub g: f64,
    /// Strength of the noises.
    pub s: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl TwoRods {
    /// L.
    pub fn lagrangian(&self, q: [f64; 4], v: [f64; 4]) -> f64 {
        let [m1, m2] = self.m;
        0.5 * m1 * (v[0].powi(2) + v[1].powi(2)) + 0.5 * m2 * (v[2].powi(2) + v[3].powi(2))
            - self.g * (m1 * q[1] + m2 * q[3])
    }

    /// γ of two processes.
    #[gamma]
    pub fn pulls(&self, q: [f64; 4]) -> [f64; 2] {
        [self.s * q[2], self.s * q[1]]
    }

    /// The rods.
    #[constraint]
    pub fn rods(&self, q: [f64; 4]) -> [f64; 2] {
        let [x, y] = [q[2] - q[0], q[3] - q[1]];
        [
            0.5 * (q[0].powi(2) + q[1].powi(2) - self.l[0].powi(2)),
            0.5 * (x.powi(2) + y.powi(2) - self.l[1].powi(2)),
        ]
    }
}

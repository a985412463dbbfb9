//! Systems with a symmetry that is declared.

use sve_comparison::compared;
use sve_runtime::prelude::*;

/// A central potential in the plane with a noise of the distance: angular momentum is conserved.
#[derive(Clone, Debug)]
pub struct Central {
    /// Mass.
    pub m: f64,
    /// Strength of the noise.
    pub s: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Central {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let r = (q[0].powi(2) + q[1].powi(2)).sqrt();
        0.5 * self.m * (v[0].powi(2) + v[1].powi(2)) - 0.25 * r.powi(4) + 1.0 / (1.0 + r)
    }

    /// γ.
    #[gamma]
    pub fn shake(&self, q: [f64; 2]) -> f64 {
        self.s * q[0].hypot(q[1]).sin()
    }

    /// ξ.
    #[symmetry]
    pub fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

/// Two charges in space that attract each other, in a homogeneous magnetic field along z, with
/// every kind of noise: rotations about z and shifts along z are symmetries, shifts along x and y
/// are not.
#[derive(Clone, Debug)]
pub struct Charges {
    /// Masses.
    pub m: [f64; 2],
    /// Magnetic field.
    pub b: f64,
    /// Strengths of the noises.
    pub s: [f64; 3],
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet)]
impl Charges {
    /// L.
    pub fn lagrangian(&self, q: [[f64; 3]; 2], v: [[f64; 3]; 2]) -> f64 {
        let mut l = 0.0;
        let mut distance = 0.3;
        for k in 0..3 {
            distance += (q[1][k] - q[0][k]).powi(2);
        }
        for i in 0..2 {
            for k in 0..3 {
                l += 0.5 * self.m[i] * v[i][k].powi(2);
            }
            l += 0.5 * self.b * (q[i][0] * v[i][1] - q[i][1] * v[i][0]);
        }
        l + distance.sqrt().recip()
    }

    /// H₁: the field fluctuates, and so does the mass.
    #[h1]
    pub fn jitter(&self, q: [[f64; 3]; 2], p: [[f64; 3]; 2]) -> [f64; 2] {
        let (mut turn, mut kinetic) = (0.0, 0.0);
        for i in 0..2 {
            turn += q[i][0] * p[i][1] - q[i][1] * p[i][0];
            for k in 0..3 {
                kinetic += 0.5 * p[i][k].powi(2);
            }
        }
        [self.s[0] * turn, self.s[1] * kinetic]
    }

    /// γ: the attraction fluctuates.
    #[gamma]
    pub fn pull(&self, q: [[f64; 3]; 2]) -> f64 {
        let [a, b] = q;
        let r2 = (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2) + (a[2] - b[2]).powi(2);
        self.s[2] * (1.0 + r2).ln()
    }

    /// ξ.
    #[symmetry]
    pub fn rotation(&self, q: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        let mut xi = [[0.0; 3]; 2];
        for i in 0..2 {
            xi[i] = [-q[i][1], q[i][0], 0.0];
        }
        xi
    }

    /// ξ.
    #[symmetry]
    pub fn shift(&self, _q: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
        [[0.0, 0.0, 1.0]; 2]
    }
}

/// A free particle in a coordinate of another scale, x = e^q: its symmetry is not affine in q.
#[derive(Clone, Debug)]
pub struct Stretched {
    /// Mass.
    pub m: f64,
}

#[compared(initial_point, endpoint, midpoint, stormer_verlet, taylor2)]
impl Stretched {
    /// L.
    pub fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * self.m * (q.exp() * v).powi(2)
    }

    /// ξ.
    #[symmetry]
    pub fn shift(&self, q: f64) -> f64 {
        (-q).exp()
    }
}

/// A planet in a plane, L = ½|v|² + k/r, γ = σ/r.
#[derive(Clone, Debug)]
pub struct Kepler {
    /// Strength of the attraction.
    pub k: f64,
    /// Strength of the noise.
    pub sigma: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Kepler {
    /// L.
    pub fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.k / q[0].hypot(q[1])
    }

    /// γ.
    #[gamma]
    pub fn flicker(&self, q: [f64; 2]) -> f64 {
        self.sigma / q[0].hypot(q[1])
    }

    /// The rotations of the plane.
    #[symmetry]
    pub fn rotation(&self, q: [f64; 2]) -> [f64; 2] {
        [-q[1], q[0]]
    }
}

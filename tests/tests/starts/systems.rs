//! Systems whose mass matrix is singular somewhere, or whose momentum is bounded.

use sve_runtime::prelude::*;

/// A mass that is a parameter.
pub(crate) struct Mass {
    pub(crate) m: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(4),
    midpoint(weak2),
    gauss(2, stage_noise)
)]
impl Mass {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * self.m * v * v - 0.5 * q * q
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.1 * q * q
    }
}

/// Two velocities that are coupled; for a = 1 they have one momentum.
pub(crate) struct Coupled {
    pub(crate) a: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Coupled {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.a * v[0] * v[1]
            - 0.5 * (q[0] * q[0] + 2.0 * q[1] * q[1])
    }
}

/// A mass that vanishes at the origin.
pub(crate) struct Vanishing;

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(4),
    taylor2
)]
impl Vanishing {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * q * q * v * v - 0.5 * q * q
    }
}

/// Polar coordinates, with noise.
pub(crate) struct Polar;

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(4),
    stormer_verlet(weak2),
    gauss(4, stage_noise)
)]
impl Polar {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + q[0] * q[0] * v[1] * v[1]) - 0.5 * q[0] * q[0]
    }
    #[gamma]
    fn push(&self, q: [f64; 2]) -> f64 {
        0.1 * q[0]
    }
}

/// A mass matrix that loses a rank where q₀ = c, in five coordinates: more than bounds judge.
pub(crate) struct Fold {
    pub(crate) b: [[f64; 5]; 5],
    pub(crate) c: f64,
}

#[variational(endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Fold {
    fn lagrangian(&self, q: [f64; 5], v: [f64; 5]) -> f64 {
        let mut l = -0.5 * q[0] * q[0] - q[1].cos();
        for k in 0..5 {
            let mut along = 0.0;
            for i in 0..5 {
                along += self.b[k][i] * v[i];
            }
            if k == 0 {
                along *= q[0] - self.c;
            }
            l += 0.5 * along * along;
        }
        l
    }
}

/// A mass matrix of parameters, of three coordinates.
#[derive(Clone)]
pub(crate) struct Gram {
    pub(crate) b: [[f64; 3]; 3],
}

#[variational(endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Gram {
    fn lagrangian(&self, q: [f64; 3], v: [f64; 3]) -> f64 {
        let mut l = q[0].cos() + q[1].cos() - 0.5 * q[2] * q[2];
        for k in 0..3 {
            let along = self.b[k][0] * v[0] + self.b[k][1] * v[1] + self.b[k][2] * v[2];
            l += 0.5 * along * along;
        }
        l
    }
}

/// A light ray in a layered medium, whose momentum is bounded.
pub(crate) struct Ray;

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(4),
    gauss(2, stage_noise)
)]
impl Ray {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        1.5 * (1.0 - 0.2 * q * q) * (1.0 + v * v).sqrt()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.1 * q
    }
}

/// A mass that vanishes at rest.
pub(crate) struct Quartic;

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2), gauss(4))]
impl Quartic {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.25 * v.powi(4) - 0.5 * q * q
    }
}

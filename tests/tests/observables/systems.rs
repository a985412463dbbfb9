//! Systems whose sections, bounces and averages are known.

use sve_runtime::prelude::*;

/// H = ½p² + ½q².
#[derive(Clone, Copy)]
pub(crate) struct Oscillator;

#[variational(midpoint, gauss(4))]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }
}

/// The potential of Hénon and Heiles.
#[derive(Clone, Copy)]
pub(crate) struct HenonHeiles;

#[variational(midpoint, stormer_verlet, gauss(2), gauss(4), gauss(8))]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y * y * y / 3.0
    }
}

/// A ball above a floor. A step of the rule is exact.
#[derive(Clone, Copy)]
pub(crate) struct Ball {
    pub(crate) g: f64,
}

#[variational(stormer_verlet)]
impl Ball {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.g * q
    }
}

/// A wheel that turns at a constant rate.
#[derive(Clone, Copy)]
pub(crate) struct Wheel;

#[variational(midpoint)]
impl Wheel {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }
}

/// A Brownian motion: q = q₀ + p t + σW.
#[derive(Clone, Copy)]
pub(crate) struct Drifting {
    pub(crate) sigma: f64,
}

#[variational(midpoint)]
impl Drifting {
    fn lagrangian(&self, _q: f64, v: f64) -> f64 {
        0.5 * v * v
    }

    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        self.sigma * p
    }
}

/// A pendulum with a noisy pivot.
#[derive(Clone, Copy)]
pub(crate) struct Pendulum {
    pub(crate) sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + q.cos()
    }

    #[gamma]
    fn shake(&self, q: f64) -> f64 {
        self.sigma * q.sin()
    }
}

/// An oscillator with friction, pushed at random.
#[derive(Clone, Copy)]
pub(crate) struct Langevin {
    pub(crate) nu: f64,
    pub(crate) sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet)]
impl Langevin {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }
}

/// Kubo's oscillator: a rotation whose speed is noisy.
#[derive(Clone, Copy)]
pub(crate) struct Kubo {
    pub(crate) sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, gauss(2), gauss(3))]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        0.5 * self.sigma * (q * q + p * p)
    }
}

/// An oscillator with a noisy stiffness, also with the term of weak order 2.
#[derive(Clone, Copy)]
pub(crate) struct Stiffness {
    pub(crate) sigma: f64,
}

#[variational(midpoint, midpoint(weak2), stormer_verlet, stormer_verlet(weak2))]
impl Stiffness {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn flicker(&self, q: f64) -> f64 {
        0.5 * self.sigma * q * q
    }
}

/// A heavy particle on the unit sphere, in a bath: kT = σ²/2ν.
#[derive(Clone, Copy)]
pub(crate) struct Sphere {
    pub(crate) g: f64,
    pub(crate) nu: f64,
    pub(crate) sigma: f64,
}

#[variational(midpoint, stormer_verlet)]
impl Sphere {
    fn lagrangian(&self, q: Vector3<f64>, v: Vector3<f64>) -> f64 {
        0.5 * v.norm_squared() - self.g * q.z
    }

    #[constraint]
    fn sphere(&self, q: Vector3<f64>) -> f64 {
        0.5 * (q.norm_squared() - 1.0)
    }

    #[gamma]
    fn push(&self, q: Vector3<f64>) -> [f64; 3] {
        [self.sigma * q.x, self.sigma * q.y, self.sigma * q.z]
    }

    #[force]
    fn friction(&self, _q: Vector3<f64>, v: Vector3<f64>) -> Vector3<f64> {
        -self.nu * v
    }
}

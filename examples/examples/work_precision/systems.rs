//! The systems of the study. All steps are derived from these definitions.

use sve_runtime::prelude::*;

/// A pendulum: H = p²/2 − g cos q.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pendulum {
    pub(crate) g: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(4),
    gauss(6),
    gauss(8),
    taylor2
)]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
}

/// The stochastic linear oscillator: dq = p dt, dp = −q dt + σ dW.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Oscillator {
    pub(crate) sigma: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(2, stage_noise),
    gauss(3, stage_noise),
    gauss(4, stage_noise)
)]
impl Oscillator {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[gamma]
    fn push(&self, q: f64) -> f64 {
        self.sigma * q
    }
}

/// The Kubo oscillator: a rotation by a dt + σ ∘ dW.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kubo {
    pub(crate) a: f64,
    pub(crate) sigma: f64,
}

#[variational(initial_point, endpoint, midpoint, stormer_verlet, gauss(2))]
impl Kubo {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        v * v / (2.0 * self.a) - self.a / 2.0 * q * q
    }

    #[h1]
    fn jitter(&self, q: f64, p: f64) -> f64 {
        self.sigma / 2.0 * (q * q + p * p)
    }
}

/// Synchrotron oscillations with noise in phase and amplitude of the field.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Synchrotron {
    pub(crate) omega: f64,
    pub(crate) sigma: [f64; 2],
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    stormer_verlet(weak2),
    gauss(2)
)]
impl Synchrotron {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.omega.powi(2) * q.cos()
    }

    #[gamma]
    fn kicks(&self, q: f64) -> [f64; 2] {
        [-self.sigma[0] * q.cos(), -self.sigma[1] * q.sin()]
    }
}

/// Hénon–Heiles, pushed at random in both directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HenonHeiles {
    pub(crate) sigma: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(2, stage_noise),
    gauss(3, stage_noise),
    gauss(4, stage_noise)
)]
impl HenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y.powi(3) / 3.0
    }

    #[gamma]
    fn push(&self, q: [f64; 2]) -> [f64; 2] {
        [self.sigma * q[0], self.sigma * q[1]]
    }
}

/// A double pendulum of unit masses and lengths; angles from the downward vertical.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DoublePendulum {
    pub(crate) g: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(4),
    gauss(6),
    gauss(8),
    taylor2
)]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0].powi(2) + 0.5 * v[1].powi(2) + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + self.g * (2.0 * q[0].cos() + q[1].cos())
    }
}

/// A planet in a plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kepler {
    pub(crate) k: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(4),
    gauss(6),
    gauss(8),
    taylor2
)]
impl Kepler {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + self.k / (q[0] * q[0] + q[1] * q[1]).sqrt()
    }
}

/// Hénon–Heiles without noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct QuietHenonHeiles;

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(4),
    gauss(6),
    gauss(8),
    taylor2
)]
impl QuietHenonHeiles {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let [x, y] = q;
        0.5 * (v[0] * v[0] + v[1] * v[1]) - 0.5 * (x * x + y * y) - x * x * y + y.powi(3) / 3.0
    }
}

/// The Sun with the inner planets, Jupiter, Saturn, Uranus, Neptune and Pluto: astronomical units,
/// days, solar masses.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OuterSolarSystem {
    /// The constant of gravitation.
    pub(crate) gravity: f64,
    pub(crate) masses: [f64; 6],
}

#[variational(initial_point, endpoint, stormer_verlet, gauss(4), gauss(6), gauss(8))]
impl OuterSolarSystem {
    fn lagrangian(&self, q: [[f64; 3]; 6], v: [[f64; 3]; 6]) -> f64 {
        let mut value = 0.0;
        for i in 0..6 {
            value +=
                0.5 * self.masses[i] * (v[i][0] * v[i][0] + v[i][1] * v[i][1] + v[i][2] * v[i][2]);
            for j in 0..i {
                let [x, y, z] = [q[i][0] - q[j][0], q[i][1] - q[j][1], q[i][2] - q[j][2]];
                value +=
                    self.gravity * self.masses[i] * self.masses[j] / (x * x + y * y + z * z).sqrt();
            }
        }
        value
    }
}

/// Langevin dynamics in a double well.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Langevin {
    /// Height of the barrier.
    pub(crate) a: f64,
    /// Rate of friction.
    pub(crate) nu: f64,
    /// Temperature times Boltzmann's constant.
    pub(crate) kt: f64,
}

#[variational(
    initial_point,
    endpoint,
    midpoint,
    stormer_verlet,
    gauss(2),
    gauss(2, stage_noise),
    gauss(3, stage_noise),
    gauss(4, stage_noise)
)]
impl Langevin {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - self.a * (q * q - 1.0).powi(2)
    }

    #[force]
    fn friction(&self, _q: f64, v: f64) -> f64 {
        -self.nu * v
    }

    #[gamma]
    fn bath(&self, q: f64) -> f64 {
        (2.0 * self.nu * self.kt).sqrt() * q
    }
}

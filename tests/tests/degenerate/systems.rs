//! Degenerate systems of the tests, each with what is known of it.

use sve_runtime::prelude::*;

/// Two species, in a gauge in which both velocities occur; one coordinate can be removed by a quadratic gauge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LotkaVolterra;

#[variational(midpoint)]
impl LotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        (q[1].ln() / q[0] + q[1]) * v[0] + q[0] * v[1] - energy
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> f64 {
        0.25 * q[0] * q[1].ln()
    }
}

/// The same in the gauge without the second velocity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InternalLotkaVolterra;

#[variational(initial_point, midpoint, endpoint)]
impl InternalLotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        q[1].ln() / q[0] * v[0] - energy
    }

    #[gamma]
    fn weather(&self, q: [f64; 2]) -> f64 {
        0.25 * q[0] * q[1].ln()
    }
}

/// The same in a cubic gauge, which has no internal form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CubicLotkaVolterra;

#[variational(midpoint)]
impl CubicLotkaVolterra {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let energy = q[0] + q[1] - q[0].ln() - 2.0 * q[1].ln();
        // the gradient of x²y + y³/3
        let gauge = 2.0 * q[0] * q[1] * v[0] + (q[0] * q[0] + q[1] * q[1]) * v[1];
        q[1].ln() / q[0] * v[0] + gauge - energy
    }
}

/// A spin in stereographic coordinates. With γ = −½H the motion is the precession by −(t + ½W) about (0.6, 0, 0.8).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Spin;

#[variational(midpoint)]
impl Spin {
    fn energy(&self, q: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        (0.6 * 2.0 * q[0] + 0.8 * (1.0 - square)) / (1.0 + square)
    }

    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let square = q[0] * q[0] + q[1] * q[1];
        2.0 * (q[0] * v[1] - q[1] * v[0]) / (1.0 + square) - self.energy(q)
    }

    #[gamma]
    fn field(&self, q: [f64; 2]) -> f64 {
        -0.5 * self.energy(q)
    }
}

/// The oscillator as a system of first order, with α = (−y, 0). With γ = −½H the motion is the rotation by t + ½W.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kubo;

#[variational(initial_point, midpoint, endpoint)]
impl Kubo {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        -q[1] * v[0] - 0.5 * (q[0] * q[0] + q[1] * q[1])
    }

    #[gamma]
    fn noise(&self, q: [f64; 2]) -> f64 {
        -0.25 * (q[0] * q[0] + q[1] * q[1])
    }
}

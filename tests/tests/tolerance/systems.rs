//! The systems of these tests.

use sve_runtime::prelude::*;

/// A body around the sun.
pub(crate) struct Kepler;

#[variational(gauss(4), gauss(5), gauss(6), gauss(7), gauss(8))]
impl Kepler {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1]) + 1.0 / (q[0] * q[0] + q[1] * q[1]).sqrt()
    }
}

/// The body at its perihelion, on an orbit with the period 2π.
pub(crate) fn perihelion(eccentricity: f64) -> State<[f64; 2]> {
    let speed = ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
    State::new([1.0 - eccentricity, 0.0], [0.0, speed])
}

/// A pendulum, with a noise that these tests leave out.
pub(crate) struct Pendulum {
    pub(crate) g: f64,
}

#[variational(gauss(4), gauss(6), gauss(8))]
impl Pendulum {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + self.g * q.cos()
    }
    #[gamma]
    fn push(&self, q: f64) -> f64 {
        0.1 * q
    }
}

/// Two pendula, one at the other, whose masses depend on the angles.
pub(crate) struct DoublePendulum;

#[variational(gauss(4), gauss(6), gauss(8))]
impl DoublePendulum {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        let kinetic = v[0] * v[0] + 0.5 * v[1] * v[1] + v[0] * v[1] * (q[0] - q[1]).cos();
        kinetic + 9.81 * (2.0 * q[0].cos() + q[1].cos())
    }
}

/// A charge that falls into a centre, in a potential with a singularity.
pub(crate) struct Fall;

#[variational(gauss(8))]
impl Fall {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + 1.0 / q
    }
}

/// A body that leaves the domain of its potential.
pub(crate) struct Edge;

#[variational(gauss(8))]
impl Edge {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v + (1.0 - q).powf(1.5)
    }
}

/// A ball above a floor.
pub(crate) struct Ball;

#[variational(gauss(4))]
impl Ball {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - q
    }
}

/// A wall of short range, higher than the energy of a particle with the velocity 1.
pub(crate) struct Wall;

#[variational(gauss(8))]
impl Wall {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 10.0 * (-q * q).exp()
    }
}

/// Walls of a channel whose forces grow with a power of the distance from its middle.
pub(crate) struct Channel;

#[variational(gauss(4))]
impl Channel {
    fn lagrangian(&self, q: [f64; 2], v: [f64; 2]) -> f64 {
        0.5 * (v[0] * v[0] + v[1] * v[1] - q[0] * q[0]) - (q[1] * q[1]).powf(1.3)
    }
}

/// Returns the largest difference of two states.
pub(crate) fn distance<const N: usize>(a: &State<[f64; N]>, b: &State<[f64; N]>) -> f64 {
    let numbers = a.q.iter().chain(&a.p).zip(b.q.iter().chain(&b.p));
    numbers.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

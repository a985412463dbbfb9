//! Vectors without order, for starts.

use std::f64::consts::TAU;

use rand::{Rng, RngExt};
use sve_runtime::nalgebra::Vector3;

/// Returns a vector of length 1, all directions alike.
pub fn direction(rng: &mut impl Rng) -> Vector3<f64> {
    let (z, angle) = (2.0 * rng.random::<f64>() - 1.0, TAU * rng.random::<f64>());
    let side = (1.0 - z * z).sqrt();
    Vector3::new(side * angle.cos(), side * angle.sin(), z)
}

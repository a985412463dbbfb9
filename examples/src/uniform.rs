//! Numbers for starts without order.

use std::f64::consts::TAU;

use sve_runtime::nalgebra::Vector3;

/// Numbers between 0 and 1, by Marsaglia's xorshift (J. Stat. Softw. 8(14), 2003).
pub struct Uniform(u64);

impl Uniform {
    /// Returns the numbers of a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    /// Returns the next number.
    pub fn number(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Returns a vector of length 1, all directions alike.
    pub fn direction(&mut self) -> Vector3<f64> {
        let (z, angle) = (2.0 * self.number() - 1.0, TAU * self.number());
        let side = (1.0 - z * z).sqrt();
        Vector3::new(side * angle.cos(), side * angle.sin(), z)
    }
}

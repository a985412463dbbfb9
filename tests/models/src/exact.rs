//! The exact solution of the linear oscillator, `dq = p dt`, `dp = −q dt + σ dW`, on a path with
//! known increments.
//!
//! Over a step it is the rotation by h plus `σ ∫ (sin(h−s), cos(h−s)) dW`. This pair is drawn
//! jointly with ΔW by the Cholesky factor of the covariance of all three.

use sve_runtime::prelude::*;

/// One exact step.
#[derive(Clone, Copy, Debug)]
pub struct OscillatorStep {
    /// Length of the step.
    pub h: f64,
    /// The number sin h.
    pub sin: f64,
    /// The number cos h.
    pub cos: f64,
    /// Covariances of the two integrals with ΔW.
    pub with_dw: [f64; 2],
    /// Covariances of the two integrals.
    pub integrals: [[f64; 2]; 2],
}

impl OscillatorStep {
    /// Returns the step of length `h`.
    pub fn new(h: f64) -> Self {
        let (sin, cos) = h.sin_cos();
        let cross = 0.5 * sin * sin;
        Self {
            h,
            sin,
            cos,
            // 1 − cos h = 2 sin²(h/2), since the difference would cancel.
            with_dw: [2.0 * (h / 2.0).sin().powi(2), sin],
            integrals: [
                [0.5 * (h - sin * cos), cross],
                [cross, 0.5 * (h + sin * cos)],
            ],
        }
    }

    /// Returns the increments of `steps` steps, and the exact end.
    ///
    /// # Panics
    /// If a number is not finite.
    pub fn path(
        &self,
        sigma: f64,
        start: State<[f64; 1]>,
        noise: &Wiener,
        steps: usize,
    ) -> (Recorded, State<[f64; 1]>) {
        let w = self.h.sqrt();
        let [[xx, xy], [_, yy]] = self.integrals;
        let [xw, yw] = self.with_dw.map(|c| c / w);
        let x = (xx - xw * xw).sqrt();
        let yx = (xy - xw * yw) / x;
        // The remaining variance has the size of h⁵. Rounding, 1e-16 h, may make it negative, which
        // does not matter.
        let y = (yy - yw * yw - yx * yx).max(0.0).sqrt();
        let (mut increments, mut end) = (Vec::new(), start);
        for step in 0..steps as u64 {
            let [z0, z1, z2] = [0, 1, 2].map(|process| noise.increment(step, process, 1.0));
            increments.push([w * z0]);
            let ([q], [p]) = (end.q, end.p);
            end.q = [self.cos * q + self.sin * p + sigma * (xw * z0 + x * z1)];
            end.p = [self.cos * p - self.sin * q + sigma * (yw * z0 + yx * z1 + y * z2)];
        }
        (Recorded::new(self.h, increments).unwrap(), end)
    }
}

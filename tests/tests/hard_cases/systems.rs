//! Systems that only the hard cases use.

use sve_runtime::prelude::*;

/// L = ½v² − ½ω²q².
pub(super) struct Stiff {
    pub(super) omega: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Stiff {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * self.omega.powi(2) * q * q
    }
}

/// L = ½v² − ½q², H₁ = s(p⁴/4 − βp³/3): the midpoint rule is a cubic equation in the momentum of
/// the middle.
#[derive(Clone)]
pub(super) struct Fourth {
    pub(super) s: f64,
    pub(super) beta: f64,
}

#[variational(initial_point, endpoint, midpoint)]
impl Fourth {
    fn lagrangian(&self, q: f64, v: f64) -> f64 {
        0.5 * v * v - 0.5 * q * q
    }

    #[h1]
    fn jitter(&self, _q: f64, p: f64) -> f64 {
        self.s * (0.25 * p.powi(4) - self.beta / 3.0 * p.powi(3))
    }
}

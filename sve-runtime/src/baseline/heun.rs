//! Stochastic Heun: `z₁ = z₀ + ½ (k₀ + k₁)`, `k₀ = h f(z₀) + Σ g_a(z₀) ΔW_a`, `k₁` the same at
//! `z₀ + k₀` and `t₀ + h`.
//!
//! Here `z = (q, p)`, f is the drift and `g_a` the noise fields of the first-order form. The
//! trapezoidal corrector on the noise makes the scheme consistent with the Stratonovich integral,
//! so no Itô correction appears. W. Rümelin, Numerical treatment of stochastic differential
//! equations, SIAM J. Numer. Anal. 19 (1982). Strong order 1 if the noises commute, otherwise ½;
//! deterministic order 2. This is the explicit Stratonovich scheme whose cost is closest to a
//! variational step.

use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::system::euler::EulerIncrement;
use crate::system::{Dims, System};

use super::explicit::{ExplicitFormula, explicit_method, stage};

/// The stochastic Heun method, on the Stratonovich form of the system.
///
/// ```
/// use sve_runtime::baseline::Heun;
/// use sve_runtime::prelude::*;
///
/// struct Kubo { a: f64, sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Kubo {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         v * v / (2.0 * self.a) - self.a / 2.0 * q * q
///     }
///     #[h1]
///     fn jitter(&self, q: f64, p: f64) -> f64 { self.sigma / 2.0 * (q * q + p * p) }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let method = Heun::new(Kubo { a: 1.0, sigma: 1.0 });
/// let mut state = State::new([1.0], [0.0]);
/// method.step(&mut state, 0.125, &[0.125])?;
/// // the rotation by x = a h + σ ΔW to second order: 1 − x²/2, −x
/// assert_eq!(state, State::at(0.125, [1.0 - 0.03125], [-0.25]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Heun<S> {
    system: S,
}

impl<S: System> Heun<S> {
    /// Creates the method for `system`.
    pub fn new(system: S) -> Self {
        Self { system }
    }
}

impl<S> ExplicitFormula for Heun<S> {
    const STAGES: usize = 2;

    #[inline(always)]
    fn formula<const N: usize, E>(
        &self,
        start: &State<[f64; N]>,
        h: f64,
        mut euler: impl FnMut(&State<[f64; N]>) -> Result<EulerIncrement<[f64; N]>, E>,
    ) -> Result<Field<[f64; N]>, E> {
        let first = euler(start)?.increment;
        let second = euler(&stage(start, h, 1.0, &first))?.increment;
        let mut d = first;
        for i in 0..N {
            d.q[i] = 0.5 * (first.q[i] + second.q[i]);
            d.p[i] = 0.5 * (first.p[i] + second.p[i]);
        }
        Ok(d)
    }
}

explicit_method!(Heun, M, []);

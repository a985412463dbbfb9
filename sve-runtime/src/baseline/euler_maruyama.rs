//! Forward Euler–Maruyama: `z₁ = z₀ + h f̂(z₀) + Σ g_a(z₀) ΔW_a`.
//!
//! Here `z = (q, p)`, f is the drift and `g_a` the noise fields of the first-order form. The scheme
//! solves the Itô equation, so the drift of the Stratonovich equation gets the Itô correction:
//! `f̂ = f + ½ Σ (Dg_a) g_a`. G. Maruyama, Continuous Markov processes and stochastic equations,
//! Rend. Circ. Mat. Palermo 4 (1955); Kloeden and Platen, Numerical Solution of Stochastic
//! Differential Equations, section 10.2. Strong order ½ (1 with additive noise), deterministic
//! order 1. This is the best known scheme. Its energy grows exponentially where the exact energy
//! grows linearly.

use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::system::euler::EulerIncrement;
use crate::system::{Dims, System};

use super::explicit::{ExplicitFormula, explicit_method};

/// Forward Euler–Maruyama, on the Itô form of the system.
///
/// ```
/// use sve_runtime::baseline::EulerMaruyama;
/// use sve_runtime::prelude::*;
///
/// struct Oscillator { sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 { self.sigma * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let method = EulerMaruyama::new(Oscillator { sigma: 2.0 });
/// let mut state = State::new([1.0], [3.0]);
/// method.step(&mut state, 0.5, &[0.25])?;
/// // q + h p, p − h q + σ ΔW
/// assert_eq!(state, State::at(0.5, [2.5], [3.0]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct EulerMaruyama<S> {
    system: S,
    is_corrected: bool,
}

impl<S: System> EulerMaruyama<S> {
    /// Creates the method for `system`, with the Itô correction of the drift.
    pub fn new(system: S) -> Self {
        Self {
            system,
            is_corrected: true,
        }
    }

    /// Leaves the Itô correction out of the drift.
    ///
    /// If the noise depends on the momentum, the uncorrected method converges to the solution of
    /// *another* equation than the Stratonovich equation of the system. Publications that apply
    /// Euler–Maruyama directly to a Stratonovich equation plot this solution.
    ///
    #[doc = include_str!("../example.md")]
    /// let method = EulerMaruyama::new(&system).uncorrected();
    /// let mut state = start;
    /// method.step(&mut state, 0.01, &[0.02])?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn uncorrected(mut self) -> Self {
        self.is_corrected = false;
        self
    }
}

impl<S> ExplicitFormula for EulerMaruyama<S> {
    const STAGES: usize = 1;

    #[inline(always)]
    fn formula<const N: usize, E>(
        &self,
        start: &State<[f64; N]>,
        _h: f64,
        mut euler: impl FnMut(&State<[f64; N]>) -> Result<EulerIncrement<[f64; N]>, E>,
    ) -> Result<Field<[f64; N]>, E> {
        let EulerIncrement {
            mut increment,
            correction,
        } = euler(start)?;
        if let Some(correction) = correction
            && self.is_corrected
        {
            increment.add_scaled(1.0, &correction);
        }
        Ok(increment)
    }
}

explicit_method!(EulerMaruyama, M, [is_corrected]);

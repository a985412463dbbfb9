//! Forward Euler–Maruyama: `z₁ = z₀ + h f̂(z₀) + Σ g_a(z₀) ΔW_a`.
//!
//! Here `z = (q, p)`, f is the drift and `g_a` the noise fields of the first-order form, and `f̂ = f + ½ Σ (Dg_a) g_a`:
//! the scheme solves the Itô equation, so a Stratonovich one has to be rewritten first.
//! G. Maruyama, Continuous Markov processes and stochastic equations, Rend. Circ. Mat. Palermo 4 (1955);
//! Kloeden and Platen, Numerical Solution of Stochastic Differential Equations, section 10.2.
//! Strong order ½ (1 where the noise is additive), deterministic order 1.
//! For: the scheme that everyone knows, whose energy grows exponentially where the exact one grows linearly.

use crate::configuration::Coordinates;
use crate::mechanics::{Field, correction_of, noise_of, solve_drift};
use crate::newton::SolveError;
use crate::state::State;
use crate::system::{Dims, System};

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
    corrected: bool,
}

impl<S: System> EulerMaruyama<S> {
    /// The method for `system`, with the Itô correction of the drift.
    pub fn new(system: S) -> Self {
        Self {
            system,
            corrected: true,
        }
    }

    /// Leaves the Itô correction out of the drift.
    ///
    /// Where the noise depends on the momentum this converges to *another* equation than the Stratonovich one of the
    /// system. It is what publications plot when they apply Euler–Maruyama to a Stratonovich equation as it stands.
    #[must_use]
    pub fn uncorrected(mut self) -> Self {
        self.corrected = false;
        self
    }
}

impl<S> EulerMaruyama<S> {
    /// `(q₁ − q₀, p₁ − p₀)`.
    #[inline]
    fn increment<Q, const N: usize, const M: usize>(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<Field<[f64; N]>, SolveError>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let drift = solve_drift(&self.system, state)?;
        let jets = self.system.noise_jets(state.t, &state.q, &state.p);
        let mut d = noise_of(&jets, dw);
        d.add_scaled(h, &drift);
        if self.corrected {
            let correction = correction_of(&jets);
            d.add_scaled(h, &correction);
        }
        Ok(d)
    }
}

method_by_increment!(EulerMaruyama, M, [corrected]);

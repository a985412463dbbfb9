//! Classical Runge–Kutta: `z₁ = z₀ + h/6 (k₁ + 2k₂ + 2k₃ + k₄)`.
//!
//! `k₁ = f(t₀, z₀)`, `k₂ = f(t₀ + h/2, z₀ + h/2 k₁)`, `k₃ = f(t₀ + h/2, z₀ + h/2 k₂)`,
//! `k₄ = f(t₀ + h, z₀ + h k₃)`, where `z = (q, p)` and f is the drift of the first-order form. W.
//! Kutta, Z. Math. Phys. 46 (1901). Order 4. The types admit only systems without noise. This is
//! the usual accurate scheme, and gives references over short times. Its energy drifts.

use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::system::euler::EulerIncrement;
use crate::system::{Dims, System};

use super::NoiseFree;
use super::explicit::{ExplicitFormula, explicit_method, stage};

const SIXTH: f64 = 1.0 / 6.0;

/// The classical Runge–Kutta method of order 4, for systems without noise.
///
/// ```
/// use sve_runtime::baseline::RungeKutta4;
/// use sve_runtime::prelude::*;
///
/// struct Oscillator;
///
/// #[variational(midpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
/// }
///
/// # fn main() -> Result<(), StepError> {
/// let method = RungeKutta4::new(Oscillator);
/// let mut state = State::new([1.0], [0.0]);
/// for _ in 0..100 {
///     method.step(&mut state, 0.01, &[])?;
/// }
/// assert!((state.q[0] - 1.0_f64.cos()).abs() < 1e-9);
/// # Ok(())
/// # }
/// ```
///
/// The constructor refuses a system with noise:
///
/// ```compile_fail
/// use sve_runtime::baseline::RungeKutta4;
/// use sve_runtime::prelude::*;
///
/// struct Kubo;
///
/// #[variational(midpoint)]
/// impl Kubo {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[h1]
///     fn jitter(&self, q: f64, p: f64) -> f64 { 0.5 * (q * q + p * p) }
/// }
///
/// let method = RungeKutta4::new(Kubo); // error: this method is for systems without noise
/// ```
#[derive(Clone, Copy, Debug)]
pub struct RungeKutta4<S> {
    system: S,
}

impl<S: System> RungeKutta4<S> {
    /// Creates the method for `system`, which has no noise.
    pub fn new(system: S) -> Self
    where
        S::Dims: NoiseFree,
    {
        Self { system }
    }
}

impl<S> ExplicitFormula for RungeKutta4<S> {
    const STAGES: usize = 4;

    #[inline(always)]
    fn formula<const N: usize, E>(
        &self,
        start: &State<[f64; N]>,
        h: f64,
        mut euler: impl FnMut(&State<[f64; N]>) -> Result<EulerIncrement<[f64; N]>, E>,
    ) -> Result<Field<[f64; N]>, E> {
        let half = 0.5 * h;
        let k1 = euler(start)?.increment;
        let k2 = euler(&stage(start, half, 0.5, &k1))?.increment;
        let k3 = euler(&stage(start, half, 0.5, &k2))?.increment;
        let k4 = euler(&stage(start, h, 1.0, &k3))?.increment;
        let mut d = k1;
        for i in 0..N {
            d.q[i] = (k1.q[i] + 2.0 * (k2.q[i] + k3.q[i]) + k4.q[i]) * SIXTH;
            d.p[i] = (k1.p[i] + 2.0 * (k2.p[i] + k3.p[i]) + k4.p[i]) * SIXTH;
        }
        Ok(d)
    }
}

explicit_method!(RungeKutta4);

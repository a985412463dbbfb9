//! Classical Runge–Kutta: `z₁ = z₀ + h/6 (k₁ + 2k₂ + 2k₃ + k₄)`.
//!
//! `k₁ = f(t₀, z₀)`, `k₂ = f(t₀ + h/2, z₀ + h/2 k₁)`, `k₃ = f(t₀ + h/2, z₀ + h/2 k₂)`, `k₄ = f(t₀ + h, z₀ + h k₃)`, where
//! `z = (q, p)` and f is the drift of the first-order form.
//! W. Kutta, Z. Math. Phys. 46 (1901). Order 4. The types admit only systems without noise.
//! This is the accurate scheme of everyday use, and gives references over short times. Its energy drifts.

use crate::configuration::VectorCoordinates;
use crate::mechanics::{Field, solve_drift};
use crate::solve::SolveError;
use crate::state::State;
use crate::system::{Dims, System};

use super::{NoiseFree, stage};

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
/// A system with noise is refused where the method is made:
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

impl<S> RungeKutta4<S> {
    /// Returns the increment `(q₁ − q₀, p₁ − p₀)`.
    #[inline]
    #[allow(clippy::trivially_copy_pass_by_ref)] // every baseline takes its increments by reference
    fn increment<Q, const N: usize>(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        _dw: &[f64; 0],
    ) -> Result<Field<[f64; N]>, SolveError>
    where
        S: System<Dims = Dims<N, 0, Q>>,
        Q: VectorCoordinates<N>,
    {
        let half = 0.5 * h;
        let k1 = solve_drift(&self.system, state)?;
        let k2 = solve_drift(&self.system, &stage(state, half, half, &k1)?)?;
        let k3 = solve_drift(&self.system, &stage(state, half, half, &k2)?)?;
        let k4 = solve_drift(&self.system, &stage(state, h, h, &k3)?)?;
        let mut d = k1;
        for i in 0..N {
            d.q[i] = h / 6.0 * (k1.q[i] + 2.0 * k2.q[i] + 2.0 * k3.q[i] + k4.q[i]);
            d.p[i] = h / 6.0 * (k1.p[i] + 2.0 * k2.p[i] + 2.0 * k3.p[i] + k4.p[i]);
        }
        Ok(d)
    }
}

method_by_increment!(RungeKutta4);

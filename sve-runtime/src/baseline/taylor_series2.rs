//! Second-order Taylor method: `z₁ = z₀ + h ż₀ + ½ h² z̈₀` for `z = (q, p)`.
//!
//! `q̇ = v`, `ṗ = L_q`, `q̈ = a` from `L_vv a = L_q − L_vq v − L_vt`, and
//! `p̈ = L_qq v + L_qv a + L_qt`. Hairer, Nørsett and Wanner, Solving Ordinary Differential
//! Equations I, section I.8. Order 2. The types admit only systems without noise. The second-order
//! Taylor variational integrator uses the same derivatives in the action. The energy of the method
//! here grows without bound.

use crate::mechanics::legendre;
use crate::mechanics::{Motion, solve_motion};
use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::system::{Dims, System};

use super::NoiseFree;

/// The Taylor expansion of the motion to second order, for systems without noise.
///
/// This method is not the rule [`Taylor2`](crate::Taylor2), which is variational.
///
/// ```
/// use sve_runtime::baseline::TaylorSeries2;
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
/// let method = TaylorSeries2::new(Oscillator);
/// let mut state = State::new([1.0], [2.0]);
/// method.step(&mut state, 0.5, &[])?;
/// // q + h p − h²/2 q, p − h q − h²/2 p
/// assert_eq!(state, State::at(0.5, [1.875], [1.25]));
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TaylorSeries2<S> {
    system: S,
}

impl<S: System> TaylorSeries2<S> {
    /// Creates the method for `system`, which has no noise.
    pub fn new(system: S) -> Self
    where
        S::Dims: NoiseFree,
    {
        Self { system }
    }
}

impl<S> TaylorSeries2<S> {
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
        let v = legendre::velocity(&self.system, state)?;
        let Motion { first, second } = solve_motion(&self.system, state, v)?;
        let mut d = first;
        for i in 0..N {
            d.q[i] = h * (first.q[i] + 0.5 * h * second.q[i]);
            d.p[i] = h * (first.p[i] + 0.5 * h * second.p[i]);
        }
        Ok(d)
    }
}

method_by_increment!(TaylorSeries2);

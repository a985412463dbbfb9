//! Backward (drift-implicit) Euler–Maruyama: `z₁ = z₀ + h f(z₁) + h c(z₀) + Σ g_a(z₀) ΔW_a`.
//!
//! Here `z = (q, p)`, f is the drift, `g_a` the noise fields and `c = ½ Σ (Dg_a) g_a` the Itô
//! correction. Only the drift is implicit. The noise and its Itô correction are evaluated at the
//! start of the step, so that no unbounded ΔW enters the implicit equation. With
//! `n = h c(z₀) + Σ g_a(z₀) ΔW_a` and `q₁ = q₀ + n_q + h v₁` the unknown is `v₁` alone: `L_v(t₁,
//! q₁, v₁) − p₀ − h (L_q + F)(t₁, q₁, v₁) − n_p = 0`, by Newton's method from `v₀`. Kloeden and
//! Platen, Numerical Solution of Stochastic Differential Equations, section 12.2. Strong order ½ (1
//! with additive noise), deterministic order 1. The scheme is stable and damps oscillations: its
//! energy settles where the exact energy grows.

use crate::mechanics::Noises;
use crate::mechanics::legendre;
use crate::phase::Field;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::solve::SolveError;
use crate::solve::newton::{Evaluation, Newton};
use crate::system::{Dims, System};

/// Backward Euler–Maruyama: implicit in the drift, explicit in the noise.
///
/// ```
/// use sve_runtime::baseline::BackwardEulerMaruyama;
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
/// let method = BackwardEulerMaruyama::new(Oscillator { sigma: 1.0 });
/// let mut state = State::new([1.0], [0.0]);
/// method.step(&mut state, 0.1, &[0.0])?;
/// // q₁ = q₀ + h p₁ and p₁ = p₀ − h q₁: the energy falls by 1 + h² although nothing takes it away
/// let energy = method.system().hamiltonian(&state)?;
/// assert!((energy - 0.5 / 1.01).abs() < 1e-14);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BackwardEulerMaruyama<S> {
    system: S,
    is_corrected: bool,
    newton: Newton,
}

impl<S: System> BackwardEulerMaruyama<S> {
    /// Creates the method for `system`, with the Itô correction of the drift.
    pub fn new(system: S) -> Self {
        Self {
            system,
            is_corrected: true,
            newton: Newton::default(),
        }
    }

    /// Leaves the Itô correction out of the drift; see
    /// [`EulerMaruyama::uncorrected`](crate::baseline::EulerMaruyama::uncorrected).
    ///
    #[doc = include_str!("../example.md")]
    /// let method = BackwardEulerMaruyama::new(&system).uncorrected();
    /// let mut state = start;
    /// method.step(&mut state, 0.01, &[0.02])?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn uncorrected(mut self) -> Self {
        self.is_corrected = false;
        self
    }

    /// Replaces the options of the Newton iteration.
    ///
    #[doc = include_str!("../example.md")]
    /// let newton = Newton { max_iterations: 20, ..Newton::default() };
    /// let method = BackwardEulerMaruyama::new(&system).with_newton(newton);
    /// let mut state = start;
    /// method.step(&mut state, 0.01, &[0.02])?;
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn with_newton(mut self, newton: Newton) -> Self {
        self.newton = newton;
        self
    }
}

impl<S> BackwardEulerMaruyama<S> {
    /// Returns the increment `(q₁ − q₀, p₁ − p₀)`.
    #[inline]
    fn increment<Q, const N: usize, const M: usize>(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<Field<[f64; N]>, SolveError>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: VectorCoordinates<N>,
    {
        let noises = Noises::at(&self.system, state);
        let mut n = noises.field(dw);
        if self.is_corrected {
            let correction = noises.correction();
            n.add_scaled(h, &correction);
        }
        drift_implicit(&self.system, &self.newton, state, h, &n)
    }
}

method_by_increment!(BackwardEulerMaruyama, M, [is_corrected, newton]);

/// Solves the implicit equation and returns the increment `(q₁ − q₀, p₁ − p₀)`; `n` is the
/// contribution of the noise.
#[inline]
fn drift_implicit<S, Q, const N: usize, const M: usize>(
    system: &S,
    newton: &Newton,
    state: &State<[f64; N]>,
    h: f64,
    n: &Field<[f64; N]>,
) -> Result<Field<[f64; N]>, SolveError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    let t = state.t + h;
    let moved = |v: &[f64; N]| {
        let mut dq = n.q;
        for i in 0..N {
            dq[i] += h * v[i];
        }
        dq
    };
    let at = |dq: &[f64; N]| {
        let mut q = state.q;
        for i in 0..N {
            q[i] += dq[i];
        }
        q
    };
    let v = newton.solve(legendre::velocity(system, state)?, |v| {
        let jet = system.lagrangian_jet(t, &at(&moved(v)), v);
        let force = system.force_jet(t, &at(&moved(v)), v);
        let mut equations = Evaluation {
            residual: [0.0; N],
            magnitude: [0.0; N],
            jacobian: jet.dvv,
            curvature: f64::NAN,
        };
        for i in 0..N {
            let kick = h * (jet.dq[i] + force.value[i]);
            let terms = [jet.dv[i], -state.p[i], -kick, -n.p[i]];
            equations.residual[i] = terms.iter().sum();
            equations.magnitude[i] = terms.iter().map(|x| x.abs()).sum();
            for j in 0..N {
                let along_q = jet.dqq[i][j] + force.dq[i][j];
                let along_v = jet.dqv[i][j] + force.dv[i][j];
                equations.jacobian[i][j] += h * (jet.dqv[j][i] - along_v - h * along_q);
            }
        }
        equations
    })?;
    let dq = moved(&v);
    let jet = system.lagrangian_jet(t, &at(&dq), &v);
    let force = system.force_jet(t, &at(&dq), &v);
    let mut dp = n.p;
    for i in 0..N {
        dp[i] += h * (jet.dq[i] + force.value[i]);
    }
    Ok(Field { q: dq, p: dp })
}

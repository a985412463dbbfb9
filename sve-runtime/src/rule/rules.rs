//! The discretisation rules: a unit type for each, which names the rule of an
//! [`Integrator`](crate::Integrator).
//!
//! The macro defines a rule by its discrete action (`docs/mathematics.md`, section 2). A step
//! consists of one substep, with the equations that the macro derived.

use super::{Mode, Rule, TellsImpulses, Walker};
use crate::system::equations::StepEquations;
use crate::system::plan::Plan;
use crate::system::start::Tested;

macro_rules! rules {
    ($($(#[$doc:meta])* $name:ident)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct $name;
    )*};
}

rules! {
    /// `S_d = h L(t₀, q₀, v) + …`: node at the start of the step. Deterministic order 1.
    InitialPoint
    /// `S_d = h L(t₁, q₁, v) + …`: node at the end of the step. Deterministic order 1.
    Endpoint
    /// `S_d = h L(t₀ + h/2, (q₀+q₁)/2, v) + …`: node in the middle. Deterministic order 2,
    /// self-adjoint.
    Midpoint
    /// `S_d = h (L(t₀, q₀, v) + L(t₁, q₁, v))/2 + …`: the rule of Störmer and Verlet, nodes at both
    /// ends, self-adjoint. Deterministic order 2. Explicit where L has constant masses and is
    /// separable, and noise is in q alone.
    StormerVerlet
    /// The second-order Taylor variational integrator of Schmitt, Shingel and Leok: deterministic
    /// systems only, order 2.
    Taylor2
}

/// The Gauss–Galerkin rule with `S` stages, from 2 to 8:
/// `S_d = Σ h b_i L(t₀ + c_i h, Q_i, V_i) + …` with nodes and weights of Gauss quadrature,
/// self-adjoint. Deterministic order `2 S`. In the attribute it is `gauss(4)`, as the rule of an
/// integrator `Gauss::<4>`.
///
/// With four stages or more the step is solved by fixed-point iteration if the iteration contracts.
/// Otherwise Newton's method solves it for the unknowns of all stages at once, with a dense matrix
/// of `S N` rows for N coordinates, or `2 S N` if noise moves positions. With many coordinates such
/// steps are slow: the outer solar system has 144 unknowns with 8 stages, and a step that is too
/// long for the fixed-point iteration takes milliseconds, some hundred times as long as a shorter
/// step.
///
/// With four stages or more [`tolerance`](crate::Trajectory::tolerance) adapts the size of the
/// steps of a path without noise, for accurate paths over short times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Gauss<const S: usize>;

/// The [`Gauss`] rule `R` with an increment of each process for each stage. In the attribute it is
/// `gauss(3, stage_noise)`, as the rule of an integrator `StageNoise(Gauss::<3>)`.
///
/// The increment of process a at stage i is `∫ ℓ_i dW_a`, where ℓ is the Lagrange basis of the
/// nodes. The `dw` of a step has `S M` entries, process by process, with nodes ascending; each is
/// independent with variance `b_i h`. [`Wiener`](crate::noise::Wiener) draws them as details of one
/// path, which serves every number of stages and the other rules; [`noise`](crate::noise) lists the
/// other sources with stage noise. The increments belong to whole steps: what divides steps, such
/// as [`refine`](crate::Trajectory::refine) and passages in ensembles, is refused.
///
/// For additive noise, γ linear in q with constant masses, the strong order is min(S, 3), also with
/// a force that is linear in velocities. If the coefficients of velocities depend on the place, as
/// in a magnetic field, it is 5/2 at most. For other noise it is 1, as without the option.
///
/// ```
/// use sve_runtime::prelude::*;
/// struct Pendulum { sigma: f64 }
/// #[variational(gauss(3, stage_noise), midpoint)]
/// impl Pendulum {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
///     #[gamma]
///     fn push(&self, q: f64) -> f64 { self.sigma * q }
/// }
/// # fn main() -> Result<(), StepError> {
/// let pendulum = Integrator::new(Pendulum { sigma: 0.1 }, StageNoise(Gauss::<3>));
/// let mut state = State::new([1.0], [0.0]);
/// pendulum.step(&mut state, 0.1, &[0.01, -0.02, 0.03])?;
/// // along the path that the midpoint rule takes too
/// let end = pendulum.trajectory(state, 0.1, Wiener::new(42)).take(100).last().unwrap()?;
/// let plain = Integrator::new(Pendulum { sigma: 0.1 }, Midpoint);
/// let coarse = plain.trajectory(state, 0.1, Wiener::new(42)).take(100).last().unwrap()?;
/// assert!((end.q[0] - coarse.q[0]).abs() < 0.05);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StageNoise<R>(pub R);

/// The rule `R` with the option `weak2`, in the attribute `midpoint(weak2)`,
/// `stormer_verlet(weak2)` or `gauss(3, weak2)`. It has weak order 2 with one Gaussian increment
/// for each process, where `R` has weak order 1.
///
/// The action gets a potential that removes the leading error of expectations. For the midpoint
/// rule it is `S_d −= h|h|/8 Σ ⟨∂γ/∂q, M⁻¹ ∂γ/∂q⟩` at the node, with M = ∂²L/∂v², and for the rule
/// of Störmer and Verlet the mean of this term over both ends. A [`Gauss`] rule has
/// `S_d −= h|h|/12 Σ_i b_i K(node i)` with the K of `docs/mathematics.md`, section 9, which is the
/// same for a γ; for noise that moves the position it depends on the momentum too. The step stays
/// variational and symmetric, and its strong order does not change. The term assumes increments of
/// variance |h|, so the rule cannot be a part of compositions.
///
/// `Weak2(StageNoise(Gauss::<3>))`, in the attribute `gauss(3, stage_noise, weak2)`, has the weak
/// order 2, and without a force the strong order 1.5 if its noises are γ's that commute, which γ's
/// of q always do. Its term is `h|h|/(8(2S − 1)) Σ_i b_i K(node i)` with S stages.
///
/// The macro refuses the option, with the reason, where the term does not raise the weak order or
/// is not a function of time, configuration and momentum: noises that do not commute; noise that
/// moves the position, except for `gauss(s, weak2)` of systems without a force; ∂²L/∂v² that
/// depends on v; a force that is not affine in v.
///
/// ```
/// use sve_runtime::prelude::*;
/// struct Oscillator { sigma: f64 }
/// #[variational(midpoint, midpoint(weak2))]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
///     #[gamma]
///     fn stiffness(&self, q: f64) -> f64 { 0.5 * self.sigma * q * q }
/// }
/// let plain = Integrator::new(Oscillator { sigma: 0.5 }, Midpoint);
/// let corrected = Integrator::new(Oscillator { sigma: 0.5 }, Weak2(Midpoint));
/// assert_eq!(plain.plan().weak_order, 1);
/// assert_eq!(corrected.plan().weak_order, 2);
///
/// // the mean of q after one step, by the three nodes of Gauss and Hermite for ΔW
/// let h: f64 = 0.1;
/// let mean = |step: &dyn Fn(&mut State<[f64; 1]>, f64)| {
///     let end = |dw: f64| {
///         let mut state = State::new([1.0], [0.0]);
///         step(&mut state, dw);
///         state.q[0]
///     };
///     let far = (3.0 * h).sqrt();
///     (end(-far) + 4.0 * end(0.0) + end(far)) / 6.0
/// };
/// let plain = mean(&|state, dw| plain.step(state, h, &[dw]).unwrap());
/// let corrected = mean(&|state, dw| corrected.step(state, h, &[dw]).unwrap());
/// // the exact mean obeys the equation without noise
/// assert!((plain - h.cos()).abs() > 4.0 * (corrected - h.cos()).abs());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Weak2<R>(pub R);

/// A rule whose step is derived without analysing its structure: Newton's method in all unknowns.
/// Tests and benchmarks compare derived steps with it; an attribute of their own derives it.
#[doc(hidden)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unstructured<R>(pub R);

macro_rules! derived {
    ($([$($generic:tt)*] $rule:ty,)*) => {$(
        impl<S: StepEquations<$rule>, $($generic)*> Rule<S> for $rule {
            type Increments = S::Increments;
            type Prepared = Tested<S::Prepared>;
            type Memory = S::Memory;
            const STAGES: usize = S::STAGES;
            const SUBSTEPS: usize = 1;
            const PLAN: &'static Plan = S::PLAN;
            const HAS_INCREMENTS: bool = !S::RETURNS.is_state();

            #[inline]
            fn prepare(system: &S, h: f64) -> Self::Prepared {
                Tested::of(system, system.prepare(h))
            }

            #[inline(always)]
            fn walk<M: Mode<S, S::Increments>>(
                walker: Walker<'_, S, Self>,
                prepared: &Self::Prepared,
                memory: &mut S::Memory,
                h: f64,
                dw: &M::Increments,
                mode: &mut M,
            ) -> Result<(), M::Failure> {
                mode.substep(walker, prepared, memory, h, dw)
            }
        }

        impl<$($generic)*> TellsImpulses for $rule {}
    )*};
}

derived! {
    [] InitialPoint,
    [] Endpoint,
    [] Midpoint,
    [] StormerVerlet,
    [] Taylor2,
    [const N: usize] Gauss<N>,
    [R] StageNoise<R>,
    [R] Weak2<R>,
    [R] Unstructured<R>,
}

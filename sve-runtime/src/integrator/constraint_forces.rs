//! The forces of the constraints in a step, from the multipliers of its equations.

use super::Integrator;
use super::step::Impulses;
use super::steps::walk_from;
use crate::error::StepError;
use crate::method::OneStepMethod;
use crate::phase::configuration::VectorCoordinates;
use crate::phase::state::State;
use crate::rule::{Rule, TellsImpulses};
use crate::system::{Dims, System};

/// The forces of all constraints in a step. `P` is the type of momenta.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintForces<P> {
    /// The impulse at the start of the step, `Σ λ ∂φ/∂q(q₀)`.
    pub at_start: P,
    /// The impulse at the end of the step, `Σ μ ∂φ/∂q(q₁)`, which ends on the constraints.
    pub at_end: P,
    /// The mean force, the sum of both impulses divided by h.
    pub mean: P,
    /// The force of each constraint, in the order of the source.
    pub constraints: Vec<ConstraintForce<P>>,
}

/// The force of a constraint in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct ConstraintForce<P> {
    /// The constraint: `rod`, `rods[0]`.
    pub name: &'static str,
    /// The multiplier λ at the start of the step.
    pub at_start: f64,
    /// The multiplier μ at the end of the step.
    pub at_end: f64,
    /// The mean force, `(λ ∂φ/∂q(q₀) + μ ∂φ/∂q(q₁))/h`.
    pub mean: P,
}

impl<P> ConstraintForces<P> {
    /// Returns the force of a constraint by its name.
    #[must_use]
    pub fn get(&self, name: &str) -> Option<&ConstraintForce<P>> {
        self.constraints.iter().find(|force| force.name == name)
    }
}

impl<S, R, Q, const N: usize, const M: usize> Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself> + TellsImpulses,
    Q: VectorCoordinates<N>,
{
    /// Returns the forces of the constraints in the step of length `h` from `state`: the impulses
    /// at both ends, and their mean force, in the units of the Lagrangian.
    ///
    /// The tension of a rod between two points is the length of its mean force on one of them.
    /// Without noise the mean force converges to the force of the constraint at order 1, at the
    /// middle of the step at order 2 with a symmetric rule. **With noise it has a part that grows
    /// like `h^(−1/2)`**: the constraint balances white noise too, whose mean over a step is
    /// `ΔW/h`. Averages over times that are long beside h converge.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A mass on a rod.
    /// struct Swing { g: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Swing {
    ///     fn lagrangian(&self, q: Vector2<f64>, v: Vector2<f64>) -> f64 {
    ///         0.5 * v.norm_squared() - self.g * q.y
    ///     }
    ///     #[constraint]
    ///     fn rod(&self, q: Vector2<f64>) -> f64 {
    ///         0.5 * (q.norm_squared() - 1.0)
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let swing = Integrator::new(Swing { g: 9.8 }, Midpoint);
    /// let hanging = State::new(Vector2::new(0.0, -1.0), Vector2::new(2.0, 0.0));
    /// let forces = swing.constraint_forces(&hanging, 1e-4, &[])?;
    /// // m g + m v²/l
    /// assert!((forces.mean.norm() - 13.8).abs() < 1e-6);
    /// assert_eq!(forces.get("rod").unwrap().mean, forces.mean);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn constraint_forces(
        &self,
        state: &State<Q>,
        h: f64,
        dw: &R::Increments,
    ) -> Result<ConstraintForces<Q::Momentum>, StepError> {
        let prepared = self.prepare(h)?;
        let system = self.system();
        let start = state.to_coordinates();
        let mut end = start;
        let mut multipliers = Vec::new();
        let visit = &mut |multiplier| multipliers.push(multiplier);
        walk_from(
            self.walker(),
            &prepared,
            &mut end,
            h,
            dw,
            Impulses { visit },
        )?;
        let slopes = |state: &State<[f64; N]>| {
            let mut slopes: Vec<[f64; N]> = Vec::new();
            system.constraint_jets(state.t, &state.q, &mut |jet| slopes.push(jet.dq));
            slopes
        };
        let (first, last) = (slopes(&start), slopes(&end));
        let mut impulses = [[0.0; N]; 2];
        let mut constraints = Vec::new();
        for (k, &name) in S::CONSTRAINTS.iter().enumerate() {
            let [lambda, mu] = [k, S::CONSTRAINTS.len() + k].map(|at| multipliers[at]);
            let mut mean = [0.0; N];
            for i in 0..N {
                let [at_start, at_end] = [lambda * first[k][i], mu * last[k][i]];
                impulses[0][i] += at_start;
                impulses[1][i] += at_end;
                mean[i] = (at_start + at_end) / h;
            }
            constraints.push(ConstraintForce {
                name,
                at_start: lambda,
                at_end: mu,
                mean: Q::from_components(&mean),
            });
        }
        let [at_start, at_end] = impulses;
        let mean: [f64; N] = core::array::from_fn(|i| (at_start[i] + at_end[i]) / h);
        Ok(ConstraintForces {
            at_start: Q::from_components(&at_start),
            at_end: Q::from_components(&at_end),
            mean: Q::from_components(&mean),
            constraints,
        })
    }
}

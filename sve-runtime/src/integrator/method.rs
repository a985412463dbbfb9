//! An integrator is a [`Method`].

use core::any::type_name;
use core::hash::Hasher;

use super::Integrator;
use super::accept::check_step_size;
use super::compensated::compensated_step;
use super::step::solve_step;
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::lanes::{Lane, Mask, StateLanes};
use crate::method::Method;
use crate::plan::StrongOrder;
use crate::solve::newton::{BlockSolver, Newton};
use crate::state::State;
use crate::system::{Dims, System, Variational};

impl<S, R, Q, const N: usize, const M: usize> Method for Integrator<S, R>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    type System = S;
    type Prepared = S::Prepared;

    fn system(&self) -> &S {
        Integrator::system(self)
    }

    #[inline]
    fn prepare(&self, h: f64) -> Result<S::Prepared, StepError> {
        check_step_size(h)?;
        Ok(Integrator::system(self).prepare(h))
    }

    #[inline]
    fn step_prepared(
        &self,
        prepared: &S::Prepared,
        state: &mut State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        Q::in_coordinates(state, |state| {
            solve_step(self, prepared, state, h, dw).map(|_| ())
        })
    }

    #[inline(always)]
    fn step_lanes(
        &self,
        prepared: &S::Prepared,
        states: &StateLanes<N>,
        next: &mut StateLanes<N>,
        h: f64,
        dw: &[Lane; M],
    ) -> Mask {
        Integrator::system(self).increment_lanes(prepared, states, next, h, dw, self.newton())
    }

    fn has_compensated_step(&self) -> bool {
        !S::RETURNS.is_state()
    }

    #[inline]
    fn compensated_step(
        &self,
        prepared: &S::Prepared,
        state: &mut State<Q>,
        low: &mut State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Result<(), StepError> {
        compensated_step(self, prepared, state, low, h, dw)
    }

    fn identify(&self, to: &mut dyn Hasher) {
        to.write(type_name::<R>().as_bytes());
        // the printed form of a number is the shortest one that reads back as the same number
        to.write(format!("{:?}", self.newton()).as_bytes());
    }

    fn order(&self) -> Option<f64> {
        let plan = self.plan();
        Some(match plan.strong_order {
            StrongOrder::Deterministic => f64::from(plan.deterministic_order),
            StrongOrder::One => 1.0,
            StrongOrder::Half { .. } => 0.5,
        })
    }

    /// Finds the lowest limit of iterations with which the step has the same bits: with a lower limit an attempt fails, and the next attempt reaches the root
    /// along another path.
    fn newton_iterations(
        &self,
        prepared: &S::Prepared,
        state: &State<Q>,
        h: f64,
        dw: &[f64; M],
    ) -> Option<u32> {
        let state = &state.to_coordinates();
        let increment = |max_iterations| {
            let newton = Newton {
                max_iterations,
                ..*self.newton()
            };
            let (q, p, _) = Integrator::system(self)
                .increment(prepared, state, h, dw, &BlockSolver::new(&newton))
                .ok()?;
            Some((q, p))
        };
        let max_iterations = self.newton().max_iterations;
        let step = increment(max_iterations)?;
        (0..=max_iterations).find(|&limit| increment(limit) == Some(step))
    }
}

//! The equations of a step of a Gauss rule, solved by Newton's method with their analytic Jacobian.
//!
//! Unknowns are the velocities `V_i` of the stages, component by component, and behind them the
//! displacements `Y_i` if a noise moves positions. Without such a noise `Y_i = h b_i V_i` is no
//! unknown. Residuals, with the notation of `step.rs`:
//!
//! ```text
//! L_v(Q_i, V_i) − p₀ − Σ_j μ_ij F_j          Y_i − h b_i V_i − Σ_a ∂G_a/∂p ω_ai
//! ```

use super::bounds::{StageBounds, Uniqueness};
use super::connected::{Solution, is_connected};
use super::jacobian::{displacement, jacobian, moves_position, velocity};
use super::step::{Stage, Step, at_stage, total};
use super::tableau::Tableau;
use crate::mechanics::legendre;
use crate::phase::configuration::VectorCoordinates;
use crate::solve::SolveError;
use crate::solve::dense::{self, DeterminantSign};
use crate::solve::newton::{BlockProperties, BlockSolver, Evaluation};
use crate::system::{Dims, System};

/// Increments of a step, and its unknowns.
pub(super) type Solved<const N: usize, const K: usize> = ([f64; N], [f64; N], [f64; K]);

/// The unknowns of a step as velocities and displacements.
pub(super) struct Unknowns<const S: usize, const N: usize> {
    pub(super) velocities: [[f64; N]; S],
    pub(super) displacements: [[f64; N]; S],
    /// Positions relative to the start.
    pub(super) moves: [[f64; N]; S],
}

impl<Sys, Q, const S: usize, const N: usize, const M: usize> Step<'_, Sys, S, N, M>
where
    Sys: StageBounds<N, M, Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    /// Solves the step.
    ///
    /// # Errors
    /// As [`BlockSolver::solve_block`]; [`SolveError::OtherBranch`] if the step has to be judged
    /// and bounds do not prove that the solution is connected.
    pub(super) fn solve<const K: usize>(
        &self,
        solver: &BlockSolver<'_>,
    ) -> Result<Solved<N, K>, SolveError> {
        let start = self.velocity_at_start();
        let (guess, sign) = match start {
            Ok(start) => start,
            Err(error) if solver.is_fast_path() => return Err(error),
            Err(_) => ([0.0; N], DeterminantSign::UNKNOWN),
        };
        let block = BlockProperties {
            first: 0,
            has_bounds: Sys::UNIQUENESS != Uniqueness::Unknown,
            needs_strong_contraction: Sys::UNIQUENESS == Uniqueness::Unknown,
            limit_sign: sign,
        };
        let x = solver.solve_block(
            block,
            &self.guess(&guess),
            || self.constant_velocity(&guess),
            |x| self.rounding(x),
            |x| self.evaluate(x),
        )?;
        self.judged(x, &guess, solver.tests_bounds())
    }

    /// Returns the increments of a solution; `start` is the velocity at the start. If `is_judged`,
    /// returns only the connected solution.
    ///
    /// A separate function, so that the jets of many coordinates are not on the stack beside
    /// Newton's matrix.
    #[inline(never)]
    fn judged<const K: usize>(
        &self,
        x: [f64; K],
        start: &[f64; N],
        is_judged: bool,
    ) -> Result<Solved<N, K>, SolveError> {
        let unknowns = self.unknowns(&x);
        let stages = self.stages(&unknowns);
        let impulses = stages.each_ref().map(|stage| stage.impulse.value);
        let solved = (total(&unknowns.displacements), total(&impulses), x);
        if !is_judged {
            return Ok(solved);
        }
        let is_accepted = match Sys::UNIQUENESS {
            Uniqueness::Linear | Uniqueness::Unknown => true,
            Uniqueness::Bounded => {
                let solution = self.solution(&unknowns, &stages, start);
                is_connected::<_, _, S, N, M, K>(self, &solution)
            }
        };
        if is_accepted {
            Ok(solved)
        } else {
            Err(SolveError::OtherBranch)
        }
    }

    /// Returns the solution in the form for the proof, with the velocity at the start.
    #[inline]
    fn solution(
        &self,
        unknowns: &Unknowns<S, N>,
        stages: &[Stage<N>; S],
        start: &[f64; N],
    ) -> Solution<S, N> {
        let mut solution = Solution {
            start: *start,
            moves: [[0.0; S]; N],
            changes: [[0.0; S]; N],
            kicks: [[0.0; S]; N],
        };
        for i in 0..S {
            for n in 0..N {
                solution.moves[n][i] = unknowns.moves[i][n];
                solution.changes[n][i] = unknowns.velocities[i][n] - start[n];
                solution.kicks[n][i] = stages[i].lagrangian.dv[n] - self.state.p[n];
            }
        }
        solution
    }
}

impl<Sys, Q, const S: usize, const N: usize, const M: usize> Step<'_, Sys, S, N, M>
where
    Sys: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
{
    /// Returns the velocity at the start, and the sign of the Jacobian's determinant in the limit
    /// of no noise and h → 0. In this limit the determinant is a product of one determinant of the
    /// mass matrix for each stage.
    fn velocity_at_start(&self) -> Result<([f64; N], DeterminantSign), SolveError> {
        let v = legendre::velocity(self.system, self.state)?;
        let mass = self
            .system
            .lagrangian_jet(self.state.t, &self.state.q, &v)
            .dvv;
        let (_, sign) = dense::solve_with_sign(&mass, &[0.0; N])
            .ok_or(SolveError::Singular { iteration: 0 })?;
        let even = DeterminantSign::of(1.0);
        Ok((v, if S.is_multiple_of(2) { even } else { sign }))
    }

    /// Returns the unknowns with the velocity `v` at all stages.
    fn constant_velocity<const K: usize>(&self, v: &[f64; N]) -> [f64; K] {
        let mut x = [0.0; K];
        for i in 0..S {
            for n in 0..N {
                x[velocity::<S>(i, n)] = v[n];
                if moves_position::<S, N, K>() {
                    x[displacement::<S, N>(i, n)] = self.weights[i] * v[n];
                }
            }
        }
        x
    }

    /// Returns the unknowns for a velocity that changes linearly in time, with acceleration and
    /// noise of the start.
    fn guess<const K: usize>(&self, v: &[f64; N]) -> [f64; K] {
        let mut x = self.constant_velocity(v);
        let Step { system, state, .. } = *self;
        let jet = system.lagrangian_jet(state.t, &state.q, v);
        let mut kick = [0.0; N];
        for m in 0..N {
            let mut force = jet.dq[m] - jet.dvt[m];
            for n in 0..N {
                force -= jet.dqv[n][m] * v[n];
            }
            kick[m] = self.h * force;
        }
        if Sys::FORCED {
            let force = system.force_jet(state.t, &state.q, v);
            for m in 0..N {
                kick[m] += self.h * force.value[m];
            }
        }
        if Sys::NOISE_FORCED {
            let forces = system.noise_force_jets(state.t, &state.q, v);
            for (force, parts) in forces.iter().zip(&self.noise) {
                let dw: f64 = parts.iter().sum();
                for m in 0..N {
                    kick[m] += dw * force.value[m];
                }
            }
        }
        let noises = system.noise_jets(state.t, &state.q, &state.p);
        for (jet, parts) in noises.iter().zip(&self.noise) {
            let dw: f64 = parts.iter().sum();
            for m in 0..N {
                kick[m] -= dw * jet.dq[m];
            }
            for i in 0..S {
                for n in 0..N {
                    if moves_position::<S, N, K>() {
                        x[displacement::<S, N>(i, n)] += parts[i] * jet.dp[n];
                    }
                }
            }
        }
        let Some(change) = dense::solve(&jet.dvv, &kick) else {
            return x;
        };
        let c = const { &Tableau::<S>::VALUES.c };
        for i in 0..S {
            for n in 0..N {
                x[velocity::<S>(i, n)] += c[i] * change[n];
            }
        }
        x
    }

    /// Returns the unknowns as velocities, displacements and positions.
    #[inline]
    pub(super) fn unknowns<const K: usize>(&self, x: &[f64; K]) -> Unknowns<S, N> {
        let mut all = Unknowns {
            velocities: [[0.0; N]; S],
            displacements: [[0.0; N]; S],
            moves: [[0.0; N]; S],
        };
        for i in 0..S {
            for n in 0..N {
                all.velocities[i][n] = x[velocity::<S>(i, n)];
                all.displacements[i][n] = if moves_position::<S, N, K>() {
                    x[displacement::<S, N>(i, n)]
                } else {
                    self.weights[i] * x[velocity::<S>(i, n)]
                };
            }
        }
        for i in 0..S {
            all.moves[i] = at_stage(i, &all.displacements);
        }
        all
    }

    /// Evaluates the jets at all stages.
    #[inline]
    pub(super) fn stages(&self, unknowns: &Unknowns<S, N>) -> [Stage<N>; S] {
        // in place: `array::from_fn` would pass copies of the largest arrays through the stack
        let mut stages = [Stage::EMPTY; S];
        for i in 0..S {
            let mut q = self.state.q;
            for n in 0..N {
                q[n] += unknowns.moves[i][n];
            }
            stages[i] = self.stage(i, &q, &unknowns.velocities[i]);
        }
        stages
    }

    /// Evaluates the residuals, the magnitudes of their terms and the Jacobian.
    fn evaluate<const K: usize>(&self, x: &[f64; K]) -> Evaluation<K> {
        let unknowns = self.unknowns(x);
        let stages = self.stages(&unknowns);
        let mut at = Evaluation {
            residual: [0.0; K],
            magnitude: [0.0; K],
            jacobian: [[0.0; K]; K],
            curvature: f64::NAN,
        };
        for i in 0..S {
            self.momentum_equation(i, &unknowns, &stages, &mut at);
            if moves_position::<S, N, K>() {
                self.displacement_equation(i, &unknowns, &stages[i], &mut at);
            }
        }
        jacobian(&self.weights, &stages, &mut at.jacobian);
        at
    }

    /// Adds the equation `L_v(Q_i, V_i) − p₀ − Σ_j μ_ij F_j`.
    #[inline]
    fn momentum_equation<const K: usize>(
        &self,
        i: usize,
        unknowns: &Unknowns<S, N>,
        stages: &[Stage<N>; S],
        at: &mut Evaluation<K>,
    ) {
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        let lagrangian = &stages[i].lagrangian;
        for n in 0..N {
            let (mut sum, mut size) = (0.0, 0.0);
            for j in 0..S {
                let term = ratio[j][i] * stages[j].impulse.value[n];
                sum += term;
                size += term.abs();
            }
            for k in 0..N {
                size += (lagrangian.dvv[n][k] * unknowns.velocities[i][k]).abs();
            }
            let (p, p0) = (lagrangian.dv[n], self.state.p[n]);
            at.residual[velocity::<S>(i, n)] = (p - p0) - sum;
            at.magnitude[velocity::<S>(i, n)] = size + p.abs() + p0.abs();
        }
    }

    /// Adds the equation `Y_i − h b_i V_i − Σ_a ∂G_a/∂p ω_ai`.
    #[inline]
    fn displacement_equation<const K: usize>(
        &self,
        i: usize,
        unknowns: &Unknowns<S, N>,
        stage: &Stage<N>,
        at: &mut Evaluation<K>,
    ) {
        for n in 0..N {
            let moved = unknowns.displacements[i][n];
            let flow = self.weights[i] * unknowns.velocities[i][n];
            let shift = stage.shift.value[n];
            let row = displacement::<S, N>(i, n);
            at.residual[row] = moved - flow - shift;
            at.magnitude[row] = moved.abs() + flow.abs() + shift.abs();
        }
    }

    /// Bounds the rounding errors of the residuals.
    #[cold]
    fn rounding<const K: usize>(&self, x: &[f64; K]) -> [f64; K] {
        let ratio = const { &Tableau::<S>::VALUES.ratio };
        let stages = self.stages(&self.unknowns(x));
        let mut bounds = [0.0; K];
        for i in 0..S {
            for n in 0..N {
                for j in 0..S {
                    bounds[velocity::<S>(i, n)] += (ratio[j][i] * stages[j].rounding[n]).abs();
                }
            }
        }
        bounds
    }
}

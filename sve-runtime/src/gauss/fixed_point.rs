//! The equations of a step of a Gauss rule, solved by fixed-point iteration with the stages in
//! lanes.
//!
//! Input: a step whose velocities follow from positions and momenta. Output: the increments and the
//! unknowns of Newton's method; `None` if the iteration does not contract. A sweep is partitioned
//! (Gauss–Seidel): impulses and momenta from the positions, then positions from the new momenta.
//!
//! - [`solve_second_order`]: L = ½⟨v, Mv⟩ − V(t, q) with constant M, and a force and noises that
//!   depend on the position alone. Only impulses are iterated,
//!   `Q_i = q₀ + h c_i M⁻¹p₀ + Σ_j h η_ij M⁻¹F_j`.
//! - `partitioned.rs`: ∂L/∂v affine in v; masses, force and noises of any form.
//!
//! Both run with the widest vectors of the machine. Their loops have no branches, and call the
//! elementary functions for lanes. Source: Antoñana, Makazaga, Murua, *Efficient implementation of
//! symplectic implicit Runge–Kutta schemes with simplified Newton iterations* (2017), for the
//! increments as unknowns; Hairer, Lubich, Wanner, *Geometric Numerical Integration* (2006),
//! section VIII.6.

use super::convergence::{Course, Verdict};
use super::jacobian::velocity;
use super::newton::Solved;
use super::scaled::{Scaled, SecondOrderCoefficients};
use super::stages::{Matrix, Rows, at_stages, inverse_size, product, relative_change, sum};
use super::step::Step;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::system::System;

/// The stages of a step, one in each lane.
#[derive(Clone, Copy, Debug)]
pub struct StageLanes<'a, const S: usize, const N: usize, const M: usize> {
    /// `h b_i`.
    pub weights: &'a [f64; S],
    /// Times of the stages.
    pub times: &'a [f64; S],
    /// The position at the start.
    pub q: &'a [f64; N],
    /// Positions of the stages relative to the start, a row for each coordinate.
    pub moves: &'a [[f64; S]; N],
    /// The momentum at the start.
    pub p: &'a [f64; N],
    /// The parts of the increments, a row for each process.
    pub noise: &'a [[f64; S]; M],
}

/// A system of the form ½⟨v, Mv⟩ − V(t, q) with constant masses M, whose force and noises depend on
/// time and position alone.
pub trait SecondOrder<const N: usize, const M: usize>: System {
    /// True if M is diagonal.
    const HAS_DIAGONAL_MASS: bool;
    /// Computes the impulses `h b_i (∂L/∂q + F) − Σ ∂G_a/∂q ω_ai` of the stages. NaN where L is not
    /// defined.
    fn impulses<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, M>,
        impulses: &mut [[f64; S]; N],
    );
}

/// Solves a step of a system of second order, starting from the impulses of the step before or from
/// the motion with constant velocity. Returns the impulses beside the solution; `None` if the
/// iteration does not contract.
pub(super) fn solve_second_order<
    Sys,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
>(
    step: &Step<'_, Sys, S, N, M>,
    coefficients: &SecondOrderCoefficients<S, N>,
    before: Option<&Rows<S, N>>,
) -> Option<(Solved<N, K>, Rows<S, N>)>
where
    Sys: SecondOrder<N, M>,
{
    let ahead = &coefficients.second_order_ahead;
    dispatch(SecondOrderIteration::<_, S, N, M, K> {
        step,
        inverse_mass: &coefficients.inverse_mass,
        scaled: &coefficients.scaled,
        guess: before.map(|impulses| (ahead, impulses)),
        course: Course::new(),
    })
}

/// The iteration of a step of a system of second order.
pub(super) struct SecondOrderIteration<
    'a,
    Sys,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
> {
    pub(super) step: &'a Step<'a, Sys, S, N, M>,
    pub(super) inverse_mass: &'a [[f64; N]; N],
    pub(super) scaled: &'a Scaled<S>,
    /// Impulses, and the matrix that gives the first displacements from them.
    pub(super) guess: Option<(&'a Matrix<S>, &'a Rows<S, N>)>,
    pub(super) course: Course,
}

impl<Sys, const S: usize, const N: usize, const M: usize, const K: usize> Kernel
    for SecondOrderIteration<'_, Sys, S, N, M, K>
where
    Sys: SecondOrder<N, M>,
{
    type Output = Option<(Solved<N, K>, Rows<S, N>)>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let step = in_own_memory(self.step);
        let Step { state, tableau, .. } = step;
        let Scaled {
            nodes,
            rest,
            second_order,
        } = self.scaled;
        let start = self.velocity(&state.p.map(|p| [p]));
        // The motion with constant velocity, relative to the start.
        let mut free = [[0.0; S]; N];
        for n in 0..N {
            for i in 0..S {
                free[n][i] = nodes[i] * start[n][0];
            }
        }
        let none = [[0.0; S]; N];
        let mut moves = match self.guess {
            Some((matrix, impulses)) => self.moves(&free, matrix, impulses),
            None => self.moves(&free, second_order, &none),
        };
        let mut inverse_sizes = [0.0; N];
        for n in 0..N {
            inverse_sizes[n] = inverse_size(state.q[n], &moves[n]);
        }
        let mut course = self.course;
        let mut impulses = none;
        loop {
            step.system.impulses(&step.lanes(&moves), &mut impulses);
            let next = self.moves(&free, second_order, &impulses);
            let change = relative_change(&mut moves, &next, &inverse_sizes);
            moves = next;
            match course.judge(change) {
                Verdict::Continue => {}
                Verdict::Converged => break,
                Verdict::Leave => return None,
            }
        }
        step.system.impulses(&step.lanes(&moves), &mut impulses);
        let velocities = self.velocity(&at_stages(tableau, &impulses));
        let mut late = [[0.0]; N];
        for n in 0..N {
            let mut terms = [0.0; S];
            for i in 0..S {
                terms[i] = rest[i] * impulses[n][i];
            }
            late[n][0] = sum(&terms);
        }
        let late = self.velocity(&late);
        let (mut dq, mut dp, mut x) = ([0.0; N], [0.0; N], [0.0; K]);
        for n in 0..N {
            for i in 0..S {
                x[velocity::<S>(i, n)] = start[n][0] + velocities[n][i];
            }
            // h = h c₁ + h (1 − c₁): the sum that is added to the position has more digits than the
            // momentum.
            dq[n] = nodes[0] * start[n][0] + (rest[0] * start[n][0] + late[n][0]);
            dp[n] = sum(&impulses[n]);
        }
        Some(((dq, dp, x), impulses))
    }
}

impl<Sys, const S: usize, const N: usize, const M: usize, const K: usize>
    SecondOrderIteration<'_, Sys, S, N, M, K>
where
    Sys: SecondOrder<N, M>,
{
    /// Returns positions relative to the start, `free + M⁻¹ Σ_j h η_ij F_j`, for the columns of
    /// `h η`.
    #[inline(always)]
    fn moves(
        &self,
        free: &Rows<S, N>,
        second_order: &[[f64; S]; S],
        impulses: &Rows<S, N>,
    ) -> Rows<S, N> {
        let mut moves = [[0.0; S]; N];
        if Sys::HAS_DIAGONAL_MASS {
            for n in 0..N {
                let pushed = product(second_order, &impulses[n]);
                for i in 0..S {
                    moves[n][i] = free[n][i] + self.inverse_mass[n][n] * pushed[i];
                }
            }
            return moves;
        }
        for n in 0..N {
            moves[n] = product(second_order, &impulses[n]);
        }
        let mut moves = self.velocity(&moves);
        for n in 0..N {
            for i in 0..S {
                moves[n][i] += free[n][i];
            }
        }
        moves
    }

    /// Returns the velocities of the given momenta.
    #[inline(always)]
    fn velocity<const L: usize>(&self, momenta: &Rows<L, N>) -> Rows<L, N> {
        let inverse_mass = self.inverse_mass;
        let mut velocities = [[0.0; L]; N];
        for n in 0..N {
            if Sys::HAS_DIAGONAL_MASS {
                for i in 0..L {
                    velocities[n][i] = inverse_mass[n][n] * momenta[n][i];
                }
            } else {
                for m in 0..N {
                    for i in 0..L {
                        velocities[n][i] += inverse_mass[n][m] * momenta[m][i];
                    }
                }
            }
        }
        velocities
    }
}

/// Returns a copy of a step. A loop over its stages writes to memory that is not that of the copy,
/// which the compiler has to know before it puts the stages into vectors; of a reference it does
/// not know it.
#[inline(always)]
pub(super) fn in_own_memory<'a, Sys, const S: usize, const N: usize, const M: usize>(
    step: &Step<'a, Sys, S, N, M>,
) -> Step<'a, Sys, S, N, M> {
    *step
}

impl<Sys, const S: usize, const N: usize, const M: usize> Step<'_, Sys, S, N, M> {
    /// Returns the stages at these positions relative to the start.
    #[inline(always)]
    pub(super) fn lanes<'a>(&'a self, moves: &'a Rows<S, N>) -> StageLanes<'a, S, N, M> {
        StageLanes {
            weights: &self.weights,
            times: &self.times,
            q: &self.state.q,
            moves,
            p: &self.state.p,
            noise: &self.noise,
        }
    }
}

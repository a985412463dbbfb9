//! The fixed-point iteration of a step of a Gauss rule with ∂L/∂v affine in v: masses, force and
//! noises of any form.
//!
//! Input and output as in `fixed_point.rs`. A sweep goes from positions to impulses and momenta,
//! and from the new momenta to positions.

use super::convergence::{Course, Verdict};
use super::fixed_point::{StageLanes, in_own_memory};
use super::jacobian::{displacement, moves_position, velocity};
use super::newton::Solved;
use super::stages::{Matrix, Rows, at_stages, inverse_size, larger, product, relative_change, sum};
use super::step::Step;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::system::System;

/// A system with ∂L/∂v = M(t, q) v + a(t, q).
pub trait Partitioned<const N: usize, const M: usize>: System {
    /// Computes the impulses `h b_i (∂L/∂q + F) − Σ ∂G_a/∂q ω_ai` of the stages from positions and
    /// momenta, with the masses. `kicks` are momenta relative to the start. NaN where L is not
    /// defined.
    fn impulses<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, M>,
        kicks: &[[f64; S]; N],
        impulses: &mut [[f64; S]; N],
        masses: &mut Masses<S, N>,
    );
    /// Computes velocities and displacements of the stages from the masses and new momenta.
    fn displacements<const S: usize>(
        &self,
        stages: &StageLanes<'_, S, N, M>,
        kicks: &[[f64; S]; N],
        masses: &Masses<S, N>,
        motion: &mut Motion<S, N>,
    );
}

/// The masses and offsets that give velocities at the stages from momenta, `v = M⁻¹ (p − a)`.
#[derive(Clone, Copy, Debug)]
pub struct Masses<const S: usize, const N: usize> {
    /// M⁻¹. If M is diagonal, only the diagonal is set.
    pub inverse: [[[f64; S]; N]; N],
    /// The offset a.
    pub offset: [[f64; S]; N],
}

impl<const S: usize, const N: usize> Masses<S, N> {
    const ZERO: Self = Self {
        inverse: [[[0.0; S]; N]; N],
        offset: [[0.0; S]; N],
    };
}

/// Velocities and displacements of the stages, a row for each coordinate.
#[derive(Clone, Copy, Debug)]
pub struct Motion<const S: usize, const N: usize> {
    /// Velocities.
    pub velocities: [[f64; S]; N],
    /// `h b_i v + Σ ∂G_a/∂p ω_ai`.
    pub displacements: [[f64; S]; N],
}

impl<const S: usize, const N: usize> Motion<S, N> {
    const ZERO: Self = Self {
        velocities: [[0.0; S]; N],
        displacements: [[0.0; S]; N],
    };
}

/// Solves a step of a system with ∂L/∂v affine in v, starting from the stages of the step before or
/// from the start. Returns displacements and impulses beside the solution; `None` if the iteration
/// does not contract.
pub(super) fn solve_partitioned<
    Sys,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
>(
    step: &Step<'_, Sys, S, N, M>,
    before: Option<&[Rows<S, N>; 2]>,
) -> Option<(Solved<N, K>, [Rows<S, N>; 2])>
where
    Sys: Partitioned<N, M>,
{
    let ahead = &step.tableau.ratio_ahead;
    dispatch(PartitionedIteration::<_, S, N, M, K> {
        step,
        guess: before.map(|stages| (ahead, stages)),
        course: Course::new(),
    })
}

/// The iteration of a step of a system with ∂L/∂v affine in v.
pub(super) struct PartitionedIteration<
    'a,
    Sys,
    const S: usize,
    const N: usize,
    const M: usize,
    const K: usize,
> {
    pub(super) step: &'a Step<'a, Sys, S, N, M>,
    /// Displacements and impulses, and the matrix that gives the first stages from them.
    pub(super) guess: Option<(&'a Matrix<S>, &'a [Rows<S, N>; 2])>,
    pub(super) course: Course,
}

impl<Sys, const S: usize, const N: usize, const M: usize, const K: usize> Kernel
    for PartitionedIteration<'_, Sys, S, N, M, K>
where
    Sys: Partitioned<N, M>,
{
    type Output = Option<(Solved<N, K>, [Rows<S, N>; 2])>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let step = in_own_memory(self.step);
        let Step { state, tableau, .. } = step;
        // Displacements and impulses are relative to the start; nothing moves in the limit of no
        // noise and h → 0.
        let (mut moves, mut kicks) = ([[0.0; S]; N], [[0.0; S]; N]);
        if let Some((matrix, [displacements, impulses])) = self.guess {
            for n in 0..N {
                moves[n] = product(matrix, &displacements[n]);
                kicks[n] = product(matrix, &impulses[n]);
            }
        }
        let mut inverse_sizes = [[0.0; N]; 2];
        let mut course = self.course;
        let mut has_converged = false;
        // In each sweep they are written anew. Here they are cleared once.
        let (mut impulses, mut masses, mut motion) = ([[0.0; S]; N], Masses::ZERO, Motion::ZERO);
        loop {
            let stages = step.lanes(&moves);
            (step.system).impulses(&stages, &kicks, &mut impulses, &mut masses);
            let new_kicks = at_stages(tableau, &impulses);
            (step.system).displacements(&stages, &new_kicks, &masses, &mut motion);
            if has_converged {
                let stages = [motion.displacements, impulses];
                return Some((increments(&motion, &impulses), stages));
            }
            let new_moves = at_stages(tableau, &motion.displacements);
            if course.is_new() {
                for n in 0..N {
                    inverse_sizes[0][n] = inverse_size(state.q[n], &new_moves[n]);
                    inverse_sizes[1][n] = inverse_size(state.p[n], &new_kicks[n]);
                }
            }
            let [of_q, of_p] = &inverse_sizes;
            let moved = relative_change(&mut moves, &new_moves, of_q);
            let kicked = relative_change(&mut kicks, &new_kicks, of_p);
            let change = larger(moved, kicked);
            (moves, kicks) = (new_moves, new_kicks);
            match course.judge(change) {
                Verdict::Continue => {}
                Verdict::Converged => has_converged = true,
                Verdict::Leave => return None,
            }
        }
    }
}

/// Returns the increments and unknowns of the last sweep.
#[inline(always)]
fn increments<const S: usize, const N: usize, const K: usize>(
    motion: &Motion<S, N>,
    impulses: &Rows<S, N>,
) -> Solved<N, K> {
    let (mut dq, mut dp, mut x) = ([0.0; N], [0.0; N], [0.0; K]);
    for n in 0..N {
        dq[n] = sum(&motion.displacements[n]);
        dp[n] = sum(&impulses[n]);
        for i in 0..S {
            x[velocity::<S>(i, n)] = motion.velocities[n][i];
            if moves_position::<S, N, K>() {
                x[displacement::<S, N>(i, n)] = motion.displacements[n][i];
            }
        }
    }
    (dq, dp, x)
}

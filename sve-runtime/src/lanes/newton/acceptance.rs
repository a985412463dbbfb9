//! Which roots an iteration in lanes accepts.
//!
//! Input: the evaluations of an iteration. Output: whether a lane goes on. The two kinds are those of the scalar method, see the header of
//! `solve/newton/mod.rs`.

use super::Update;
use crate::lanes::solve::{solve, solve_with_sign};
use crate::lanes::{LANES, Lane};
use crate::solve::newton::convergence::{Evaluation, ROOT_OF_ROUNDING};

/// Which roots are accepted.
pub trait Acceptance<const K: usize> {
    /// Nothing known of any lane.
    fn new() -> Self;
    /// Solves for the update. Returns a number with the sign of the determinant too, where [`passes`](Self::passes) asks for it.
    fn solve(jacobian: &[[f64; K]; K], residual: &[f64; K]) -> ([f64; K], f64);
    /// Returns whether a lane may make an update from an evaluation; `previous` is the relative residual of the evaluation before.
    fn passes(&self, lane: usize, at: &Evaluation<K>, previous: f64, update: &Update<K>) -> bool;
    /// Records an evaluation with this relative residual.
    fn note(&mut self, lane: usize, at: &Evaluation<K>, relative: f64);
}

/// Any root of the iteration, which the step tests by bounds of the Jacobian afterwards.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct ByBounds<const K: usize> {
    /// The solutions in the limit of no noise and h → 0, for the bounds of the Jacobian.
    limit: [Lane; K],
}

impl<const K: usize> ByBounds<K> {
    #[inline(always)]
    pub(super) fn set_limit(&mut self, lane: usize, limit: [f64; K]) {
        for i in 0..K {
            self.limit[i][lane] = limit[i];
        }
    }

    #[inline(always)]
    pub(super) fn limit(&self, lane: usize) -> [f64; K] {
        core::array::from_fn(|i| self.limit[i][lane])
    }
}

impl<const K: usize> Acceptance<K> for ByBounds<K> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            limit: [[0.0; LANES]; K],
        }
    }

    #[inline(always)]
    fn solve(jacobian: &[[f64; K]; K], residual: &[f64; K]) -> ([f64; K], f64) {
        (solve(jacobian, residual), f64::NAN)
    }

    #[inline(always)]
    fn passes(&self, _: usize, _: &Evaluation<K>, _: f64, _: &Update<K>) -> bool {
        true
    }

    #[inline(always)]
    fn note(&mut self, _: usize, _: &Evaluation<K>, _: f64) {}
}

/// The root of a contracting iteration: every residual decreases by the contraction factor, and the determinant of every Jacobian has the sign that it has
/// in the limit of no noise and h → 0.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
pub struct ByContraction<const K: usize> {
    /// Largest residuals of the next evaluation with which the iteration contracts.
    largest: [Lane; K],
    /// Numbers with the sign of the determinant in the limit; NaN if it is unknown.
    sign: Lane,
}

impl<const K: usize> ByContraction<K> {
    #[inline(always)]
    pub(super) fn set_sign(&mut self, lane: usize, sign: f64) {
        self.sign[lane] = sign;
    }
}

impl<const K: usize> Acceptance<K> for ByContraction<K> {
    #[inline(always)]
    fn new() -> Self {
        Self {
            largest: [[f64::MAX; LANES]; K],
            sign: [f64::NAN; LANES],
        }
    }

    #[inline(always)]
    fn solve(jacobian: &[[f64; K]; K], residual: &[f64; K]) -> ([f64; K], f64) {
        solve_with_sign(jacobian, residual)
    }

    #[inline(always)]
    fn passes(&self, lane: usize, at: &Evaluation<K>, previous: f64, update: &Update<K>) -> bool {
        let mut is_within = true;
        for i in 0..K {
            is_within &= at.residual[i].abs() <= self.largest[i][lane];
        }
        let (sign, expected) = (update.sign, self.sign[lane]);
        let is_opposite = ((sign < 0.0) & (expected > 0.0)) | ((sign > 0.0) & (expected < 0.0));
        // At smaller residuals, rounding errors can prevent contraction.
        let is_contracting = is_within | (previous < ROOT_OF_ROUNDING);
        // For a single unknown, the condition for third order is Kantorovich's.
        is_contracting & !is_opposite & ((K > 1) | update.is_third_order)
    }

    #[inline(always)]
    fn note(&mut self, lane: usize, at: &Evaluation<K>, relative: f64) {
        let bounds = at.contraction_bounds(relative);
        for i in 0..K {
            self.largest[i][lane] = bounds[i];
        }
    }
}

//! The roots that an iteration in lanes accepts.
//!
//! Input: the evaluations of an iteration, with the Jacobian or with the solution of its linear
//! system. Output: true if a lane may continue. There are two kinds of acceptance, as in the scalar
//! method, see the header of `solve/newton/mod.rs`.

use super::Update;
use crate::lanes::solve::{Solved, solve};
use crate::lanes::{LANES, Lane};
use crate::solve::newton::convergence::{
    ERROR_OF_UPDATE, Evaluation, ROOT_OF_ROUNDING, STRONG_CONTRACTION,
};

/// The criterion by which roots are accepted.
pub trait Acceptance<const K: usize> {
    /// The Jacobian in an evaluation, or the solution of its linear system.
    type Jacobian;
    /// Returns a state without information about any lane.
    fn new() -> Self;
    /// Returns the slope of a single unknown.
    fn slope(jacobian: &Self::Jacobian) -> f64;
    /// Solves for the update of several unknowns.
    fn solve(jacobian: &Self::Jacobian, residual: &[f64; K]) -> Solved<K>;
    /// Returns whether a lane may make an update from an evaluation; `previous` is the relative
    /// residual of the evaluation before.
    fn passes(
        &self,
        lane: usize,
        at: &Evaluation<K, Self::Jacobian>,
        previous: f64,
        update: &Update<K>,
    ) -> bool;
    /// Records an evaluation with this relative residual.
    fn note(&mut self, lane: usize, at: &Evaluation<K, Self::Jacobian>, relative: f64);
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
    type Jacobian = [[f64; K]; K];

    #[inline(always)]
    fn new() -> Self {
        Self {
            limit: [[0.0; LANES]; K],
        }
    }

    #[inline(always)]
    fn slope(jacobian: &[[f64; K]; K]) -> f64 {
        jacobian[0][0]
    }

    #[inline(always)]
    fn solve(jacobian: &[[f64; K]; K], residual: &[f64; K]) -> Solved<K> {
        Solved {
            by: solve(jacobian, residual),
            determinant: f64::NAN,
        }
    }

    #[inline(always)]
    fn passes(&self, _: usize, _: &Evaluation<K>, _: f64, _: &Update<K>) -> bool {
        true
    }

    #[inline(always)]
    fn note(&mut self, _: usize, _: &Evaluation<K>, _: f64) {}
}

/// The root of a contracting iteration: every residual decreases by the contraction factor, and the
/// determinant of every Jacobian has the same sign as in the limit of no noise and h → 0.
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
    type Jacobian = Solved<K>;

    #[inline(always)]
    fn new() -> Self {
        Self {
            largest: [[f64::MAX; LANES]; K],
            sign: [f64::NAN; LANES],
        }
    }

    #[inline(always)]
    fn slope(solved: &Solved<K>) -> f64 {
        solved.determinant
    }

    #[inline(always)]
    fn solve(solved: &Solved<K>, _: &[f64; K]) -> Solved<K> {
        *solved
    }

    #[inline(always)]
    fn passes(
        &self,
        lane: usize,
        at: &Evaluation<K, Solved<K>>,
        previous: f64,
        update: &Update<K>,
    ) -> bool {
        let mut is_within = true;
        for i in 0..K {
            // If all terms were small at the previous point, the bound can be below the rounding
            // errors at this point.
            let rounding = ERROR_OF_UPDATE * at.magnitude[i];
            let (size, largest) = (at.residual[i].abs(), self.largest[i][lane]);
            is_within &= (size <= largest) | (size <= rounding);
        }
        let (sign, expected) = (update.solved.determinant, self.sign[lane]);
        let is_opposite = ((sign < 0.0) & (expected > 0.0)) | ((sign > 0.0) & (expected < 0.0));
        // At smaller residuals, rounding errors can prevent contraction.
        let is_contracting = is_within | (previous < ROOT_OF_ROUNDING);
        // For a single unknown, the condition for third order is Kantorovich's.
        is_contracting & !is_opposite & ((K > 1) | update.is_third_order)
    }

    #[inline(always)]
    fn note(&mut self, lane: usize, at: &Evaluation<K, Solved<K>>, relative: f64) {
        let bounds = at.contraction_bounds(relative, STRONG_CONTRACTION);
        for i in 0..K {
            self.largest[i][lane] = bounds[i];
        }
    }
}

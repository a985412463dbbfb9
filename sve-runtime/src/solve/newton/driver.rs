//! The driver of Newton's method: attempts, phases, and the decision when an iteration leaves the
//! fast path.
//!
//! The loop of [`Newton::solve_from`] is the fast path: evaluate, judge, update. Functions marked
//! `#[cold]` decide the rare cases. They get the iteration by value, so that its numbers stay in
//! registers on the fast path.

use super::convergence::{
    CONTRACTION, ERROR_OF_UPDATE, ROOT_OF_ROUNDING, are_comparable, judge, predicts_negligible,
};
use super::iteration::{Decision, Iteration, Judged, Phase};
use super::update::{Update, is_regular_with};
use super::{Evaluation, Newton};
use crate::solve::SolveError;
use crate::solve::dense::{DeterminantSign, Matrix};

/// Relative change of an unknown that is only rounding: an iteration at its root jumps between
/// neighbouring numbers, which differ by up to one unit of rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Halvings of an update in the line search.
const MAX_DAMPINGS: u32 = 24;

/// Largest residual at which a change of the unknowns by rounding alone ends the iteration.
const STEEP: f64 = 0.1;

/// The roots that a solve returns.
#[derive(Clone, Copy)]
pub(super) struct RootTest {
    /// The sign of the Jacobian's determinant in the limit of no noise and h → 0.
    pub(super) sign: DeterminantSign,
    pub(super) acceptance: Acceptance,
    /// Largest ratio of successive residuals at which the iteration counts as contracting.
    pub(super) contraction: f64,
}

/// The roots that are accepted beside the root of a contracting iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Acceptance {
    /// None.
    Contracting,
    /// A root of a single unknown with the right sign of the determinant along the segment from the
    /// guess: there is no fold between guess and root. For more unknowns a segment proves little,
    /// since paths lead around folds.
    OneUnknownOnSegment,
    /// Any root with the right sign of the determinant along the segment. Any root at all if the
    /// sign is unknown.
    Any,
}

impl RootTest {
    /// Returns whether a root in so many unknowns can be accepted if the iteration does not
    /// contract.
    #[inline(always)]
    fn accepts_without_contraction(self, unknowns: usize) -> bool {
        match self.acceptance {
            Acceptance::Contracting => false,
            Acceptance::OneUnknownOnSegment => unknowns == 1,
            Acceptance::Any => true,
        }
    }

    /// Returns whether the root of an iteration is accepted without following the segment from the
    /// guess.
    #[inline(always)]
    fn accepts<const K: usize>(self, iteration: &Iteration<K>) -> bool {
        iteration.is_contracting || (self.accepts_without_contraction(K) && self.sign.is_unknown())
    }
}

/// The attempts after the first: full steps from a second guess, then damped steps from the first.
struct Attempts<F> {
    fallback: Option<F>,
    are_over: bool,
}

impl<F> Attempts<F> {
    /// Returns the start of the next attempt.
    #[cold]
    #[inline(never)]
    fn next<const K: usize>(&mut self, guess: &[f64; K]) -> Option<Iteration<K>>
    where
        F: FnOnce() -> [f64; K],
    {
        if self.are_over {
            return None;
        }
        if let Some(fallback) = self.fallback.take() {
            // Contraction from another point proves nothing about the guess.
            return Some(Iteration {
                is_contracting: false,
                ..Iteration::new(fallback())
            });
        }
        self.are_over = true;
        Some(Iteration {
            phase: Phase::DampedSteps,
            ..Iteration::new(*guess)
        })
    }
}

impl Newton {
    /// Finds a root near `guess`, without a second guess or a test of the root.
    ///
    /// # Errors
    /// As [`solve_from`](Self::solve_from).
    #[inline]
    pub(crate) fn solve<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let test = RootTest {
            sign: DeterminantSign::UNKNOWN,
            acceptance: Acceptance::Any,
            contraction: CONTRACTION,
        };
        let no_fallback = None::<fn() -> [f64; K]>;
        self.solve_from(&guess, test, no_fallback, |_| [0.0; K], evaluate)
    }

    /// Finds a root and tests it.
    ///
    /// Attempts full steps from `guess`, then full steps from the point that `fallback` returns,
    /// then damped steps from `guess`. A later attempt is made only if the test can accept its
    /// root. `rounding` bounds the rounding errors of the residual at a point; it is called only if
    /// the residual stops decreasing.
    ///
    /// An update that leads out of the domain of the equations is halved until it stays inside. A
    /// guess outside of the domain moves towards zero in the same way: unknowns are increments or
    /// velocities, and at zero nothing moves.
    ///
    /// # Errors
    /// The [`SolveError`] of the last attempt.
    #[inline]
    pub(super) fn solve_from<const K: usize, J: Matrix<K>>(
        &self,
        guess: &[f64; K],
        test: RootTest,
        fallback: Option<impl FnOnce() -> [f64; K]>,
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let mut attempts = Attempts {
            are_over: fallback.is_none() || !test.accepts_without_contraction(K),
            fallback,
        };
        let mut iteration = Iteration::new(*guess);
        loop {
            // The only call of `evaluate`, so that the equations are compiled once, into this loop.
            let at = evaluate(&iteration.x);
            let residual = at.relative_residual();
            let update = at.update();
            let bounds = || at.contraction_bounds(residual, test.contraction);
            let verdict = judge(residual, iteration.previous_residual, self.tolerance);
            let iterates = !matches!(iteration.phase, Phase::Verification { .. });
            // If the Jacobian at the guess is singular, the guess is one of many roots or next to
            // no root.
            let is_root = if iterates
                && verdict.is_converged
                && (iteration.updates > 0 || is_regular_with(update.as_ref(), test.sign))
            {
                iteration.make_last_update(update.as_ref());
                true
            } else if iterates
                && verdict.has_halved
                && at.is_within(&iteration.contraction_bounds)
                && iteration.updates < self.max_iterations
                && let Some(update) = &update
                && let Some(is_root) =
                    self.update(&mut iteration, update, residual, &bounds(), test.sign)
            {
                is_root
            } else {
                let judged = Judged {
                    residual: at.residual,
                    magnitude: at.magnitude,
                    relative: residual,
                    update,
                    has_finite_jacobian: at.jacobian.is_finite(),
                };
                match self.leave_fast_path(iteration, judged, bounds(), test, guess, &rounding) {
                    Ok(Decision::Verified(root)) => return Ok(root),
                    Ok(Decision::Root(last)) => {
                        iteration = last;
                        true
                    }
                    Ok(Decision::Continue(next)) => {
                        iteration = next;
                        continue;
                    }
                    Err(error) => {
                        iteration = attempts.next(guess).ok_or(error)?;
                        continue;
                    }
                }
            };
            if is_root {
                if test.accepts(&iteration) {
                    return Ok(iteration.x);
                }
                if !test.accepts_without_contraction(K) {
                    return Err(SolveError::OtherBranch);
                }
                iteration = iteration.into_verification(guess);
            }
        }
    }

    /// Makes an update. Returns whether it leads to the root. Returns `None` if the determinant of
    /// the Jacobian does not have the given sign, or if the update is not finite.
    #[inline(always)]
    fn update<const K: usize>(
        &self,
        iteration: &mut Iteration<K>,
        update: &Update<K>,
        residual: f64,
        contraction_bounds: &[f64; K],
        expected: DeterminantSign,
    ) -> Option<bool> {
        let Update {
            by,
            newton: _,
            is_third_order,
            sign,
        } = *update;
        let mut x = iteration.x;
        let mut sum = 0.0;
        for i in 0..K {
            x[i] -= by[i];
            sum += by[i];
        }
        if !sum.is_finite() || sign.is_opposite_to(expected) {
            return None;
        }
        let previous = iteration.previous_residual;
        let is_root = predicts_negligible(residual, previous, is_third_order, self.tolerance)
            && (K == 1
                || are_comparable(
                    [previous, residual],
                    [&iteration.contraction_bounds, contraction_bounds],
                ));
        *iteration = Iteration {
            x,
            previous_x: iteration.x,
            previous_residual: residual,
            contraction_bounds: *contraction_bounds,
            updates: iteration.updates + 1,
            halvings: 0,
            // For a single unknown, the condition for third order is Kantorovich's.
            is_contracting: iteration.is_contracting && (K != 1 || is_third_order),
            ..*iteration
        };
        Some(is_root)
    }

    /// Decides how an iteration continues off the fast path: in verification, or after an
    /// evaluation that is not finite, a residual that did not contract, the limit of iterations, or
    /// a Jacobian that is singular or has a determinant of the wrong sign.
    #[cold]
    fn leave_fast_path<const K: usize>(
        &self,
        mut iteration: Iteration<K>,
        judged: Judged<K>,
        contraction_bounds: [f64; K],
        test: RootTest,
        guess: &[f64; K],
        rounding: &impl Fn(&[f64; K]) -> [f64; K],
    ) -> Result<Decision<K>, SolveError> {
        let residual = judged.relative;
        if let Phase::Verification { root, point } = iteration.phase {
            if !residual.is_finite() || !is_regular_with(judged.update.as_ref(), test.sign) {
                return Err(SolveError::OtherBranch);
            }
            return Ok(iteration.verify_next(guess, root, point));
        }
        if !residual.is_finite() {
            return iteration.halve_update().map(Decision::Continue);
        }
        let not_converged = SolveError::NotConverged {
            iterations: iteration.updates,
            residual,
            tolerance: self.tolerance,
        };
        if !judge(residual, iteration.previous_residual, self.tolerance).has_halved {
            if self.is_limited_by_rounding(&iteration, &judged, rounding) {
                return Ok(Decision::Root(iteration));
            }
            if iteration.x == iteration.previous_x {
                return Err(if judged.has_finite_jacobian {
                    not_converged
                } else {
                    SolveError::NonFinite
                });
            }
        }
        // At smaller residuals, rounding errors can prevent contraction.
        iteration.is_contracting &= iteration.previous_residual < ROOT_OF_ROUNDING
            || Self::contracts_to_rounding(&iteration, &judged, test);
        let can_be_accepted = iteration.is_contracting || test.accepts_without_contraction(K);
        if iteration.updates >= self.max_iterations || !can_be_accepted {
            return Err(not_converged);
        }
        if matches!(iteration.phase, Phase::DampedSteps) && !iteration.has_decreased(residual) {
            let halved = iteration.halve_update()?;
            if halved.halvings > MAX_DAMPINGS {
                return Err(not_converged);
            }
            return Ok(Decision::Continue(halved));
        }
        // Far from the root, a determinant of the wrong sign proves nothing about the root.
        let Some(update) = &judged.update else {
            return Err(SolveError::Singular {
                iteration: iteration.updates + 1,
            });
        };
        let unknown = DeterminantSign::UNKNOWN;
        match self.update(
            &mut iteration,
            update,
            residual,
            &contraction_bounds,
            unknown,
        ) {
            Some(true) => Ok(Decision::Root(iteration)),
            Some(false) => Ok(Decision::Continue(iteration)),
            None => Err(SolveError::NonFinite),
        }
    }

    /// Returns whether the iteration contracts but for rounding errors: each residual is within its
    /// bound or is the rounding error of its own terms or of the last update, which has the
    /// rounding errors of the terms before it. An example is a solution at which all terms of an
    /// equation vanish, such as the momentum of a system at rest that only noise moves.
    fn contracts_to_rounding<const K: usize>(
        iteration: &Iteration<K>,
        judged: &Judged<K>,
        test: RootTest,
    ) -> bool {
        let contracted = test.contraction * iteration.previous_residual;
        let of_update = (ERROR_OF_UPDATE / contracted).max(1.0);
        is_regular_with(judged.update.as_ref(), test.sign)
            && (0..K).all(|i| {
                let own = ERROR_OF_UPDATE * judged.magnitude[i];
                judged.residual[i].abs() <= own.max(of_update * iteration.contraction_bounds[i])
            })
    }

    /// Returns whether rounding errors keep the residual from decreasing.
    fn is_limited_by_rounding<const K: usize>(
        &self,
        iteration: &Iteration<K>,
        judged: &Judged<K>,
        rounding: &impl Fn(&[f64; K]) -> [f64; K],
    ) -> bool {
        let residual = judged.relative;
        if judge(residual, iteration.previous_residual, self.tolerance).is_stalled_by_rounding {
            return true;
        }
        if !judged.has_finite_jacobian {
            return false;
        }
        // One unit in the last place of an unknown can change a steep residual by more than its
        // tolerance.
        let Iteration { x, previous_x, .. } = iteration;
        let has_changed_by_rounding =
            |i: usize| (x[i] - previous_x[i]).abs() <= ROUNDING * x[i].abs();
        if residual < STEEP && (0..K).all(has_changed_by_rounding) {
            return true;
        }
        if iteration.updates == 0 {
            return false;
        }
        // A residual of products whose factors cancel, such as the force between neighbours far
        // from the origin, can be rounding error of the factors. It cannot decrease relative to its
        // terms, which are as small as the error.
        let bounds = rounding(x);
        let is_rounding_error = |i: usize| {
            let size = judged.residual[i].abs();
            let is_converged = size <= self.tolerance * judged.magnitude[i];
            is_converged || (size <= bounds[i] && bounds[i].is_finite())
        };
        (0..K).all(is_rounding_error)
    }
}

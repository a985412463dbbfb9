//! Newton's method for a few equations, knowing nothing of mechanics.
//!
//! Input: a first guess and a function that gives residual, the size of the residual's terms and the Jacobian.
//! Output: the root, to rounding. Invariant: every test compares a residual with the terms it is the sum of, so the method
//! does the same when the units of any unknown or equation change.

use crate::linear;

/// Options of the Newton iteration. The defaults iterate to rounding level and need no change.
///
/// ```
/// use sve_runtime::prelude::*;
/// let newton = Newton { max_iterations: 20, ..Newton::default() };
/// # assert_eq!(newton.tolerance, Newton::default().tolerance);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Residual, relative to the sum of its terms' magnitudes, that counts as zero.
    pub tolerance: f64,
    /// Iterations (Jacobian evaluations) after which the step fails.
    pub max_iterations: u32,
}

impl Default for Newton {
    /// Tolerance of two units of rounding; 50 iterations, where a step within reach of the method takes 2 to 4.
    fn default() -> Self {
        Self {
            tolerance: 2.0 * f64::EPSILON,
            max_iterations: 50,
        }
    }
}

/// Residual and Jacobian at a point.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const K: usize> {
    /// What has to vanish.
    pub residual: [f64; K],
    /// For each equation, the sum of the magnitudes of its terms.
    pub magnitude: [f64; K],
    /// Derivatives, rows by equation.
    pub jacobian: [[f64; K]; K],
}

/// Why an equation was not solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SolveError {
    /// The iteration limit came first.
    NotConverged {
        /// Iterations made.
        iterations: u32,
        /// Relative residual reached.
        residual: f64,
        /// Relative residual wanted.
        tolerance: f64,
    },
    /// The Jacobian is singular to rounding.
    Singular {
        /// Iteration, from 1; 0 for a linear block.
        iteration: u32,
    },
    /// Residual or Jacobian is NaN or infinite.
    NonFinite,
}

/// Below the square root of rounding an exact Newton step squares the residual; one that does not even halve it
/// there is moving within rounding errors of the residual itself.
const QUADRATIC: f64 = 1.5e-8;

/// Relative residual under which two successive ones measure the constant of quadratic convergence.
const NEAR: f64 = 0.1;

/// Relative change of an unknown that is its own rounding: two numbers next to each other differ by up to one unit, and
/// an iteration that has arrived jumps between neighbours.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Halvings of an update that leads out of the domain of the equations.
const HALVINGS: u32 = 60;

impl Newton {
    /// The root near `guess`.
    ///
    /// It is accepted where the residual is `tolerance` times the terms it is the sum of, or where it no longer shrinks
    /// for want of digits: those of its terms' inner sums, or those of the unknowns.
    /// The last update is not confirmed by another evaluation where quadratic convergence, measured on the previous two
    /// residuals, puts the next one below rounding.
    ///
    /// An update that leads out of the domain of the equations is halved until it does not. A guess outside is
    /// drawn towards zero likewise: unknowns are increments or velocities, and at zero nothing moves.
    ///
    /// # Errors
    /// [`SolveError`] when the iteration limit is reached or the iteration stands still away from a root, the Jacobian is
    /// singular, or no finite residual can be found.
    #[inline]
    pub fn solve<const K: usize>(
        &self,
        guess: [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K>,
    ) -> Result<[f64; K], SolveError> {
        let mut x = guess;
        let mut from = [0.0; K];
        let mut previous = f64::INFINITY;
        let mut iteration = 0;
        loop {
            let mut at = evaluate(&x);
            let mut relative = relative(&at);
            if !relative.is_finite() {
                (x, at) = retreat(&from, x, &evaluate)?;
                relative = self::relative(&at);
            }
            if relative <= self.tolerance {
                return Ok(x);
            }
            let not_converged = SolveError::NotConverged {
                iterations: iteration,
                residual: relative,
                tolerance: self.tolerance,
            };
            if relative > 0.5 * previous {
                match stall(&from, &x, &at, relative) {
                    Stall::Root => return Ok(x),
                    Stall::Stuck => return Err(not_converged),
                    Stall::Undefined => return Err(SolveError::NonFinite),
                    Stall::No => {}
                }
            }
            if iteration == self.max_iterations {
                return Err(not_converged);
            }
            iteration += 1;
            let update = linear::solve(&at.jacobian, &at.residual)
                .ok_or(SolveError::Singular { iteration })?;
            from = x;
            for i in 0..K {
                x[i] -= update[i];
            }
            if !update.iter().all(|u| u.is_finite()) {
                return Err(SolveError::NonFinite);
            }
            // r_{k+1} ≈ (r_k / r_{k−1}²) r_k², with a factor of 16 to spare; an update that was damped or
            // is not yet in the quadratic regime has a ratio too large to pass.
            if 16.0 * relative.powi(3) <= self.tolerance * previous.powi(2) && previous < NEAR {
                return Ok(x);
            }
            previous = relative;
        }
    }
}

/// Largest residual relative to the terms it is the sum of; NaN where one is not finite.
#[inline]
fn relative<const K: usize>(at: &Evaluation<K>) -> f64 {
    let mut largest = 0.0;
    for i in 0..K {
        let r = if at.magnitude[i] == 0.0 {
            // an equation whose terms all vanish is satisfied
            0.0
        } else if at.magnitude[i] == f64::INFINITY {
            // no finite residual is small against infinity
            f64::NAN
        } else {
            (at.residual[i] / at.magnitude[i]).abs()
        };
        // not `max`, which would drop a NaN
        if !(r <= largest || f64::is_nan(largest)) {
            largest = r;
        }
    }
    largest
}

/// Why a residual was not even halved by an update.
enum Stall {
    /// There are no more digits: this is the root.
    Root,
    /// The unknowns do not move any more, and this is no root.
    Stuck,
    /// The unknowns do not move because the Jacobian is not finite.
    Undefined,
    /// The iteration is still far from the root.
    No,
}

/// What the update from `from` to `x`, which did not halve the residual, says.
#[cold]
fn stall<const K: usize>(
    from: &[f64; K],
    x: &[f64; K],
    at: &Evaluation<K>,
    relative: f64,
) -> Stall {
    let jacobian_is_finite = at.jacobian.iter().flatten().all(|a| a.is_finite());
    let at_rounding = |i: usize| (x[i] - from[i]).abs() <= ROUNDING * x[i].abs();
    // The second case is a steep residual, which one unit in the last place of an unknown changes by more than its tolerance.
    if relative < QUADRATIC || (relative < NEAR && jacobian_is_finite && (0..K).all(at_rounding)) {
        Stall::Root
    } else if x != from {
        Stall::No
    } else if jacobian_is_finite {
        Stall::Stuck
    } else {
        Stall::Undefined
    }
}

/// Halves the way from `from` to `to` until the equations are defined.
#[cold]
fn retreat<const K: usize>(
    from: &[f64; K],
    to: [f64; K],
    evaluate: impl Fn(&[f64; K]) -> Evaluation<K>,
) -> Result<([f64; K], Evaluation<K>), SolveError> {
    let mut way = [0.0; K];
    for i in 0..K {
        way[i] = to[i] - from[i];
    }
    if !way.iter().all(|w| w.is_finite()) {
        way = [0.0; K];
    }
    for _ in 0..HALVINGS {
        // `way` is halved, not `to`: half of one unit in the last place would be rounded up to where it came from
        let mut x = *from;
        for i in 0..K {
            way[i] *= 0.5;
            x[i] += way[i];
        }
        let at = evaluate(&x);
        if relative(&at).is_finite() {
            return Ok((x, at));
        }
        if x == *from {
            break;
        }
    }
    Err(SolveError::NonFinite)
}

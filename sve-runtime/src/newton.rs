//! Newton's method for a few equations, knowing nothing of mechanics.
//!
//! Input: a first guess and a function that gives residual, the size of the residual's terms and the Jacobian.
//! Output: the root, to rounding. Invariant: every test compares a residual with the terms it is the sum of, so the method
//! does the same when the units of any unknown or equation change.

use crate::linear::Matrix;

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

/// Residual and Jacobian at a point. The Jacobian is of any type that can be solved with.
#[derive(Clone, Copy, Debug)]
pub struct Evaluation<const K: usize, J = [[f64; K]; K]> {
    /// What has to vanish.
    pub residual: [f64; K],
    /// For each equation, the sum of the magnitudes of its terms.
    pub magnitude: [f64; K],
    /// Derivatives, rows by equation.
    pub jacobian: J,
    /// Second derivative of a single equation in a single unknown; NaN where there are more, or where it is not at hand.
    pub curvature: f64,
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
pub(crate) const QUADRATIC: f64 = 1.5e-8;

/// Relative change of an update by the curvature up to which the change is made.
pub(crate) const BENT: f64 = 0.25;

/// Relative residual under which two successive ones measure the constant of quadratic convergence.
pub(crate) const NEAR: f64 = 0.1;

/// Relative change of an unknown that is its own rounding: two numbers next to each other differ by up to one unit, and
/// an iteration that has arrived jumps between neighbours.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Halvings of an update that leads out of the domain of the equations.
const HALVINGS: u32 = 60;

/// Where an iteration stands.
#[derive(Clone, Copy)]
struct Run<const K: usize> {
    /// The point to evaluate.
    x: [f64; K],
    /// The point before the last update.
    from: [f64; K],
    /// Relative residual there.
    previous: f64,
    /// Updates made.
    iteration: u32,
    /// Halvings of the last update.
    halvings: u32,
}

impl Newton {
    /// The root near `guess`; from the point that `fallback` gives where the iteration fails from there.
    ///
    /// It is accepted where the residual is `tolerance` times the terms it is the sum of, or where it no longer shrinks
    /// for want of digits: those of its terms' inner sums, or those of the unknowns. `rounding` tells by how much the
    /// evaluation of the residual at a point can be wrong; it is asked only then.
    /// The last update is not confirmed by another evaluation where the order of convergence, measured on the previous two
    /// residuals, puts the next one below rounding.
    ///
    /// An update that leads out of the domain of the equations is halved until it does not. A guess outside is
    /// drawn towards zero likewise: unknowns are increments or velocities, and at zero nothing moves.
    ///
    /// # Errors
    /// [`SolveError`] when the iteration limit is reached or the iteration stands still away from a root, the Jacobian is
    /// singular, or no finite residual can be found; the one from the second point.
    #[inline]
    pub fn solve_or<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        fallback: impl FnOnce() -> [f64; K],
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        self.iterate(guess, Some(fallback), rounding, evaluate)
    }

    /// The root near `guess`, as [`solve_or`](Self::solve_or) without a second point or a bound of rounding errors.
    ///
    /// # Errors
    /// As there.
    #[inline]
    pub fn solve<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        self.iterate(guess, None::<fn() -> [f64; K]>, |_| [0.0; K], evaluate)
    }

    #[inline]
    fn iterate<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        mut fallback: Option<impl FnOnce() -> [f64; K]>,
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let mut run = Run::from(guess);
        loop {
            // The only call, so that the equations are compiled into the loop.
            let at = evaluate(&run.x);
            let relative = relative(&at);
            // A guess that satisfies singular equations is one of many that do.
            if relative <= self.tolerance && (run.iteration > 0 || update(&at).is_some()) {
                return Ok(run.x);
            }
            if relative <= 0.5 * run.previous
                && run.iteration < self.max_iterations
                && let Some(arrived) = self.update(&mut run, &at, relative)
            {
                if arrived {
                    return Ok(run.x);
                }
                continue;
            }
            match self.doubt(run, &at, relative, &rounding) {
                Ok(Doubt::Root(x)) => return Ok(x),
                Ok(Doubt::Goes(on)) => run = on,
                Err(error) => match fallback.take() {
                    Some(fallback) => run = Run::from(fallback()),
                    None => return Err(error),
                },
            }
        }
    }

    /// Moves on; whether to the root. Nothing where the Jacobian is singular or the update not finite.
    #[inline]
    fn update<const K: usize, J: Matrix<K>>(
        &self,
        run: &mut Run<K>,
        at: &Evaluation<K, J>,
        relative: f64,
    ) -> Option<bool> {
        let (update, cubic) = update(at)?;
        let mut x = run.x;
        let mut sum = 0.0;
        for i in 0..K {
            x[i] -= update[i];
            sum += update[i];
        }
        if !sum.is_finite() {
            return None;
        }
        // r_{k+1} ≈ (r_k / r_{k−1}²) r_k², or with cubes, with a factor of 16 to spare; an update that was damped or
        // is not yet in the regime of that order has a ratio too large to pass.
        let (r2, p2) = (relative * relative, run.previous * run.previous);
        let (next, ratio) = if cubic {
            (r2 * r2, p2 * run.previous)
        } else {
            (r2 * relative, p2)
        };
        let arrived = 16.0 * next <= self.tolerance * ratio && run.previous < NEAR;
        *run = Run {
            x,
            from: run.x,
            previous: relative,
            iteration: run.iteration + 1,
            halvings: 0,
        };
        Some(arrived)
    }

    /// Decides where an evaluation is not finite, an update did not halve the residual, the limit is reached or the
    /// Jacobian is singular.
    #[cold]
    fn doubt<const K: usize, J: Matrix<K>>(
        &self,
        mut run: Run<K>,
        at: &Evaluation<K, J>,
        relative: f64,
        rounding: &impl Fn(&[f64; K]) -> [f64; K],
    ) -> Result<Doubt<K>, SolveError> {
        if !relative.is_finite() {
            return run.retreat().map(Doubt::Goes);
        }
        let not_converged = SolveError::NotConverged {
            iterations: run.iteration,
            residual: relative,
            tolerance: self.tolerance,
        };
        if relative > 0.5 * run.previous {
            let jacobian_is_finite = at.jacobian.is_finite();
            let at_rounding =
                |i: usize| (run.x[i] - run.from[i]).abs() <= ROUNDING * run.x[i].abs();
            // The second case is a steep residual, which one unit in the last place of an unknown changes by more than
            // its tolerance.
            let digits_are_gone = relative < NEAR && jacobian_is_finite && (0..K).all(at_rounding);
            if relative < QUADRATIC || digits_are_gone {
                return Ok(Doubt::Root(run.x));
            }
            // A residual of products whose factors cancel, such as the force between neighbours far from the origin, may be
            // all rounding: it cannot shrink beside its terms, which are as small.
            let bounds = rounding(&run.x);
            let is_rounding = |i: usize| {
                let satisfied = self.tolerance * at.magnitude[i];
                let size = at.residual[i].abs();
                size <= satisfied || (size <= bounds[i] && bounds[i].is_finite())
            };
            if run.iteration > 0 && jacobian_is_finite && (0..K).all(is_rounding) {
                return Ok(Doubt::Root(run.x));
            }
            if run.x == run.from {
                return Err(if jacobian_is_finite {
                    not_converged
                } else {
                    SolveError::NonFinite
                });
            }
        }
        if run.iteration >= self.max_iterations {
            return Err(not_converged);
        }
        match self.update(&mut run, at, relative) {
            Some(true) => Ok(Doubt::Root(run.x)),
            Some(false) => Ok(Doubt::Goes(run)),
            None if update(at).is_none() => Err(SolveError::Singular {
                iteration: run.iteration + 1,
            }),
            None => Err(SolveError::NonFinite),
        }
    }
}

/// What [`Newton::doubt`] decides.
enum Doubt<const K: usize> {
    /// This is the root.
    Root([f64; K]),
    /// The iteration goes on from here.
    Goes(Run<K>),
}

impl<const K: usize> Run<K> {
    fn from(guess: [f64; K]) -> Self {
        Self {
            x: guess,
            from: [0.0; K],
            // so large that the first residual passes for smaller, if it is finite
            previous: f64::MAX,
            iteration: 0,
            halvings: 0,
        }
    }

    /// Half the way back from a point where the equations are not defined.
    fn retreat(self) -> Result<Self, SolveError> {
        if self.x == self.from || self.halvings == HALVINGS {
            return Err(SolveError::NonFinite);
        }
        let mut nearer = self.from;
        for i in 0..K {
            nearer[i] += 0.5 * (self.x[i] - self.from[i]);
        }
        // half of one unit in the last place may be rounded up to where it came from
        if nearer == self.x || !nearer.iter().all(|y| y.is_finite()) {
            nearer = self.from;
        }
        Ok(Self {
            x: nearer,
            halvings: self.halvings + 1,
            ..self
        })
    }
}

/// Bound of the error of `f(x)` where x is wrong by up to `error`.
#[cold]
pub fn spread(f: impl Fn(f64) -> f64, x: f64, error: f64) -> f64 {
    let value = f(x);
    let (above, below) = ((f(x + error) - value).abs(), (f(x - error) - value).abs());
    // the larger one, or NaN: at the edge of its domain a function has no bound
    let largest = if above > below { above } else { below };
    largest + 0.0 * above + f64::EPSILON * value.abs()
}

/// The update, and whether it is of third order: of a single unknown, Newton's `u = f/f′` becomes Chebyshev's
/// `u + ½ (f″/f′) u²` where that is a small change (Traub, Iterative Methods for the Solution of Equations, section 5).
#[inline]
fn update<const K: usize, J: Matrix<K>>(at: &Evaluation<K, J>) -> Option<([f64; K], bool)> {
    if K != 1 {
        return Some((at.jacobian.solve(&at.residual)?, false));
    }
    let slope = at.jacobian.first();
    if slope == 0.0 {
        return None;
    }
    // two divisions at once: one, of which the other quantity is a multiple, would be followed by the multiplication
    let mut update = [at.residual[0] / slope; K];
    let bend = 0.5 * at.curvature / slope * update[0];
    if bend.abs() <= BENT {
        update[0] += bend * update[0];
        Some((update, true))
    } else {
        Some((straight(update), false))
    }
}

/// Keeps the compiler from selecting between two updates after both are known, where it can go on with one.
#[cold]
#[inline(never)]
fn straight<const K: usize>(update: [f64; K]) -> [f64; K] {
    update
}

/// Largest residual relative to the terms it is the sum of; NaN where one is not finite.
#[inline]
fn relative<const K: usize, J>(at: &Evaluation<K, J>) -> f64 {
    let (mut largest, mut sum) = (0.0, 0.0);
    for i in 0..K {
        let m = at.magnitude[i];
        // 0/0 is 0: an equation whose terms all vanish is satisfied. An infinite m gives NaN: no finite residual is small
        // against infinity.
        let r = at.residual[i].abs() / (m + f64::MIN_POSITIVE) + 0.0 * m;
        if r > largest {
            largest = r;
        }
        sum += r;
    }
    // the comparison drops a NaN, the sum does not
    largest + 0.0 * sum
}

#[cfg(test)]
#[allow(clippy::trivially_copy_pass_by_ref)] // `solve` passes its unknowns by reference
mod tests;

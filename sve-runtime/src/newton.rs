//! Newton's method for a few equations, knowing nothing of mechanics.
//!
//! Input: a first guess and a function that gives residual, the size of the residual's terms and the Jacobian.
//! Output: the root, to rounding. Invariant: every test compares a residual with the terms it is the sum of, so the method
//! does the same when the units of any unknown or equation change.
//!
//! **When it stops.** Each iteration evaluates residual and Jacobian, and updates the unknowns. It ends
//! - after the update at a residual below the tolerance. The update is made all the same: what the iteration has left over has the same
//!   sign step after step, and would add up over a long run to more than the rounding errors of the unknowns, which walk at random;
//! - after an update that foresees a residual of [`UNSEEN`] times the tolerance, from the order of convergence measured on the last two;
//! - where the residual no longer halves and is rounding: below [`QUADRATIC`], or within the bound of its own errors, or where the update
//!   was one of the last digits of the unknowns.
//!
//! E. Hairer, R. I. `McLachlan`, A. Razakarivony, *Achieving Brouwer's law with implicit Runge–Kutta methods*, BIT 48 (2008).
//!
//! **Which root.** Equations of a step may have several solutions; the step is the one that is connected with no noise and h → 0, where
//! the velocity is that of the momentum at the start. A block of up to four unknowns whose equations are affine in that limit is
//! *judged* after its iteration, by bounds of its Jacobian between the limit and the root that the macro derives, see
//! [`regular`](crate::regular). Nothing is asked of the iteration then. The other blocks are accepted by the course of their
//! iteration. It has to be contracting: each Jacobian has the orientation (the sign of the determinant) of the one in the limit, and
//! each residual is at most a quarter of the one before, beside the terms it had then; of a single unknown also |f f″| ≤ ½ f′²
//! (Kantorovich's theorem gives these bounds). Of a single unknown the root of another
//! iteration is accepted too, if the orientation holds all along the segment from the guess, at 17 points.
//! What is not accepted is left to [`continuation`](crate::continuation).
//!
//! What is proved: within a judged box every Jacobian is regular, so it holds one solution at most at each smaller step and increment, but
//! for rounding errors of the radii, which the bound of the spectral radius leaves room for. Not excluded is a path from
//! the limit that leaves the box and comes back. The course of an iteration samples, and so does continuation.
//!
//! Sources: Neumaier, *Interval Methods for Systems of Equations* (1990), chapter 5;
//! Ortega, Rheinboldt, *Iterative Solution of Nonlinear Equations in Several Variables* (1970), section 12.6;
//! Deuflhard, *Newton Methods for Nonlinear Problems* (2011), section 2.1.

mod solver;
mod update;

pub use solver::{BlockSolve, Solver};
use update::{Update, is_regular, relative, update};
pub(crate) use update::{is_opposite, last_factor};

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
    /// Residual, relative to the sum of its terms' magnitudes, at which the iteration makes its last update. The residual after it is not
    /// evaluated; near a regular root it is smaller by another order. With the default, what is left over is below
    /// the rounding of the unknowns and rounding errors of a long run walk at random; a larger tolerance saves evaluations and lets
    /// conserved quantities drift. A smaller one, or zero, costs evaluations: the iteration then ends where residuals no longer shrink.
    pub tolerance: f64,
    /// Iterations (Jacobian evaluations) after which an attempt fails; a step makes several before it does.
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
    /// Nothing shows that what was found is connected with the limit of no noise and h → 0.
    OtherBranch,
    /// No velocity of the momentum is connected with the reference velocity of the Legendre transform.
    NoVelocity {
        /// The part of the way to the momentum up to which velocities were found.
        reached: f64,
    },
    /// What was found is outside of the domain of L or of a noise.
    OutsideDomain {
        /// Which condition does not hold.
        condition: usize,
    },
}

/// Below the square root of rounding an exact Newton step squares the residual; one that does not even halve it
/// there is moving within rounding errors of the residual itself.
pub(crate) const QUADRATIC: f64 = 1.5e-8;

/// Relative change of an update by the curvature up to which the change is made.
pub(crate) const BENT: f64 = 0.25;

/// Relative residual under which two successive ones measure the constant of quadratic convergence.
pub(crate) const NEAR: f64 = 0.1;

/// Part of the tolerance below which the residual after an update has to be foreseen, if it is not to be evaluated: 3·10⁻²⁰ of the terms by
/// default. What an iteration leaves over has the same sign step after step, while the rounding of the unknowns, 10⁻¹⁶, walks at random:
/// over 10⁷ steps the sum of the former stays below the latter.
pub(crate) const UNSEEN: f64 = 1.0 / 16384.0;

/// Relative change of an unknown that is its own rounding: two numbers next to each other differ by up to one unit, and
/// an iteration that has arrived jumps between neighbours.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Halvings of an update that leads out of the domain of the equations.
const HALVINGS: u32 = 60;

/// Halvings of an update that does not reduce the residual.
const DAMPINGS: u32 = 24;

/// Part of the decrease that the slope promises with which a damped update is content.
const DECREASE: f64 = 0.25;

/// Parts of the segment from a guess to its root at whose ends the Jacobian is looked at.
const PARTS: u32 = 16;

/// What an iteration of several unknowns in reach of its root multiplies the residual by, at most (Kantorovich).
pub(crate) const CALM: f64 = 0.25;

/// Where an iteration stands.
#[derive(Clone, Copy)]
struct Run<const K: usize> {
    /// The point to evaluate.
    x: [f64; K],
    /// The point before the last update.
    from: [f64; K],
    /// Relative residual there.
    previous: f64,
    /// What the residuals have to come below in a calm iteration.
    bound: [f64; K],
    /// Updates made.
    iteration: u32,
    /// Halvings of the last update.
    halvings: u32,
    /// Whether nothing but the usual course was taken.
    calm: bool,
    /// Whether updates have to reduce the residual.
    damped: bool,
    /// Relative residual that is accepted.
    tolerance: f64,
    /// Where the segment from the guess to the root is looked at: the number of the point, from 1. `from` is the root then.
    sample: u32,
}

/// How an iteration is to go.
#[derive(Clone, Copy)]
struct Way {
    /// The sign of the determinant of the Jacobian where the solution comes from; NaN where it is not known.
    origin: f64,
    trust: Trust,
}

/// What is accepted beside the root of a calm iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Trust {
    /// Nothing.
    Calm,
    /// A single unknown with the right orientation all along the segment from its guess: no fold is between them. With more
    /// unknowns a segment says little, since ways lead around folds.
    Segment,
    /// Any root with the right orientation all along the segment, where there is no better way to know.
    Any,
}

impl Trust {
    /// Whether an iteration in so many unknowns that was not calm may be of use.
    fn extends_to(self, unknowns: usize) -> bool {
        match self {
            Self::Calm => false,
            Self::Segment => unknowns == 1,
            Self::Any => true,
        }
    }
}

impl Newton {
    /// The root near `guess`; as far as these are trusted: if none is reached from there, from the point that `fallback` gives; if none from there either, by
    /// updates from `guess` that are halved until they reduce the residual.
    ///
    /// It is accepted after the update at a residual of `tolerance` times the terms it is the sum of, or where it no longer shrinks
    /// for want of digits: those of its terms' inner sums, or those of the unknowns. `rounding` tells by how much the
    /// evaluation of the residual at a point can be wrong; it is asked only then.
    /// The last update is not confirmed by another evaluation where the order of convergence, measured on the previous two
    /// residuals, puts the next one far below rounding.
    ///
    /// An update that leads out of the domain of the equations is halved until it does not. A guess outside is
    /// drawn towards zero likewise: unknowns are increments or velocities, and at zero nothing moves.
    ///
    /// # Errors
    /// [`SolveError`] when the iteration limit is reached or the iteration stands still away from a root, the Jacobian is
    /// singular, no finite residual can be found, or the root belongs to another branch; the last one.
    #[inline]
    fn solve_or<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        way: Way,
        fallback: impl FnOnce() -> [f64; K],
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        self.iterate(guess, way, Some(fallback), rounding, evaluate)
    }

    /// The root near `guess`, without a second point, a bound of rounding errors or a place that it comes from.
    ///
    /// # Errors
    /// As there.
    #[inline]
    pub fn solve<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let way = Way {
            origin: f64::NAN,
            trust: Trust::Any,
        };
        self.iterate(guess, way, None::<fn() -> [f64; K]>, |_| [0.0; K], evaluate)
    }

    #[inline]
    fn iterate<const K: usize, J: Matrix<K>>(
        &self,
        guess: [f64; K],
        way: Way,
        mut fallback: Option<impl FnOnce() -> [f64; K]>,
        rounding: impl Fn(&[f64; K]) -> [f64; K],
        evaluate: impl Fn(&[f64; K]) -> Evaluation<K, J>,
    ) -> Result<[f64; K], SolveError> {
        let single = fallback.is_none() || !way.trust.extends_to(K);
        let mut run = Run::from(guess, self.tolerance);
        loop {
            // The only call, so that the equations are compiled into the loop.
            let at = evaluate(&run.x);
            let relative = relative(&at);
            // A guess that satisfies singular equations is one of many that do.
            let arrived = if relative <= run.tolerance
                && (run.iteration > 0 || is_regular(&at, way.origin))
            {
                run.finish(&at);
                true
            } else if relative <= 0.5 * run.previous
                && run.is_calm(&at)
                && run.iteration < self.max_iterations
                && let Some(arrived) = self.update(&mut run, &at, relative, way.origin)
            {
                arrived
            } else {
                match self.doubt(run, &at, relative, way, &guess, &rounding) {
                    Ok(Doubt::Root(root)) => return Ok(root),
                    Ok(Doubt::Arrived(at)) => {
                        run = at;
                        true
                    }
                    Ok(Doubt::Goes(on)) => {
                        run = on;
                        continue;
                    }
                    Err(error) if single || run.damped => return Err(error),
                    Err(_) => {
                        run = match fallback.take() {
                            // a calm way from another point says nothing of the guess
                            Some(fallback) => Run {
                                calm: false,
                                ..Run::from(fallback(), self.tolerance)
                            },
                            None => Run::damped(guess, self.tolerance),
                        };
                        continue;
                    }
                }
            };
            if arrived {
                let extends = way.trust.extends_to(K);
                if run.calm || (way.origin.is_nan() && extends) {
                    return Ok(run.x);
                }
                if !extends {
                    return Err(SolveError::OtherBranch);
                }
                run = run.to_be_looked_at(&guess);
            }
        }
    }

    /// Moves on; whether to the root. Nothing where the Jacobian is singular or of another orientation than at `origin`, or the
    /// update not finite.
    #[inline]
    fn update<const K: usize, J: Matrix<K>>(
        &self,
        run: &mut Run<K>,
        at: &Evaluation<K, J>,
        relative: f64,
        origin: f64,
    ) -> Option<bool> {
        let Update {
            by: update,
            cubic,
            orientation,
        } = update(at)?;
        let mut x = run.x;
        let mut sum = 0.0;
        for i in 0..K {
            x[i] -= update[i];
            sum += update[i];
        }
        if !sum.is_finite() || is_opposite(orientation, origin) {
            return None;
        }
        // r_{k+1} ≈ (r_k / r_{k−1}²) r_k², or with cubes, of which the constant is measured; an update that was damped or
        // is not yet in the regime of that order has a ratio too large to pass.
        let (r2, p2) = (relative * relative, run.previous * run.previous);
        let (next, ratio) = if cubic {
            (r2 * r2, p2 * run.previous)
        } else {
            (r2 * relative, p2)
        };
        let arrived = next <= UNSEEN * self.tolerance * ratio && run.previous < NEAR;
        let mut bound = [0.0; K];
        for i in 0..K {
            // of a single residual that is a part of itself, at hand before the division
            bound[i] = if K == 1 {
                CALM * at.residual[i].abs()
            } else {
                CALM * relative * at.magnitude[i]
            };
        }
        *run = Run {
            x,
            from: run.x,
            previous: relative,
            bound,
            iteration: run.iteration + 1,
            halvings: 0,
            // of a single unknown the bend of its curve, which decides on the order, is the test of Kantorovich
            calm: run.calm && (K != 1 || cubic),
            ..*run
        };
        Some(arrived)
    }

    /// Decides where an evaluation is not finite, an update did not halve the residual or was not calm, the limit is reached or
    /// the Jacobian is singular or turned.
    #[cold]
    fn doubt<const K: usize, J: Matrix<K>>(
        &self,
        mut run: Run<K>,
        at: &Evaluation<K, J>,
        relative: f64,
        way: Way,
        start: &[f64; K],
        rounding: &impl Fn(&[f64; K]) -> [f64; K],
    ) -> Result<Doubt<K>, SolveError> {
        if run.sample > 0 {
            if !relative.is_finite() {
                return Err(SolveError::OtherBranch);
            }
            return run.look(at, way.origin, start);
        }
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
                return Ok(Doubt::Arrived(run));
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
                return Ok(Doubt::Arrived(run));
            }
            if run.x == run.from {
                return Err(if jacobian_is_finite {
                    not_converged
                } else {
                    SolveError::NonFinite
                });
            }
        }
        // below that the residual may be shrinking into its rounding
        run.calm &= run.previous < QUADRATIC;
        if run.iteration >= self.max_iterations || !(run.calm || way.trust.extends_to(K)) {
            return Err(not_converged);
        }
        if run.damped && !run.decreased(relative) {
            let nearer = run.retreat()?;
            if nearer.halvings > DAMPINGS {
                return Err(not_converged);
            }
            return Ok(Doubt::Goes(nearer));
        }
        // another orientation far from the root need not be one at the root
        match self.update(&mut run, at, relative, f64::NAN) {
            Some(true) => Ok(Doubt::Arrived(run)),
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
    /// This is the root, and of the right branch.
    Root([f64; K]),
    /// This is a root.
    Arrived(Run<K>),
    /// The iteration goes on from here.
    Goes(Run<K>),
}

impl<const K: usize> Run<K> {
    fn from(guess: [f64; K], tolerance: f64) -> Self {
        Self {
            x: guess,
            from: [0.0; K],
            // so large that the first residual passes for smaller, if it is finite
            previous: f64::MAX,
            bound: [f64::MAX; K],
            iteration: 0,
            halvings: 0,
            calm: true,
            damped: false,
            tolerance,
            sample: 0,
        }
    }

    fn damped(guess: [f64; K], tolerance: f64) -> Self {
        Self {
            damped: true,
            ..Self::from(guess, tolerance)
        }
    }

    /// Makes the last update, at a residual below the tolerance; not where the Jacobian is singular, or where it would be larger than the
    /// update before: there is nothing to be gained.
    #[inline]
    fn finish<J: Matrix<K>>(&mut self, at: &Evaluation<K, J>) {
        let Some((update, _)) = at.jacobian.solve_oriented(&at.residual) else {
            return;
        };
        let mut shrinks = true;
        for i in 0..K {
            shrinks &= update[i].abs() <= (self.x[i] - self.from[i]).abs();
        }
        if !shrinks {
            return;
        }
        for i in 0..K {
            self.x[i] -= update[i] * last_factor(self.x[i]);
        }
    }

    /// Whether the residuals are as much smaller as those of an iteration in reach of its root.
    #[inline]
    fn is_calm<J>(&self, at: &Evaluation<K, J>) -> bool {
        let mut calm = true;
        for i in 0..K {
            calm &= at.residual[i].abs() <= self.bound[i];
        }
        calm
    }

    /// Whether the residual is smaller by a part of what the slope promises for a part of an update.
    fn decreased(&self, relative: f64) -> bool {
        let part = 0.5_f64.powi(self.halvings as i32);
        self.previous == f64::MAX || relative <= (1.0 - DECREASE * part) * self.previous
    }

    /// From a root: looks at the segment from the guess to it.
    #[cold]
    fn to_be_looked_at(self, start: &[f64; K]) -> Self {
        Self {
            x: *start,
            from: self.x,
            // neither accepted nor improved: each evaluation comes to `look`
            tolerance: -1.0,
            previous: -1.0,
            sample: 1,
            ..self
        }
    }

    /// Looks at a point of the segment from the guess to the root.
    fn look<J: Matrix<K>>(
        mut self,
        at: &Evaluation<K, J>,
        origin: f64,
        start: &[f64; K],
    ) -> Result<Doubt<K>, SolveError> {
        if !is_regular(at, origin) {
            return Err(SolveError::OtherBranch);
        }
        if self.sample > PARTS {
            return Ok(Doubt::Root(self.from));
        }
        let part = f64::from(self.sample) / f64::from(PARTS);
        for i in 0..K {
            self.x[i] = start[i] + part * (self.from[i] - start[i]);
        }
        self.sample += 1;
        Ok(Doubt::Goes(self))
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
            calm: false,
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

#[cfg(test)]
#[allow(clippy::trivially_copy_pass_by_ref)] // `solve` passes its unknowns by reference
mod tests;

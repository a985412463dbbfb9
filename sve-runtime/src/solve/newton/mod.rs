//! Newton's method for a few equations.
//!
//! Input: a guess, and a function that gives the residual, the magnitudes of the residual's terms
//! and the Jacobian. Output: the root, to rounding. Invariant: every test compares a residual with
//! the sum of the magnitudes of its terms, so a change of the unit of any unknown or equation
//! changes nothing.
//!
//! **Phases** (`driver.rs`). A solve makes up to three attempts: full Newton steps from the guess,
//! full steps from a second guess, and damped steps from the first guess, which are halved until
//! they decrease the residual (line search). Each attempt ends with a root or an error. Where the
//! iteration did not contract, a last phase verifies the root.
//!
//! **When an attempt ends** (`convergence.rs`). Each iteration evaluates residual and Jacobian and
//! updates the unknowns. The iteration ends
//! - after the update at a residual below the tolerance. This last update is made because an error
//!   left over has the same sign step after step: over a long run it would add up to more than the
//!   rounding errors of the unknowns, which form a random walk;
//! - after an update whose residual is predicted to be below
//!   [`NEGLIGIBLE`](convergence::NEGLIGIBLE) times the tolerance. The constant of the order of
//!   convergence is measured on the last two residuals;
//! - if the residual no longer halves and is rounding error: it is below
//!   [`ROOT_OF_ROUNDING`](convergence::ROOT_OF_ROUNDING), or below the bound of its own rounding
//!   errors, or the update changed only the last digits of the unknowns.
//!
//! Source: Hairer, `McLachlan`, Razakarivony, *Achieving Brouwer's law with implicit Runge–Kutta
//! methods*, BIT 48 (2008).
//!
//! **The connected root.** The equations of a step may have several solutions. The step is the
//! solution connected with the limit of no noise and h → 0. In this limit the velocity follows from
//! the momentum at the start. Blocks fall into three classes.
//! - The macro derives, for blocks of up to four unknowns whose equations are affine in that limit,
//!   bounds of the Jacobian between the limit and the root. The step accepts the root if every
//!   matrix within the bounds is regular, see [`regularity`](super::regularity). The iteration may
//!   take any path.
//! - The stages of a Gauss rule, for systems of up to four coordinates: the macro derives bounds of
//!   the derivatives at a node, and the step accepts the root if the equations are a contraction in
//!   a box that contains the root and the limit (`gauss/connected.rs`). The iteration may take any
//!   path. Linear equations of stages have one root, which is accepted.
//! - The other blocks are accepted by the path of their iteration. The iteration has to contract:
//!   the determinant of each Jacobian has the same sign as in the limit, and each residual is at
//!   most ¼ of the residual before, relative to the magnitudes at the point before. A single
//!   unknown needs |f f″| ≤ ½ f′² too. Kantorovich's theorem gives these bounds. If the iteration
//!   for a single unknown does not contract, its root is accepted if the determinant has the sign
//!   of the limit at 17 points of the segment from the guess to the root.
//!
//! Blocks with multipliers of constraints are accepted by the path of their iteration, with a ratio
//! of 1/64 in the place of ¼, if noise does not undo most of the motion. Lanes accept their roots
//! by the same test. Off the fast path such blocks have bounds that contain the whole path of
//! solutions ([`contains_path`](super::regularity::contains_path)), if they have up to four
//! unknowns, or no others than multipliers and are small or banded.
//!
//! [`continuation`](crate::continuation) treats a step whose root is not accepted.
//!
//! **Proved properties.** Every Jacobian within accepted bounds is regular, so the bounds contain
//! at most one solution for each smaller step and increment. This holds but for rounding errors of
//! the radii, for which the bound of the spectral radius leaves room. The bounds exclude a path
//! from the limit that leaves them and comes back only for blocks with multipliers of constraints
//! and for the stages of Gauss rules, where they show that the path stays in the box. The test of
//! the iteration's path samples the Jacobian, as continuation does, and so does the fixed-point
//! iteration of Gauss rules from four stages on (`gauss/convergence.rs`). For constrained systems a
//! test of the repository compares the roots of random long steps with a continuation of its own.
//!
//! Sources: Neumaier, *Interval Methods for Systems of Equations* (1990), chapter 5; Ortega,
//! Rheinboldt, *Iterative Solution of Nonlinear Equations in Several Variables* (1970), section
//! 12.6; Deuflhard, *Newton Methods for Nonlinear Problems* (2011), section 2.1.

mod block;
pub(crate) mod convergence;
mod driver;
mod iteration;
pub mod rounding;
pub(crate) mod update;

pub use block::{BlockProperties, BlockSolver};
pub use convergence::Evaluation;

/// Options of the Newton iteration. The defaults iterate to rounding level and need no change.
///
/// ```
/// use sve_runtime::prelude::*;
/// let newton = Newton { max_iterations: 20, ..Newton::default() };
/// # assert_eq!(newton.tolerance, Newton::default().tolerance);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Newton {
    /// Residual, relative to the sum of its terms' magnitudes, at which the iteration makes its
    /// last update.
    ///
    /// The residual after that update is not evaluated; near a regular root it is smaller by
    /// another order. With the default, the error left over is below the rounding of the unknowns,
    /// and the rounding errors of a long run form a random walk. A larger tolerance saves
    /// evaluations and lets conserved quantities drift. With a smaller one, or zero, the iteration
    /// ends where residuals no longer decrease, which costs evaluations.
    pub tolerance: f64,
    /// Iterations (Jacobian evaluations) after which an attempt fails. A step makes several
    /// attempts before it fails.
    pub max_iterations: u32,
}

impl Default for Newton {
    /// Returns a tolerance of two units of rounding, and 50 iterations. A step within reach of the
    /// method takes 2 to 4.
    fn default() -> Self {
        Self {
            tolerance: 2.0 * f64::EPSILON,
            max_iterations: 50,
        }
    }
}

#[cfg(test)]
#[allow(clippy::trivially_copy_pass_by_ref)] // `solve` passes its unknowns by reference
mod tests;

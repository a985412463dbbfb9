//! Errors of steps, and the conversion of solver errors. Each message has the numbers in question
//! and what to change.

mod convert;
mod messages;
mod noise;
pub(crate) mod observed;

pub(crate) use convert::step_error;
use messages::{branch_lost, iteration_limit, no_time, singular_mass, stiff, within_step};
pub use noise::NoiseError;
pub(crate) use noise::check_step;

use crate::readable::debug_is_display;
use crate::solve::SingularRow;

/// Why a step could not be made. The state it was given is unchanged.
#[derive(Clone, PartialEq, thiserror::Error)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StepError {
    /// An input of the step is NaN or infinite.
    #[error(
        "{what} is {value} at t = {t}: a step needs finite numbers; look at what produced this value"
    )]
    NonFiniteInput {
        /// Which number: `q[0]`, `p[1]`, `dw[0]`, `t`.
        what: String,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// An index in a function of a scene is out of range.
    #[error(
        "{text} has the index {index} at t = {t}, and the length is {length}: let the loop run over indices that exist, \
         put an `if` around this term, or look at the fields that give the index"
    )]
    Index {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The indexed expression, its function, and the counters of its loops.
        text: Box<str>,
        /// The index.
        index: i64,
        /// The length of the array.
        length: usize,
    },
    /// An array of a scene has another length than the others.
    #[error("{what} has {found} entries at t = {t}, and {expected} are needed")]
    Length {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The array: `p`, which is as long as `q`, `dw`, which has an entry for each process, or
        /// the result of a force, which has an entry for each site.
        what: Box<str>,
        /// Its length.
        found: usize,
        /// The length that it has to have.
        expected: usize,
    },
    /// The mass of a component of a scene has no inverse.
    #[error(
        "the mass of {what} is {mass} at t = {t}: each component needs a kinetic energy ½ m v² with a finite mass that is not zero"
    )]
    Mass {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The velocity: `v[5]`.
        what: String,
        /// Its mass.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        mass: f64,
    },
    /// No velocity of a site of a scene has its momentum, or its kinetic energy is not defined.
    #[error("the site {site}, alone: {error}")]
    Site {
        /// The number of the site.
        site: usize,
        /// The mistake, with the configuration and the momentum of the site.
        error: Box<StepError>,
    },
    /// The equations for the forces of velocities and for the `#[h1]` of a scene are not solved by
    /// the iteration over its sites. With `midpoint` and an `#[h1]`, it is not certain to contract.
    #[error(
        "the forces of velocities or the `#[h1]` in the step from t = {t} with h = {h:e} are too strong for its iteration: the ratio of successive changes, or with `midpoint` the bound of it, is {ratio:.3}; \
         take h below about {wanted:.1e}; without `#[h1]`, the rule `endpoint` has explicit forces of velocities; with it, truncated increments (`Truncated`) bound the noise"
    )]
    Contraction {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Length of the step, or of a part of it in a composition.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The ratio of the last two changes of the impulses; for `midpoint`, a bound of the ratio
        /// of successive errors.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        ratio: f64,
        /// The magnitude of a step size at which the iteration converges, by an estimate from the
        /// ratio. The ratio may have been smaller than later ones.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        wanted: f64,
    },
    /// The step of a scene left the numbers.
    #[error(
        "the step from t = {t} with h = {h:e} gave a {what} that is not finite: \
         L or a derivative is undefined nearby, the motion overflowed, or a parameter is not finite; take a smaller h, or look at L there"
    )]
    NonFiniteCoordinate {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The first number of the result that is not finite: `q[0]`, `p[7][2]`.
        what: String,
    },
    /// The bounds of the equations of a step of a scene by the midpoint rule allow other solutions
    /// than the one that is connected with h → 0, or the iteration would take too many sweeps.
    #[error("{}", stiff(*t, *h, what, *bounds))]
    Stiff {
        /// Time at the start of the step.
        t: f64,
        /// Length of the step, or of a part of it in a composition.
        h: f64,
        /// The component with the worst bounds: `q[5]`, `q[7][2]`.
        what: String,
        /// Bounds of the eigenvalues of `h²/4 M⁻¹ ∂²V/∂q²` with the noise, by Gershgorin; NaN if a
        /// function has no bounds.
        bounds: [f64; 2],
    },
    /// The iteration of a step of a scene by the midpoint rule does not contract.
    #[error(
        "the iteration of the step from t = {t} with h = {h:e} stopped contracting after {sweeps} sweeps, with changes of {change:e} of the largest displacement: \
         the forces change much within the step, L has a jump in its derivative there, such as a cut-off, or its terms cancel; take a smaller h, or look at L there"
    )]
    NotContracting {
        /// Time at the start of the step.
        t: f64,
        /// Length of the step, or of a part of it in a composition.
        h: f64,
        /// Sweeps made.
        sweeps: u32,
        /// The last change of a displacement, relative to the largest displacement.
        change: f64,
    },
    /// The loss of a gradient or one of its derivatives is not finite.
    #[error(
        "the loss of the state at t = {t} is {value}, or one of its derivatives is not finite; is it smooth there?"
    )]
    NonFiniteLoss {
        /// The loss.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// Time of the state.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// The function of a gradient asks for a parameter that the system does not have.
    #[error(
        "`parameter(\"{parameter}\")`: L, the noises and the force have no such parameter; they have {known:?}"
    )]
    UnknownParameter {
        /// The name that was asked for.
        parameter: String,
        /// The parameters of the system.
        known: Vec<String>,
    },
    /// The function of the inputs panicked.
    #[error(
        "the function of the inputs panicked at step {step}, t = {t}: {message}; \
         a table of inputs needs an entry for each step"
    )]
    Inputs {
        /// The step, from 0.
        step: u64,
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The message of the panic.
        message: String,
    },
    /// The time scale of a system is not positive and finite at a node of a step, or at the place
    /// to which the velocity at its start leads.
    #[error(
        "the time scale is {scale} at q = {q:?}, at a node of the step from t = {t} with h = {h:e} or where the velocity at its start leads: \
         a function with `#[time_scale]` is positive and finite wherever the motion comes; look at it there, or take a smaller h"
    )]
    TimeScale {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Length of the step in τ; 0 outside of a step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The value of the time scale.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        scale: f64,
        /// The configuration there.
        q: Vec<f64>,
    },
    /// The step size is zero or not finite.
    #[error("the step size h = {h} must be finite and not zero")]
    StepSize {
        /// The step size given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
    },
    /// The tolerance of a path is not between 10⁻¹⁵ and 10⁻².
    #[error(
        "the tolerance {tolerance:e} of the path from t = {t} must be between 1e-15 and 1e-2: it is the error after about one characteristic time of the motion, in units of the state"
    )]
    Tolerance {
        /// Time at the start of the path.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The tolerance given.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        tolerance: f64,
    },
    /// A snapshot of a path with a tolerance was resumed without one.
    #[error(
        "the snapshot at t = {t} is that of a path whose step sizes were adapted to a tolerance: give the tolerance again, \
         `integrator.resume(snapshot, NoNoise)?.tolerance(tol)`, or begin a new trajectory at its state"
    )]
    ToleranceMissing {
        /// Time of the snapshot.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// A step that the tolerance of a path allows is too small to change the time, or no size was
    /// found for it.
    #[error(
        "the tolerance of the path allows no step from t = {t}: the last of {attempts} attempts had h = {h:e}, below {least:e} no step is made; \
         L is singular or not smooth near q = {q:?}, or the argument of a sine or cosine is above 10⁵ there, or the tolerance is below the rounding errors of its terms: end the path before, or take a larger tolerance or equal steps"
    )]
    StepTooSmall {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The size of the step that was tried last, or was to be tried first.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The smallest size, four times the rounding error of the time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        least: f64,
        /// Number of sizes that were tried.
        attempts: u32,
        /// Configuration at the start of the step.
        q: Vec<f64>,
    },
    /// A path with a tolerance has made the largest number of steps.
    #[error(
        "the path has made {steps} steps to t = {t}, the last with h = {h:e}, and that is its limit: \
         allow more with `.max_steps(n)`, end it before, or take a larger tolerance"
    )]
    TooManySteps {
        /// The time that the path has reached.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The size of the last step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The number of steps.
        steps: u64,
    },
    /// Newton's method did not reach rounding level.
    #[error(
        "Newton's method stopped after {iterations} iterations in the step from t = {t} with h = {h:e}: \
         relative residual {residual:e}, wanted {tolerance:e}; \
         take a smaller h{}",
        iteration_limit(*iterations)
    )]
    NotConverged {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Iterations made.
        iterations: u32,
        /// Largest residual, relative to the sum of the magnitudes of its equation's terms.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        residual: f64,
        /// The tolerance.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        tolerance: f64,
    },
    /// The solution that is connected with the limit of no noise and h → 0 ends before the whole
    /// step. Other solutions of the equations belong to another branch and are not accepted.
    #[error("{}", branch_lost(*t, *h, dw, *step, *reached))]
    BranchLost {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Increments of the noise.
        dw: Vec<f64>,
        /// Fraction of the step size up to which the solution was followed without noise.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        step: f64,
        /// Fraction of the increments up to which the solution was followed at the whole step size;
        /// 0 if the whole step size was not reached.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        reached: f64,
    },
    /// A noise force that depends on velocities is too strong for the step: its equations become
    /// singular on the way to its increment. For `f = σp` the midpoint rule divides by 1 − σΔW/2.
    #[error(
        "the step from t = {t} with h = {h:e} and the increments {dw:?}: its solution was followed from no noise and lost at {reached:.3} of the increments, \
         and a noise force depends on velocities: with it a step by this rule may have a pole where an increment is large; \
         truncated increments (`Truncated`) do not reach it, and a smaller h makes it rare; where the system takes them, `endpoint` has none if the force is linear in p, and `gauss(2)` none for a friction of one coordinate"
    )]
    NoisePole {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Increments of the noise.
        dw: Vec<f64>,
        /// Fraction of the increments up to which the solution was followed at the whole step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        reached: f64,
    },
    /// The configuration at the start of a step does not satisfy a constraint.
    #[error(
        "the constraint `{constraint}` is {value:e} at t = {t}, and its terms are of size {magnitude:e}: a step starts where the constraints hold; \
         `integrator.consistent(state)` returns the nearest state where they do"
    )]
    InconsistentStart {
        /// Time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The constraint.
        constraint: Box<str>,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// The sum of the magnitudes of its terms.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        magnitude: f64,
    },
    /// The gradients of the constraints are linearly dependent, as in a linkage that is folded or
    /// stretched into a line.
    #[error(
        "the constraint `{constraint}` depends on those before it at t = {t}, q = {q:?} (pivot {pivot:e} of ∂φ/∂q M⁻¹ ∂φ/∂q, 1 if it were independent): \
         the constraint forces are not determined there, as in a folded linkage; remove the constraint if it repeats others, or start elsewhere"
    )]
    ConstraintRank {
        /// Time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Configuration.
        q: Vec<f64>,
        /// Number of the constraint, from 0, in the order of the source.
        k: usize,
        /// The constraint.
        constraint: Box<str>,
        /// Its pivot in the elimination, relative to its diagonal entry.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        pivot: f64,
    },
    /// The gradient of a constraint vanishes where the constraint holds, as that of f² does for
    /// every f: a function with a double root is no constraint.
    #[error(
        "the gradient of the constraint `{constraint}` vanishes where the constraint does, near t = {t}, q = {q:?}: the constraint is {value:e} with terms of size {magnitude:e}, its gradient is \
         {gradient:?}, and that changes by {change:.2} of itself as far as its value and rounding errors are open; the constraint forces are not determined there; \
         write it as a function with a simple root, f and not f²"
    )]
    ConstraintGradient {
        /// Time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Configuration.
        q: Vec<f64>,
        /// The constraint.
        constraint: Box<str>,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// The sum of the magnitudes of its terms.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        magnitude: f64,
        /// ∂φ/∂q.
        gradient: Vec<f64>,
        /// Change of the gradient along its own direction, relative to the gradient, over the
        /// distance at which the constraint changes by its value and its rounding errors.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        change: f64,
    },
    /// The step passes a place near which the gradients of the constraints become dependent, such
    /// as a linkage that is almost stretched into a line: the motion turns there within a distance
    /// that is short beside the step.
    #[error(
        "the step from t = {t} with h = {h:e} passes near a fold of the constraints: at {step:.3} of h and {noise:.3} of the increments ∂φ/∂q M⁻¹ ∂φ/∂qᵀ has shrunk to {part:e} of that at the \
         start for some combination of constraints; the motion turns there within a distance that is short beside the step; take a smaller h"
    )]
    NearFold {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Fraction of the step size at the place.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        step: f64,
        /// Fraction of the increments there.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        noise: f64,
        /// Smallest eigenvalue of ∂φ/∂q M⁻¹ ∂φ/∂qᵀ there, relative to that of the start.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        part: f64,
    },
    /// The step is longer than the curvature of the constraints allows: their solution ends within
    /// the step.
    #[error(
        "the step from t = {t} with h = {h:e} loses the constraints: its solution was followed to {step:.3} of h without noise and to {noise:.3} of the increments, and ends there; \
         with the velocity of the start, h |v| = {distance:e}, the constraint `{constraint}` leaves zero by {violation:e} of its terms; take a smaller h"
    )]
    ConstraintLost {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Fraction of the step size up to which the solution was followed without noise.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        step: f64,
        /// Fraction of the increments up to which the solution was followed at the whole step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        noise: f64,
        /// Displacement in the step with the velocity of the start and the displacements by noise.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        distance: f64,
        /// The constraint that is violated most after that displacement.
        constraint: Box<str>,
        /// Its value there, relative to the sum of the magnitudes of its terms.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        violation: f64,
    },
    /// No configuration near the given one satisfies the constraints.
    #[error(
        "no configuration on the constraints was found near q = {q:?} at t = {t}: after {iterations} Gauss–Newton steps `{constraint}` is {value:e}; \
         start nearer to the constraints, or look at whether their parameters allow a configuration"
    )]
    NoConsistentState {
        /// Time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Configuration that was given.
        q: Vec<f64>,
        /// Gauss–Newton steps made.
        iterations: u32,
        /// The constraint that is violated most.
        constraint: Box<str>,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
    },
    /// No velocity with the momentum was found: none that is connected with the reference velocity
    /// of the Legendre transform, which is rest where L is defined there.
    #[error(
        "no velocity with the momentum p = {p:?} was found at t = {t}, q = {q:?}, and a step needs one to start with: from a reference velocity, which is rest where L allows it, \
         velocities were followed to {reached:.3} of the way to p and no further: ∂²L/∂v² may be singular there, or ∂L/∂v have no larger value or change too fast; \
         the momentum found last is {distance:e} away from p; look at the range of ∂L/∂v"
    )]
    NoVelocity {
        /// Time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Configuration.
        q: Vec<f64>,
        /// Momentum.
        p: Vec<f64>,
        /// Fraction of the path to the momentum along which velocities were found.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        reached: f64,
        /// Distance of the momentum from that of the last velocity found: the largest of its
        /// components.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        distance: f64,
    },
    /// The step ends where a function in L or in a noise is not defined.
    #[error(
        "the step from t = {t} with h = {h:e} leads out of the domain of L, from q = {q:?}: it needs {condition}; \
         take a smaller h, or choose L so that the motion stays within its domain"
    )]
    OutsideDomain {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Configuration at the start of the step.
        q: Vec<f64>,
        /// The condition that does not hold.
        condition: Box<str>,
    },
    /// A body turns by more than 229 degrees in the step.
    #[error(
        "a body would turn by {:.0} degrees in the step from t = {t} with h = {h:e}, and the limit is 229: take a smaller h, \
         or truncated increments if noise turned it (`Truncated`)",
        angle.to_degrees()
    )]
    LargeRotation {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// The angle in radians.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        angle: f64,
    },
    /// The mass matrix ∂²L/∂v² is singular at the start, so velocities are no differentiable
    /// function of the momentum there: none has it, or many, or one next to which the function has
    /// no derivative.
    #[error("{}", singular_mass([*t, *h], q, p, found))]
    SingularMass {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size; 0 where the Legendre transform itself was to be inverted.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Configuration.
        q: Vec<f64>,
        /// Momentum.
        p: Vec<f64>,
        /// The remaining row of the mass matrix, and the velocities that have the momentum.
        found: Box<SingularRow>,
    },
    /// The equations of the step have a singular Jacobian.
    #[error(
        "the equations of the step from t = {t} with h = {h:e} are singular near q = {q:?} (iteration {iteration}, 0 without one): take another h, or start elsewhere"
    )]
    Singular {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size; 0 where no step was involved.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Configuration at the start of the step.
        q: Vec<f64>,
        /// Newton iteration; 0 for a linear system.
        iteration: u32,
    },
    /// The momentum of a coordinate without mass is not that of its configuration, or an algebraic
    /// coordinate does not solve its equation.
    #[error(
        "{what} is {value} at t = {t}, and L makes it {expected}: this Lagrangian is degenerate, so this value follows from the configuration; \
         start from `State::from_configuration`"
    )]
    Inconsistent {
        /// Time of the state.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The quantity that has another value: `p[0]`, or `∂L/∂q[1]` of an algebraic coordinate.
        what: String,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
        /// The value that follows from the configuration.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        expected: f64,
    },
    /// The two-form of a degenerate Lagrangian has no inverse: nothing determines the velocities
    /// there.
    #[error(
        "the two-form ω = Dαᵀ − Dα of the degenerate Lagrangian is singular near q = {q:?} at t = {t} (step h = {h:e}, determinant {determinant:e}): \
         choose coordinates that are regular there, or start elsewhere"
    )]
    SingularForm {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size; 0 where no step was involved.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Configuration at the start of the step.
        q: Vec<f64>,
        /// Determinant of ω on the massless coordinates at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        determinant: f64,
    },
    /// A quantity that degenerate Lagrangians do not have.
    #[error(
        "{what} of a degenerate Lagrangian at t = {t}: not available, since momenta do not determine the velocities; take differences along a path"
    )]
    Degenerate {
        /// The quantity.
        what: String,
        /// Time of the state.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// The step left the numbers: an overflow, or a point where L or its derivatives are not
    /// defined.
    #[error(
        "the step from t = {t} with h = {h:e} gave a non-finite result from q = {q:?}, p = {p:?}: \
         L or a derivative is undefined nearby, the motion overflowed, or a parameter is not finite; take a smaller h, or look at L there"
    )]
    NonFiniteResult {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size; 0 where no step was involved.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Configuration at the start of the step.
        q: Vec<f64>,
        /// Momentum at the start of the step.
        p: Vec<f64>,
    },
    /// The step does not lead to a later finite time.
    #[error("{}", no_time(*t, *h, *end))]
    Time {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Time at its end: infinite, or that of the start where `h` is below its rounding.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        end: f64,
    },
    /// A snapshot of a compensated trajectory was given to a method that makes no compensated
    /// steps.
    #[error(
        "the snapshot at t = {t} has the low parts of compensated sums, and this method makes no compensated steps: resume it with the integrator that made it"
    )]
    Uncompensated {
        /// Time of the snapshot.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// A snapshot has numbers that its method carries from step to step, and the system or the
    /// method have changed since, so that the numbers are of other steps.
    #[error(
        "the snapshot at t = {t} has numbers that its method carried from step to step ({numbers} of them), and it was made with other {differs}: \
         resume it with the integrator as it was, or begin a new trajectory at its state, \
         `integrator.trajectory(*snapshot.state(), snapshot.h(), noise.from_step(snapshot.step()))`"
    )]
    OtherSteps {
        /// Time of the snapshot.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// How many numbers the snapshot has.
        numbers: usize,
        /// The part that differs: formulas, values of parameters, the method.
        differs: Box<str>,
    },
    /// Every 0th state of a trajectory is to be saved.
    #[error(
        "`every(0)` for the trajectory at t = {t}: the number is that of steps from one saved state to the next, so it is at least 1; `every(1)` saves each state"
    )]
    SavedInterval {
        /// The time that the trajectory has reached.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
    },
    /// A time at which a state is to be saved is not ahead of the trajectory.
    #[error(
        "a state at t = {t} is to be saved, and the trajectory is at t = {after} and goes on with h = {h}: \
         give finite times in the order in which it reaches them, none before its start"
    )]
    TimeOrder {
        /// The time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The time that the trajectory has reached.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        after: f64,
        /// The step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
    },
    /// A time at which a state is to be saved is within a step of which no part can be made.
    #[error("{}", within_step(*t, *from, *h, *stages))]
    WithinStep {
        /// The time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        from: f64,
        /// Step size.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        h: f64,
        /// Number of increments of a process in a step: 1, or the stages of a rule with stage
        /// noise.
        stages: usize,
    },
    /// A recorded path ends before a time at which a state is to be saved.
    #[error(
        "the recorded path ends at t = {end}, and a state at t = {t} is to be saved: record more steps, or end before"
    )]
    PathEnded {
        /// The time.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Time at the end of the path.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        end: f64,
    },
    /// A function whose zeros are events is not finite.
    #[error(
        "function {number} of the events (from 0) is {value} at t = {t}: its sign is not known there; give a function that is finite wherever the motion leads"
    )]
    EventFunction {
        /// Time of the state.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Number of the function, in the order in which they were given.
        number: usize,
        /// Its value.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        value: f64,
    },
    /// A function whose zeros are events changes its sign in a jump.
    #[error(
        "function {number} of the events (from 0) jumps from {before:e} to {after:e} at t = {t} and has no zero there: \
         if it is an angle, add `.angle()`; otherwise give a continuous function"
    )]
    EventJump {
        /// Time of the jump.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Number of the function, in the order in which they were given.
        number: usize,
        /// Its value before the jump.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        before: f64,
        /// Its value after the jump.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        after: f64,
    },
    /// The changes that a function causes follow one another faster than steps resolve.
    #[error(
        "function {number} of the events (from 0) changed the state at t = {t}, {interval:e} after it did so before: the changes accumulate, as the bounces \
         of a ball that comes to rest; end the trajectory before with `stop_at`, or take a smaller h"
    )]
    EventsAccumulate {
        /// Time of the change.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// Number of the function, in the order in which they were given.
        number: usize,
        /// Time since the change before.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        interval: f64,
    },
    /// Friction and noise of a system that [`Baoab`](crate::baseline::Baoab) cannot solve exactly.
    #[error(
        "BAOAB at t = {t}: {what}; it solves a friction −Cv with a diagonal C M⁻¹ and noises of the configuration exactly; \
         for other systems use a derived rule, or `baseline::Heun`"
    )]
    NotLangevin {
        /// Time in the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The property of the system.
        what: String,
    },
    /// The noise could not give the increments of this step.
    #[error("no noise for the step from t = {t}: {source}")]
    Noise {
        /// Time at the start of the step.
        #[cfg_attr(feature = "serde", serde(with = "crate::floats"))]
        t: f64,
        /// The error of the noise.
        source: NoiseError,
    },
}

debug_is_display!(StepError);

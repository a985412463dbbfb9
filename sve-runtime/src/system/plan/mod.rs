//! The plan of a step: its derivation, its solution and its cost. The macro writes it; users read
//! it through `Integrator::plan`.

mod text;

use core::fmt;

/// The method by which a block of equations is solved.
///
/// A kind is larger than another one if it is more demanding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum BlockKind {
    /// Each equation has one unknown, whose coefficient depends on parameters only: straight-line
    /// code.
    Explicit,
    /// The Jacobian does not depend on the unknowns: one linear solve, no iteration.
    Linear,
    /// Newton's method with the analytic Jacobian.
    Newton,
    /// A fixed-point iteration for the velocities of all sites of a scene, which forces of
    /// velocities or an H₁ join; or for their displacements, with bounds of the Jacobian, which
    /// forces make no symmetric one.
    FixedPoint,
    /// Chebyshev's iteration for the displacements of all sites of a scene, with bounds of the
    /// spectrum.
    Chebyshev,
}

impl fmt::Display for BlockKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Explicit => "explicit",
            Self::Linear => "linear",
            Self::Newton => "Newton",
            Self::FixedPoint => "fixed-point iteration",
            Self::Chebyshev => "Chebyshev's iteration",
        })
    }
}

/// A block of equations that is solved together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// The method by which the block is solved.
    pub kind: BlockKind,
    /// Names of the block's unknowns. Unknowns that other unknowns define are eliminated.
    pub unknowns: &'static [&'static str],
    /// Number of structural non-zeros of its Jacobian.
    pub nonzeros: usize,
    /// Lower and upper bandwidth of its Jacobian, if it is solved as a banded matrix. `unknowns`
    /// are in the order of the band.
    pub band: Option<(usize, usize)>,
}

/// Strong order of convergence of a stochastic step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StrongOrder {
    /// No noise.
    Deterministic,
    /// All noises commute: order 1. [`Formulas::system`] states whether this is proved or only
    /// checked numerically.
    One,
    /// Stage noise with γ alone, and the term of the option `weak2`: order 3/2.
    OneAndAHalf,
    /// Stage noise of two stages, with additive noise and forces that are linear in velocities:
    /// order 2.
    Two,
    /// Stage noise of three stages or more, as [`Three`](Self::Three), but with forces of
    /// velocities that depend on the place, such as a magnetic force: order 5/2.
    TwoAndAHalf,
    /// Stage noise of three stages or more, with additive noise, and forces of velocities that are
    /// linear in them with constant coefficients: order 3.
    Three,
    /// The named pair of noises does not commute: order ½.
    Half {
        /// Source names of a pair whose Poisson bracket does not vanish.
        pair: (&'static str, &'static str),
    },
}

/// The treatment of a Lagrangian that does not determine every velocity, and the quantity that the
/// step preserves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DegenerateStep {
    /// The degenerate coordinates occur in L without their velocities. `0 = ∂L/∂q` eliminates them,
    /// and the step is the symplectic step of the remaining Lagrangian.
    Eliminated,
    /// α = ∂L/∂v is affine in q: the discrete equations are the implicit midpoint rule. The
    /// two-form ω = Dαᵀ − Dα is preserved to rounding.
    Affine,
    /// Half of the velocities do not occur in L, up to a total derivative of a quadratic function:
    /// these coordinates are variables of the node. The two-form ω is preserved to rounding.
    Internal,
    /// Both ends are projected to p = α(q) by the same multiplier. The two-form ω is preserved up
    /// to O(h⁵) a step, with a constant that depends on the total derivatives in L. If L is written
    /// without half of the velocities, the step is [`Internal`](Self::Internal).
    Projected,
}

impl DegenerateStep {
    /// Returns whether the two-form is preserved to rounding.
    pub fn keeps_two_form(self) -> bool {
        self != Self::Projected
    }
}

impl fmt::Display for DegenerateStep {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Eliminated => "coordinates without velocities are eliminated by 0 = ∂L/∂q; the step is symplectic",
            Self::Affine => "p = α(q) with an affine α: the implicit midpoint rule, which preserves ω = Dαᵀ − Dα to rounding",
            Self::Internal => "p = α(q), half of the velocities removed: preserves ω = Dαᵀ − Dα to rounding",
            Self::Projected => {
                "p = α(q) by symmetric projection: preserves ω = Dαᵀ − Dα up to O(h⁵) a step; to rounding if L is written without half of the velocities"
            }
        })
    }
}

/// Numbers of floating-point operations. Comparisons, the choice of pivots and the tests of
/// Newton's method are not counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions, subtractions, multiplications, divisions.
    pub arithmetic: usize,
    /// Calls of `sqrt`, `sin`, `exp` and the like.
    pub transcendental: usize,
    /// Angle additions: sine and cosine of a sum, from sine and cosine of an angle and a short
    /// polynomial in the small increment.
    pub angle_additions: usize,
}

impl Operations {
    /// Returns the sum of these operations and `times` times the others.
    pub(crate) const fn plus(self, times: usize, others: Self) -> Self {
        Self {
            arithmetic: self.arithmetic + times * others.arithmetic,
            transcendental: self.transcendental + times * others.transcendental,
            angle_additions: self.angle_additions + times * others.angle_additions,
        }
    }
}

/// A step that is a sequence of substeps, each a step of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Substeps {
    /// Name of the composition.
    pub composition: &'static str,
    /// Number of substeps.
    pub count: usize,
}

/// The mathematics of a step, as text. Lines end with `\n`, except for the last line.
///
/// Time levels are subscripts, `q₀` and `q₁`, start and end of a step; components are in brackets,
/// `q₀[2]`, and a single coordinate has no brackets. `q̄`, `t̄` are the node of the midpoint rule,
/// `q̂`, `v̂` the predicted end of `taylor2`; `Δq = q₁ − q₀`; `ΔW[a]` is the increment of process
/// `a`. Parameters have the names of their fields. `c1`, `s1`, `u1`, … stand for expressions that
/// are written below. Long texts are cut off, with a note of the missing length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Formulas {
    /// L, the noise terms, the force, and the momenta of symmetries.
    pub system: &'static str,
    /// Equations of motion, as stochastic differential equations of Stratonovich.
    pub motion: &'static str,
    /// The discrete action of the rule, and the virtual work of the force.
    pub action: &'static str,
    /// The equations of the step after elimination, block by block, and the results that follow
    /// from them.
    pub step: &'static str,
}

/// The plan of a step.
///
/// ```
/// use sve_runtime::prelude::*;
/// struct Oscillator;
/// #[variational(midpoint)]
/// impl Oscillator {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
/// }
/// let plan = Integrator::new(Oscillator, Midpoint).plan();
/// assert_eq!(plan.unknowns(), 1);
/// assert_eq!(plan.deterministic_order, 2);
/// println!("{plan}");
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// Name of the user's type.
    pub system: &'static str,
    /// Attribute name of the rule, or the names of both rules of a splitting.
    pub rule: &'static str,
    /// The substeps of a composition. Blocks and formulas then describe a substep, which for a
    /// splitting is a step of the initial-point rule; orders and numbers of operations describe the
    /// whole step.
    pub substeps: Option<Substeps>,
    /// Degrees of freedom; [`OF_STATE`](Self::OF_STATE) if they are those of the state.
    pub degrees_of_freedom: usize,
    /// Wiener processes; [`OF_STATE`](Self::OF_STATE) if their number depends on the state.
    pub noises: usize,
    /// Blocks, in the order in which they are solved.
    pub blocks: &'static [Block],
    /// Order of convergence without noise.
    pub deterministic_order: u32,
    /// Strong order of convergence with noise.
    pub strong_order: StrongOrder,
    /// Weak order of convergence: errors of expectations are of the order of h to this power.
    /// Without noise it is the deterministic order. With noise it is 1, except in two cases, in
    /// which it is 2: for rules of deterministic order 2 or above with the option `weak2`, and
    /// without the option if its term would be constant, that is for additive noise in position
    /// alone with constant masses.
    pub weak_order: u32,
    /// The functions of the momenta of symmetries that every step conserves to rounding.
    pub conserved: &'static [&'static str],
    /// True if ensembles make this step for many paths at once, in lanes of vector registers. A
    /// step with too many unknowns, with a banded matrix, with rotations, or with roots that no
    /// bounds judge is made for one path after the other. `false` without the feature `ensemble`.
    pub in_lanes: bool,
    /// The treatment of a degenerate Lagrangian; `None` if L determines every velocity.
    pub degenerate: Option<DegenerateStep>,
    /// Operations for each step size.
    pub prepare: Operations,
    /// Operations for each step, with the linear solves and without the iterations. For a system
    /// whose `q` is a slice, those of a site that all loops with neighbouring sites read, in a
    /// sweep; loops over lists of sites are not counted.
    pub step: Operations,
    /// Operations of a step that a trajectory does not repeat, since it carries their results from
    /// the step before: the force at the end of a step is the force at the start of the next one.
    pub carried: Operations,
    /// Operations for each iteration of all Newton blocks, with the linear solves. For a
    /// [`Gauss`](crate::Gauss) rule the operations of a sweep over the stages: an iteration of its
    /// fixed point, or the residuals of Newton's method without the Jacobian and the linear solve.
    pub iteration: Operations,
    /// The mathematics of the step.
    pub formulas: Formulas,
}

impl Plan {
    /// A number that the length of the state determines, of a system whose `q` is a slice.
    pub const OF_STATE: usize = usize::MAX;

    /// Returns the number of unknowns that a linear solve or an iteration determines.
    pub fn unknowns(&self) -> usize {
        self.implicit().map(|b| b.unknowns.len()).sum()
    }

    /// Returns the number of structural non-zeros of the Jacobians of all implicit blocks.
    pub fn jacobian_nonzeros(&self) -> usize {
        self.implicit().map(|b| b.nonzeros).sum()
    }

    /// Returns the most demanding kind of block in the step.
    pub fn kind(&self) -> BlockKind {
        let kinds = self.blocks.iter().map(|block| block.kind);
        kinds.max().unwrap_or(BlockKind::Explicit)
    }

    /// Returns the operations of a step in which each Newton block takes so many iterations.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    /// struct Pendulum;
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    /// }
    /// let plan = Integrator::new(Pendulum, Midpoint).plan();
    /// let (two, three) = (plan.operations(2), plan.operations(3));
    /// assert_eq!(three.arithmetic - two.arithmetic, plan.iteration.arithmetic);
    /// ```
    pub fn operations(&self, iterations: usize) -> Operations {
        self.step.plus(iterations, self.iteration)
    }

    fn implicit(&self) -> impl Iterator<Item = &Block> {
        self.blocks.iter().filter(|b| b.kind != BlockKind::Explicit)
    }
}

impl fmt::Display for Operations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} arithmetic, {} transcendental",
            self.arithmetic, self.transcendental
        )?;
        match self.angle_additions {
            0 => Ok(()),
            1 => write!(f, ", 1 angle addition"),
            n => write!(f, ", {n} angle additions"),
        }
    }
}

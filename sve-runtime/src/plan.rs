//! What the macro made of a step: read by users through `Integrator::plan`, written by the macro.

use core::fmt;

/// How a block of equations is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum BlockKind {
    /// Each unknown stands alone, with a coefficient of parameters: straight-line code.
    Explicit,
    /// The Jacobian does not contain the unknowns: one solve, no iteration.
    Linear,
    /// Newton's method with the analytic Jacobian.
    Newton,
}

impl fmt::Display for BlockKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Explicit => "explicit",
            Self::Linear => "linear",
            Self::Newton => "Newton",
        })
    }
}

/// A block of equations that is solved together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Block {
    /// How it is solved.
    pub kind: BlockKind,
    /// Names of its unknowns, after elimination of what is defined by the others.
    pub unknowns: &'static [&'static str],
    /// Structural non-zeros of its Jacobian.
    pub nonzeros: usize,
    /// Entries before and behind the diagonal of its Jacobian, where it is solved as a banded matrix; `unknowns` are in that
    /// order.
    pub band: Option<(usize, usize)>,
}

/// Strong order of convergence of a stochastic step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum StrongOrder {
    /// No noise.
    Deterministic,
    /// All noises commute: order 1.
    One,
    /// The named pair of noises does not commute: order ½.
    Half {
        /// Source names of a pair whose Poisson bracket does not vanish.
        pair: (&'static str, &'static str),
    },
}

/// Floating-point operations of straight-line code.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Operations {
    /// Additions, subtractions, multiplications, divisions.
    pub arithmetic: usize,
    /// Calls of `sqrt`, `sin`, `exp` and the like.
    pub transcendental: usize,
}

/// What a step became.
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
    /// Attribute name of the rule.
    pub rule: &'static str,
    /// Degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Wiener processes.
    pub noises: usize,
    /// Blocks, in the order in which they are solved.
    pub blocks: &'static [Block],
    /// Order of convergence without noise.
    pub deterministic_order: u32,
    /// Strong order of convergence with noise.
    pub strong_order: StrongOrder,
    /// Done once for a step size.
    pub prepare: Operations,
    /// Done once a step (iterations not counted).
    pub step: Operations,
    /// Done once an iteration, all Newton blocks together, linear solves not counted.
    pub iteration: Operations,
}

impl Plan {
    /// Unknowns that a linear solve or an iteration determines.
    pub fn unknowns(&self) -> usize {
        self.implicit().map(|b| b.unknowns.len()).sum()
    }

    /// Structural non-zeros of the Jacobians of all implicit blocks.
    pub fn jacobian_nonzeros(&self) -> usize {
        self.implicit().map(|b| b.nonzeros).sum()
    }

    /// The most demanding kind of block in the step.
    pub fn kind(&self) -> BlockKind {
        let has = |kind| self.blocks.iter().any(|b| b.kind == kind);
        if has(BlockKind::Newton) {
            BlockKind::Newton
        } else if has(BlockKind::Linear) {
            BlockKind::Linear
        } else {
            BlockKind::Explicit
        }
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
        )
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let (n, m, k) = (self.degrees_of_freedom, self.noises, self.unknowns());
        writeln!(f, "{} by the rule {}", self.system, self.rule)?;
        writeln!(
            f,
            "  {n} degree{} of freedom, {m} Wiener process{}",
            plural(n),
            if m == 1 { "" } else { "es" }
        )?;
        write!(f, "  {}, {k} unknown{}", self.kind(), plural(k))?;
        if k > 0 {
            let nonzeros = self.jacobian_nonzeros();
            write!(
                f,
                ", {nonzeros} non-zero{} in the Jacobian",
                plural(nonzeros)
            )?;
        }
        writeln!(f)?;
        for block in self.blocks {
            write!(
                f,
                "    {:<8} {}",
                block.kind.to_string(),
                block.unknowns.join(", ")
            )?;
            if let Some((before, behind)) = block.band {
                write!(f, " (banded, {before} + 1 + {behind})")?;
            }
            writeln!(f)?;
        }
        write!(f, "  deterministic order {}", self.deterministic_order)?;
        match self.strong_order {
            StrongOrder::Deterministic => writeln!(f)?,
            StrongOrder::One => writeln!(f, ", strong order 1 (all noises commute)")?,
            StrongOrder::Half { pair: (a, b) } => {
                writeln!(f, ", strong order 1/2 ({a} and {b} do not commute)")?;
            }
        }
        writeln!(f, "  operations a step size: {}", self.prepare)?;
        write!(f, "  operations a step: {}", self.step)?;
        if self.kind() == BlockKind::Newton {
            write!(f, "\n  operations an iteration: {}", self.iteration)?;
        }
        Ok(())
    }
}

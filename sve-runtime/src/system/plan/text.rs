//! The text of a plan.

use core::fmt;

use super::{BlockKind, Formulas, Operations, Plan, StrongOrder, Substeps};

impl Plan {
    /// Returns the first part of the printed plan: sizes, blocks and orders, without the formulas
    /// and the counts of operations.
    pub fn structure(&self) -> impl fmt::Display + '_ {
        Structure(self)
    }
}

impl fmt::Display for Plan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Formulas {
            system,
            motion,
            action,
            step,
        } = self.formulas;
        let of_motion = match self.strong_order {
            StrongOrder::Deterministic => "equations of motion",
            _ => "equations of motion (Stratonovich)",
        };
        let of_step = match self.substeps {
            Some(_) => "equations of a substep",
            None => "equations of the step",
        };
        writeln!(f, "{}", self.structure())?;
        for (heading, text) in [
            ("system", system),
            (of_motion, motion),
            ("discrete action", action),
            (of_step, step),
        ] {
            writeln!(f, "  {heading}")?;
            for line in text.lines() {
                writeln!(f, "    {line}")?;
            }
        }
        write!(f, "  operations a step size: {}", self.prepare)?;
        match self.degrees_of_freedom {
            // Loops over lists of sites have operations that are not counted.
            Self::OF_STATE if self.step == Operations::default() => {}
            Self::OF_STATE => write!(
                f,
                "\n  operations of a sweep at an inner site: {}",
                self.step
            )?,
            _ => write!(f, "\n  operations a step: {}", self.step)?,
        }
        if self.carried != Operations::default() {
            write!(f, "\n  of which a trajectory carries: {}", self.carried)?;
        }
        if self.kind() == BlockKind::Newton {
            write!(f, "\n  operations an iteration: {}", self.iteration)?;
        }
        Ok(())
    }
}

/// A plan without its formulas, see [`Plan::structure`].
struct Structure<'a>(&'a Plan);

impl fmt::Display for Structure<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let plan = self.0;
        let plural = |n: usize| if n == 1 { "" } else { "s" };
        let (n, m, k) = (plan.degrees_of_freedom, plan.noises, plan.unknowns());
        writeln!(f, "{} by the rule {}", plan.system, plan.rule)?;
        if let Some(Substeps { composition, count }) = plan.substeps {
            writeln!(f, "  {count} substeps of the composition {composition}")?;
        }
        match n {
            Plan::OF_STATE => write!(f, "  as many degrees of freedom as the state has, ")?,
            n => write!(f, "  {n} degree{} of freedom, ", plural(n))?,
        }
        match m {
            Plan::OF_STATE => writeln!(f, "a number of Wiener processes that depends on it")?,
            1 => writeln!(f, "1 Wiener process")?,
            m => writeln!(f, "{m} Wiener processes")?,
        }
        if k > 0 && n == Plan::OF_STATE {
            write!(f, "  {}, an unknown for each coordinate", plan.kind())?;
        } else {
            write!(f, "  {}, {k} unknown{}", plan.kind(), plural(k))?;
        }
        if k > 0 && n != Plan::OF_STATE {
            let nonzeros = plan.jacobian_nonzeros();
            write!(
                f,
                ", {nonzeros} non-zero{} in the Jacobian",
                plural(nonzeros)
            )?;
        }
        writeln!(f)?;
        let listed = plan.blocks.iter();
        for block in listed.filter(|block| block.kind != BlockKind::Chebyshev) {
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
        if let Some(degenerate) = plan.degenerate {
            writeln!(f, "  {degenerate}")?;
        }
        write!(f, "  deterministic order {}", plan.deterministic_order)?;
        match plan.strong_order {
            StrongOrder::Deterministic => {}
            StrongOrder::One => write!(f, ", strong order 1 (all noises commute)")?,
            StrongOrder::OneAndAHalf => write!(f, ", strong order 3/2 (stage noise)")?,
            StrongOrder::Two => write!(f, ", strong order 2 (stage noise, additive)")?,
            StrongOrder::TwoAndAHalf => {
                write!(
                    f,
                    ", strong order 5/2 (stage noise, additive, forces of velocities and places)"
                )?;
            }
            StrongOrder::Three => write!(f, ", strong order 3 (stage noise, additive)")?,
            StrongOrder::Half { pair: (a, b) } => {
                write!(f, ", strong order 1/2 ({a} and {b} do not commute)")?;
            }
        }
        if plan.noises > 0 {
            write!(f, ", weak order {}", plan.weak_order)?;
        }
        if !plan.conserved.is_empty() {
            write!(f, "\n  conserves {}", plan.conserved.join(", "))?;
        }
        if cfg!(feature = "ensemble") && !plan.in_lanes && n != Plan::OF_STATE {
            write!(f, "\n  ensembles step one path after the other")?;
        }
        Ok(())
    }
}

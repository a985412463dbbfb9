//! Elimination of unknowns that some equation gives with a numeric coefficient, and the blocks of
//! the remaining equations.

use std::collections::{HashMap, HashSet};

use super::Degenerate;
use super::graph::{match_columns, strong_components};
use crate::algebra::{Arena, Expr, Node, Symbol};
use crate::discretise::equations::{Equations, Leading};
use crate::model::domain::Condition;
use crate::model::{Family, Meaning, Symbols, Unknown};

/// Equations and the unknowns that they determine.
type RowsAndColumns = (Vec<usize>, Vec<usize>);

/// The equations after the eliminations so far.
pub(super) struct Reduced<'a> {
    /// For each residual, the unknowns that it may not eliminate.
    pub(super) kept: Vec<HashSet<Symbol>>,
    pub(super) arena: &'a mut Arena,
    pub(super) symbols: &'a mut Symbols,
    pub(super) unknowns: Vec<Symbol>,
    pub(super) residuals: Vec<Expr>,
    pub(super) dq: Vec<Expr>,
    pub(super) dp: Vec<Vec<Expr>>,
    pub(super) domain: Vec<Condition<Expr>>,
    /// The equations to leading order, if the first guess is solved from these.
    pub(super) leading: Option<Leading>,
    /// Unknowns that are taken as known if this makes other unknowns explicit.
    pub(super) torn: Vec<Symbol>,
    /// Expressions that must not be negative if a solution is accepted because its iteration
    /// contracts.
    pub(super) guards: Vec<Expr>,
    /// Additional results of a step.
    pub(super) reported: Vec<Expr>,
    pub(super) turned: Vec<Expr>,
    /// The increments of noise forces that depend on velocities.
    pub(super) dividing: Vec<Symbol>,
}

/// An unknown that an equation gives as `x = f(others)`.
#[derive(Clone, Copy)]
struct Pivot {
    unknown: Symbol,
    coefficient: f64,
}

/// An equation that may give an unknown. It is examined again only when it has changed.
struct Candidate {
    /// Unknowns in the equation, in the order of `unknowns`.
    present: Vec<Symbol>,
    /// True if `pivot` was sought.
    asked: bool,
    pivot: Option<Pivot>,
}

impl<'a> Reduced<'a> {
    /// The equations before any elimination.
    pub(super) fn new(
        equations: Equations,
        symbols: &'a mut Symbols,
        arena: &'a mut Arena,
    ) -> Self {
        Self {
            kept: Vec::new(),
            dividing: Vec::new(),
            arena,
            symbols,
            unknowns: equations.unknowns,
            residuals: equations.residuals,
            dq: equations.dq,
            dp: equations.dp,
            domain: Vec::new(),
            leading: equations.leading,
            torn: equations.torn,
            guards: equations.guards,
            reported: equations.reported,
            turned: equations.turned,
        }
    }

    /// Returns the conditions of the domain at the solution of all blocks.
    pub(super) fn domain_at(&mut self, known: &HashMap<Symbol, Expr>) -> Vec<Condition<Expr>> {
        let conditions = self.domain.clone().into_iter();
        let at = conditions.map(|condition| Condition {
            value: self.arena.substitute(condition.value, known),
            ..condition
        });
        at.collect()
    }

    /// Removes every unknown that an equation gives as `x = f(others)` with a numeric coefficient,
    /// the shortest equation first.
    pub(super) fn eliminate(&mut self) {
        let mut candidates: Vec<Candidate> = Vec::new();
        for row in 0..self.residuals.len() {
            candidates.push(self.candidate(row));
        }
        while let Some((
            row,
            Pivot {
                unknown,
                coefficient,
            },
        )) = self.best(&mut candidates)
        {
            candidates.remove(row);
            self.kept.remove(row);
            let equation = self.residuals.remove(row);
            if let Some(leading) = &mut self.leading {
                leading.residuals.remove(row);
                leading.mean_values.remove(row);
                leading.scales.remove(row);
                leading.variations.remove(row);
            }
            let zero = self.arena.constant(0.0);
            let rest = self
                .arena
                .substitute(equation, &HashMap::from([(unknown, zero)]));
            let value = self.arena.scale(-1.0 / coefficient, rest);
            let by = HashMap::from([(unknown, value)]);
            self.unknowns.retain(|&u| u != unknown);
            for row in 0..self.residuals.len() {
                if self.arena.contains(self.residuals[row], unknown) {
                    self.residuals[row] = self.arena.substitute(self.residuals[row], &by);
                    candidates[row] = self.candidate(row);
                }
            }
            let leading = self
                .leading
                .iter_mut()
                .map(|leading| &mut leading.residuals);
            let lists = [
                &mut self.dq,
                &mut self.reported,
                &mut self.turned,
                &mut self.guards,
            ]
            .into_iter();
            for list in lists.chain(&mut self.dp).chain(leading) {
                for expr in list {
                    if self.arena.contains(*expr, unknown) {
                        *expr = self.arena.substitute(*expr, &by);
                    }
                }
            }
            let means = self.leading.iter_mut().flat_map(|l| &mut l.mean_values);
            for mean in means.flatten() {
                mean.rate = self.arena.substitute(mean.rate, &by);
            }
            for condition in &mut self.domain {
                condition.value = self.arena.substitute(condition.value, &by);
            }
        }
    }

    /// Keeps displacements in the equations that couple several of them in the limit of no noise
    /// and h → 0. The two-form couples them there, and which of its entries is large is unknown at
    /// compile time.
    pub(super) fn keep_coupled(&mut self) {
        for row in 0..self.residuals.len() {
            let residual = self.residuals[row];
            let zero = self.arena.constant(0.0);
            let small = self.small(&[residual]).into_iter();
            let limit: HashMap<Symbol, Expr> = small.map(|s| (s, zero)).collect();
            let mut coupled = HashSet::new();
            for unknown in self.unknowns.clone() {
                let meaning = self.symbols.meaning(unknown);
                if !matches!(meaning, Meaning::Unknown(u) if u.family.is_displacement()) {
                    continue;
                }
                let slope = self.arena.diff(residual, unknown);
                if self.arena.substitute(slope, &limit) != zero {
                    coupled.insert(unknown);
                }
            }
            if coupled.len() > 1 {
                self.kept[row].extend(coupled);
            }
        }
    }

    /// Returns the equation with the fewest unknowns among the equations that give one with a
    /// numeric coefficient, and its pivot. Ties go to the first equation.
    fn best(&mut self, candidates: &mut [Candidate]) -> Option<(usize, Pivot)> {
        let mut best: Option<(usize, usize, Pivot)> = None;
        for (row, candidate) in candidates.iter_mut().enumerate() {
            self.arena.spend(1);
            if self.arena.is_exhausted() {
                return None;
            }
            let present = candidate.present.len();
            if best.is_some_and(|b| b.0 <= present) {
                continue;
            }
            if !std::mem::replace(&mut candidate.asked, true) {
                candidate.pivot = self.pivot(row, &candidate.present);
            }
            if let Some(pivot) = candidate.pivot {
                best = Some((present, row, pivot));
            }
        }
        best.map(|(_, row, pivot)| (row, pivot))
    }

    fn candidate(&self, row: usize) -> Candidate {
        let contained = |u: &Symbol| self.arena.contains(self.residuals[row], *u);
        Candidate {
            present: self.unknowns.iter().copied().filter(contained).collect(),
            asked: false,
            pivot: None,
        }
    }

    /// Returns the first unknown of an equation, in the order of `unknowns`, that has a numeric
    /// coefficient. With this order the momentum balance stays, and the velocity in it.
    fn pivot(&mut self, row: usize, present: &[Symbol]) -> Option<Pivot> {
        let residual = self.residuals[row];
        for &unknown in present {
            if self.kept[row].contains(&unknown) || self.moves_node(residual, unknown) {
                continue;
            }
            let slope = self.arena.diff(residual, unknown);
            if let Some(coefficient) = self.arena.constant_value(slope)
                && coefficient != 0.0
            {
                return Some(Pivot {
                    unknown,
                    coefficient,
                });
            }
        }
        None
    }

    /// Returns whether an unknown occurs within a named intermediate result, `q₀ + c d`. In a small
    /// step the unknown is added to a much larger q₀, so solving the equation for it loses the
    /// digits of q₀: `m v − B (q₀ + d) = p₀` is not used as an equation for d.
    pub(super) fn moves_node(&self, residual: Expr, unknown: Symbol) -> bool {
        let mut nodes = self
            .arena
            .reachable(&[residual], |e| self.arena.contains(e, unknown))
            .into_iter();
        nodes.any(|e| matches!(self.arena.node(e), Node::Opaque(..)))
    }

    /// Returns the rows and columns of each block, in the order of solution.
    pub(super) fn blocks(&mut self) -> Result<Vec<RowsAndColumns>, Degenerate> {
        let n = self.unknowns.len();
        let depends: Vec<Vec<usize>> = self
            .residuals
            .iter()
            .map(|&r| {
                (0..n)
                    .filter(|&c| self.arena.contains(r, self.unknowns[c]))
                    .collect()
            })
            .collect();
        let row_of = match_columns(&depends, n).map_err(|free| Degenerate {
            unknowns: free.into_iter().map(|c| self.unknowns[c]).collect(),
        })?;
        // equation row_of[c] gives unknown c and needs the other unknowns in it
        let needs: Vec<Vec<usize>> = (0..n).map(|c| depends[row_of[c]].clone()).collect();
        Ok(strong_components(&needs)
            .into_iter()
            .map(|mut columns| {
                columns.sort_unstable();
                let mut rows: Vec<usize> = columns.iter().map(|&c| row_of[c]).collect();
                rows.sort_unstable();
                (rows, columns)
            })
            .collect())
    }
}

/// Returns, for each equation, the unknowns that it may not eliminate although they have numeric
/// coefficients. Such a coefficient may be small compared with the masses, for example the
/// coefficient of a weak coupling or of friction. A velocity, an acceleration or its multiplier may
/// come from the equation of its own coordinate, and a velocity never from the equation of motion:
/// elimination along the diagonal of a mass matrix, which is positive definite, needs no pivoting
/// (Higham, Accuracy and Stability of Numerical Algorithms, section 10.1). The equations of
/// constraints eliminate nothing, and their multipliers stay.
pub(super) fn kept_unknowns(equations: &Equations, symbols: &Symbols) -> Vec<HashSet<Symbol>> {
    let as_unknown = |symbol: Symbol| match symbols.meaning(symbol) {
        Meaning::Unknown(unknown) => Some(*unknown),
        _ => None,
    };
    let is_kept = |variation: Symbol, unknown: Symbol| {
        let (Some(of), Some(Unknown { family, index })) =
            (as_unknown(variation), as_unknown(unknown))
        else {
            return false;
        };
        if of.family.is_multiplier_of_constraint() {
            return true;
        }
        let (is_own, is_motion) = (
            index == of.index,
            of.family == Family::AccelerationMultiplier,
        );
        match family {
            Family::Velocity | Family::StageVelocity => is_motion || !is_own,
            Family::Acceleration | Family::AccelerationMultiplier | Family::EndVelocity => !is_own,
            Family::StartMultiplier | Family::EndMultiplier => true,
            Family::Displacement
            | Family::NodeDisplacement
            | Family::Projection
            | Family::Momentum
            | Family::VelocityMultiplier => false,
        }
    };
    let rows = equations.variations.iter().map(|&variation| {
        let unknowns = equations.unknowns.iter().copied();
        unknowns.filter(|&u| is_kept(variation, u)).collect()
    });
    rows.collect()
}

//! Tearing: a block becomes a system in a few unknowns, and the other unknowns are explicit
//! functions of these.
//!
//! Input: a block, and the unknowns that are torn, that is, taken as known. Output: formulas of the
//! unknowns that some equation then gives with a known coefficient, and the remaining equations and
//! unknowns. The multipliers of constraints are torn: if the masses are constant and the forces
//! explicit, Newton's method has one unknown for each constraint (SHAKE). So it has if the force on
//! a coordinate has a friction of its own velocity, whose coefficient is m + ½hν.
//!
//! Source: Duff, Erisman, Reid, *Direct Methods for Sparse Matrices* (2017), section 7.6.

use std::collections::HashMap;

use super::block::Replacement;
use super::elimination::Reduced;
use super::scheme::{Block, Kind, Solution};
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;

/// A block after tearing.
pub(super) struct Torn {
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
    /// The explicit unknowns with their formulas in the remaining unknowns, in the order in which
    /// they were found.
    pub(super) formulas: Vec<Formula>,
}

/// An unknown with its formula.
pub(super) struct Formula {
    unknown: Symbol,
    value: Expr,
    kind: Kind,
}

impl Reduced<'_> {
    /// Finds the explicit unknowns of a block and replaces them in its equations.
    pub(super) fn tear(
        &mut self,
        mut rows: Vec<usize>,
        mut columns: Vec<usize>,
        known: &Replacement,
    ) -> Torn {
        let mut formulas = Vec::new();
        let has_torn = columns
            .iter()
            .any(|&c| self.torn.contains(&self.unknowns[c]));
        if has_torn {
            for &row in &rows {
                self.replace(row, known);
            }
            while let Some((row, column, found)) = self.explicit(&rows, &columns) {
                rows.retain(|&r| r != row);
                columns.retain(|&c| c != column);
                let by = HashMap::from([(found.unknown, found.value)]);
                for &row in &rows {
                    self.replace(row, &by);
                }
                formulas.push(found);
            }
        }
        Torn {
            rows,
            columns,
            formulas,
        }
    }

    /// Returns the explicit unknowns of a block as blocks to be solved after the remaining
    /// unknowns. Adds their formulas to `known`.
    pub(super) fn explicit_blocks(
        &mut self,
        formulas: Vec<Formula>,
        known: &mut Replacement,
    ) -> Vec<Block<Expr>> {
        let blocks = formulas.into_iter().map(|found| {
            let formula = self.arena.substitute(found.value, known);
            known.insert(found.unknown, formula);
            Block {
                kind: found.kind,
                unknowns: vec![found.unknown],
                nonzeros: 1,
                pivots: None,
                solution: Solution::Formula(formula),
            }
        });
        blocks.collect()
    }

    /// Replaces symbols of an equation by expressions.
    fn replace(&mut self, row: usize, by: &Replacement) {
        self.residuals[row] = self.arena.substitute(self.residuals[row], by);
        if let Some(leading) = &mut self.leading {
            leading.residuals[row] = self.arena.substitute(leading.residuals[row], by);
            if let Some(mean) = &mut leading.mean_values[row] {
                mean.rate = self.arena.substitute(mean.rate, by);
            }
        }
    }

    /// Returns an equation with a single unknown that is not torn, this unknown and its formula.
    fn explicit(&mut self, rows: &[usize], columns: &[usize]) -> Option<(usize, usize, Formula)> {
        for &row in rows {
            let residual = self.residuals[row];
            let mut present = columns.iter().copied().filter(|&c| {
                let unknown = self.unknowns[c];
                !self.torn.contains(&unknown) && self.arena.contains(residual, unknown)
            });
            let (Some(column), None) = (present.next(), present.next()) else {
                continue;
            };
            drop(present);
            let unknown = self.unknowns[column];
            if self.kept[row].contains(&unknown) || self.moves_node(residual, unknown) {
                continue;
            }
            let slope = self.arena.diff(residual, unknown);
            let Some(kind) = self.kind_of_division(slope) else {
                continue;
            };
            let zero = self.arena.constant(0.0);
            let origin = HashMap::from([(unknown, zero)]);
            let rest = self.arena.substitute(residual, &origin);
            let rest = self.arena.neg(rest);
            let formula = self.arena.div(rest, slope);
            let found = Formula {
                unknown,
                value: self.arena.opaque(formula),
                kind,
            };
            return Some((row, column, found));
        }
        None
    }

    /// Returns the kind of an equation whose unknown has this coefficient; `None` if the
    /// coefficient is not known before the block, or is not a parameter in the limit h → 0. The
    /// coefficient must keep the sign of its limit: a negative friction may change it, and the
    /// solution is then not connected with the motion.
    fn kind_of_division(&mut self, slope: Expr) -> Option<Kind> {
        let is_step = |s: &Symbol| matches!(self.symbols.meaning(*s), Meaning::StepSize);
        let step = self.arena.symbols_of(slope).find(is_step);
        let zero = self.arena.constant(0.0);
        let limit = match step {
            Some(h) => self.arena.substitute(slope, &HashMap::from([(h, zero)])),
            None => slope,
        };
        if !self.is_defined(&[limit]) || !self.is_parameter(limit) || self.arena.is_zero(limit) {
            return None;
        }
        if limit == slope {
            return Some(Kind::Explicit);
        }
        let is_open = |s| {
            let meaning = self.symbols.meaning(s);
            matches!(meaning, Meaning::Unknown(_) | Meaning::Wiener(_))
        };
        if self.arena.symbols_of(slope).any(is_open) {
            return None;
        }
        self.guards.push(self.arena.mul(limit, slope));
        Some(Kind::Linear)
    }
}

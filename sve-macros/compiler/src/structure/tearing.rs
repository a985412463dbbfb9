//! Tearing: a block becomes a system in a few unknowns, and the other unknowns are explicit
//! functions of these.
//!
//! Input: a block, and the unknowns that are torn, that is, taken as known. Output: formulas of the
//! unknowns that some equation then gives with a coefficient of parameters alone, and the remaining
//! equations and unknowns. The multipliers of constraints are torn: if the masses are constant and
//! the forces explicit, Newton's method has one unknown for each constraint (SHAKE).
//!
//! Source: Duff, Erisman, Reid, *Direct Methods for Sparse Matrices* (2017), section 7.6.

use std::collections::HashMap;

use super::block::Replacement;
use super::elimination::Reduced;
use super::scheme::{Block, Kind, Solution};
use crate::algebra::{Expr, Symbol};

/// A block after tearing.
pub(super) struct Torn {
    pub(super) rows: Vec<usize>,
    pub(super) columns: Vec<usize>,
    /// The explicit unknowns with their formulas in the remaining unknowns, in the order in which
    /// they were found.
    pub(super) formulas: Vec<(Symbol, Expr)>,
}

impl Reduced<'_> {
    /// Finds the explicit unknowns of a block and replaces them in its equations.
    pub(super) fn tear(
        &mut self,
        mut rows: Vec<usize>,
        mut columns: Vec<usize>,
        known: &Replacement,
    ) -> Torn {
        let mut formulas: Vec<(Symbol, Expr)> = Vec::new();
        let has_torn = columns
            .iter()
            .any(|&c| self.torn.contains(&self.unknowns[c]));
        if has_torn {
            for &row in &rows {
                self.replace(row, known);
            }
            while let Some((row, column, formula)) = self.explicit(&rows, &columns) {
                let unknown = self.unknowns[column];
                rows.retain(|&r| r != row);
                columns.retain(|&c| c != column);
                let by = HashMap::from([(unknown, formula)]);
                for &row in &rows {
                    self.replace(row, &by);
                }
                formulas.push((unknown, formula));
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
        formulas: Vec<(Symbol, Expr)>,
        known: &mut Replacement,
    ) -> Vec<Block<Expr>> {
        let blocks = formulas.into_iter().map(|(unknown, formula)| {
            let formula = self.arena.substitute(formula, known);
            known.insert(unknown, formula);
            Block {
                kind: Kind::Explicit,
                unknowns: vec![unknown],
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
    fn explicit(&mut self, rows: &[usize], columns: &[usize]) -> Option<(usize, usize, Expr)> {
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
            if !self.is_parameter(slope) || self.arena.is_zero(slope) {
                continue;
            }
            let zero = self.arena.constant(0.0);
            let origin = HashMap::from([(unknown, zero)]);
            let rest = self.arena.substitute(residual, &origin);
            let rest = self.arena.neg(rest);
            let formula = self.arena.div(rest, slope);
            return Some((row, column, self.arena.opaque(formula)));
        }
        None
    }
}

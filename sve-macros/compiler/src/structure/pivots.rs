//! The order of pivots of a block with multipliers of constraints, for solves in lanes, where an
//! exchange of rows would cost as much as the elimination.
//!
//! Input: the equations of the block to leading order, from which Newton's method starts. Output:
//! pivots that do not vanish for a small step. The pivots of the equations of motion come first,
//! whose matrix is as regular as the masses; then the pivots of the constraints, whose Schur
//! complement is as regular as `Dφ M⁻¹ Dφᵀ`. Zeros of the matrix that this order does not fill in
//! stay zeros.
//!
//! Source: Benzi, Golub, Liesen, *Numerical solution of saddle point problems*, Acta Numerica 14
//! (2005), section 7.

use super::elimination::Reduced;
use super::matrix::Matrix;
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::{Meaning, Unknown};

/// The row and column of each pivot, in the order of elimination.
#[derive(Clone, Debug)]
pub(crate) struct Pivots(pub(crate) Vec<(usize, usize)>);

/// An equation or an unknown of a block.
#[derive(Clone, Copy)]
struct Line {
    /// The number of its coordinate or constraint.
    index: usize,
    /// True if it belongs to a constraint.
    is_of_constraint: bool,
}

impl Reduced<'_> {
    /// Returns the pivots of a matrix whose equations belong to these variations. `None` if the
    /// equations of motion do not determine the unknowns of motion one by one.
    pub(super) fn pivots(
        &self,
        variations: &[Symbol],
        unknowns: &[Symbol],
        matrix: &Matrix<Expr>,
    ) -> Option<Pivots> {
        let lines = |symbols: &[Symbol]| -> Option<Vec<Line>> {
            let line = |&symbol: &Symbol| match *self.symbols.meaning(symbol) {
                Meaning::Unknown(Unknown { family, index }) => Some(Line {
                    index,
                    is_of_constraint: family.is_multiplier_of_constraint(),
                }),
                _ => None,
            };
            symbols.iter().map(line).collect()
        };
        let (rows, columns) = (lines(variations)?, lines(unknowns)?);
        let pattern = pattern(matrix, self.arena);
        let mut pivots = motion(&rows, &columns, &pattern)?;
        let of_constraints = |lines: &[Line]| {
            let mut found: Vec<usize> = (0..lines.len())
                .filter(|&i| lines[i].is_of_constraint)
                .collect();
            found.sort_by_key(|&i| lines[i].index);
            found
        };
        let (rows, columns) = (of_constraints(&rows), of_constraints(&columns));
        pivots.extend(rows.into_iter().zip(columns));
        let pivots = Pivots(pivots);
        pivots.suit(matrix, self.arena).then_some(pivots)
    }
}

/// Returns the pivots of the equations of motion. Each step takes an equation with the fewest
/// unknowns that have no pivot yet.
fn motion(rows: &[Line], columns: &[Line], pattern: &[Vec<bool>]) -> Option<Vec<(usize, usize)>> {
    let of_motion = |lines: &[Line]| -> Vec<usize> {
        let all = 0..lines.len();
        all.filter(|&i| !lines[i].is_of_constraint).collect()
    };
    let (mut left, mut open) = (of_motion(rows), of_motion(columns));
    if left.len() != open.len() {
        return None;
    }
    let mut pivots = Vec::new();
    while !left.is_empty() {
        let count = |row: usize| open.iter().filter(|&&c| pattern[row][c]).count();
        let row = left
            .iter()
            .copied()
            .filter(|&row| count(row) > 0)
            .min_by_key(|&row| count(row))?;
        let has_entry = |c: &&usize| pattern[row][**c];
        let is_own = |c: &&usize| columns[**c].index == rows[row].index;
        let own = open.iter().filter(has_entry).find(is_own);
        let column = *own.or_else(|| open.iter().find(has_entry))?;
        left.retain(|&r| r != row);
        open.retain(|&c| c != column);
        pivots.push((row, column));
    }
    Some(pivots)
}

/// Returns, for each entry of a matrix, whether it is nonzero.
fn pattern(matrix: &Matrix<Expr>, arena: &Arena) -> Vec<Vec<bool>> {
    let is_entry = |e: Option<Expr>| e.is_some_and(|e| arena.constant_value(e) != Some(0.0));
    let rows = (0..matrix.size()).map(|row| matrix.all_entries(row).into_iter().map(is_entry));
    rows.map(Iterator::collect).collect()
}

impl Pivots {
    /// Returns whether no pivot is an entry of the matrix that is always zero.
    pub(crate) fn suit(&self, matrix: &Matrix<Expr>, arena: &Arena) -> bool {
        let mut pattern = pattern(matrix, arena);
        if self.0.len() != pattern.len() {
            return false;
        }
        for (k, &(row, column)) in self.0.iter().enumerate() {
            if !pattern[row][column] {
                return false;
            }
            for &(other, _) in &self.0[k + 1..] {
                if pattern[other][column] {
                    for j in 0..pattern.len() {
                        pattern[other][j] |= pattern[row][j];
                    }
                }
            }
        }
        true
    }
}

//! Tests of the start of a step: whether a velocity has the given momentum there, and no other
//! velocity near it has.
//!
//! Input: the derivatives of L. Output: the parts of the mass matrix ∂²L/∂v² that may be singular.
//! If ∂L/∂v is affine in v, a velocity exists and is isolated exactly if the mass matrix is
//! regular. The matrix decomposes into diagonal blocks, each of which must be regular. A block of
//! numbers was tested when the system was classified, a block of parameters is tested once for all
//! steps of one size, and a block that depends on the configuration or the time is tested in each
//! step.
//!
//! Constraints and degenerate Lagrangians define starts of their own.

use std::collections::{BTreeSet, HashMap};

use super::matrix::Matrix;
use crate::algebra::{Arena, Expr, Symbol};
use crate::system::classify::Classified;
use crate::system::mechanics::Mechanics;

/// The tests of the start of a step.
#[derive(Default)]
pub(crate) struct StartTest {
    /// Blocks of the mass matrix that depend on parameters alone.
    pub(crate) of_parameters: Vec<Matrix<Expr>>,
    /// Blocks of the mass matrix that depend on configuration or time.
    pub(crate) of_state: Vec<Matrix<Expr>>,
    /// True if ∂L/∂v is not affine in v, so that the velocity must be found by iteration.
    pub(crate) needs_velocity: bool,
}

impl StartTest {
    /// Determines the tests. The mass matrix is already in its stable form, so no step changes.
    pub(crate) fn new(system: &Classified, mechanics: &Mechanics, arena: &mut Arena) -> Self {
        let model = &system.model;
        let mut test = Self::default();
        if system.degeneracy.is_some() || !mechanics.constraints.is_empty() {
            return test;
        }
        if !mechanics.affine_momentum {
            test.needs_velocity = true;
            return test;
        }
        let zero = arena.constant(0.0);
        let rest: HashMap<Symbol, Expr> = model.v.iter().map(|&v| (v, zero)).collect();
        let rows = mechanics.lagrangian.dvv.iter();
        let mass: Vec<Vec<Expr>> = rows.map(|row| arena.substitute_all(row, &rest)).collect();
        let state: BTreeSet<Symbol> = model.q.iter().copied().chain([model.time]).collect();
        let mut seen: Vec<Vec<Vec<Expr>>> = Vec::new();
        for block in diagonal_blocks(&mass, arena) {
            let is_number = |&e: &Expr| arena.constant_value(e).is_some();
            if block.iter().flatten().all(is_number) || seen.contains(&block) {
                continue;
            }
            let depends = |&e: &Expr| arena.symbols_of(e).any(|s| state.contains(&s));
            let depends_on_state = block.iter().flatten().any(depends);
            seen.push(block.clone());
            let matrix = Matrix::new(block, arena);
            if depends_on_state {
                test.of_state.push(matrix);
            } else {
                test.of_parameters.push(matrix);
            }
        }
        test
    }
}

/// Returns the smallest diagonal blocks into which a symmetric matrix decomposes under reordering.
fn diagonal_blocks(matrix: &[Vec<Expr>], arena: &Arena) -> Vec<Vec<Vec<Expr>>> {
    let n = matrix.len();
    let is_zero = |e: Expr| arena.constant_value(e) == Some(0.0);
    let mut block_of: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            if !is_zero(matrix[i][j]) || !is_zero(matrix[j][i]) {
                let (from, to) = (block_of[i], block_of[j]);
                for block in &mut block_of {
                    if *block == from {
                        *block = to;
                    }
                }
            }
        }
    }
    let numbers: BTreeSet<usize> = block_of.iter().copied().collect();
    let members = numbers.into_iter().map(|number| {
        let all = (0..n).filter(|&i| block_of[i] == number);
        all.collect::<Vec<usize>>()
    });
    let entries = members.map(|members| {
        let row = |&i: &usize| members.iter().map(|&j| matrix[i][j]).collect();
        members.iter().map(row).collect()
    });
    entries.collect()
}

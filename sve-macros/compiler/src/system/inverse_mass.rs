//! Solves with the mass matrix M = ∂²L/∂v² in the algebra, M w = b.
//!
//! The same algorithm solves with the matrix `ϑ_yᵀ` of a degenerate Lagrangian, which need not be
//! symmetric. Coordinates that M couples form a block; each block is solved alone. A block of up to
//! three coordinates is solved by Cramer's rule, whose only denominator is the determinant of the
//! block. A larger block is eliminated if its entries do not depend on the configuration. Otherwise
//! it is refused: the derivatives of the elimination enter each iteration, and for four coupled
//! coordinates the straight-line code is so long that rustc overflows its stack when it writes
//! debug information.

use crate::algebra::{Arena, Expr, Symbol};

/// Largest number of coordinates in a block that Cramer's rule solves.
const CRAMER: usize = 3;

/// The reason why M w = b has no solution as a formula.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NoFormula {
    /// This many coordinates are coupled, with entries that depend on the configuration.
    TooManyCoupled(usize),
    /// The elimination of a block of this many coordinates finds no pivot on the diagonal.
    NoPivot(usize),
}

/// Returns w = M⁻¹ b, each entry an intermediate result. The entries of large blocks must not
/// depend on the symbols `moving`.
pub(crate) fn solve(
    mass: &[Vec<Expr>],
    b: &[Expr],
    moving: &[Symbol],
    arena: &mut Arena,
) -> Result<Vec<Expr>, NoFormula> {
    let zero = arena.constant(0.0);
    let mut w = vec![zero; b.len()];
    for block in blocks(mass, arena) {
        if block
            .iter()
            .all(|&i| arena.constant_value(b[i]) == Some(0.0))
        {
            continue;
        }
        let rows: Vec<Vec<Expr>> = block
            .iter()
            .map(|&i| block.iter().map(|&j| mass[i][j]).collect())
            .collect();
        let rhs: Vec<Expr> = block.iter().map(|&i| b[i]).collect();
        let depends = |&entry: &Expr| moving.iter().any(|&s| arena.contains(entry, s));
        let solution = if block.len() <= CRAMER {
            cramer(&rows, &rhs, arena)
        } else if rows.iter().flatten().any(depends) {
            return Err(NoFormula::TooManyCoupled(block.len()));
        } else {
            eliminated(rows, rhs, arena)?
        };
        for (&i, value) in block.iter().zip(solution) {
            w[i] = arena.opaque(value);
        }
    }
    Ok(w)
}

/// Returns the coordinates that M couples, each block ascending.
fn blocks(mass: &[Vec<Expr>], arena: &Arena) -> Vec<Vec<usize>> {
    let n = mass.len();
    let entries = mass.concat();
    let is_zero = arena.zeros(&entries);
    let mut block_of: Vec<usize> = (0..n).collect();
    for i in 0..n {
        for j in 0..i {
            let (a, b) = (block_of[i], block_of[j]);
            if a != b && !(is_zero[i * n + j] && is_zero[j * n + i]) {
                for block in &mut block_of {
                    if *block == a.max(b) {
                        *block = a.min(b);
                    }
                }
            }
        }
    }
    let members = (0..n).map(|block| (0..n).filter(|&i| block_of[i] == block).collect());
    members
        .filter(|block: &Vec<usize>| !block.is_empty())
        .collect()
}

/// Solves by Cramer's rule: the solution is the adjugate matrix times b, divided by the
/// determinant.
fn cramer(matrix: &[Vec<Expr>], b: &[Expr], arena: &mut Arena) -> Vec<Expr> {
    let n = b.len();
    let all: Vec<usize> = (0..n).collect();
    let determinant = determinant(matrix, &all, &all, arena);
    let mut solution = Vec::with_capacity(n);
    for i in 0..n {
        let mut terms = Vec::with_capacity(n);
        for j in 0..n {
            let without = |k: usize| -> Vec<usize> { (0..n).filter(|&l| l != k).collect() };
            let minor = self::determinant(matrix, &without(j), &without(i), arena);
            let sign = if (i + j) % 2 == 0 { 1.0 } else { -1.0 };
            terms.push((sign, arena.mul(minor, b[j])));
        }
        let numerator = arena.sum(0.0, &terms);
        solution.push(arena.div(numerator, determinant));
    }
    solution
}

/// Returns the determinant of some rows and columns, expanded along the first row.
fn determinant(matrix: &[Vec<Expr>], rows: &[usize], columns: &[usize], arena: &mut Arena) -> Expr {
    let Some((&first, rest)) = rows.split_first() else {
        return arena.constant(1.0);
    };
    let mut terms = Vec::new();
    for (at, &column) in columns.iter().enumerate() {
        let mut others = columns.to_vec();
        others.remove(at);
        let minor = determinant(matrix, rest, &others, arena);
        let sign = if at % 2 == 0 { 1.0 } else { -1.0 };
        terms.push((sign, arena.mul(matrix[first][column], minor)));
    }
    arena.sum(0.0, &terms)
}

/// Solves by Gaussian elimination with pivots on the diagonal that do not vanish identically.
fn eliminated(
    mut matrix: Vec<Vec<Expr>>,
    mut b: Vec<Expr>,
    arena: &mut Arena,
) -> Result<Vec<Expr>, NoFormula> {
    let n = b.len();
    let mut order = Vec::with_capacity(n);
    let mut left: Vec<usize> = (0..n).collect();
    while !left.is_empty() {
        let is_pivot = |&at: &usize| !arena.is_zero(matrix[left[at]][left[at]]);
        let at = (0..left.len())
            .find(is_pivot)
            .ok_or(NoFormula::NoPivot(n))?;
        let k = left.remove(at);
        order.push(k);
        for &i in &left {
            let factor = arena.div(matrix[i][k], matrix[k][k]);
            if arena.constant_value(factor) == Some(0.0) {
                continue;
            }
            for &j in &left {
                let product = arena.mul(factor, matrix[k][j]);
                matrix[i][j] = arena.sub(matrix[i][j], product);
            }
            let product = arena.mul(factor, b[k]);
            b[i] = arena.sub(b[i], product);
        }
    }
    let mut solution = b.clone();
    for (at, &k) in order.iter().enumerate().rev() {
        let mut terms = vec![(1.0, b[k])];
        for &j in &order[at + 1..] {
            terms.push((-1.0, arena.mul(matrix[k][j], solution[j])));
        }
        let sum = arena.sum(0.0, &terms);
        solution[k] = arena.div(sum, matrix[k][k]);
    }
    Ok(solution)
}

#[cfg(test)]
mod tests;

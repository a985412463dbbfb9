//! Formulas of vectors and matrices, entry by entry.

use super::{Kind, Matrix, MatrixType, sum};
use crate::algebra::{Arena, Expr, Function};

pub(super) fn inner(arena: &mut Arena, a: &Matrix<Expr>, b: &Matrix<Expr>) -> Expr {
    let products = entrywise(arena, a, b, Arena::mul);
    sum(arena, &products.entries)
}

/// Returns √(Σ x²). Its derivatives do not exist at 0, which the domain of the root excludes.
pub(super) fn norm(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let square = inner(arena, m, m);
    arena.call(Function::Sqrt, square)
}

pub(super) fn normalized(arena: &mut Arena, m: &Matrix<Expr>) -> Matrix<Expr> {
    let norm = norm(arena, m);
    each(arena, m, norm, Arena::div)
}

/// Applies an operation to the corresponding entries of two vectors or matrices.
pub(super) fn entrywise(
    arena: &mut Arena,
    a: &Matrix<Expr>,
    b: &Matrix<Expr>,
    operation: fn(&mut Arena, Expr, Expr) -> Expr,
) -> Matrix<Expr> {
    let pairs = a.entries.iter().zip(&b.entries);
    let entries = pairs.map(|(&a, &b)| operation(arena, a, b)).collect();
    Matrix {
        ty: a.ty.plain(),
        entries,
    }
}

/// Applies an operation to each entry and a number.
pub(super) fn each(
    arena: &mut Arena,
    m: &Matrix<Expr>,
    x: Expr,
    operation: fn(&mut Arena, Expr, Expr) -> Expr,
) -> Matrix<Expr> {
    let entries = m
        .entries
        .iter()
        .map(|&entry| operation(arena, entry, x))
        .collect();
    Matrix {
        ty: m.ty.plain(),
        entries,
    }
}

pub(super) fn transpose(m: &Matrix<Expr>) -> Matrix<Expr> {
    let transposed = m.transposed();
    match m.ty.kind {
        Kind::Rotation => transposed,
        _ => transposed.with_kind(Kind::Matrix),
    }
}

/// Returns `a₀ b₁ − a₁ b₀`.
pub(super) fn minor(arena: &mut Arena, a: [Expr; 2], b: [Expr; 2]) -> Expr {
    let [left, right] = [(a[0], b[1]), (a[1], b[0])].map(|(a, b)| arena.mul(a, b));
    arena.sub(left, right)
}

/// Returns the image of a vector under a rotation.
pub(super) fn image(arena: &mut Arena, rotation: &Matrix<Expr>, v: &Matrix<Expr>) -> Matrix<Expr> {
    let entries = (0..rotation.ty.rows).map(|i| {
        let row = rotation.part((i, 0), MatrixType::matrix(1, rotation.ty.columns));
        inner(arena, &row, v)
    });
    Matrix {
        ty: v.ty.plain(),
        entries: entries.collect(),
    }
}

/// Expands a determinant along its first column, recursively. Each minor of the last columns is computed once. Returns `None` if the
/// matrix is too large.
pub(super) fn determinant(arena: &mut Arena, m: &Matrix<Expr>) -> Option<Expr> {
    let n = m.ty.rows;
    if n > MAX_DETERMINANT {
        return None;
    }
    // minors of the last columns, by the set of their rows
    let mut minors = vec![arena.constant(1.0); 1 << n];
    for rows in 1_usize..1 << n {
        let column = n - rows.count_ones() as usize;
        let mut terms = Vec::new();
        for (sign, row) in (0..n).filter(|row| rows >> row & 1 == 1).enumerate() {
            let product = arena.mul(m.at(row, column), minors[rows & !(1 << row)]);
            terms.push(if sign % 2 == 0 {
                product
            } else {
                arena.neg(product)
            });
        }
        minors[rows] = sum(arena, &terms);
    }
    minors.last().copied()
}

/// Largest number of rows of a determinant that is expanded. The number of minors doubles with each row.
pub(super) const MAX_DETERMINANT: usize = 6;

//! Formulas of vectors and matrices, entry by entry.

use super::{Kind, Matrix, MatrixType};
use crate::algebra::{Arena, Expr, Function};

/// Adds numbers, from the first to the last.
pub(in crate::interpret) fn sum(arena: &mut Arena, terms: &[Expr]) -> Expr {
    let mut terms = terms.iter().copied();
    match terms.next() {
        Some(first) => terms.fold(first, |sum, term| arena.add(sum, term)),
        None => arena.constant(0.0),
    }
}

pub(in crate::interpret) fn inner(arena: &mut Arena, a: &Matrix<Expr>, b: &Matrix<Expr>) -> Expr {
    let products = entrywise(arena, a, b, Arena::mul);
    sum(arena, &products.entries)
}

pub(in crate::interpret) fn norm_squared(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    inner(arena, m, m)
}

pub(in crate::interpret) fn product(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let factors: Vec<(Expr, i32)> = m.entries.iter().map(|&entry| (entry, 1)).collect();
    arena.product(&factors)
}

pub(in crate::interpret) fn mean(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let total = sum(arena, &m.entries);
    let count = arena.constant(m.entries.len() as f64);
    arena.div(total, count)
}

pub(in crate::interpret) fn trace(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    sum(arena, &diagonal(m).entries)
}

/// Returns √(Σ x²). Its derivatives do not exist at 0, which the domain of the root excludes.
pub(in crate::interpret) fn norm(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let square = inner(arena, m, m);
    arena.call(Function::Sqrt, square)
}

pub(in crate::interpret) fn normalized(arena: &mut Arena, m: &Matrix<Expr>) -> Matrix<Expr> {
    let norm = norm(arena, m);
    each(arena, m, norm, Arena::div)
}

/// Applies an operation to the corresponding entries of two vectors or matrices.
pub(in crate::interpret) fn entrywise(
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
pub(in crate::interpret) fn each(
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

pub(in crate::interpret) fn transpose(m: &Matrix<Expr>) -> Matrix<Expr> {
    let transposed = m.transposed();
    match m.ty.kind {
        Kind::Rotation => transposed,
        _ => transposed.with_kind(Kind::Matrix),
    }
}

/// Returns the length of a difference.
pub(in crate::interpret) fn distance(
    arena: &mut Arena,
    a: &Matrix<Expr>,
    b: &Matrix<Expr>,
) -> Expr {
    let difference = entrywise(arena, a, b, Arena::sub);
    norm(arena, &difference)
}

pub(in crate::interpret) fn diagonal(m: &Matrix<Expr>) -> Matrix<Expr> {
    Matrix::from_fn(MatrixType::vector(m.ty.rows), |i, _| m.at(i, i))
}

/// Returns `a₀ b₁ − a₁ b₀`.
fn minor(arena: &mut Arena, a: [Expr; 2], b: [Expr; 2]) -> Expr {
    let [left, right] = [(a[0], b[1]), (a[1], b[0])].map(|(a, b)| arena.mul(a, b));
    arena.sub(left, right)
}

pub(in crate::interpret) fn perp(arena: &mut Arena, a: &Matrix<Expr>, b: &Matrix<Expr>) -> Expr {
    let [a, b] = [a, b].map(|m| [m.entries[0], m.entries[1]]);
    minor(arena, a, b)
}

pub(in crate::interpret) fn cross(
    arena: &mut Arena,
    a: &Matrix<Expr>,
    b: &Matrix<Expr>,
) -> Matrix<Expr> {
    let ty = a.ty.plain();
    let [a, b] = [&a.entries, &b.entries];
    let entry = |i: usize| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        minor(arena, [a[j], a[k]], [b[j], b[k]])
    };
    let entries = (0..3).map(entry).collect();
    Matrix { ty, entries }
}

/// Returns the matrix whose product with a vector is the cross product with `m`.
pub(in crate::interpret) fn cross_matrix(arena: &mut Arena, m: &Matrix<Expr>) -> Matrix<Expr> {
    let zero = arena.constant(0.0);
    let [x, y, z] = [0, 1, 2].map(|i| m.entries[i]);
    let [nx, ny, nz] = [x, y, z].map(|entry| arena.neg(entry));
    let rows = [[zero, nz, y], [z, zero, nx], [ny, x, zero]];
    Matrix::from_fn(MatrixType::matrix(3, 3), |i, j| rows[i][j])
}

/// Returns the image of a vector under a rotation.
pub(in crate::interpret) fn image(
    arena: &mut Arena,
    rotation: &Matrix<Expr>,
    v: &Matrix<Expr>,
) -> Matrix<Expr> {
    let entries = (0..rotation.ty.rows).map(|i| inner(arena, &rotation.row(i), v));
    Matrix {
        ty: v.ty.plain(),
        entries: entries.collect(),
    }
}

pub(in crate::interpret) fn inverse_image(
    arena: &mut Arena,
    rotation: &Matrix<Expr>,
    v: &Matrix<Expr>,
) -> Matrix<Expr> {
    image(arena, &rotation.transposed(), v)
}

/// Expands a determinant along its first column, recursively. Each minor of the last columns is
/// computed once.
pub(in crate::interpret) fn determinant(arena: &mut Arena, m: &Matrix<Expr>) -> Expr {
    let n = m.ty.rows;
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
    minors[(1 << n) - 1]
}

/// Largest number of rows of a determinant that is expanded. The number of minors doubles with each
/// row.
pub(super) const MAX_DETERMINANT: usize = 6;

//! Bounds of the Jacobian of a block between the limit of a small step without noise and the step.
//! They decide whether a root is accepted.
//!
//! Input: the residuals and the Jacobian of a block at its solution. Output: expressions of the
//! midpoints and radii of intervals that contain every entry of the Jacobian while the step size
//! goes from 0 to h, the increments from 0 to ΔW, and the unknowns stay within a box around the
//! solution that contains the limit. If every matrix within these intervals is regular, the
//! equations have one solution in the box for each of these steps, so the solution is connected
//! with the limit.
//!
//! Source: Neumaier, *Interval Methods for Systems of Equations* (1990), sections 1.6 and 4.1.

use std::collections::HashMap;

use super::band::Band;
use super::matrix::{Matrix, Storage};
use super::scheme::Lower;
use crate::algebra::intervals::{Flavour, Intervals, Range, intervals};
use crate::algebra::{Arena, Expr, Symbol};

/// Bounds of the entries of a matrix.
#[derive(Clone)]
pub(crate) struct Enclosure<T> {
    /// Midpoints of the entries.
    pub(crate) middle: Matrix<T>,
    /// Radii of all entries, or of the entries in the band of a banded matrix.
    pub(crate) radii: Vec<Vec<T>>,
    /// Expressions that must be positive for the radii to hold: distances to poles and to the
    /// borders of domains.
    pub(crate) conditions: Vec<T>,
}

impl<T> Enclosure<T> {
    /// Returns all expressions to be computed.
    pub(crate) fn entries(&self) -> impl Iterator<Item = &T> {
        let Self {
            middle,
            radii,
            conditions,
        } = self;
        let middle = &middle.rows;
        middle.iter().chain(radii).flatten().chain(conditions)
    }
}

impl Enclosure<Expr> {
    pub(super) fn lower<L: Lower>(&self, by: &mut L) -> Enclosure<L::Value> {
        Enclosure {
            middle: self.middle.map(|e| by.value(e)),
            radii: by.rows(&self.radii),
            conditions: by.values(&self.conditions),
        }
    }
}

impl Enclosure<Expr> {
    /// Returns all expressions to be computed.
    pub(super) fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            middle,
            radii,
            conditions,
        } = self;
        let middle = &mut middle.rows;
        middle.iter_mut().chain(radii).flatten().chain(conditions)
    }

    /// Returns whether the bounds hold for all values of the unknowns.
    pub(super) fn is_free_of(&self, ranges: &HashMap<Symbol, Range>, arena: &Arena) -> bool {
        let contains = |e: &Expr| {
            let mut unknowns = ranges.iter().filter(|r| !matches!(r.1, Range::Small));
            unknowns.any(|(&u, _)| arena.contains(*e, u))
        };
        !self.entries().any(contains)
    }
}

/// Returns bounds of the entries of a matrix that hold while the values in `domain` stay positive.
/// `None` if a function has no bound.
pub(super) fn enclose(
    matrix: &[Vec<Expr>],
    domain: &[Expr],
    ranges: &HashMap<Symbol, Range>,
    flavour: Flavour,
    arena: &mut Arena,
) -> Option<Enclosure<Expr>> {
    let Intervals {
        middle,
        radii,
        conditions,
    } = intervals(&matrix.concat(), domain, ranges, flavour, arena)?;
    let rows = |flat: &[Expr]| -> Vec<Vec<Expr>> {
        flat.chunks(matrix.len()).map(<[Expr]>::to_vec).collect()
    };
    let (middle, radii) = stored(rows(&middle), rows(&radii), arena);
    Some(Enclosure {
        middle,
        radii,
        conditions,
    })
}

/// Returns midpoints and radii in the storage that suits both. A midpoint may be zero even if its
/// radius is not.
fn stored(
    middle: Vec<Vec<Expr>>,
    radii: Vec<Vec<Expr>>,
    arena: &mut Arena,
) -> (Matrix<Expr>, Vec<Vec<Expr>>) {
    let zero = arena.constant(0.0);
    let either = |(&mid, &radius): (&Expr, &Expr)| if mid == zero { radius } else { mid };
    let rows = middle.iter().zip(&radii);
    let present: Vec<Vec<Expr>> = rows
        .map(|(middle, radii)| middle.iter().zip(radii).map(either).collect())
        .collect();
    if let Some(band) = Band::of(&present, |e| e == zero) {
        let middle = Matrix {
            storage: Storage::Banded(band),
            rows: band.rows(&middle, zero),
        };
        return (middle, band.rows(&radii, zero));
    }
    let matrix = Matrix::new(middle.clone(), arena);
    match matrix.storage {
        Storage::Banded(_) => (Matrix::dense(middle), radii),
        Storage::Dense | Storage::Cofactors | Storage::Diagonal => (matrix, radii),
    }
}

//! Bounds of the Jacobian of a block between the limit of a small step without noise and the step: the judge of a root.
//!
//! Input: the residuals and the Jacobian of a block at its solution. Output: expressions of the midpoints and radii of
//! intervals that contain every entry of the Jacobian while the step size goes from 0 to h, the increments from 0 to ΔW, and
//! the unknowns stay within a box around the solution that contains the limit. Where every matrix within these intervals is
//! regular, the equations have one solution in the box for each of those steps, so the solution is the one that is connected
//! with the limit.
//!
//! Interval arithmetic in the form of midpoint and radius. The step size and the increments go from 0 to their values together, and
//! so do their products. Each function has its bound in its entry of the table of functions.
//!
//! Source: Neumaier, *Interval Methods for Systems of Equations* (1990), sections 1.6 and 4.1.

mod bounds;

use std::collections::HashMap;

use super::band::Band;
use super::matrix::{Matrix, Storage};
use crate::algebra::{Arena, Expr, Map, Symbol};
use bounds::{Bounds, Interval};

/// Half the width of the box in each unknown, in distances of the solution from the limit. The box is centred between the two and
/// contains as much as a quarter of their distance beyond each. A single unknown may go there by way of what one small quantity
/// does and another one undoes; its box is wider by that.
const BOX: f64 = 0.75;

/// Exponents up to which powers are bounded.
const EXPONENT: u32 = 16;

/// Bounds of the entries of a matrix.
#[derive(Clone)]
pub(crate) struct Enclosure<T> {
    /// Midpoints of the entries.
    pub(crate) middle: Matrix<T>,
    /// Radii of all entries, or of those in the band of a banded matrix.
    pub(crate) radii: Vec<Vec<T>>,
    /// What has to be positive for the radii to hold: distances to poles and to the borders of domains.
    pub(crate) conditions: Vec<T>,
}

impl<T> Enclosure<T> {
    /// All that is to be computed.
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
    /// All that is to be computed.
    pub(super) fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            middle,
            radii,
            conditions,
        } = self;
        let middle = &mut middle.rows;
        middle.iter_mut().chain(radii).flatten().chain(conditions)
    }

    /// Whether it holds wherever the unknowns are.
    pub(super) fn is_free_of(&self, ranges: &HashMap<Symbol, Range>, arena: &Arena) -> bool {
        let contains = |e: &Expr| {
            let mut unknowns = ranges.iter().filter(|r| !matches!(r.1, Range::Small));
            unknowns.any(|(&u, _)| arena.contains(*e, u))
        };
        !self.entries().any(contains)
    }
}

/// How wide the bounds are, and what they cost.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flavour {
    /// Sines and cosines of what varies are anything between −1 and 1.
    Global,
    /// Around the limit, where most of what is needed is at hand. What is proportional to a small quantity is bounded by its size, with
    /// sines and cosines of at most 1.
    Limit,
    /// Around the middle between limit and solution: half as wide.
    Box,
}

/// What varies between the limit and the step.
#[derive(Clone, Copy)]
pub(crate) enum Range {
    /// The step size or an increment, from 0 to its value.
    Small,
    /// A coordinate, within this radius of its value.
    Within(Symbol),
    /// An unknown, with its limit, and how far each small quantity by itself moves it from there, to first order.
    Unknown { limit: Symbol, moved: Expr },
    /// An unknown, with its limit and the half width of the box around it.
    Around { limit: Symbol, reach: Expr },
}

/// Bounds of the entries of a matrix, while the values in `domain` stay positive. Nothing where a function has no bound here.
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

/// Bounds of expressions.
pub(crate) struct Intervals {
    /// Midpoints.
    pub(crate) middle: Vec<Expr>,
    pub(crate) radii: Vec<Expr>,
    /// What has to be positive for the radii to hold.
    pub(crate) conditions: Vec<Expr>,
}

/// Bounds of expressions, while the values in `domain` stay positive. Nothing where a function has no bound here.
pub(crate) fn intervals(
    roots: &[Expr],
    domain: &[Expr],
    ranges: &HashMap<Symbol, Range>,
    flavour: Flavour,
    arena: &mut Arena,
) -> Option<Intervals> {
    let mut bounds = Bounds {
        arena,
        ranges,
        flavour,
        done: Map::default(),
        conditions: Vec::new(),
    };
    let found = bounds.all(&[roots, domain].concat())?;
    let (entries, borders) = found.split_at(roots.len());
    for border in borders {
        let distance = bounds.arena.sub(border.mid, border.radius);
        bounds.conditions.push(distance);
    }
    let part = |part: fn(&Interval) -> Expr| entries.iter().map(part).collect();
    Some(Intervals {
        middle: part(|i| i.mid),
        radii: part(|i| i.radius),
        conditions: bounds.conditions,
    })
}

/// The largest magnitudes of some expressions, and what has to be positive for these to hold. Nothing where a function has no bound here.
pub(super) fn largest(
    exprs: &[Expr],
    ranges: &HashMap<Symbol, Range>,
    flavour: Flavour,
    arena: &mut Arena,
) -> Option<(Vec<Expr>, Vec<Expr>)> {
    let mut bounds = Bounds {
        arena,
        ranges,
        flavour,
        done: Map::default(),
        conditions: Vec::new(),
    };
    let found = bounds.all(exprs)?;
    let sizes = found.into_iter().map(|interval| {
        let middle = bounds.arena.abs(interval.mid);
        bounds.arena.add(middle, interval.radius)
    });
    let sizes = sizes.collect();
    Some((sizes, bounds.conditions))
}

/// Midpoints and radii in the storage of both. A midpoint may be zero where the radius is not.
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

//! Bounds of expressions on the way from the limit of a small step without noise to the actual
//! step.
//!
//! Interval arithmetic in the form of midpoint and radius. The step size and the increments go from
//! 0 to their values together, and so do their products. The table of functions has a bound for
//! each function.
//!
//! Source: Neumaier, *Interval Methods for Systems of Equations* (1990), section 1.6.

mod bounds;

use std::collections::HashMap;

use super::{Arena, Expr, Symbol};
use bounds::{Bounds, Interval};

/// Half the width of the box in each unknown, as a multiple of the distance between the limit and
/// the solution. The box is centred between the two and extends a quarter of their distance beyond
/// each. If the effects of two small quantities on a single unknown cancel, its path may leave the
/// segment; its box is wider by these effects.
const BOX: f64 = 0.75;

/// Largest exponent of a power that is bounded.
const EXPONENT: u32 = 16;

/// The widths of bounds, and their costs.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flavour {
    /// Sines and cosines of varying arguments are bounded by −1 and 1 only.
    Global,
    /// Around the limit, where most subexpressions are already computed. A term proportional to a
    /// small quantity is bounded by its magnitude, with sines and cosines of at most 1.
    Limit,
    /// Around the midpoint between limit and solution: half as wide.
    Box,
}

/// The range of a symbol between the limit and the step.
#[derive(Clone, Copy)]
pub(crate) enum Range {
    /// The step size or an increment, from 0 to its value.
    Small,
    /// A coordinate, within this radius of its value.
    Within(Symbol),
    /// An unknown, with its limit and its displacement by each small quantity alone, to first
    /// order.
    Unknown { limit: Symbol, moved: Expr },
    /// An unknown, with its limit and the half width of the box around it.
    Around { limit: Symbol, reach: Expr },
}

/// Bounds of expressions.
pub(crate) struct Intervals {
    /// Midpoints of the intervals.
    pub(crate) middle: Vec<Expr>,
    pub(crate) radii: Vec<Expr>,
    /// Expressions that must be positive for the radii to hold.
    pub(crate) conditions: Vec<Expr>,
}

/// Returns bounds of expressions that hold while the values in `domain` stay positive; `None` if a
/// function has no bound.
pub(crate) fn intervals(
    roots: &[Expr],
    domain: &[Expr],
    ranges: &HashMap<Symbol, Range>,
    flavour: Flavour,
    arena: &mut Arena,
) -> Option<Intervals> {
    let mut bounds = Bounds::new(ranges, flavour, arena);
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

/// Returns the largest magnitudes of some expressions, and the expressions that must be positive
/// for these to hold; `None` if a function has no bound.
pub(crate) fn largest(
    exprs: &[Expr],
    ranges: &HashMap<Symbol, Range>,
    flavour: Flavour,
    arena: &mut Arena,
) -> Option<(Vec<Expr>, Vec<Expr>)> {
    let mut bounds = Bounds::new(ranges, flavour, arena);
    let found = bounds.all(exprs)?;
    let sizes = found.into_iter().map(|interval| {
        let middle = bounds.arena.abs(interval.mid);
        bounds.arena.add(middle, interval.radius)
    });
    let sizes = sizes.collect();
    Some((sizes, bounds.conditions))
}

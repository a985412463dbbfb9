//! Bounds of expressions between the limit of a small step without noise and the step.
//!
//! Interval arithmetic in the form of midpoint and radius. The step size and the increments go from
//! 0 to their values together, and so do their products. Each function has its bound in its entry
//! of the table of functions.
//!
//! Source: Neumaier, *Interval Methods for Systems of Equations* (1990), section 1.6.

mod bounds;

use std::collections::HashMap;

use super::{Arena, Expr, Symbol};
use bounds::{Bounds, Interval};

/// Half the width of the box in each unknown, in distances of the solution from the limit. The box
/// is centred between the two and contains as much as a quarter of their distance beyond each. A
/// single unknown may go there by way of what one small quantity does and another one undoes; its
/// box is wider by that.
const BOX: f64 = 0.75;

/// Exponents up to which powers are bounded.
const EXPONENT: u32 = 16;

/// How wide the bounds are, and what they cost.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Flavour {
    /// Sines and cosines of what varies are anything between −1 and 1.
    Global,
    /// Around the limit, where most of what is needed is at hand. What is proportional to a small
    /// quantity is bounded by its size, with sines and cosines of at most 1.
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
    /// An unknown, with its limit, and how far each small quantity by itself moves it from there,
    /// to first order.
    Unknown { limit: Symbol, moved: Expr },
    /// An unknown, with its limit and the half width of the box around it.
    Around { limit: Symbol, reach: Expr },
}

/// Bounds of expressions.
pub(crate) struct Intervals {
    /// Midpoints.
    pub(crate) middle: Vec<Expr>,
    pub(crate) radii: Vec<Expr>,
    /// What has to be positive for the radii to hold.
    pub(crate) conditions: Vec<Expr>,
}

/// Bounds of expressions, while the values in `domain` stay positive. Nothing where a function has
/// no bound here.
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

/// The largest magnitudes of some expressions, and what has to be positive for these to hold.
/// Nothing where a function has no bound here.
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

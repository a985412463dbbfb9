//! The test whether a solution of a block is connected with the limit of no noise and h → 0.
//!
//! Input: a block. Output: its limit, and bounds of its Jacobian between the limit and the solution
//! ([`enclosure`](super::enclosure)). A solution is accepted if every matrix within the bounds is
//! regular. A single step tests quick bounds first and full bounds if the quick ones reject. Lanes
//! test full bounds only, since they have no second attempt. `structure/path.rs` has the bounds of
//! blocks with multipliers of constraints.

use std::collections::HashMap;

use super::block::Replacement;
use super::elimination::Reduced;
use super::enclosure::{Enclosure, enclose};
use super::scheme::Lower;
use crate::algebra::intervals::{Flavour, Range};
use crate::algebra::{Expr, Node, Symbol};
use crate::model::Meaning;

/// Largest number of unknowns of a block whose solutions are tested by bounds of its Jacobian. The
/// bounds take about as long to compute as the Jacobian itself and a product of matrices.
const JUDGED: usize = 4;

/// The test whether a solution of a block is connected with its limit.
#[derive(Clone)]
pub(crate) struct Judge<T> {
    /// Names of the limit in the bounds.
    pub(crate) limit: Vec<Symbol>,
    /// Right-hand side of the linear system whose solution is the limit. Its matrix is the Jacobian
    /// there.
    pub(crate) limit_rhs: Vec<T>,
    /// The bounds that are tested first.
    pub(crate) bounds: Enclosure<T>,
    /// The full bounds, tested if the first bounds reject. `None` if the first bounds are the full
    /// ones: then they hold for all values of the unknowns.
    pub(crate) full: Option<Enclosure<Expr>>,
}

impl Judge<Expr> {
    /// Returns all expressions to be computed.
    pub(super) fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            limit: _,
            limit_rhs,
            bounds,
            full,
        } = self;
        let full = full.iter_mut().flat_map(Enclosure::exprs_mut);
        limit_rhs.iter_mut().chain(bounds.exprs_mut()).chain(full)
    }

    pub(super) fn lower<L: Lower>(&self, by: &mut L) -> Judge<L::Value> {
        let bounds = self.bounds.lower(by);
        Judge {
            limit: self.limit.clone(),
            limit_rhs: by.values(&self.limit_rhs),
            bounds,
            full: self.full.clone(),
        }
    }
}

impl Reduced<'_> {
    /// Returns the test of a solution of a block. It exists if the equations without noise and step
    /// are affine, so that their solution is known, and if all functions in the block have bounds.
    /// `known` has the names of the solution.
    pub(super) fn judge(
        &mut self,
        residual: &[Expr],
        jacobian: &[Vec<Expr>],
        unknowns: &[Symbol],
        known: &Replacement,
    ) -> Option<Judge<Expr>> {
        if unknowns.len() > JUDGED {
            return None;
        }
        let zero = self.arena.constant(0.0);
        let small = self.small(residual);
        let still: Replacement = small.iter().map(|&s| (s, zero)).collect();
        // a displacement vanishes in the limit, whatever its factor
        let mut resting = still.clone();
        let displacements = unknowns.iter().filter(|&&u| self.is_displacement(u));
        resting.extend(displacements.map(|&u| (u, zero)));
        let at_limit = self.arena.substitute_all(&jacobian.concat(), &resting);
        let moves = |(at, e): (usize, &Expr)| {
            !self.is_displacement(unknowns[at % unknowns.len()])
                && unknowns.iter().any(|&u| self.arena.contains(*e, u))
        };
        if at_limit.iter().enumerate().any(moves) {
            return None;
        }
        let mut limit_of: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        limit_of.extend(still);
        let limit_rhs = self.newton_step(residual, jacobian, &limit_of).1;
        let (limit, ranges) = self.ranges((residual, jacobian), unknowns, known, &small)?;
        let is_open = |system: &Self, e: Expr| {
            let mut symbols = system.arena.symbols_of(e);
            symbols.any(|s| {
                let is_unknown = matches!(system.symbols.meaning(s), Meaning::Unknown(_));
                is_unknown && !ranges.contains_key(&s)
            })
        };
        let entries = self.arena.substitute_all(&jacobian.concat(), known);
        if entries.iter().any(|&e| is_open(self, e)) {
            return None;
        }
        let matrix = entries.chunks(unknowns.len());
        let matrix: Vec<Vec<Expr>> = matrix.map(<[Expr]>::to_vec).collect();
        let borders: Vec<Expr> = self.domain.iter().map(|c| c.value).collect();
        let mut borders = self.arena.substitute_all(&borders, known);
        borders.retain(|&e| !is_open(self, e));
        let (bounds, full) = self.bounds(&matrix, &borders, &ranges)?;
        Some(Judge {
            limit,
            limit_rhs,
            bounds,
            full,
        })
    }

    /// Returns the names of the limit, and the range of each symbol between the limit and the
    /// solution.
    fn ranges(
        &mut self,
        (residual, jacobian): (&[Expr], &[Vec<Expr>]),
        unknowns: &[Symbol],
        known: &Replacement,
        small: &[Symbol],
    ) -> Option<(Vec<Symbol>, HashMap<Symbol, Range>)> {
        let mut ranges: HashMap<Symbol, Range> = HashMap::new();
        ranges.extend(small.iter().map(|&s| (s, Range::Small)));
        let mut limits = Vec::new();
        for &unknown in unknowns {
            let Meaning::Unknown(named) = *self.symbols.meaning(unknown) else {
                return None;
            };
            let limit = self.symbols.declare(Meaning::Limit(named));
            let Node::Symbol(solution) = *self.arena.node(known[&unknown]) else {
                return None;
            };
            let moved = self.moved(residual, jacobian, unknowns, limit, small);
            ranges.insert(solution, Range::Unknown { limit, moved });
            limits.push(limit);
        }
        Some((limits, ranges))
    }

    /// Returns the bounds that are tested first, and the full bounds if they differ from these.
    fn bounds(
        &mut self,
        matrix: &[Vec<Expr>],
        borders: &[Expr],
        ranges: &HashMap<Symbol, Range>,
    ) -> Option<(Enclosure<Expr>, Option<Enclosure<Expr>>)> {
        let arena = &mut *self.arena;
        let enclosed = |flavour, arena: &mut _| enclose(matrix, borders, ranges, flavour, arena);
        let global = enclosed(Flavour::Global, arena)?;
        if global.is_free_of(ranges, arena) {
            return Some((global, None));
        }
        let quick = enclosed(Flavour::Limit, arena)?;
        Some((quick, Some(enclosed(Flavour::Box, arena)?)))
    }

    fn is_displacement(&self, symbol: Symbol) -> bool {
        let meaning = self.symbols.meaning(symbol);
        matches!(meaning, Meaning::Unknown(u) if u.family.is_displacement())
    }

    /// Returns how far several small quantities may move a single unknown beyond their common
    /// effect, to first order: the sum of the magnitudes of their separate effects. Zero if there
    /// is one small quantity or more than one unknown.
    fn moved(
        &mut self,
        residual: &[Expr],
        jacobian: &[Vec<Expr>],
        unknowns: &[Symbol],
        limit: Symbol,
        small: &[Symbol],
    ) -> Expr {
        let zero = self.arena.constant(0.0);
        let (&[unknown], &[residual], 2..) = (unknowns, residual, small.len()) else {
            return zero;
        };
        let mut point: Replacement = small.iter().map(|&s| (s, zero)).collect();
        point.insert(unknown, self.arena.symbol(limit));
        let slope = self.arena.substitute(jacobian[0][0], &point);
        let mut terms = Vec::new();
        for &s in small {
            let along = self.arena.diff(residual, s);
            let along = self.arena.substitute(along, &point);
            let s = self.arena.symbol(s);
            let moved = self.arena.product(&[(along, 1), (s, 1), (slope, -1)]);
            terms.push((1.0, self.arena.abs(moved)));
        }
        self.arena.sum(0.0, &terms)
    }
}

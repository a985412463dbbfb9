//! The test whether a solution of a block with multipliers of constraints is connected with the
//! limit of no noise and h → 0.
//!
//! Input: a block. Output: a [`PathJudge`] whose bounds contain the path of solutions from the
//! limit to the step. The equation φ(t₁, q₀ + d)/h has no value at h = 0, but its Jacobian has one,
//! and so has `φ/h = ∂φ/∂t + Σ ∂φ/∂q_i d_i/h` with the gradient at some point between the ends.
//!
//! Let x₀ be the limit, `|x − x₀| ≤ r` a box, F the largest residuals at x₀ and A the Jacobians in
//! the box, all over every smaller step and increment. If every A is regular and `|A⁻¹ F| ≤ r` for
//! each of them, then the path of solutions that starts at x₀ exists for the whole step, does not
//! leave the box, and ends at the only solution in the box. The test therefore does not assume that
//! the path stays in the box.
//!
//! Source: Neumaier, *Interval Methods for Systems of Equations* (1990), sections 5.1 and 5.4.

use std::collections::HashMap;

use super::band::Band;
use super::block::Replacement;
use super::cancel::Cancellation;
use super::elimination::Reduced;
use super::enclosure::{Enclosure, enclose};
use super::matrix::Matrix;
use super::scheme::Linear;
use crate::algebra::intervals::{Flavour, Range, largest};
use crate::algebra::{Expr, Node, Symbol};
use crate::model::Meaning;
use crate::rules::constraints::MeanValue;

/// Largest number of unknowns of a block whose solutions are tested by bounds; the test inverts a
/// matrix.
const JUDGED: usize = 4;

/// Largest number of multipliers of a block without other unknowns whose solutions are tested, if
/// its Jacobian is not banded.
const JUDGED_MULTIPLIERS: usize = 8;

/// Half the width of the box in each unknown, as a multiple of two lengths: the distance of the
/// solution from the limit, and the displacement that solves the equations at the limit with one
/// unknown each. Steps that are short compared with the curvature of the constraints pass with any
/// factor. The bounds of the residuals exceed the residuals, most where forces cancel.
const REACH: f64 = 8.0;

/// The test whether a solution of a block is connected with its limit, and whether the limit is
/// connected with any solution.
#[derive(Clone)]
pub(crate) struct PathJudge {
    /// Names of the limit in the bounds.
    pub(crate) limit: Vec<Symbol>,
    pub(crate) of_limit: Linear<Expr>,
    /// The bounds in a box around the limit.
    pub(crate) bounds: Enclosure<Expr>,
    /// Half the widths of the box.
    pub(crate) reach: Vec<Expr>,
    /// Largest residuals at the limit.
    pub(crate) defects: Vec<Expr>,
}

impl PathJudge {
    /// Returns all expressions to be computed.
    pub(super) fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            limit: _,
            of_limit,
            bounds,
            reach,
            defects,
        } = self;
        let bounds = bounds.exprs_mut().chain(reach).chain(defects);
        of_limit.exprs_mut().chain(bounds)
    }
}

/// A block with multipliers of constraints.
pub(super) struct Constrained<'a> {
    pub(super) residual: &'a [Expr],
    /// The equations to leading order.
    pub(super) leading: &'a [Expr],
    /// The equations of the constraints in a form that has a limit.
    pub(super) mean_values: &'a [Option<MeanValue>],
    pub(super) jacobian: &'a [Vec<Expr>],
    pub(super) variations: &'a [Symbol],
    pub(super) unknowns: &'a [Symbol],
}

/// The Jacobian and the equations of a block, in a form that has a limit for a small step.
struct Scaled {
    /// The entries of the Jacobian, row by row.
    entries: Vec<Expr>,
    defects: Vec<Expr>,
    /// Symbols that vanish in the limit.
    small: Vec<Symbol>,
}

/// A block in terms of its solution, with its limit.
struct NamedBlock<'a> {
    /// The Jacobian.
    matrix: Vec<Vec<Expr>>,
    at_limit: Vec<Vec<Expr>>,
    /// The equations at the limit.
    defects: Vec<Expr>,
    /// The constraints at the start of the step, divided by h. They are rounding errors, which are
    /// added to the equations.
    starts: Vec<Option<Expr>>,
    /// Names of the solution and of the limit.
    solution: Vec<Symbol>,
    limit: Vec<Symbol>,
    small: &'a [Symbol],
    /// The row and column of each pivot. The pivots of constraints stand behind the others.
    pivots: Vec<(usize, usize)>,
}

impl Reduced<'_> {
    /// Returns the test of a solution of a block, if all functions in the block have bounds.
    /// `known` has the names of the solution.
    pub(super) fn judge_path(
        &mut self,
        block: &Constrained<'_>,
        known: &Replacement,
    ) -> Option<PathJudge> {
        let unknowns = block.unknowns;
        if unknowns.len() > self.largest_judged(block) {
            return None;
        }
        let scaled = self.scaled(block)?;
        let zero = self.arena.constant(0.0);
        let still: Replacement = scaled.small.iter().map(|&s| (s, zero)).collect();
        let at_limit = self.at_limit(&scaled, unknowns, &still)?;
        let mut limit_of: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        limit_of.extend(still);
        let limit_rhs = self.arena.substitute_all(block.leading, &limit_of);
        let limit_rhs: Vec<Expr> = limit_rhs.into_iter().map(|r| self.arena.neg(r)).collect();
        let [limit, solution] = self.names(unknowns, known)?;
        let at: Replacement = {
            let limits = unknowns.iter().zip(&limit);
            limits.map(|(&u, &l)| (u, self.arena.symbol(l))).collect()
        };
        let defects = self.arena.substitute_all(&scaled.defects, &at);
        let entries = self.arena.substitute_all(&scaled.entries, known);
        let is_open = |&e: &Expr| {
            let mut symbols = self.arena.symbols_of(e);
            let is_unknown = |s: Symbol| matches!(self.symbols.meaning(s), Meaning::Unknown(_));
            symbols.any(|s| is_unknown(s) && !solution.contains(&s))
        };
        if entries.iter().chain(&defects).any(is_open) {
            return None;
        }
        let rows = |entries: &[Expr]| -> Vec<Vec<Expr>> {
            let rows = entries.chunks(unknowns.len());
            rows.map(<[Expr]>::to_vec).collect()
        };
        let at_limit = rows(&at_limit);
        let matrix = Matrix::dense(at_limit.clone());
        let pivots = self.pivots(block.variations, unknowns, &matrix)?.0;
        let starts = block.mean_values.iter();
        let block = NamedBlock {
            matrix: rows(&entries),
            at_limit,
            defects,
            starts: starts.map(|mean| mean.map(|mean| mean.start)).collect(),
            solution,
            limit: limit.clone(),
            small: &scaled.small,
            pivots,
        };
        let of_limit = self.linear((block.at_limit.clone(), limit_rhs));
        let (bounds, reach, defects) = self.path(&block)?;
        Some(PathJudge {
            limit,
            of_limit,
            bounds,
            reach,
            defects,
        })
    }

    /// Returns the Jacobian and the equations of a block without divisions by the step size.
    fn scaled(&mut self, block: &Constrained<'_>) -> Option<Scaled> {
        let small = self.small(block.residual);
        let is_step = |s: &Symbol| matches!(self.symbols.meaning(*s), Meaning::StepSize);
        let is_wiener = |s: &Symbol| matches!(self.symbols.meaning(*s), Meaning::Wiener(_));
        let step = *small.iter().find(|s| is_step(s))?;
        let h = self.arena.symbol(step);
        let zero = self.arena.constant(0.0);
        let wiener = small.into_iter().filter(is_wiener);
        let without_noise: Replacement = wiener.map(|s| (s, zero)).collect();
        let whole = self.symbols.declare(Meaning::StepSize);
        let mut cancellation = Cancellation {
            h,
            whole: self.arena.symbol(whole),
            arena: self.arena,
            still: &without_noise,
            done: HashMap::new(),
        };
        let entries = cancellation.all(&block.jacobian.concat())?;
        let means = block.mean_values.iter().zip(block.residual);
        let defects = means.map(|(mean, &r)| mean.map_or(r, |mean| mean.rate));
        let defects = cancellation.all(&defects.collect::<Vec<Expr>>())?;
        let small = self.small(&[entries.as_slice(), &defects].concat());
        Some(Scaled {
            small: small.into_iter().filter(|&s| s != whole).collect(),
            entries,
            defects,
        })
    }

    /// Returns the Jacobian in the limit. `None` if it depends on the unknowns, or if it or the
    /// equations are not defined there.
    fn at_limit(
        &mut self,
        scaled: &Scaled,
        unknowns: &[Symbol],
        still: &Replacement,
    ) -> Option<Vec<Expr>> {
        let at_limit = self.arena.substitute_all(&scaled.entries, still);
        let resting = self.arena.substitute_all(&scaled.defects, still);
        let moves = |e: &Expr| unknowns.iter().any(|&u| self.arena.contains(*e, u));
        let is_defined =
            !at_limit.iter().any(moves) && self.is_defined(&[&at_limit, &resting[..]].concat());
        is_defined.then_some(at_limit)
    }

    /// Declares names of the limit of some unknowns. Returns these and the names of the solution.
    fn names(&mut self, unknowns: &[Symbol], known: &Replacement) -> Option<[Vec<Symbol>; 2]> {
        let (mut limit, mut solution) = (Vec::new(), Vec::new());
        for unknown in unknowns {
            let Meaning::Unknown(named) = *self.symbols.meaning(*unknown) else {
                return None;
            };
            let Node::Symbol(solved) = *self.arena.node(known[unknown]) else {
                return None;
            };
            limit.push(self.symbols.declare(Meaning::Limit(named)));
            solution.push(solved);
        }
        Some([limit, solution])
    }

    /// Returns the bounds of the Jacobian, half the widths of the box and the residuals at the
    /// limit.
    fn path(&mut self, block: &NamedBlock<'_>) -> Option<(Enclosure<Expr>, Vec<Expr>, Vec<Expr>)> {
        let flavour = Flavour::Box;
        let mut ranges: HashMap<Symbol, Range> = HashMap::new();
        ranges.extend(block.small.iter().map(|&s| (s, Range::Small)));
        let (mut defects, mut conditions) = largest(&block.defects, &ranges, flavour, self.arena)?;
        for (defect, start) in defects.iter_mut().zip(&block.starts) {
            if let &Some(start) = start {
                let size = self.arena.abs(start);
                *defect = self.arena.add(*defect, size);
            }
        }
        let steps = self.single_steps(block, &defects);
        let mut reach = Vec::new();
        for (at, (&solution, &limit)) in block.solution.iter().zip(&block.limit).enumerate() {
            let [x, x0] = [solution, limit].map(|s| self.arena.symbol(s));
            let distance = self.arena.sub(x, x0);
            let distance = self.arena.abs(distance);
            let reach_of = self
                .arena
                .sum(0.0, &[(REACH, distance), (REACH, steps[at])]);
            reach.push(reach_of);
            let range = Range::Around {
                limit,
                reach: reach_of,
            };
            ranges.insert(solution, range);
        }
        let mut bounds = enclose(&block.matrix, &[], &ranges, flavour, self.arena)?;
        conditions.append(&mut bounds.conditions);
        bounds.conditions = conditions;
        Some((bounds, reach, defects))
    }

    /// Estimates how far residuals of these magnitudes move each unknown: each equation is solved
    /// for the unknown of its pivot, and the equations of constraints after elimination of the
    /// other unknowns.
    fn single_steps(&mut self, block: &NamedBlock<'_>, defects: &[Expr]) -> Vec<Expr> {
        let zero = self.arena.constant(0.0);
        let a = &block.at_limit;
        let mut steps = vec![zero; defects.len()];
        let (motion, of_constraints) = {
            let is_multiplier = |s: &&Symbol| matches!(self.symbols.meaning(**s), Meaning::Limit(u) if u.family.is_multiplier_of_constraint());
            let multipliers = block.limit.iter().filter(is_multiplier).count();
            block.pivots.split_at(block.pivots.len() - multipliers)
        };
        for &(row, column) in motion {
            steps[column] = self.quotient(defects[row], a[row][column]);
        }
        for &(row, column) in of_constraints {
            let (mut terms, mut sizes) = (vec![(1.0, a[row][column])], vec![(1.0, defects[row])]);
            for &(r, c) in motion {
                let term = [(a[row][c], 1), (a[r][column], 1), (a[r][c], -1)];
                terms.push((-1.0, self.arena.product(&term)));
                let slope = self.arena.abs(a[row][c]);
                sizes.push((1.0, self.arena.mul(slope, steps[c])));
            }
            let (complement, size) = (self.arena.sum(0.0, &terms), self.arena.sum(0.0, &sizes));
            steps[column] = self.quotient(size, complement);
        }
        for &(row, column) in motion {
            let mut terms = vec![(1.0, steps[column])];
            for &(_, multiplier) in of_constraints {
                let slope = self.arena.abs(a[row][multiplier]);
                let moved = self.arena.mul(slope, steps[multiplier]);
                terms.push((1.0, self.quotient(moved, a[row][column])));
            }
            steps[column] = self.arena.sum(0.0, &terms);
        }
        steps
    }

    fn quotient(&mut self, size: Expr, divisor: Expr) -> Expr {
        let divisor = self.arena.abs(divisor);
        self.arena.div(size, divisor)
    }

    /// Returns the largest number of unknowns up to which a block is tested.
    fn largest_judged(&self, block: &Constrained<'_>) -> usize {
        let is_multiplier = |s: &Symbol| matches!(self.symbols.meaning(*s), Meaning::Unknown(u) if u.family.is_multiplier_of_constraint());
        if !block.unknowns.iter().all(is_multiplier) {
            return JUDGED;
        }
        let is_zero = |e| self.arena.constant_value(e) == Some(0.0);
        match Band::of(block.jacobian, is_zero) {
            Some(_) => usize::MAX,
            None => JUDGED_MULTIPLIERS,
        }
    }
}

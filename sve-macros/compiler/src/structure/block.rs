//! One block of equations: its kind, and the method that solves it.

use std::collections::HashMap;

use super::band::{self, Order};
use super::elimination::Reduced;
use super::judge::Judge;
use super::matrix::Matrix;
use super::path::Constrained;
use super::path::PathJudge;
use super::scheme::{Block, Iteration, Kind, Linear, Refinement, Solution};
use crate::algebra::{Expr, Symbol};
use crate::model::configuration::Factor;
use crate::model::{Meaning, Unknown};
use crate::rules::constraints::MeanValue;

/// Expressions that take the place of symbols.
pub(super) type Replacement = HashMap<Symbol, Expr>;

/// The rows of a matrix, and a right-hand side.
type Rows = (Vec<Vec<Expr>>, Vec<Expr>);

/// The equations of a block to leading order.
struct LeadingRows {
    residuals: Vec<Expr>,
    variations: Vec<Symbol>,
    /// See [`Leading`](crate::discretise::equations::Leading).
    mean_values: Vec<Option<MeanValue>>,
    scales: Vec<Option<Expr>>,
    has_sign: bool,
}

/// The start of an iteration, and the test of its solution.
struct Start {
    judge: Option<Judge<Expr>>,
    path: Option<PathJudge>,
    /// The guess with its refinements. If absent, the iteration starts from the linearly implicit
    /// step.
    explicit: Option<(Linear<Expr>, Vec<Refinement<Expr>>)>,
    /// True if the determinant of the matrix of the guess has the sign of the determinant in the
    /// limit.
    has_sign: bool,
}

impl LeadingRows {
    /// Returns the equations in another order.
    fn in_order(&self, rows: &[usize]) -> Self {
        Self {
            residuals: rows.iter().map(|&r| self.residuals[r]).collect(),
            variations: rows.iter().map(|&r| self.variations[r]).collect(),
            mean_values: rows.iter().map(|&r| self.mean_values[r]).collect(),
            scales: rows.iter().map(|&r| self.scales[r]).collect(),
            has_sign: self.has_sign,
        }
    }
}

impl Reduced<'_> {
    /// Chooses how a block is solved. Adds to `known` the symbols that stand for its solution.
    pub(super) fn solve(
        &mut self,
        rows: &[usize],
        columns: &[usize],
        known: &mut Replacement,
    ) -> Block<Expr> {
        let unknowns = columns.iter().map(|&c| self.unknowns[c]).collect();
        let residual = rows
            .iter()
            .map(|&r| self.arena.substitute(self.residuals[r], known))
            .collect();
        let leading = self.leading_of(rows, columns, known);
        let (residual, unknowns, leading) = self.ordered(residual, unknowns, leading);
        let jacobian = self.jacobian(&residual, &unknowns);
        let zero = self.arena.constant(0.0);
        let nonzeros = jacobian.iter().flatten().filter(|&&e| e != zero).count();
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let at_zero = self.newton_step(&residual, &jacobian, &origin);

        let is_linear = self.is_linear(&jacobian, &unknowns);
        let (kind, solution) = match unknowns.as_slice() {
            &[unknown] if is_linear => self.formula(&at_zero, unknown, known),
            _ if is_linear => {
                let solved = self.solved(&unknowns, known);
                let linear = self.linear(at_zero);
                (Kind::Linear, Solution::System { linear, solved })
            }
            _ => {
                let equations = (residual, jacobian);
                let iteration =
                    self.iteration(equations, at_zero, &unknowns, leading.as_ref(), known);
                (Kind::Newton, Solution::Iteration(Box::new(iteration)))
            }
        };
        let matrix = match &solution {
            Solution::Formula(_) => None,
            Solution::System { linear, .. } => Some(&linear.matrix),
            Solution::Iteration(iteration) => Some(&iteration.guess.matrix),
        };
        let pivots = leading
            .zip(matrix)
            .and_then(|(leading, matrix)| self.pivots(&leading.variations, &unknowns, matrix));
        Block {
            kind,
            unknowns,
            nonzeros,
            pivots,
            solution,
        }
    }

    /// Solves a linear equation in one unknown. The formula replaces the unknown in later blocks.
    fn formula(
        &mut self,
        (matrix, rhs): &Rows,
        unknown: Symbol,
        known: &mut Replacement,
    ) -> (Kind, Solution<Expr>) {
        let coefficient = matrix[0][0];
        let formula = self.arena.div(rhs[0], coefficient);
        let formula = self.arena.opaque(formula);
        known.insert(unknown, formula);
        let kind = if self.is_parameter(coefficient) {
            Kind::Explicit
        } else {
            Kind::Linear
        };
        (kind, Solution::Formula(formula))
    }

    /// Sets up Newton's method for equations with their Jacobian; `at_zero` is its step from zero.
    fn iteration(
        &mut self,
        (residual, jacobian): (Vec<Expr>, Vec<Vec<Expr>>),
        at_zero: Rows,
        unknowns: &[Symbol],
        leading: Option<&LeadingRows>,
        known: &mut Replacement,
    ) -> Iteration<Expr> {
        let solved = self.solved(unknowns, known);
        let Start {
            judge,
            path,
            explicit,
            has_sign,
        } = self.start(leading, (&residual, &jacobian), unknowns, known);
        let fallback = self.linear(at_zero);
        let limit = explicit.as_ref().map(|(guess, _)| guess.matrix.clone());
        let limit = limit.filter(|_| has_sign);
        let (guess, refinements) = explicit.unwrap_or_else(|| (fallback.clone(), Vec::new()));
        let curvature = match unknowns {
            [unknown] => Some(self.arena.diff(jacobian[0][0], *unknown)),
            _ => None,
        };
        Iteration {
            guess,
            scales: leading.map_or_else(Vec::new, |leading| leading.scales.clone()),
            judge: judge.filter(|_| limit.is_some()),
            path,
            limit,
            refinements,
            jacobian: if self.is_rotation(unknowns) {
                Matrix::of_rotation(jacobian, self.arena)
            } else {
                Matrix::new(jacobian, self.arena)
            },
            residual,
            curvature,
            fallback,
            needs_guess: leading.is_some(),
            iterates: unknowns.to_vec(),
            solved,
        }
    }

    /// Returns the guess of an iteration and the test of its solution. The guess of a block with
    /// multipliers is the solution of its equations to leading order.
    fn start(
        &mut self,
        leading: Option<&LeadingRows>,
        (residual, jacobian): (&[Expr], &[Vec<Expr>]),
        unknowns: &[Symbol],
        known: &Replacement,
    ) -> Start {
        let Some(leading) = leading else {
            return Start {
                judge: self.judge(residual, jacobian, unknowns, known),
                path: None,
                explicit: self.guess(residual, jacobian, unknowns),
                has_sign: true,
            };
        };
        let guess = self.guess_from(&leading.residuals, unknowns);
        let block = Constrained {
            residual,
            leading: &leading.residuals,
            mean_values: &leading.mean_values,
            jacobian,
            variations: &leading.variations,
            unknowns,
        };
        let path = self.judge_path(&block, known);
        Start {
            judge: None,
            path: path.filter(|_| leading.has_sign),
            explicit: Some((guess, Vec::new())),
            has_sign: leading.has_sign,
        }
    }

    /// Makes all equations one block, solved by Newton's method with dense matrices from the Newton
    /// step from zero. Adds to `known` the symbols that stand for its solution.
    pub(super) fn unstructured(&mut self, known: &mut Replacement) -> Block<Expr> {
        let (residual, unknowns) = (self.residuals.clone(), self.unknowns.clone());
        let jacobian = self.jacobian(&residual, &unknowns);
        let zero = self.arena.constant(0.0);
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let (matrix, rhs) = self.newton_step(&residual, &jacobian, &origin);
        let at_zero = Linear {
            matrix: Matrix::dense(matrix),
            rhs,
        };
        let iteration = Iteration {
            guess: at_zero.clone(),
            limit: None,
            refinements: Vec::new(),
            jacobian: Matrix::dense(jacobian),
            residual,
            scales: Vec::new(),
            curvature: None,
            judge: None,
            path: None,
            fallback: at_zero,
            needs_guess: false,
            iterates: unknowns.clone(),
            solved: self.solved(&unknowns, known),
        };
        Block {
            kind: Kind::Newton,
            nonzeros: unknowns.len() * unknowns.len(),
            pivots: None,
            unknowns,
            solution: Solution::Iteration(Box::new(iteration)),
        }
    }

    pub(super) fn linear(&mut self, (matrix, rhs): Rows) -> Linear<Expr> {
        Linear {
            matrix: Matrix::new(matrix, self.arena),
            rhs,
        }
    }

    /// Orders equations and unknowns so that their Jacobian is banded, if such an order exists.
    fn ordered(
        &self,
        residual: Vec<Expr>,
        unknowns: Vec<Symbol>,
        leading: Option<LeadingRows>,
    ) -> (Vec<Expr>, Vec<Symbol>, Option<LeadingRows>) {
        let contained = |&r: &Expr| {
            let present = (0..unknowns.len()).filter(|&c| self.arena.contains(r, unknowns[c]));
            present.collect()
        };
        let depends: Vec<Vec<usize>> = residual.iter().map(contained).collect();
        match band::order(&depends) {
            Some(Order { rows, columns }) => (
                rows.iter().map(|&r| residual[r]).collect(),
                columns.iter().map(|&c| unknowns[c]).collect(),
                leading.map(|leading| leading.in_order(&rows)),
            ),
            None => (residual, unknowns, leading),
        }
    }

    /// Returns the equations of a block to leading order, from which its guess is solved; `None`
    /// for a block without multipliers of constraints.
    fn leading_of(
        &mut self,
        rows: &[usize],
        columns: &[usize],
        known: &Replacement,
    ) -> Option<LeadingRows> {
        columns
            .iter()
            .find(|&&c| self.torn.contains(&self.unknowns[c]))?;
        let leading = self.leading.as_ref()?;
        let (has_sign, list) = (leading.has_sign, leading.residuals.clone());
        let means: Vec<_> = rows.iter().map(|&r| leading.mean_values[r]).collect();
        let scales = rows.iter().map(|&r| leading.scales[r]).collect();
        let variations = rows.iter().map(|&r| leading.variations[r]).collect();
        let residuals = rows.iter().map(|&r| self.arena.substitute(list[r], known));
        let residuals = residuals.collect();
        let means = means.into_iter();
        let mean_values = means.map(|mean| {
            mean.map(|MeanValue { rate, start }| MeanValue {
                rate: self.arena.substitute(rate, known),
                start,
            })
        });
        Some(LeadingRows {
            residuals,
            mean_values: mean_values.collect(),
            variations,
            scales,
            has_sign,
        })
    }

    pub(super) fn jacobian(&mut self, residual: &[Expr], unknowns: &[Symbol]) -> Vec<Vec<Expr>> {
        let zero = self.arena.constant(0.0);
        let mut slopes = Vec::with_capacity(residual.len() * unknowns.len());
        for &r in residual {
            slopes.extend(unknowns.iter().map(|&u| self.arena.diff(r, u)));
        }
        let zeros = self.arena.zeros(&slopes);
        for (slope, is_zero) in slopes.iter_mut().zip(zeros) {
            if is_zero {
                *slope = zero;
            }
        }
        slopes
            .chunks(unknowns.len())
            .map(<[Expr]>::to_vec)
            .collect()
    }

    /// Returns the linear system of the Newton step from a point.
    pub(super) fn newton_step(
        &mut self,
        residual: &[Expr],
        jacobian: &[Vec<Expr>],
        point: &Replacement,
    ) -> Rows {
        let entries = self.arena.substitute_all(&jacobian.concat(), point);
        let matrix = entries
            .chunks(residual.len())
            .map(<[Expr]>::to_vec)
            .collect();
        let rhs = self.arena.substitute_all(residual, point);
        let rhs = rhs.into_iter().map(|r| self.arena.neg(r)).collect();
        (matrix, rhs)
    }

    /// Declares symbols for the solution of a block. Adds them to `known` in place of the unknowns.
    fn solved(&mut self, unknowns: &[Symbol], known: &mut Replacement) -> Vec<Symbol> {
        let mut solved = Vec::new();
        for &unknown in unknowns {
            let symbol = self.symbols.declare(self.symbols.meaning(unknown).clone());
            known.insert(unknown, self.arena.symbol(symbol));
            solved.push(symbol);
        }
        solved
    }

    /// Returns whether the unknowns are the three directions of one rotation.
    pub(super) fn is_rotation(&self, unknowns: &[Symbol]) -> bool {
        let mut directions: Vec<usize> = unknowns
            .iter()
            .filter_map(|&u| match *self.symbols.meaning(u) {
                Meaning::Unknown(Unknown { index, .. }) => Some(index),
                _ => None,
            })
            .collect();
        directions.sort_unstable();
        let blocks = self.symbols.configuration.blocks();
        let mut rotations = blocks.iter().filter(|b| b.factor == Factor::Rotation);
        rotations.any(|rotation| rotation.directions.clone().eq(directions.iter().copied()))
    }

    /// Returns whether no entry of the Jacobian depends on the unknowns, nor on the increments of
    /// noise forces of velocities: a solution beyond a singular matrix is not connected.
    fn is_linear(&mut self, jacobian: &[Vec<Expr>], unknowns: &[Symbol]) -> bool {
        for &entry in jacobian.iter().flatten() {
            if self.dividing.iter().any(|&s| self.arena.contains(entry, s)) {
                return false;
            }
            for &u in unknowns {
                if !self.arena.contains(entry, u) {
                    continue;
                }
                let change = self.arena.diff(entry, u);
                if !self.arena.is_zero(change) {
                    return false;
                }
            }
        }
        true
    }

    /// Returns whether an expression contains parameters only. A coefficient that contains the step
    /// size comes from an implicit equation.
    pub(super) fn is_parameter(&self, expr: Expr) -> bool {
        self.arena
            .symbols_of(expr)
            .all(|s| matches!(self.symbols.meaning(s), Meaning::Parameter { .. }))
    }
}

//! One block: what kind it is, and what solves it.

use std::collections::HashMap;

use super::band::{self, Order};
use super::elimination::Reduced;
use super::matrix::Matrix;
use super::scheme::{Block, Iteration, Kind, Linear, Refinement, Solution};
use crate::algebra::{Expr, Symbol};
use crate::system::model::Meaning;

/// Expressions that take the place of symbols.
pub(super) type Replacement = HashMap<Symbol, Expr>;

/// Rows of a matrix, and a right-hand side.
type Rows = (Vec<Vec<Expr>>, Vec<Expr>);

/// The equations of a block to leading order.
struct LeadingRows {
    residuals: Vec<Expr>,
    variations: Vec<Symbol>,
    scales: Vec<Option<Expr>>,
    has_sign: bool,
}

impl LeadingRows {
    /// The equations in another order.
    fn in_order(&self, rows: &[usize]) -> Self {
        Self {
            residuals: rows.iter().map(|&r| self.residuals[r]).collect(),
            variations: rows.iter().map(|&r| self.variations[r]).collect(),
            scales: rows.iter().map(|&r| self.scales[r]).collect(),
            has_sign: self.has_sign,
        }
    }
}

impl Reduced<'_> {
    /// Classifies a block and writes down what solves it; `known` gets what its unknowns are called afterwards.
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

        let linear = self.is_linear(&jacobian, &unknowns);
        if linear && unknowns.len() == 1 {
            let (coefficient, rhs) = (at_zero.0[0][0], at_zero.1[0]);
            let formula = self.arena.div(rhs, coefficient);
            let formula = self.arena.opaque(formula);
            known.insert(unknowns[0], formula);
            let kind = if self.is_parameter(coefficient) {
                Kind::Explicit
            } else {
                Kind::Linear
            };
            return Block {
                kind,
                unknowns,
                nonzeros,
                pivots: None,
                solution: Solution::Formula(formula),
            };
        }
        let solved = self.solved(&unknowns, known);
        let variations = leading.as_ref().map(|leading| leading.variations.clone());
        let pivots = |system: &Self, matrix: &Matrix<Expr>| {
            variations.and_then(|variations| system.pivots(&variations, &unknowns, matrix))
        };
        if linear {
            let linear = self.linear(at_zero);
            return Block {
                kind: Kind::Linear,
                pivots: pivots(self, &linear.matrix),
                unknowns,
                nonzeros,
                solution: Solution::System { linear, solved },
            };
        }
        let needs_guess = leading.is_some();
        let scales = leading
            .as_ref()
            .map_or_else(Vec::new, |leading| leading.scales.clone());
        let (judge, explicit, has_sign) = match leading {
            Some(leading) => {
                let guess = self.guess_from(&leading.residuals, &unknowns);
                (None, Some((guess, None)), leading.has_sign)
            }
            None => {
                let judge = self.judge(&residual, &jacobian, &unknowns, known);
                (judge, self.guess(&residual, &jacobian, &unknowns), true)
            }
        };
        let fallback = self.linear(at_zero);
        let limit = explicit.as_ref().map(|(guess, _)| guess.matrix.clone());
        let limit = limit.filter(|_| has_sign);
        let (guess, refinement) = explicit.unwrap_or_else(|| (fallback.clone(), None));
        let curvature = match unknowns.as_slice() {
            [unknown] => Some(self.arena.diff(jacobian[0][0], *unknown)),
            _ => None,
        };
        let pivots = pivots(self, &guess.matrix);
        let iteration = Iteration {
            guess,
            scales,
            judge: judge.filter(|_| limit.is_some()),
            limit,
            refinement,
            jacobian: Matrix::new(jacobian, self.arena),
            residual,
            curvature,
            fallback,
            needs_guess,
            iterates: unknowns.clone(),
            solved,
        };
        Block {
            kind: Kind::Newton,
            unknowns,
            nonzeros,
            pivots,
            solution: Solution::Iteration(Box::new(iteration)),
        }
    }

    /// All equations as one block that is iterated from the Newton step from zero, with dense matrices; `known` gets what its
    /// unknowns are called afterwards.
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
            refinement: None,
            jacobian: Matrix::dense(jacobian),
            residual,
            scales: Vec::new(),
            curvature: None,
            judge: None,
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

    fn linear(&mut self, (matrix, rhs): Rows) -> Linear<Expr> {
        Linear {
            matrix: Matrix::new(matrix, self.arena),
            rhs,
        }
    }

    /// Equations and unknowns in an order that makes their Jacobian banded, if there is one.
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

    /// The equations of a block to leading order, where its guess is solved from these, and whether they have the sign of its determinant.
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
        let scales = rows.iter().map(|&r| leading.scales[r]).collect();
        let variations = rows.iter().map(|&r| leading.variations[r]).collect();
        let residuals = rows.iter().map(|&r| self.arena.substitute(list[r], known));
        Some(LeadingRows {
            residuals: residuals.collect(),
            variations,
            scales,
            has_sign,
        })
    }

    /// The Newton step from zero of the equations to leading order.
    fn guess_from(&mut self, leading: &[Expr], unknowns: &[Symbol]) -> Linear<Expr> {
        let zero = self.arena.constant(0.0);
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let jacobian = self.jacobian(leading, unknowns);
        let step = self.newton_step(leading, &jacobian, &origin);
        self.linear(step)
    }

    fn jacobian(&mut self, residual: &[Expr], unknowns: &[Symbol]) -> Vec<Vec<Expr>> {
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

    /// The linear system of the Newton step from a point.
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

    /// A guess that costs little, from the limit of h = 0 and no noise, where the equations are linear in most systems:
    /// the explicit velocity. One unknown that noise kicks takes the kick too; several unknowns are refined to first order in
    /// h and the increments, with the same matrix. Nothing where that matrix does not exist.
    fn guess(
        &mut self,
        residual: &[Expr],
        jacobian: &[Vec<Expr>],
        unknowns: &[Symbol],
    ) -> Option<(Linear<Expr>, Option<Refinement<Expr>>)> {
        let zero = self.arena.constant(0.0);
        let small = self.small(residual);
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let mut limit = origin.clone();
        limit.extend(small.iter().map(|&s| (s, zero)));
        let (matrix, mut rhs) = self.newton_step(residual, jacobian, &limit);
        let noisy = small
            .iter()
            .any(|&s| matches!(self.symbols.meaning(s), Meaning::Wiener(_)));
        let refinement = if unknowns.len() > 1 {
            Some(self.refinement(residual, unknowns, &small))
        } else {
            if noisy {
                rhs = self.newton_step(residual, jacobian, &origin).1;
            }
            None
        };
        let size = unknowns.len();
        let regular = (0..size).all(|i| {
            matrix[i].iter().any(|&e| e != zero) && matrix.iter().any(|row| row[i] != zero)
        });
        let refined = refinement.iter().flat_map(|r| &r.rhs);
        let all: Vec<Expr> = matrix
            .iter()
            .flatten()
            .chain(&rhs)
            .chain(refined)
            .copied()
            .collect();
        let mut nodes = self.arena.reachable(&all, |_| true).into_iter();
        let defined = nodes.all(|e| self.arena.constant_value(e).is_none_or(f64::is_finite));
        (regular && defined).then(|| (self.linear((matrix, rhs)), refinement))
    }

    /// The step size and the increments of the noise, as far as they occur.
    pub(super) fn small(&self, residual: &[Expr]) -> Vec<Symbol> {
        let is_small = |s: &Symbol| {
            matches!(
                self.symbols.meaning(*s),
                Meaning::StepSize | Meaning::Wiener(_)
            )
        };
        let mut small: Vec<Symbol> = residual
            .iter()
            .flat_map(|&r| self.arena.symbols_of(r))
            .filter(is_small)
            .collect();
        small.sort_unstable();
        small.dedup();
        small
    }

    /// `−Σ s ∂R/∂s` at the first stage, over the small quantities s.
    fn refinement(
        &mut self,
        residual: &[Expr],
        unknowns: &[Symbol],
        small: &[Symbol],
    ) -> Refinement<Expr> {
        let zero = self.arena.constant(0.0);
        let mut point: Replacement = small.iter().map(|&s| (s, zero)).collect();
        let mut first = Vec::new();
        for &unknown in unknowns {
            let symbol = self.symbols.declare(self.symbols.meaning(unknown).clone());
            point.insert(unknown, self.arena.symbol(symbol));
            first.push(symbol);
        }
        let rhs = residual
            .iter()
            .map(|&r| {
                let mut terms = Vec::new();
                for &s in small {
                    let slope = self.arena.diff(r, s);
                    let slope = self.arena.substitute(slope, &point);
                    let s = self.arena.symbol(s);
                    terms.push((-1.0, self.arena.mul(slope, s)));
                }
                self.arena.sum(0.0, &terms)
            })
            .collect();
        Refinement { first, rhs }
    }

    /// Names for the solution of a block, which `known` puts in the place of its unknowns.
    fn solved(&mut self, unknowns: &[Symbol], known: &mut Replacement) -> Vec<Symbol> {
        let mut solved = Vec::new();
        for &unknown in unknowns {
            let symbol = self.symbols.declare(self.symbols.meaning(unknown).clone());
            known.insert(unknown, self.arena.symbol(symbol));
            solved.push(symbol);
        }
        solved
    }

    /// Whether no entry of the Jacobian changes with the unknowns.
    fn is_linear(&mut self, jacobian: &[Vec<Expr>], unknowns: &[Symbol]) -> bool {
        for &entry in jacobian.iter().flatten() {
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

    /// Whether only parameters occur: with the step size in it, a coefficient comes from an implicit equation.
    pub(super) fn is_parameter(&self, expr: Expr) -> bool {
        self.arena
            .symbols_of(expr)
            .all(|s| matches!(self.symbols.meaning(s), Meaning::Parameter { .. }))
    }
}

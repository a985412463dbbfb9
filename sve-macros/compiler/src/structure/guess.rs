//! The first guess of an iteration.
//!
//! Input: the residuals of a block with their Jacobian. Output: a linear system whose solution is
//! the guess, and the stages that refine the guess with the same matrix.

use super::block::Replacement;
use super::elimination::Reduced;
use super::scheme::{Linear, Refinement};
use crate::algebra::{Expr, Symbol};
use crate::model::{Meaning, chart};

impl Reduced<'_> {
    /// Returns the Newton step from zero of the equations to leading order.
    pub(super) fn guess_from(&mut self, leading: &[Expr], unknowns: &[Symbol]) -> Linear<Expr> {
        let zero = self.arena.constant(0.0);
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let jacobian = self.jacobian(leading, unknowns);
        let step = self.newton_step(leading, &jacobian, &origin);
        self.linear(step)
    }

    /// Returns a cheap guess from the limit of h = 0 and no noise, where the equations of most
    /// systems are linear: the explicit velocity. The guess of a single unknown that noise kicks
    /// includes the kick. The guess of several unknowns is refined to first order in h and the
    /// increments, with the same matrix. The guess of a rotation is refined to second order by two
    /// steps of Newton's method with this matrix, in which the functions of its chart are short
    /// polynomials. `None` if the matrix does not exist.
    pub(super) fn guess(
        &mut self,
        residual: &[Expr],
        jacobian: &[Vec<Expr>],
        unknowns: &[Symbol],
    ) -> Option<(Linear<Expr>, Vec<Refinement<Expr>>)> {
        let zero = self.arena.constant(0.0);
        let small = self.small(residual);
        let origin: Replacement = unknowns.iter().map(|&u| (u, zero)).collect();
        let mut limit = origin.clone();
        limit.extend(small.iter().map(|&s| (s, zero)));
        let (matrix, mut rhs) = self.newton_step(residual, jacobian, &limit);
        let noisy = small
            .iter()
            .any(|&s| matches!(self.symbols.meaning(s), Meaning::Wiener(_)));
        let refinements = if self.is_rotation(unknowns) {
            let mut stage = || self.chord_step(residual, unknowns);
            vec![stage(), stage()]
        } else if unknowns.len() > 1 {
            vec![self.refinement(residual, unknowns, &small)]
        } else {
            if noisy {
                rhs = self.newton_step(residual, jacobian, &origin).1;
            }
            Vec::new()
        };
        let size = unknowns.len();
        let regular = (0..size).all(|i| {
            matrix[i].iter().any(|&e| e != zero) && matrix.iter().any(|row| row[i] != zero)
        });
        let refined = refinements.iter().flat_map(|r| &r.rhs);
        let all: Vec<Expr> = matrix
            .iter()
            .flatten()
            .chain(&rhs)
            .chain(refined)
            .copied()
            .collect();
        (regular && self.is_defined(&all)).then(|| (self.linear((matrix, rhs)), refinements))
    }

    /// Returns whether all constants in some expressions are finite.
    pub(super) fn is_defined(&self, exprs: &[Expr]) -> bool {
        let mut nodes = self.arena.reachable(exprs, |_| true).into_iter();
        nodes.all(|e| self.arena.constant_value(e).is_none_or(f64::is_finite))
    }

    /// Returns the step size and the increments of the noise that occur in the residuals.
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

    /// Returns `−Σ s ∂R/∂s` at the first stage, summed over the small quantities s.
    fn refinement(
        &mut self,
        residual: &[Expr],
        unknowns: &[Symbol],
        small: &[Symbol],
    ) -> Refinement<Expr> {
        let zero = self.arena.constant(0.0);
        let (first, mut point) = self.stage_names(unknowns);
        point.extend(small.iter().map(|&s| (s, zero)));
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

    /// Returns `−R` at the previous stage, for small rotations.
    fn chord_step(&mut self, residual: &[Expr], unknowns: &[Symbol]) -> Refinement<Expr> {
        let (first, point) = self.stage_names(unknowns);
        let residual = chart::of_small_angles(residual, self.arena);
        let residual = self.arena.substitute_all(&residual, &point).into_iter();
        let rhs = residual.map(|r| self.arena.neg(r)).collect();
        Refinement { first, rhs }
    }

    /// Declares names for the result of a stage of a guess, which replace the unknowns.
    fn stage_names(&mut self, unknowns: &[Symbol]) -> (Vec<Symbol>, Replacement) {
        let (mut names, mut point) = (Vec::new(), Replacement::new());
        for &unknown in unknowns {
            let symbol = self.symbols.declare(self.symbols.meaning(unknown).clone());
            point.insert(unknown, self.arena.symbol(symbol));
            names.push(symbol);
        }
        (names, point)
    }
}

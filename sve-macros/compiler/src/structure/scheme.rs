//! A step as blocks that are solved in order.
//!
//! One tree for all later stages. Its leaves `T` are expressions after this stage and values of a
//! program after scheduling ([`Lower`]). `R` is a residual, which has a magnitude beside its value
//! once it is scheduled. Quantities that a step computes only if its fast path fails stay
//! expressions; they are computed at their place of use.

use super::judge::Judge;
use super::matrix::Matrix;
use super::path::PathJudge;
use super::pivots::Pivots;
use crate::algebra::{Expr, Symbol};
use crate::model::domain::Condition;

/// A step.
#[derive(Clone)]
pub(crate) struct Scheme<T, R = T> {
    pub(crate) blocks: Vec<Block<T, R>>,
    pub(crate) returns: Returns,
    /// The results for configuration and momenta, see [`Returns`].
    pub(crate) dq: Vec<T>,
    pub(crate) dp: Vec<T>,
    /// Conditions at the solution under which L is defined there.
    pub(crate) domain: Vec<Condition<T>>,
    /// Expressions that must not be negative if a solution is accepted because its iteration
    /// contracts.
    pub(crate) guards: Vec<T>,
    /// `q₁ − q₀` and `p₁ − p₀` as the equations give them, for the printed plan.
    pub(crate) increments: [Vec<Expr>; 2],
    /// Additional results of a step, in terms of the solution: the multipliers of constraints, at
    /// the start and at the end.
    pub(crate) reported: Vec<Expr>,
    /// Entries of rotations at the end of the step, by their numbers in the configuration, if a
    /// node of the rule is there.
    pub(crate) turned: Vec<(usize, Expr)>,
}

/// The results of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Returns {
    /// `q₁ − q₀` and `p₁ − p₀`.
    Increment,
    /// `q₁` and `p₁`: a matrix that differs from step to step times the state, plus an offset.
    State,
    /// `q₁ − q₀` and `p₁ − p₀`: a matrix that is the same in all steps times the state, plus an
    /// offset.
    MatrixTimesState,
}

impl Returns {
    /// Returns whether the step multiplies the state by a matrix whose entries are known before the
    /// state.
    pub(crate) fn is_matrix(self) -> bool {
        self != Self::Increment
    }
}

/// Equations that are solved together.
#[derive(Clone)]
pub(crate) struct Block<T, R = T> {
    pub(crate) kind: Kind,
    /// Unknowns, under their names in the equations.
    pub(crate) unknowns: Vec<Symbol>,
    /// Number of nonzero entries of the Jacobian.
    pub(crate) nonzeros: usize,
    /// The order of pivots, if the block has multipliers of constraints and such an order exists.
    pub(crate) pivots: Option<Pivots>,
    pub(crate) solution: Solution<T, R>,
}

/// How a block is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Explicit,
    Linear,
    Newton,
}

/// How a block is computed: by a formula, a linear solve or an iteration.
#[derive(Clone)]
pub(crate) enum Solution<T, R = T> {
    /// A single unknown by a formula. The formula has replaced the unknown in all later
    /// expressions, where it is computed.
    Formula(Expr),
    /// A linear system. Later expressions name its solution `solved`.
    System {
        linear: Linear<T>,
        solved: Vec<Symbol>,
    },
    /// An iteration from the solution of a linear system.
    Iteration(Box<Iteration<T, R>>),
}

/// A linear system.
#[derive(Clone)]
pub(crate) struct Linear<T> {
    pub(crate) matrix: Matrix<T>,
    pub(crate) rhs: Vec<T>,
}

/// A later stage of a guess, with the same matrix as the first stage.
#[derive(Clone)]
pub(crate) struct Refinement<T> {
    /// Names in `rhs` of the sum of the previous stages.
    pub(crate) first: Vec<Symbol>,
    pub(crate) rhs: Vec<T>,
}

/// Newton's method on a block.
#[derive(Clone)]
pub(crate) struct Iteration<T, R = T> {
    /// First guess.
    pub(crate) guess: Linear<T>,
    /// The Jacobian in the limit of no noise and h → 0. Its determinant has the same sign as the
    /// determinant at the solution. `None` if the limit never exists: for L = v⁴/4 the mass
    /// vanishes at rest.
    pub(crate) limit: Option<Matrix<T>>,
    /// The corrections that are added to the guess, stage by stage.
    pub(crate) refinements: Vec<Refinement<T>>,
    pub(crate) jacobian: Matrix<T>,
    pub(crate) residual: Vec<R>,
    /// An expression added to the magnitude of each residual, for equations all of whose terms may
    /// be small; empty if there are none.
    pub(crate) scales: Vec<Option<Expr>>,
    /// The second derivative of a single equation in a single unknown.
    pub(crate) curvature: Option<T>,
    /// The test whether a solution is connected with its limit, if the Jacobian has bounds.
    pub(crate) judge: Option<Judge<T>>,
    /// The same test for a block with multipliers of constraints. Its bounds are computed only if
    /// the iteration does not contract enough.
    pub(crate) path: Option<PathJudge>,
    /// The guess after a failure: the Newton step from zero, which is the linearly implicit step.
    pub(crate) fallback: Linear<Expr>,
    /// True if a step fails when the matrix of the guess is singular, since no other guess exists.
    pub(crate) needs_guess: bool,
    /// Names of the iterates in `residual`, `jacobian` and `curvature`.
    pub(crate) iterates: Vec<Symbol>,
    pub(crate) solved: Vec<Symbol>,
}

/// Translates the expressions of a scheme, in the order of the calls.
pub(crate) trait Lower {
    type Value;
    type Residual;
    fn value(&mut self, expr: Expr) -> Self::Value;
    /// Translates a residual, and the expression that is added to the sum of the magnitudes of its
    /// terms.
    fn residual(&mut self, expr: Expr, scale: Option<Expr>) -> Self::Residual;

    fn values(&mut self, exprs: &[Expr]) -> Vec<Self::Value> {
        exprs.iter().map(|&e| self.value(e)).collect()
    }

    fn rows(&mut self, rows: &[Vec<Expr>]) -> Vec<Vec<Self::Value>> {
        rows.iter().map(|row| self.values(row)).collect()
    }
}

impl<T, R> Scheme<T, R> {
    /// Returns whether the step has multipliers of constraints.
    pub(crate) fn is_constrained(&self) -> bool {
        !self.reported.is_empty()
    }
}

impl Scheme<Expr> {
    pub(crate) fn lower<L: Lower>(&self, by: &mut L) -> Scheme<L::Value, L::Residual> {
        Scheme {
            blocks: self.blocks.iter().map(|block| block.lower(by)).collect(),
            returns: self.returns,
            dq: by.values(&self.dq),
            dp: by.values(&self.dp),
            domain: self.domain.iter().map(|c| c.lower(by)).collect(),
            guards: by.values(&self.guards),
            increments: self.increments.clone(),
            reported: self.reported.clone(),
            turned: self.turned.clone(),
        }
    }

    /// Returns all expressions that the fast path computes.
    pub(crate) fn roots(&self) -> Vec<Expr> {
        struct Roots(Vec<Expr>);
        impl Lower for Roots {
            type Value = ();
            type Residual = ();
            fn value(&mut self, expr: Expr) {
                self.0.push(expr);
            }
            fn residual(&mut self, expr: Expr, scale: Option<Expr>) {
                self.0.push(expr);
                self.0.extend(scale);
            }
        }
        let mut roots = Roots(Vec::new());
        self.lower(&mut roots);
        roots.0
    }

    /// Returns all expressions that are computed, also those computed only if the fast path fails.
    pub(super) fn exprs_mut(&mut self) -> Vec<&mut Expr> {
        let Self {
            blocks,
            returns: _,
            dq,
            dp,
            domain,
            guards,
            increments: _,
            reported,
            turned,
        } = self;
        let mut exprs: Vec<&mut Expr> = dq
            .iter_mut()
            .chain(dp)
            .chain(reported)
            .chain(guards)
            .chain(turned.iter_mut().map(|(_, entry)| entry))
            .collect();
        exprs.extend(domain.iter_mut().map(|condition| &mut condition.value));
        for block in blocks {
            match &mut block.solution {
                Solution::Formula(formula) => exprs.push(formula),
                Solution::System { linear, solved: _ } => exprs.extend(linear.exprs_mut()),
                Solution::Iteration(iteration) => exprs.extend(iteration.exprs_mut()),
            }
        }
        exprs
    }
}

impl Block<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Block<L::Value, L::Residual> {
        Block {
            kind: self.kind,
            unknowns: self.unknowns.clone(),
            nonzeros: self.nonzeros,
            pivots: self.pivots.clone(),
            solution: self.solution.lower(by),
        }
    }
}

impl Solution<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Solution<L::Value, L::Residual> {
        match self {
            Self::Formula(formula) => Solution::Formula(*formula),
            Self::System { linear, solved } => Solution::System {
                linear: linear.lower(by),
                solved: solved.clone(),
            },
            Self::Iteration(iteration) => Solution::Iteration(Box::new(iteration.lower(by))),
        }
    }
}

impl<T, R> Block<T, R> {
    /// Returns the widths of the band of the Jacobian, if it is banded.
    pub(crate) fn bandwidths(&self) -> Option<(usize, usize)>
    where
        T: Copy,
    {
        match &self.solution {
            Solution::Formula(_) => None,
            Solution::System { linear, .. } => linear.matrix.bandwidths(),
            Solution::Iteration(iteration) => iteration.jacobian.bandwidths(),
        }
    }
}

impl<T, R> Solution<T, R> {
    /// Returns the names of the solution in later expressions; empty for a formula.
    pub(crate) fn solved(&self) -> &[Symbol] {
        match self {
            Self::Formula(_) => &[],
            Self::System { solved, .. } => solved,
            Self::Iteration(iteration) => &iteration.solved,
        }
    }
}

impl<T: PartialEq, R> Iteration<T, R> {
    /// Returns whether the limit equals the solution of the first stage of the guess.
    pub(crate) fn limit_is_guess(&self, judge: &Judge<T>) -> bool {
        judge.limit_rhs == self.guess.rhs
    }
}

impl Linear<Expr> {
    /// Returns the stored entries of the matrix and the right-hand side.
    pub(crate) fn entries(&self) -> Vec<Expr> {
        self.matrix
            .stored()
            .chain(self.rhs.iter().copied())
            .collect()
    }

    pub(super) fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self { matrix, rhs } = self;
        matrix.rows.iter_mut().flatten().chain(rhs)
    }

    fn lower<L: Lower>(&self, by: &mut L) -> Linear<L::Value> {
        Linear {
            matrix: self.matrix.map(|e| by.value(e)),
            rhs: by.values(&self.rhs),
        }
    }
}

impl Refinement<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Refinement<L::Value> {
        Refinement {
            first: self.first.clone(),
            rhs: by.values(&self.rhs),
        }
    }
}

impl Iteration<Expr> {
    fn exprs_mut(&mut self) -> impl Iterator<Item = &mut Expr> {
        let Self {
            guess,
            limit,
            refinements,
            jacobian,
            residual,
            scales,
            curvature,
            judge,
            path,
            fallback,
            needs_guess: _,
            iterates: _,
            solved: _,
        } = self;
        let limit = limit.iter_mut().flat_map(|m| &mut m.rows).flatten();
        let refined = refinements.iter_mut().flat_map(|r| &mut r.rhs);
        let entries = residual
            .iter_mut()
            .chain(jacobian.rows.iter_mut().flatten());
        let linear = guess.exprs_mut().chain(limit).chain(fallback.exprs_mut());
        let judged = judge.iter_mut().flat_map(Judge::exprs_mut);
        let all = linear.chain(refined).chain(entries);
        let path = path.iter_mut().flat_map(PathJudge::exprs_mut);
        all.chain(curvature)
            .chain(judged)
            .chain(path)
            .chain(scales.iter_mut().flatten())
    }

    fn lowered_residual<L: Lower>(&self, by: &mut L) -> Vec<L::Residual> {
        let residuals = self.residual.iter().enumerate();
        residuals
            .map(|(i, &r)| by.residual(r, self.scales.get(i).copied().flatten()))
            .collect()
    }

    fn lower<L: Lower>(&self, by: &mut L) -> Iteration<L::Value, L::Residual> {
        Iteration {
            guess: self.guess.lower(by),
            limit: self.limit.as_ref().map(|m| m.map(|e| by.value(e))),
            refinements: self.refinements.iter().map(|r| r.lower(by)).collect(),
            jacobian: self.jacobian.map(|e| by.value(e)),
            residual: self.lowered_residual(by),
            scales: self.scales.clone(),
            curvature: self.curvature.map(|c| by.value(c)),
            judge: self.judge.as_ref().map(|j| j.lower(by)),
            path: self.path.clone(),
            fallback: self.fallback.clone(),
            needs_guess: self.needs_guess,
            iterates: self.iterates.clone(),
            solved: self.solved.clone(),
        }
    }
}

impl Condition<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Condition<L::Value> {
        Condition {
            value: by.value(self.value),
            is_closed: self.is_closed,
            text: self.text,
        }
    }
}

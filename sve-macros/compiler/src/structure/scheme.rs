//! A step as blocks that are solved in order.
//!
//! One tree for all later stages, generic in what stands for its quantities: expressions after this
//! stage, values of a program after scheduling ([`Lower`]). `R` is what stands for a residual,
//! which has a magnitude beside its value once it is scheduled. What a step computes only where its
//! fast path fails stays an expression; it is computed where it stands.

use super::enclosure::Enclosure;
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
    /// What the step returns of the configuration and of the momenta, see [`Returns`].
    pub(crate) dq: Vec<T>,
    pub(crate) dp: Vec<T>,
    /// What has to hold at the solution, so that L is defined there.
    pub(crate) domain: Vec<Condition<T>>,
    /// What must not be negative where a solution is accepted by the contraction of its iteration.
    pub(crate) guards: Vec<T>,
    /// `q₁ − q₀` and `p₁ − p₀` as the equations give them, for readers.
    pub(crate) increments: [Vec<Expr>; 2],
    /// What a step can tell beside its result, in the names of the solution: the multipliers of
    /// constraints, at the start and at the end.
    pub(crate) reported: Vec<Expr>,
}

/// What a step returns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Returns {
    /// `q₁ − q₀` and `p₁ − p₀`.
    Increment,
    /// `q₁` and `p₁`: a matrix that differs from step to step times the state, and an offset.
    State,
    /// `q₁ − q₀` and `p₁ − p₀` as a matrix, the same in all steps, times the state, and an offset.
    MatrixTimesState,
}

impl Returns {
    /// Returns whether the entries of a matrix are known before the state that it is applied to.
    pub(crate) fn is_matrix(self) -> bool {
        self != Self::Increment
    }
}

/// Equations that are solved together.
#[derive(Clone)]
pub(crate) struct Block<T, R = T> {
    pub(crate) kind: Kind,
    /// Unknowns, as the equations name them.
    pub(crate) unknowns: Vec<Symbol>,
    /// Entries of the Jacobian that are not zero.
    pub(crate) nonzeros: usize,
    /// The order of pivots, if the block has multipliers of constraints and such an order was
    /// found.
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

/// What there is to compute.
#[derive(Clone)]
pub(crate) enum Solution<T, R = T> {
    /// A single unknown by a formula, which has taken its place in everything that follows and is
    /// computed there.
    Formula(Expr),
    /// A linear system; `solved` are the names of the solution in everything that follows.
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

/// A later stage of a guess, with the same matrix as the first.
#[derive(Clone)]
pub(crate) struct Refinement<T> {
    /// Names in `rhs` of what the stages before found.
    pub(crate) first: Vec<Symbol>,
    pub(crate) rhs: Vec<T>,
}

/// Newton's method on a block.
#[derive(Clone)]
pub(crate) struct Iteration<T, R = T> {
    /// First guess.
    pub(crate) guess: Linear<T>,
    /// The Jacobian in the limit of no noise and h → 0, whose determinant has the sign of that of
    /// the solution. Nothing where it does not exist, wherever the system is: the mass vanishes at
    /// rest, as for L = v⁴/4.
    pub(crate) limit: Option<Matrix<T>>,
    /// What is added to the guess, stage by stage.
    pub(crate) refinements: Vec<Refinement<T>>,
    pub(crate) jacobian: Matrix<T>,
    pub(crate) residual: Vec<R>,
    /// What joins the magnitude of each residual, where its own terms may all be small. Empty if no
    /// equation has it.
    pub(crate) scales: Vec<Option<Expr>>,
    /// Second derivative of a single equation in a single unknown.
    pub(crate) curvature: Option<T>,
    /// What decides whether a solution is connected with its limit, where that can be bounded.
    pub(crate) judge: Option<Judge<T>>,
    /// The same for a block with multipliers of constraints. Its bounds are computed where the
    /// iteration does not contract enough.
    pub(crate) path: Option<PathJudge>,
    /// The guess after a failure: the Newton step from zero, which is the linearly implicit step.
    pub(crate) fallback: Linear<Expr>,
    /// True if the step fails where the matrix of the guess is singular: no other guess replaces
    /// it.
    pub(crate) needs_guess: bool,
    /// Names of the iterates in `residual`, `jacobian` and `curvature`.
    pub(crate) iterates: Vec<Symbol>,
    pub(crate) solved: Vec<Symbol>,
}

/// Turns the expressions of a scheme into something else, in the order of the calls.
pub(crate) trait Lower {
    type Value;
    type Residual;
    fn value(&mut self, expr: Expr) -> Self::Value;
    /// Returns a residual, and what joins the sum of the magnitudes of its terms.
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
        }
    }

    /// All that the fast path computes.
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

    /// All that is computed, where the fast path fails too.
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
        } = self;
        let mut exprs: Vec<&mut Expr> = dq
            .iter_mut()
            .chain(dp)
            .chain(reported)
            .chain(guards)
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
    /// Returns the band of its Jacobian, where not all entries are stored.
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
    /// Names of the solution in everything that follows; none where formulas have taken their
    /// place.
    pub(crate) fn solved(&self) -> &[Symbol] {
        match self {
            Self::Formula(_) => &[],
            Self::System { solved, .. } => solved,
            Self::Iteration(iteration) => &iteration.solved,
        }
    }
}

impl<T: PartialEq, R> Iteration<T, R> {
    /// Returns whether the limit is the solution that the first stage of the guess finds.
    pub(crate) fn limit_is_guess(&self, judge: &Judge<T>) -> bool {
        judge.limit_rhs == self.guess.rhs
    }
}

impl Linear<Expr> {
    /// Returns the stored entries of the matrix, and the right-hand side.
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

impl Enclosure<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Enclosure<L::Value> {
        Enclosure {
            middle: self.middle.map(|e| by.value(e)),
            radii: by.rows(&self.radii),
            conditions: by.values(&self.conditions),
        }
    }
}

impl Judge<Expr> {
    fn lower<L: Lower>(&self, by: &mut L) -> Judge<L::Value> {
        let bounds = self.bounds.lower(by);
        Judge {
            limit: self.limit.clone(),
            limit_rhs: by.values(&self.limit_rhs),
            bounds,
            full: self.full.clone(),
        }
    }
}

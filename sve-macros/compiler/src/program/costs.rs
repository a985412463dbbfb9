//! Counts of the operations of a step, for its plan: the operations of its program and of its
//! linear solves, and those that a trajectory saves.
//!
//! A sine and the cosine of the same angle count as one call. Comparisons, the choice of pivots,
//! tests for singular matrices, and the operations of Newton's method other than evaluations and
//! solves are not counted.

use std::iter::Sum;
use std::ops::Add;

use super::step::Step;
use super::{Carried, Factored, Operation, Program, Tier};
use crate::structure::{Band, Block, Matrix, Scheme, Solution, Storage};

/// Floating-point operations.
#[derive(Clone, Copy, Default)]
pub(crate) struct Operations {
    pub(crate) arithmetic: usize,
    pub(crate) transcendental: usize,
    pub(crate) angle_additions: usize,
}

/// The operations of a step: once for each step size, once for each step, and in each iteration.
pub(crate) struct Work {
    pub(crate) prepare: Operations,
    pub(crate) step: Operations,
    /// The operations of a step whose results a trajectory carries from the step before.
    pub(crate) carried: Operations,
    pub(crate) iteration: Operations,
}

impl Work {
    /// Counts the operations of a step.
    pub(crate) fn of(step: &Step, carried: Option<&Carried>) -> Self {
        let is_iteration = |tier| matches!(tier, Tier::Iterate(_));
        let of = |wanted: &dyn Fn(Tier) -> bool| Operations::of(&step.program, wanted);
        let work = Self {
            prepare: of(&|tier| tier == Tier::Prepare),
            step: of(&|t| t != Tier::Prepare && !is_iteration(t)),
            carried: carried.map_or_else(Operations::default, |carried| {
                let sources = carried.sources.iter();
                sources
                    .map(|&v| Operations::one(step.program.get(v).operation))
                    .sum()
            }),
            iteration: of(&is_iteration),
        };
        work.with_solves(&step.scheme, |block| block.factored(&step.program))
    }

    /// Adds the operations of the linear solves of a scheme, whose matrices are factored where
    /// `factored` says.
    pub(crate) fn with_solves<T: Copy + PartialEq, R>(
        self,
        scheme: &Scheme<T, R>,
        factored: impl Fn(&Block<T, R>) -> Factored,
    ) -> Self {
        let first: Vec<[usize; 2]> = scheme
            .blocks
            .iter()
            .map(|block| first_solves(block, factored(block)))
            .collect();
        let [prepare, once] = [0, 1].map(|part| first.iter().map(|counts| counts[part]).sum());
        let again = scheme.blocks.iter().map(solves_of_iteration).sum();
        Self {
            prepare: self.prepare + arithmetic(prepare),
            step: self.step + arithmetic(once),
            carried: self.carried,
            iteration: self.iteration + arithmetic(again),
        }
    }
}

impl Operations {
    /// Counts the operations of a program in the tiers for which `wanted` holds.
    pub(crate) fn of(program: &Program, wanted: impl Fn(Tier) -> bool) -> Self {
        let listed = program.all().filter(|(_, i)| wanted(i.tier));
        listed.map(|(_, i)| Self::one(i.operation)).sum()
    }

    fn one(operation: Operation) -> Self {
        let [arithmetic, transcendental, angle_additions] = match operation {
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_) => [0, 0, 0],
            Operation::Add(..)
            | Operation::Sub(..)
            | Operation::Mul(..)
            | Operation::Div(..)
            | Operation::Neg(_)
            | Operation::Abs(_)
            | Operation::Recip(_) => [1, 0, 0],
            Operation::Call(..) | Operation::Call2(..) | Operation::SinCos(_) => [0, 1, 0],
            Operation::AngleAddition(..) => [0, 0, 1],
        };
        Self {
            arithmetic,
            transcendental,
            angle_additions,
        }
    }
}

impl Add for Operations {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            arithmetic: self.arithmetic + other.arithmetic,
            transcendental: self.transcendental + other.transcendental,
            angle_additions: self.angle_additions + other.angle_additions,
        }
    }
}

impl Sum for Operations {
    fn sum<I: Iterator<Item = Self>>(all: I) -> Self {
        all.fold(Self::default(), Add::add)
    }
}

fn arithmetic(count: usize) -> Operations {
    Operations {
        arithmetic: count,
        ..Operations::default()
    }
}

/// Counts the operations of the linear solves of a block before any iteration: in `prepare`, and in
/// the step.
fn first_solves<T: Copy + PartialEq, R>(block: &Block<T, R>, factored: Factored) -> [usize; 2] {
    let Some(matrix) = block.solution.first_matrix() else {
        return [0, 0];
    };
    let (solves, once) = (block.solution.first_solves(), solve(matrix));
    let substitutions = solves * substitute(matrix.size());
    let [prepare, step] = match factored {
        Factored::Nowhere => [0, solves * once],
        Factored::InStep => [0, factor(matrix.size()) + substitutions],
        Factored::InPrepare => [factor(matrix.size()), substitutions],
    };
    // a later stage of a guess is added to the earlier ones
    let refinements = match &block.solution {
        Solution::Iteration(iteration) => iteration.refinements.as_slice(),
        _ => &[],
    };
    let sums: usize = refinements.iter().map(|r| r.rhs.len()).sum();
    [prepare, step + sums]
}

/// Counts the operations of factoring a dense matrix.
fn factor(k: usize) -> usize {
    elimination(k, |at| k - at - 1, |at| k - at - 1) - substitute(k)
}

/// Counts the operations of a solve with the factors of a dense matrix.
fn substitute(k: usize) -> usize {
    k * (2 * k - 1)
}

/// Counts the operations of the linear solves of a block in each iteration.
fn solves_of_iteration<T: Copy, R>(block: &Block<T, R>) -> usize {
    match &block.solution {
        Solution::Formula(_) | Solution::System { .. } => 0,
        Solution::Iteration(iteration) => solve(&iteration.jacobian),
    }
}

/// Counts the operations of the runtime's solve with a matrix.
fn solve<T: Copy>(matrix: &Matrix<T>) -> usize {
    let k = matrix.size();
    match (k, matrix.storage) {
        (0, _) => 0,
        (1, _) => 1,
        (_, Storage::Diagonal) => k,
        // Cramer's rule: the determinant, its reciprocal, two numerators with a product each
        (2, Storage::Dense) => 3 + 1 + 2 * 4,
        // three cross products, the determinant, its reciprocal, three numerators with a product
        // each
        (_, Storage::Cofactors) => 3 * 9 + 5 + 1 + 3 * 6,
        (_, Storage::Dense) => elimination(k, |at| k - at - 1, |at| k - at - 1),
        (_, Storage::Banded(band)) => {
            let Band { lower, .. } = band;
            elimination(k, |at| lower.min(k - at - 1), |_| band.width() - 1)
        }
    }
}

/// Counts the operations of an elimination. `below` is the number of rows below the pivot of a
/// column, `right` the number of entries to the right of the pivot in its row.
fn elimination(k: usize, below: impl Fn(usize) -> usize, right: impl Fn(usize) -> usize) -> usize {
    let column = |at: usize| {
        let forward = below(at) * (3 + 2 * right(at));
        let back = 2 * right(at).min(k - at - 1) + 1;
        forward + back
    };
    (0..k).map(column).sum()
}

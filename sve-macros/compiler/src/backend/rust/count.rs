//! Operations of a step, counted for its plan: those of its programs, and those of its linear solves.
//!
//! Output: counts as the runtime's `Operations`. A sine with its cosine is one call. Not counted: comparisons, the choice of
//! pivots, tests for singular matrices, and what Newton's method does beside evaluating and solving.

use std::iter::Sum;
use std::ops::Add;

use proc_macro2::TokenStream;
use quote::quote;

use crate::program::{Operation, Program, Tier};
use crate::structure::{Band, Block, Kind, Scheme, Solution};

/// Floating-point operations.
#[derive(Clone, Copy, Default)]
pub(super) struct Operations {
    arithmetic: usize,
    transcendental: usize,
    turns: usize,
}

/// The operations of a step by how often they are done.
pub(super) struct Work {
    pub(super) prepare: Operations,
    pub(super) step: Operations,
    pub(super) iteration: Operations,
}

impl Work {
    /// What one program in tiers does, without linear solves.
    pub(super) fn of(program: &Program) -> Self {
        let is_iteration = |tier| matches!(tier, Tier::Iterate(_));
        Self {
            prepare: Operations::of(program, |tier| tier == Tier::Prepare),
            step: Operations::of(program, |t| t != Tier::Prepare && !is_iteration(t)),
            iteration: Operations::of(program, is_iteration),
        }
    }

    /// With the linear solves of a scheme.
    pub(super) fn with_solves(self, scheme: &Scheme) -> Self {
        let once = scheme.blocks.iter().map(first_solves).sum();
        let newton = scheme.blocks.iter().filter(|b| b.kind == Kind::Newton);
        let again = newton.map(|b| solve(b.unknowns.len(), b.band)).sum();
        Self {
            prepare: self.prepare,
            step: self.step + arithmetic(once),
            iteration: self.iteration + arithmetic(again),
        }
    }
}

impl Operations {
    /// Those of some tiers.
    pub(super) fn of(program: &Program, wanted: impl Fn(Tier) -> bool) -> Self {
        let listed = program.all().filter(|(_, i)| wanted(i.tier));
        listed.map(|(_, i)| Self::one(i.operation)).sum()
    }

    fn one(operation: Operation) -> Self {
        let [arithmetic, transcendental, turns] = match operation {
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
            Operation::Turn(..) => [0, 0, 1],
        };
        Self {
            arithmetic,
            transcendental,
            turns,
        }
    }

    pub(super) fn tokens(self, private: &TokenStream) -> TokenStream {
        let Self {
            arithmetic,
            transcendental,
            turns,
        } = self;
        quote! {
            #private::Operations { arithmetic: #arithmetic, transcendental: #transcendental, angle_additions: #turns }
        }
    }
}

impl Add for Operations {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            arithmetic: self.arithmetic + other.arithmetic,
            transcendental: self.transcendental + other.transcendental,
            turns: self.turns + other.turns,
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

/// Operations of the solves of a block before any iteration.
fn first_solves(block: &Block) -> usize {
    let once = solve(block.unknowns.len(), block.band);
    match &block.solution {
        Solution::Formula(_) => 0,
        Solution::System { .. } => once,
        // the second stage of a guess has the matrix of the first, and is solved anew
        Solution::Iteration(iteration) => once + iteration.refinement.as_ref().map_or(0, |_| once),
    }
}

/// Operations of the runtime's solve with a matrix of `k` rows.
fn solve(k: usize, band: Option<Band>) -> usize {
    match (k, band) {
        (0, _) => 0,
        (1, _) => 1,
        // Cramer's rule: the determinant, its inverse, two numerators
        (2, None) => 3 + 1 + 2 * 4,
        _ => {
            // rows below a pivot, entries behind it in its row
            let below = |at: usize| band.map_or(k, |b| k.min(at + b.lower + 1)) - at - 1;
            let eliminated = |at: usize| band.map_or(k - at - 1, |b| b.width() - 1);
            let behind = |at: usize| eliminated(at).min(k - at - 1);
            let pivots = 0..k;
            pivots
                .map(|at| below(at) * (3 + 2 * eliminated(at)) + 2 * behind(at) + 1)
                .sum()
        }
    }
}

//! A scheduled step: the common input of the printers for single states and for lanes.
//!
//! Input: a scheme. Output: one program in tiers, the scheme with values in place of its
//! expressions, and labels of the values.

use std::collections::HashMap;

use super::labels::Labels;
use super::{Factored, Operation, Program, Scheduler, Tier, Tiers, Value};
use crate::algebra::{Arena, Expr};
use crate::model::Symbols;
use crate::structure::{Block, Iteration, Lower, Matrix, Returns, Scheme, Solution};

/// A scheduled step.
pub(crate) struct Step {
    pub(crate) scheme: Scheme<Value, Residual>,
    pub(crate) program: Program,
    pub(crate) labels: Labels,
    /// Entries of rotations at the end that the step computes, by their numbers in the
    /// configuration.
    pub(crate) turned: HashMap<usize, Value>,
}

/// A residual of an iteration.
pub(crate) struct Residual {
    pub(crate) expr: Expr,
    pub(crate) value: Value,
    /// The sum of the magnitudes of the residual's terms.
    pub(crate) magnitude: Value,
}

impl Lower for Scheduler<'_> {
    type Value = Value;
    type Residual = Residual;

    fn value(&mut self, expr: Expr) -> Value {
        Scheduler::value(self, expr)
    }

    fn residual(&mut self, expr: Expr, scale: Option<Expr>) -> Residual {
        let (value, magnitude) = Scheduler::residual(self, expr);
        let magnitude = match scale {
            Some(more) => {
                let more = Scheduler::value(self, more);
                self.push(Operation::Add(magnitude, more))
            }
            None => magnitude,
        };
        Residual {
            expr,
            value,
            magnitude,
        }
    }
}

impl Step {
    /// Schedules all expressions of a scheme in one program.
    pub(crate) fn new(scheme: &Scheme<Expr>, symbols: &Symbols, arena: &Arena) -> Self {
        let roots = scheme.roots();
        let mut scheduler = Scheduler::new(arena, symbols, tiers(&scheme.blocks), &roots);
        let lowered = scheme.lower(&mut scheduler);
        let mut labels = Labels::default();
        if scheme.returns.is_matrix() {
            let rows = [scheme.dq.as_slice(), &scheme.dp].concat();
            labels.map(&scheduler, &rows);
        }
        let formulas = formulas(&scheme.blocks, symbols);
        labels.expressions(&scheduler, &formulas);
        let mut first = 0;
        for block in &lowered.blocks {
            block.solution.label(first, &mut labels);
            first += block.unknowns.len();
        }
        let [q, p] = match scheme.returns {
            Returns::Increment | Returns::MatrixTimesState => ["dq", "dp"],
            Returns::State => ["q1", "p1"],
        };
        labels.vector(q, 0, &lowered.dq);
        labels.vector(p, 0, &lowered.dp);
        let turned = scheme.turned.iter();
        let turned = turned.filter_map(|&(entry, e)| Some((entry, scheduler.known(e)?)));
        Self {
            turned: turned.collect(),
            program: scheduler.finish(&results(&lowered, |_| true)),
            labels,
            scheme: lowered,
        }
    }

    /// Returns the values that the step uses outside of its instructions: in solves, in conditions
    /// and as results.
    pub(crate) fn results(&self) -> Vec<Value> {
        results(&self.scheme, |block| {
            block.factored(&self.program) != Factored::InPrepare
        })
    }
}

/// Every value that is used other than by an instruction; of first solves, the matrices of those
/// blocks whose matrix is wanted.
fn results(
    scheme: &Scheme<Value, Residual>,
    wants_matrix: impl Fn(&Block<Value, Residual>) -> bool,
) -> Vec<Value> {
    let solves = scheme.blocks.iter().flat_map(|block| {
        let s = &block.solution;
        let matrices = if wants_matrix(block) {
            s.matrices()
        } else {
            Vec::new()
        };
        [matrices, s.right_sides(), s.each(), s.after()]
    });
    let outputs = scheme.dq.iter().chain(&scheme.dp).copied();
    outputs
        .chain(scheme.domain.iter().map(|c| c.value))
        .chain(scheme.guards.iter().copied())
        .chain(solves.flatten())
        .collect()
}

/// Returns the tier of each unknown of the blocks.
fn tiers(blocks: &[Block<Expr>]) -> Tiers {
    let mut tiers = Tiers::new();
    for (at, block) in blocks.iter().enumerate() {
        let mut set = |symbols: &[_], tier| tiers.extend(symbols.iter().map(|&s| (s, tier)));
        set(block.solution.solved(), Tier::Solved(at));
        if let Solution::Iteration(iteration) = &block.solution {
            set(&iteration.iterates, Tier::Iterate(at));
            for (stage, refinement) in iteration.refinements.iter().enumerate() {
                set(&refinement.first, Tier::Guess(at, stage));
            }
            if let Some(judge) = &iteration.judge {
                // the limit is used together with the solution
                set(&judge.limit, Tier::Solved(at));
            }
        }
    }
    tiers
}

/// Returns the formulas of the unknowns that have one, with the names of these unknowns.
fn formulas(blocks: &[Block<Expr>], symbols: &Symbols) -> Vec<(Expr, String)> {
    let formula = |block: &Block<Expr>| match block.solution {
        Solution::Formula(formula) => Some((formula, symbols.name(block.unknowns[0]))),
        _ => None,
    };
    blocks.iter().filter_map(formula).collect()
}

impl Solution<Value, Residual> {
    /// Returns the values that solves before an iteration use.
    pub(crate) fn before(&self) -> Vec<Value> {
        [self.matrices(), self.right_sides()].concat()
    }

    /// Entries of the matrices of the solves before an iteration.
    fn matrices(&self) -> Vec<Value> {
        match self {
            Self::Formula(_) => Vec::new(),
            Self::System { linear, .. } => linear.matrix.stored().collect(),
            Self::Iteration(iteration) => {
                let limit = iteration.limit.iter().flat_map(Matrix::stored);
                iteration.guess.matrix.stored().chain(limit).collect()
            }
        }
    }

    /// Right-hand sides of the solves before an iteration.
    fn right_sides(&self) -> Vec<Value> {
        match self {
            Self::Formula(_) => Vec::new(),
            Self::System { linear, .. } => linear.rhs.clone(),
            Self::Iteration(iteration) => {
                let guess = iteration.guess.rhs.iter();
                let refined = iteration.refinements.iter().flat_map(|r| &r.rhs);
                let limit = iteration.judge.iter().flat_map(|j| &j.limit_rhs);
                guess.chain(refined).chain(limit).copied().collect()
            }
        }
    }

    /// Returns the values that the solve in each iteration uses.
    pub(crate) fn each(&self) -> Vec<Value> {
        match self {
            Self::Formula(_) | Self::System { .. } => Vec::new(),
            Self::Iteration(iteration) => {
                let residuals = iteration.residual.iter();
                let residuals = residuals.flat_map(|r| [r.value, r.magnitude]);
                let all = residuals.chain(iteration.jacobian.stored());
                all.chain(iteration.curvature).collect()
            }
        }
    }

    /// Returns the values by which a solution is judged after its iteration.
    pub(crate) fn after(&self) -> Vec<Value> {
        match self {
            Self::Formula(_) | Self::System { .. } => Vec::new(),
            Self::Iteration(iteration) => {
                let judge = iteration.judge.iter();
                judge.flat_map(|j| j.bounds.entries()).copied().collect()
            }
        }
    }

    /// Labels the values of a block, whose equations are counted from `first`.
    fn label(&self, first: usize, labels: &mut Labels) {
        match self {
            Self::Formula(_) => {}
            Self::System { linear, solved: _ } => {
                labels.matrix("matrix", first, &linear.matrix);
                labels.vector("rhs", first, &linear.rhs);
            }
            Self::Iteration(iteration) => iteration.label(first, labels),
        }
    }
}

impl Iteration<Value, Residual> {
    fn label(&self, first: usize, labels: &mut Labels) {
        let parts = |of: fn(&Residual) -> Value| self.residual.iter().map(of).collect::<Vec<_>>();
        labels.matrix("mass", first, &self.guess.matrix);
        labels.vector("residual", first, &parts(|r| r.value));
        labels.matrix("jacobian", first, &self.jacobian);
        if let Some(curvature) = self.curvature {
            labels.call(curvature, format!("curvature_{first}"));
        }
        labels.vector("guess_rhs", first, &self.guess.rhs);
        for refinement in &self.refinements {
            labels.vector("refinement_rhs", first, &refinement.rhs);
        }
        labels.vector("magnitude", first, &parts(|r| r.magnitude));
        if let Some(judge) = &self.judge {
            labels.vector("limit_rhs", first, &judge.limit_rhs);
            labels.matrix("middle", first, &judge.bounds.middle);
            labels.rows("radius", first, &judge.bounds.radii);
            labels.vector("distance", first, &judge.bounds.conditions);
        }
    }
}

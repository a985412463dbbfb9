//! A step with values for its expressions: what the printers of single states and of lanes have in common.
//!
//! Input: a scheme, and which of its linear systems an iteration starts from. Output: one program in tiers, with the values
//! that solves and results are made of, and names for them.

use super::names::Labels;
use crate::model::Symbols;
use crate::schedule::{Program, Scheduler, Tier, Tiers, Value};
use crate::structure::{Band, Block, Form, Iteration, Linear, Refinement, Scheme, Solution};
use crate::symbolic::{Arena, Expr};

/// Which linear system an iteration starts from.
pub(super) type Start = fn(&Iteration) -> &Linear;

/// A step.
pub(super) struct Step {
    pub(super) solves: Vec<Solve>,
    pub(super) dq: Vec<Value>,
    pub(super) dp: Vec<Value>,
    pub(super) program: Program,
    /// What the values are.
    pub(super) labels: Labels,
}

/// A block.
pub(super) enum Solve {
    Formula,
    System(System),
    Iteration(Box<Newton>),
}

/// A linear system.
pub(super) struct System {
    pub(super) matrix: Matrix,
    pub(super) rhs: Vec<Value>,
}

/// The entries of a matrix, of its band where it has one.
pub(super) struct Matrix {
    pub(super) rows: Vec<Vec<Value>>,
    pub(super) band: Option<Band>,
}

/// An iteration.
pub(super) struct Newton {
    pub(super) guess: System,
    /// Right-hand side of the second stage of the guess.
    pub(super) refinement: Option<Vec<Value>>,
    pub(super) residual: Vec<Value>,
    pub(super) magnitude: Vec<Value>,
    pub(super) jacobian: Matrix,
    pub(super) curvature: Option<Value>,
}

impl Step {
    /// Turns all expressions of a scheme into one program.
    pub(super) fn new(scheme: &Scheme, start: Start, symbols: &Symbols, arena: &Arena) -> Self {
        let Scheme {
            blocks,
            dq,
            dp,
            form,
            increments: _,
        } = scheme;
        let (tiers, all) = wanted(scheme, start);
        let mut scheduler = Scheduler::new(arena, symbols, tiers, &all);
        let solves: Vec<Solve> = blocks
            .iter()
            .map(|block| Solve::new(block, start, &mut scheduler))
            .collect();
        let rows = [dq.as_slice(), dp].concat();
        let (dq, dp) = (scheduler.values(dq), scheduler.values(dp));
        let mut labels = Labels::default();
        if scheme.is_matrix() {
            labels.map(&scheduler, arena, symbols, &rows);
        }
        labels.expressions(&scheduler, arena, symbols, &formulas(blocks, symbols), &all);
        let mut first = 0;
        for (solve, block) in solves.iter().zip(blocks) {
            solve.label(first, &mut labels);
            first += block.unknowns.len();
        }
        let [q, p] = match form {
            Form::Increment => ["dq", "dp"],
            Form::State => ["q1", "p1"],
        };
        labels.vector(q, 0, &dq);
        labels.vector(p, 0, &dp);
        let results = results(&solves, &dq, &dp);
        Self {
            program: scheduler.finish(&results),
            labels,
            solves,
            dq,
            dp,
        }
    }

    /// Every value that is used other than by an instruction.
    pub(super) fn results(&self) -> Vec<Value> {
        results(&self.solves, &self.dq, &self.dp)
    }
}

fn results(solves: &[Solve], dq: &[Value], dp: &[Value]) -> Vec<Value> {
    let solves = solves.iter().flat_map(|s| [s.begin(), s.iterate()]);
    dq.iter()
        .chain(dp)
        .copied()
        .chain(solves.flatten())
        .collect()
}

/// When the unknowns of the blocks are known, and all that is to be computed.
fn wanted(scheme: &Scheme, start: Start) -> (Tiers, Vec<Expr>) {
    let mut tiers = Tiers::new();
    let mut all: Vec<Expr> = [scheme.dq.as_slice(), &scheme.dp].concat();
    for (at, block) in scheme.blocks.iter().enumerate() {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(linear.matrix.iter().flatten().chain(&linear.rhs));
            }
            Solution::Iteration(iteration) => {
                let guess = start(iteration);
                let Iteration {
                    guess: _,
                    refinement,
                    fallback: _,
                    singular_at_rest: _,
                    residual,
                    jacobian,
                    curvature,
                    iterates,
                    solved,
                } = &**iteration;
                if let Some(Refinement { first, rhs }) = refinement {
                    tiers.extend(first.iter().map(|&s| (s, Tier::Guess(at))));
                    all.extend(rhs);
                }
                tiers.extend(iterates.iter().map(|&s| (s, Tier::Iterate(at))));
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                let matrices = guess.matrix.iter().chain(jacobian).flatten();
                all.extend(matrices.chain(&guess.rhs).chain(residual).chain(curvature));
            }
        }
    }
    (tiers, all)
}

/// The unknowns that have formulas, which bear their names.
fn formulas(blocks: &[Block], symbols: &Symbols) -> Vec<(Expr, String)> {
    let formula = |block: &Block| match block.solution {
        Solution::Formula(formula) => Some((formula, symbols.name(block.unknowns[0]))),
        _ => None,
    };
    blocks.iter().filter_map(formula).collect()
}

impl Solve {
    fn new(block: &Block, start: Start, scheduler: &mut Scheduler<'_>) -> Self {
        match &block.solution {
            Solution::Formula(_) => Self::Formula,
            Solution::System { linear, solved: _ } => Self::System(System::new(linear, scheduler)),
            Solution::Iteration(iteration) => {
                let guess = System::new(start(iteration), scheduler);
                let refinement = iteration.refinement.as_ref();
                let refinement = refinement.map(|r| scheduler.values(&r.rhs));
                let jacobian = Matrix::new(&iteration.jacobian, scheduler);
                let residuals = iteration.residual.iter();
                let (residual, magnitude) = residuals.map(|&r| scheduler.residual(r)).unzip();
                Self::Iteration(Box::new(Newton {
                    guess,
                    refinement,
                    residual,
                    magnitude,
                    jacobian,
                    curvature: iteration.curvature.map(|c| scheduler.value(c)),
                }))
            }
        }
    }

    /// Values that are used before an iteration, other than by instructions.
    pub(super) fn begin(&self) -> Vec<Value> {
        match self {
            Self::Formula => Vec::new(),
            Self::System(system) => system.values().collect(),
            Self::Iteration(newton) => {
                let refined = newton.refinement.iter().flatten().copied();
                newton.guess.values().chain(refined).collect()
            }
        }
    }

    /// Values that are used in each iteration, other than by instructions.
    pub(super) fn iterate(&self) -> Vec<Value> {
        match self {
            Self::Formula | Self::System(_) => Vec::new(),
            Self::Iteration(newton) => {
                let Newton {
                    guess: _,
                    refinement: _,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                } = &**newton;
                let vectors = residual.iter().chain(magnitude);
                let all = vectors.chain(jacobian.rows.iter().flatten());
                all.chain(curvature).copied().collect()
            }
        }
    }

    /// Says what the values of a block are, its equations counted from `first`.
    fn label(&self, first: usize, labels: &mut Labels) {
        match self {
            Self::Formula => {}
            Self::System(System { matrix, rhs }) => {
                matrix.label("matrix", first, labels);
                labels.vector("rhs", first, rhs);
            }
            Self::Iteration(newton) => {
                let Newton {
                    guess,
                    refinement,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                } = &**newton;
                guess.matrix.label("mass", first, labels);
                labels.vector("residual", first, residual);
                jacobian.label("jacobian", first, labels);
                if let Some(curvature) = curvature {
                    labels.call(*curvature, format!("curvature_{first}"));
                }
                labels.vector("guess_rhs", first, &guess.rhs);
                if let Some(rhs) = refinement {
                    labels.vector("refinement_rhs", first, rhs);
                }
                labels.vector("magnitude", first, magnitude);
            }
        }
    }
}

impl System {
    fn new(linear: &Linear, scheduler: &mut Scheduler<'_>) -> Self {
        Self {
            matrix: Matrix::new(&linear.matrix, scheduler),
            rhs: scheduler.values(&linear.rhs),
        }
    }

    fn values(&self) -> impl Iterator<Item = Value> + '_ {
        self.matrix.rows.iter().flatten().chain(&self.rhs).copied()
    }
}

impl Matrix {
    fn new(entries: &[Vec<Expr>], scheduler: &mut Scheduler<'_>) -> Self {
        let (band, entries) = banded(entries, scheduler.arena());
        Self {
            rows: entries.iter().map(|row| scheduler.values(row)).collect(),
            band,
        }
    }

    /// Says what the entries are, their rows and columns counted from `first`.
    fn label(&self, name: &str, first: usize, labels: &mut Labels) {
        let Some(band) = self.band else {
            labels.matrix(name, first, &self.rows);
            return;
        };
        for (i, row) in self.rows.iter().enumerate() {
            let begin = band.begin(i);
            for (k, &value) in row.iter().enumerate() {
                labels.call(value, format!("{name}_{}_{}", first + i, first + begin + k));
            }
        }
    }
}

/// A matrix as its band, if it has one, else as it is.
pub(super) fn banded<'a>(
    matrix: &'a [Vec<Expr>],
    arena: &Arena,
) -> (Option<Band>, std::borrow::Cow<'a, [Vec<Expr>]>) {
    let is_zero = |e: &&Expr| arena.constant_value(**e) == Some(0.0);
    match (
        Band::of(matrix, arena),
        matrix.iter().flatten().find(is_zero),
    ) {
        (Some(band), Some(&zero)) => (Some(band), band.rows(matrix, zero).into()),
        _ => (None, matrix.into()),
    }
}

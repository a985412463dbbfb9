//! A step with values for its expressions: what the printers of single states and of lanes have in common.
//!
//! Input: a scheme, and which of its linear systems an iteration starts from. Output: one program in tiers, with the values
//! that solves and results are made of, and names for them.

use super::names::Labels;
use crate::algebra::{Arena, Expr};
use crate::program::{Program, Scheduler, Tier, Tiers, Value};
use crate::structure::{
    Band, Block, Enclosure, Form, Iteration, Judge, Linear, Refinement, Scheme, Solution,
};
use crate::system::model::Symbols;

/// What of an iteration is printed in the main program of a step.
#[derive(Clone, Copy)]
pub(super) struct Chosen {
    /// The linear system that it starts from.
    pub(super) start: fn(&Iteration) -> &Linear,
    /// The bounds that judge its solution.
    pub(super) bounds: fn(&Judge) -> &Enclosure,
}

/// A step.
pub(super) struct Step {
    pub(super) solves: Vec<Solve>,
    pub(super) dq: Vec<Value>,
    pub(super) dp: Vec<Value>,
    /// What has to be positive, with whether 0 is allowed.
    pub(super) domain: Vec<(Value, bool)>,
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
    /// The Jacobian in the limit of no noise and h → 0, where it exists: its determinant has the sign of that of the solution.
    pub(super) origin: Option<Matrix>,
    /// Right-hand side of the second stage of the guess.
    pub(super) refinement: Option<Vec<Value>>,
    pub(super) residual: Vec<Value>,
    pub(super) magnitude: Vec<Value>,
    pub(super) jacobian: Matrix,
    pub(super) curvature: Option<Value>,
    pub(super) judge: Option<Verdict>,
}

/// What decides whether a solution is connected with its limit.
pub(super) struct Verdict {
    /// Right-hand side of the limit where it is not the guess.
    pub(super) limit_rhs: Option<Vec<Value>>,
    pub(super) middle: Vec<Vec<Value>>,
    pub(super) radii: Vec<Vec<Value>>,
    pub(super) conditions: Vec<Value>,
}

impl Verdict {
    fn new(
        judge: &Judge,
        chosen: Chosen,
        iteration: &Iteration,
        scheduler: &mut Scheduler<'_>,
    ) -> Self {
        let Enclosure {
            middle,
            radii,
            conditions,
        } = (chosen.bounds)(judge);
        let mut rows = |matrix: &[Vec<Expr>]| -> Vec<Vec<Value>> {
            matrix.iter().map(|row| scheduler.values(row)).collect()
        };
        let (middle, radii) = (rows(middle), rows(radii));
        let differs = judge.limit_rhs != (chosen.start)(iteration).rhs;
        Self {
            limit_rhs: differs.then(|| scheduler.values(&judge.limit_rhs)),
            middle,
            radii,
            conditions: scheduler.values(conditions),
        }
    }

    /// Values that are used once a solution is found.
    fn values(&self) -> impl Iterator<Item = Value> + '_ {
        let entries = self.middle.iter().chain(&self.radii).flatten();
        entries.chain(&self.conditions).copied()
    }
}

impl Step {
    /// Turns all expressions of a scheme into one program.
    pub(super) fn new(scheme: &Scheme, chosen: Chosen, symbols: &Symbols, arena: &Arena) -> Self {
        let Scheme {
            blocks,
            dq,
            dp,
            form,
            domain,
            increments: _,
        } = scheme;
        let (tiers, all) = wanted(scheme, chosen);
        let mut scheduler = Scheduler::new(arena, symbols, tiers, &all);
        let solves: Vec<Solve> = blocks
            .iter()
            .map(|block| Solve::new(block, chosen, &mut scheduler))
            .collect();
        let rows = [dq.as_slice(), dp].concat();
        let (dq, dp) = (scheduler.values(dq), scheduler.values(dp));
        let domain: Vec<(Value, bool)> = domain
            .iter()
            .map(|c| (scheduler.value(c.value), c.is_closed))
            .collect();
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
        let results = results(&solves, &dq, &dp, &domain);
        Self {
            program: scheduler.finish(&results),
            labels,
            solves,
            dq,
            dp,
            domain,
        }
    }

    /// Every value that is used other than by an instruction.
    pub(super) fn results(&self) -> Vec<Value> {
        results(&self.solves, &self.dq, &self.dp, &self.domain)
    }
}

fn results(solves: &[Solve], dq: &[Value], dp: &[Value], domain: &[(Value, bool)]) -> Vec<Value> {
    let solves = solves
        .iter()
        .flat_map(|s| [s.begin(), s.iterate(), s.judge()]);
    dq.iter()
        .chain(dp)
        .copied()
        .chain(domain.iter().map(|c| c.0))
        .chain(solves.flatten())
        .collect()
}

/// When the unknowns of the blocks are known, and all that is to be computed.
fn wanted(scheme: &Scheme, chosen: Chosen) -> (Tiers, Vec<Expr>) {
    let mut tiers = Tiers::new();
    let mut all: Vec<Expr> = [scheme.dq.as_slice(), &scheme.dp].concat();
    all.extend(scheme.domain.iter().map(|condition| condition.value));
    for (at, block) in scheme.blocks.iter().enumerate() {
        match &block.solution {
            Solution::Formula(_) => {}
            Solution::System { linear, solved } => {
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                all.extend(linear.matrix.iter().flatten().chain(&linear.rhs));
            }
            Solution::Iteration(iteration) => {
                let guess = (chosen.start)(iteration);
                let Iteration {
                    guess: limit,
                    refinement,
                    fallback: _,
                    singular_at_rest: _,
                    residual,
                    jacobian,
                    curvature,
                    judge,
                    iterates,
                    solved,
                } = &**iteration;
                if let Some(judge) = judge {
                    // together with the solution
                    tiers.extend(judge.limit.iter().map(|&s| (s, Tier::Solved(at))));
                    all.extend((chosen.bounds)(judge).exprs());
                    all.extend(&judge.limit_rhs);
                }
                if let Some(Refinement { first, rhs }) = refinement {
                    tiers.extend(first.iter().map(|&s| (s, Tier::Guess(at))));
                    all.extend(rhs);
                }
                tiers.extend(iterates.iter().map(|&s| (s, Tier::Iterate(at))));
                tiers.extend(solved.iter().map(|&s| (s, Tier::Solved(at))));
                if !std::ptr::eq(guess, limit) {
                    all.extend(limit.matrix.iter().flatten());
                }
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
    fn new(block: &Block, chosen: Chosen, scheduler: &mut Scheduler<'_>) -> Self {
        match &block.solution {
            Solution::Formula(_) => Self::Formula,
            Solution::System { linear, solved: _ } => Self::System(System::new(linear, scheduler)),
            Solution::Iteration(iteration) => {
                let guess = System::new((chosen.start)(iteration), scheduler);
                let origin = (!iteration.singular_at_rest)
                    .then(|| Matrix::new(&iteration.guess.matrix, scheduler));
                let refinement = iteration.refinement.as_ref();
                let refinement = refinement.map(|r| scheduler.values(&r.rhs));
                let jacobian = Matrix::new(&iteration.jacobian, scheduler);
                let residuals = iteration.residual.iter();
                let (residual, magnitude) = residuals.map(|&r| scheduler.residual(r)).unzip();
                let curvature = iteration.curvature.map(|c| scheduler.value(c));
                let judge = iteration.judge.as_ref();
                let judge = judge.map(|j| Verdict::new(j, chosen, iteration, scheduler));
                Self::Iteration(Box::new(Newton {
                    guess,
                    origin,
                    refinement,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                    judge,
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
                let origin = newton.origin.iter().flat_map(|m| &m.rows).flatten();
                let guess = newton.guess.values().chain(origin.copied());
                let limit = newton.judge.iter().flat_map(|j| &j.limit_rhs).flatten();
                guess.chain(refined).chain(limit.copied()).collect()
            }
        }
    }

    /// Values that are used after an iteration to judge its solution.
    pub(super) fn judge(&self) -> Vec<Value> {
        match self {
            Self::Formula | Self::System(_) => Vec::new(),
            Self::Iteration(newton) => newton.judge.iter().flat_map(Verdict::values).collect(),
        }
    }

    /// Values that are used in each iteration, other than by instructions.
    pub(super) fn iterate(&self) -> Vec<Value> {
        match self {
            Self::Formula | Self::System(_) => Vec::new(),
            Self::Iteration(newton) => {
                let Newton {
                    guess: _,
                    origin: _,
                    refinement: _,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                    judge: _,
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
                    origin: _,
                    refinement,
                    residual,
                    magnitude,
                    jacobian,
                    curvature,
                    judge,
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
                if let Some(Verdict {
                    limit_rhs,
                    middle,
                    radii,
                    conditions,
                }) = judge
                {
                    labels.vector("limit_rhs", first, limit_rhs.as_deref().unwrap_or_default());
                    labels.matrix("middle", first, middle);
                    labels.matrix("radius", first, radii);
                    labels.vector("distance", first, conditions);
                }
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

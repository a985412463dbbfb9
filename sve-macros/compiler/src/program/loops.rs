//! How the step of many states at once is cut into loops over its lanes.
//!
//! Input: a scheme. Output: its program, and the loops; or nothing for a system that is too large for lanes. The code is cut where
//! an iteration begins and ends. A value that a later loop needs is kept in an array over the lanes.

use std::collections::BTreeMap;

use super::step::Step;
use super::{Operation, Tier, Value, operands};
use crate::algebra::{Arena, Expr};
use crate::structure::{Block, Matrix, Scheme, Solution, Storage};
use crate::system::model::Symbols;

/// Unknowns of a block up to which it is solved in lanes.
const UNKNOWNS: usize = 6;

/// Instructions up to which a step is written for lanes: beyond, its values fit neither registers nor the first cache.
const INSTRUCTIONS: usize = 1500;

/// Values kept between loops, likewise.
const KEPT: usize = 96;

/// The step of a scheme in lanes, where it is small enough.
pub(crate) fn in_lanes(
    scheme: &Scheme<Expr>,
    symbols: &Symbols,
    arena: &Arena,
) -> Option<(Step, Loops)> {
    if !scheme.blocks.iter().all(fits) {
        return None;
    }
    let step = Step::new(&for_lanes(scheme), symbols, arena);
    if step.program.all().count() > INSTRUCTIONS {
        return None;
    }
    let loops = Loops::new(&step);
    (loops.rows.len() <= KEPT).then_some((step, loops))
}

/// Whether a block is small, its Jacobian dense and no matrix banded, and its solution judged where it is iterated: only the scalar
/// step can follow a solution.
fn fits(block: &Block<Expr>) -> bool {
    let is_banded = |matrix: &Matrix<Expr>| matches!(matrix.storage, Storage::Banded(_));
    let fits = match &block.solution {
        Solution::Formula(_) => true,
        Solution::System { linear, .. } => !is_banded(&linear.matrix),
        Solution::Iteration(iteration) => {
            iteration.judge.is_some()
                && iteration.jacobian.storage == Storage::Dense
                && !is_banded(&iteration.guess.matrix)
        }
    };
    fits && block.unknowns.len() <= UNKNOWNS
}

/// The scheme in lanes, which handle no failure: the best bounds judge its solutions, and a single unknown starts from the linearly
/// implicit step. That step is second order in h and worth its division, since a lane waits for the slowest of all, and two
/// evaluations are enough mostly.
fn for_lanes(scheme: &Scheme<Expr>) -> Scheme<Expr> {
    let mut scheme = scheme.clone();
    for block in &mut scheme.blocks {
        let Solution::Iteration(iteration) = &mut block.solution else {
            continue;
        };
        if iteration.iterates.len() == 1 {
            iteration.guess = iteration.fallback.clone();
        }
        if let Some(judge) = &mut iteration.judge
            && let Some(full) = judge.full.take()
        {
            judge.bounds = full;
        }
    }
    scheme
}

/// Which loop computes and which one uses a value. The loops are numbered in order: 0 up to the first iteration, 1 the
/// iteration, 2 from there to the next, …
pub(crate) struct Loops {
    /// The loop before or at which each block stands.
    pub(crate) of_block: Vec<usize>,
    /// For each loop, the values of earlier ones that it uses, in order.
    pub(crate) uses: Vec<Vec<Value>>,
    /// Their rows in `kept`; inputs are read again.
    pub(crate) rows: BTreeMap<Value, usize>,
}

impl Loops {
    fn new(step: &Step) -> Self {
        let scheme = &step.scheme;
        let mut of_block = Vec::new();
        let mut current = 0;
        for block in &scheme.blocks {
            of_block.push(current);
            if matches!(block.solution, Solution::Iteration(_)) {
                current += 2;
            }
        }
        let mut loops = Self {
            of_block,
            uses: vec![Vec::new(); current + 1],
            rows: BTreeMap::new(),
        };
        for (_, instruction) in step.program.all() {
            let user = loops.of_tier(instruction.tier, step);
            for operand in operands(instruction.operation) {
                loops.note(operand, user, step);
            }
        }
        for (at, block) in scheme.blocks.iter().enumerate() {
            let begin = loops.of_block[at];
            for value in block.solution.before() {
                loops.note(value, Some(begin), step);
            }
            for value in block.solution.each() {
                loops.note(value, Some(begin + 1), step);
            }
        }
        for (at, block) in scheme.blocks.iter().enumerate() {
            let end = loops.of_block[at] + 2;
            for value in block.solution.after() {
                loops.note(value, Some(end), step);
            }
        }
        let domain = scheme.domain.iter().map(|c| &c.value);
        for &value in scheme.dq.iter().chain(&scheme.dp).chain(domain) {
            loops.note(value, Some(current), step);
        }
        for uses in &mut loops.uses {
            uses.sort_unstable();
            uses.dedup();
        }
        loops
    }

    /// The loop in which values of a tier are computed; none where they are before all lanes.
    pub(crate) fn of_tier(&self, tier: Tier, step: &Step) -> Option<usize> {
        let iterates =
            |at: usize| matches!(step.scheme.blocks[at].solution, Solution::Iteration(_));
        let after = |at: usize| if iterates(at) { 2 } else { 0 };
        match tier {
            Tier::Prepare => None,
            Tier::Noise | Tier::State => Some(0),
            Tier::Guess(at) => Some(self.of_block[at]),
            Tier::Iterate(at) => Some(self.of_block[at] + 1),
            Tier::Solved(at) => Some(self.of_block[at] + after(at)),
        }
    }

    /// Notes that a loop uses a value.
    fn note(&mut self, value: Value, user: Option<usize>, step: &Step) {
        let instruction = step.program.get(value);
        let (Some(user), Some(computed)) = (user, self.of_tier(instruction.tier, step)) else {
            return;
        };
        if user == computed || matches!(instruction.operation, Operation::Constant(_)) {
            return;
        }
        self.uses[user].push(value);
        let next = self.rows.len();
        self.rows.entry(value).or_insert(next);
    }
}

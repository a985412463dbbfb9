//! The loops over the lanes in a step of many states.
//!
//! Input: a scheme. Output: its program and its loops, or `None` if the system is too large for
//! lanes. A loop ends where an iteration begins or ends. A value that a later loop uses is kept in
//! an array over the lanes.

use std::collections::{BTreeMap, BTreeSet};

use super::limits::in_lanes as limits;
use super::step::Step;
use super::{Operation, Tier, Value, operands};
use crate::algebra::{Arena, Expr};
use crate::model::Symbols;
use crate::structure::{Block, Matrix, Scheme, Solution, Storage};

/// Returns the step of a scheme in lanes, or `None` if the step is too large.
pub(crate) fn in_lanes(
    scheme: &Scheme<Expr>,
    symbols: &Symbols,
    arena: &Arena,
) -> Option<(Step, Loops)> {
    if !scheme
        .blocks
        .iter()
        .all(|block| fits(block, scheme.is_constrained(), arena))
    {
        return None;
    }
    let step = Step::new(&for_lanes(scheme), symbols, arena);
    if step.program.all().count() > limits::INSTRUCTIONS {
        return None;
    }
    let loops = Loops::new(&step);
    (loops.rows.len() <= limits::KEPT).then_some((step, loops))
}

/// Returns whether a block can be solved in lanes: it is small, its Jacobian is dense, and no
/// matrix is banded. If the block is iterated, bounds must judge its solution, since only the
/// scalar step can follow a solution by continuation. A block with multipliers of constraints is
/// accepted by the path of its iteration, in lanes as in the scalar step; it needs an order of
/// pivots.
fn fits(block: &Block<Expr>, is_constrained: bool, arena: &Arena) -> bool {
    let is_banded = |matrix: &Matrix<Expr>| matches!(matrix.storage, Storage::Banded(_));
    let has_pivots = |matrix: &Matrix<Expr>| {
        let pivots = block.pivots.as_ref();
        matrix.size() <= limits::BY_FORMULA
            || pivots.is_some_and(|pivots| pivots.suit(matrix, arena))
    };
    let (fits, largest) = match &block.solution {
        Solution::Formula(_) => (true, limits::UNKNOWNS),
        Solution::System { linear, .. } if is_constrained => {
            (has_pivots(&linear.matrix), limits::CONSTRAINED)
        }
        Solution::System { linear, .. } => (!is_banded(&linear.matrix), limits::UNKNOWNS),
        Solution::Iteration(iteration) if iteration.needs_guess => (
            has_pivots(&iteration.guess.matrix) && has_pivots(&iteration.jacobian),
            limits::CONSTRAINED,
        ),
        Solution::Iteration(iteration) => (
            iteration.judge.is_some()
                && iteration.jacobian.storage == Storage::Dense
                && !is_banded(&iteration.guess.matrix),
            limits::UNKNOWNS,
        ),
    };
    fits && block.unknowns.len() <= largest
}

/// Returns the variant of a scheme that is used in lanes. Lanes have no second attempt after a
/// failure, so the tightest bounds judge their solutions.
fn for_lanes(scheme: &Scheme<Expr>) -> Scheme<Expr> {
    let mut scheme = scheme.clone();
    for block in &mut scheme.blocks {
        let Solution::Iteration(iteration) = &mut block.solution else {
            continue;
        };
        if let Some(judge) = &mut iteration.judge
            && let Some(full) = judge.full.take()
        {
            judge.bounds = full;
        }
    }
    scheme
}

/// Returns whether a block is iterated in a single unknown whose root is accepted by bounds. The
/// evaluation at its guess belongs to the loop before its iteration.
pub(crate) fn is_single<E, R>(solution: &Solution<E, R>) -> bool {
    match solution {
        Solution::Iteration(iteration) => iteration.iterates.len() == 1 && !iteration.needs_guess,
        Solution::Formula(_) | Solution::System { .. } => false,
    }
}

/// The loops that compute and use each value. Loop 0 runs up to the first iteration, loop 1 is this
/// iteration, loop 2 runs from there to the second iteration, and so on.
pub(crate) struct Loops {
    /// For each block, the loop that ends where the iteration of the block begins. A block without
    /// iteration is in this loop.
    pub(crate) of_block: Vec<usize>,
    /// For each loop, the values of earlier loops that it uses, in order.
    pub(crate) uses: Vec<Vec<Value>>,
    /// The row of each of these values in the array `kept`. Inputs have rows too, but are read
    /// again.
    pub(crate) rows: BTreeMap<Value, usize>,
    /// The angle additions whose base moves to the guess, each with its base. Sine and cosine of
    /// the base itself are not needed.
    pub(crate) moved: BTreeMap<Value, Value>,
    /// The values that are not needed since a base moves.
    pub(crate) omitted: BTreeSet<Value>,
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
            moved: BTreeMap::new(),
            omitted: BTreeSet::new(),
        };
        loops.move_bases(step);
        loops.note_operands(step);
        loops.note_solves(step);
        let domain = scheme.domain.iter().map(|c| &c.value);
        let results = scheme.dq.iter().chain(&scheme.dp).chain(&scheme.guards);
        for &value in results.chain(domain) {
            loops.note(value, Some(current), step);
        }
        for uses in &mut loops.uses {
            uses.sort_unstable();
            uses.dedup();
        }
        loops
    }

    /// Records the values that instructions use.
    fn note_operands(&mut self, step: &Step) {
        for (value, instruction) in step.program.all() {
            if self.omitted.contains(&value) {
                continue;
            }
            let user = self.of_tier(instruction.tier, step);
            let guess = evaluated_at_guess(instruction.tier, step);
            for operand in operands(instruction.operation) {
                if !self.omitted.contains(&operand) {
                    self.note(operand, user, step);
                    self.note_at_guess(operand, guess, step);
                }
            }
            if let Some(&base) = self.moved.get(&value) {
                self.note_at_guess(base, guess, step);
            }
        }
    }

    /// Records the values that the solves of the blocks use.
    fn note_solves(&mut self, step: &Step) {
        let blocks = &step.scheme.blocks;
        for (at, block) in blocks.iter().enumerate() {
            let begin = self.of_block[at];
            if is_single(&block.solution) {
                for value in block.solution.each() {
                    self.note_at_guess(value, Some(at), step);
                }
            }
            for value in block.solution.before() {
                self.note(value, Some(begin), step);
            }
            for value in block.solution.each() {
                self.note(value, Some(begin + 1), step);
            }
        }
        for (at, block) in blocks.iter().enumerate() {
            let end = self.of_block[at] + 2;
            for value in block.solution.after() {
                self.note(value, Some(end), step);
            }
        }
    }

    /// Returns the loop in which values of a tier are computed; `None` if they are computed once
    /// for all lanes.
    pub(crate) fn of_tier(&self, tier: Tier, step: &Step) -> Option<usize> {
        let iterates =
            |at: usize| matches!(step.scheme.blocks[at].solution, Solution::Iteration(_));
        let after = |at: usize| if iterates(at) { 2 } else { 0 };
        match tier {
            Tier::Prepare => None,
            Tier::Noise | Tier::State => Some(0),
            Tier::Guess(at, _) => Some(self.of_block[at]),
            Tier::Iterate(at) => Some(self.of_block[at] + 1),
            Tier::Solved(at) => Some(self.of_block[at] + after(at)),
        }
    }

    /// Finds the angle additions of blocks in a single unknown whose base has no other use, so that
    /// the angle at the guess can be the base.
    fn move_bases(&mut self, step: &Step) {
        let program = &step.program;
        let mut used: BTreeSet<Value> = step.results().into_iter().collect();
        let mut candidates = Vec::new();
        for (value, instruction) in program.all() {
            match instruction.operation {
                Operation::AngleAddition(sin, cos, by)
                    if evaluated_at_guess(instruction.tier, step).is_some() =>
                {
                    candidates.push((value, sin, cos));
                    used.insert(by);
                }
                Operation::SinOf(_) | Operation::CosOf(_) => {}
                operation => used.extend(operands(operation)),
            }
        }
        for (value, sin, cos) in candidates {
            let (Operation::SinOf(pair), Operation::CosOf(other)) =
                (program.get(sin).operation, program.get(cos).operation)
            else {
                continue;
            };
            let Operation::SinCos(base) = program.get(pair).operation else {
                continue;
            };
            let is_of_lane = self.of_tier(program.get(pair).tier, step).is_some();
            if pair == other && is_of_lane && ![sin, cos, pair].iter().any(|x| used.contains(x)) {
                self.moved.insert(value, base);
                self.omitted.extend([sin, cos, pair]);
            }
        }
    }

    /// Records that the evaluation of a block at its guess uses a value.
    fn note_at_guess(&mut self, value: Value, block: Option<usize>, step: &Step) {
        let Some(at) = block else {
            return;
        };
        if step.program.get(value).tier != Tier::Iterate(at) {
            self.note(value, Some(self.of_block[at]), step);
        }
    }

    /// Records that a loop uses a value.
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

/// Returns the block in a single unknown that values of a tier are computed for, first at its
/// guess.
fn evaluated_at_guess(tier: Tier, step: &Step) -> Option<usize> {
    match tier {
        Tier::Iterate(at) if is_single(&step.scheme.blocks[at].solution) => Some(at),
        _ => None,
    }
}

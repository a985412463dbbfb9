//! Straight-line code: two-operand instructions, each with the tier in which it is computed.
//!
//! Invariant: an instruction's operands precede it and are of its tier or an earlier one.

use crate::algebra::{Binary, Function, Map, Symbol};

/// When a value is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Tier {
    /// From parameters and step size alone.
    Prepare,
    /// With time and Wiener increments.
    Noise,
    /// With the state.
    State,
    /// With the first stage of a block's guess.
    Guess(usize),
    /// In each iteration of a block.
    Iterate(usize),
    /// After a block is solved.
    Solved(usize),
}

impl Tier {
    /// Whether it waits for the unknowns of a block.
    pub(super) fn is_late(self) -> bool {
        matches!(self, Self::Guess(_) | Self::Iterate(_) | Self::Solved(_))
    }

    /// Position in the order of computation.
    pub(crate) fn rank(self) -> usize {
        match self {
            Self::Prepare => 0,
            Self::Noise => 1,
            Self::State => 2,
            Self::Guess(block) => 3 + 3 * block,
            Self::Iterate(block) => 4 + 3 * block,
            Self::Solved(block) => 5 + 3 * block,
        }
    }
}

/// The result of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Value(pub(super) u32);

/// One operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Operation {
    /// A constant, by its bits.
    Constant(u64),
    Input(Symbol),
    Add(Value, Value),
    Sub(Value, Value),
    Mul(Value, Value),
    Div(Value, Value),
    Neg(Value),
    Abs(Value),
    Recip(Value),
    Call(Function, Value),
    Call2(Binary, Value, Value),
    /// Sine and cosine together, of which the two below are the components.
    SinCos(Value),
    SinOf(Value),
    CosOf(Value),
    /// Sine and cosine of an angle of which these are known, turned further by a third operand.
    Turn(Value, Value, Value),
}

/// An operation with its tier.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Instruction {
    pub(crate) operation: Operation,
    pub(crate) tier: Tier,
}

/// Straight-line code in order of computation.
#[derive(Default)]
pub(crate) struct Program {
    pub(super) instructions: Vec<Instruction>,
    pub(super) numbers: Map<Operation, Value>,
    /// Which instructions a result depends on; the others are not listed.
    live: Vec<bool>,
}

impl Program {
    pub(crate) fn get(&self, value: Value) -> Instruction {
        self.instructions[value.0 as usize]
    }

    /// Instructions of a tier, operands first.
    pub(crate) fn of_tier(&self, tier: Tier) -> impl Iterator<Item = (Value, Operation)> + '_ {
        self.instructions
            .iter()
            .enumerate()
            .filter(move |(at, i)| i.tier == tier && self.live[*at])
            .map(|(at, i)| (Value(at as u32), i.operation))
    }

    /// All instructions, operands first.
    pub(crate) fn all(&self) -> impl Iterator<Item = (Value, Instruction)> + '_ {
        self.instructions
            .iter()
            .enumerate()
            .filter(|(at, _)| self.live[*at])
            .map(|(at, i)| (Value(at as u32), *i))
    }

    /// All instructions in the order of their tiers, operands first.
    pub(crate) fn in_order(&self) -> Vec<(Value, Instruction)> {
        let mut list: Vec<_> = self.all().collect();
        list.sort_by_key(|(_, i)| i.tier.rank());
        list
    }

    /// Number of instructions so far, to come back to.
    pub(super) fn checkpoint(&self) -> usize {
        self.instructions.len()
    }

    /// Instructions of a step that were added after a checkpoint; a negation mostly disappears in a sum.
    pub(super) fn work_since(&self, checkpoint: usize) -> usize {
        let counts =
            |i: &&Instruction| i.tier != Tier::Prepare && !matches!(i.operation, Operation::Neg(_));
        self.instructions[checkpoint..]
            .iter()
            .filter(counts)
            .count()
    }

    /// Forgets what was added after a checkpoint.
    pub(super) fn undo(&mut self, checkpoint: usize) {
        for instruction in self.instructions.drain(checkpoint..) {
            self.numbers.remove(&instruction.operation);
        }
    }

    /// Marks what `results` depend on.
    pub(super) fn mark_live(&mut self, results: &[Value]) {
        self.live = vec![false; self.instructions.len()];
        for result in results {
            self.live[result.index()] = true;
        }
        for at in (0..self.instructions.len()).rev() {
            if self.live[at] {
                for operand in operands(self.instructions[at].operation) {
                    self.live[operand.index()] = true;
                }
            }
        }
    }
}

impl Value {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Operands of an operation.
pub(crate) fn operands(operation: Operation) -> impl Iterator<Item = Value> {
    let list = match operation {
        Operation::Constant(_) | Operation::Input(_) => [None, None, None],
        Operation::Add(a, b)
        | Operation::Sub(a, b)
        | Operation::Mul(a, b)
        | Operation::Div(a, b)
        | Operation::Call2(_, a, b) => [Some(a), Some(b), None],
        Operation::Turn(a, b, c) => [Some(a), Some(b), Some(c)],
        Operation::Neg(a)
        | Operation::Abs(a)
        | Operation::Recip(a)
        | Operation::Call(_, a)
        | Operation::SinCos(a)
        | Operation::SinOf(a)
        | Operation::CosOf(a) => [Some(a), None, None],
    };
    list.into_iter().flatten()
}

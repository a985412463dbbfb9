//! Straight-line code: two-operand instructions, each with the tier in which it is computed.
//!
//! Invariant: an instruction's operands precede it and are of its tier or an earlier one.

use std::collections::BTreeSet;

use super::limits::OPERATIONS_OF_STATEMENT;
use crate::algebra::{Binary, Function, Map, Symbol};

/// The stage of a step in which a value is computed. Each tier adds inputs to the inputs of the
/// earlier tiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Tier {
    /// From parameters and step size alone.
    Prepare,
    /// From time and Wiener increments.
    Noise,
    /// From the state.
    State,
    /// From a stage of a block's guess: block, and number of the stage.
    Guess(usize, usize),
    /// In each iteration of a block.
    Iterate(usize),
    /// After a block is solved.
    Solved(usize),
}

/// Stages of a guess that are told apart in the order of computation.
const MAX_STAGES: usize = 2;

/// Tiers of a block.
const RANKS: usize = MAX_STAGES + 2;

impl Tier {
    /// Returns whether values of this tier depend on the unknowns of a block.
    pub(super) fn is_late(self) -> bool {
        matches!(self, Self::Guess(..) | Self::Iterate(_) | Self::Solved(_))
    }

    /// Returns the position in the order of computation.
    pub(crate) fn rank(self) -> usize {
        match self {
            Self::Prepare => 0,
            Self::Noise => 1,
            Self::State => 2,
            Self::Guess(block, stage) => 3 + RANKS * block + stage.min(MAX_STAGES - 1),
            Self::Iterate(block) => 3 + RANKS * block + MAX_STAGES,
            Self::Solved(block) => 4 + RANKS * block + MAX_STAGES,
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
    /// Sine and cosine of an angle, as a pair.
    SinCos(Value),
    /// The sine in a pair.
    SinOf(Value),
    /// The cosine in a pair.
    CosOf(Value),
    /// Sine and cosine of the sum of two angles, as a pair: from sine and cosine of the first
    /// angle, and the second angle.
    AngleAddition(Value, Value, Value),
}

impl Operation {
    /// Returns whether the operation gives a single number from others.
    fn is_arithmetic(self) -> bool {
        !matches!(
            self,
            Self::Constant(_)
                | Self::Input(_)
                | Self::SinCos(_)
                | Self::SinOf(_)
                | Self::CosOf(_)
                | Self::AngleAddition(..)
        )
    }
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
    /// For each instruction, whether a result depends on it. The other instructions are omitted
    /// from the lists below.
    live: Vec<bool>,
    /// For each instruction, how often other instructions use it; no count for a result.
    uses: Vec<Option<u32>>,
}

impl Program {
    pub(crate) fn get(&self, value: Value) -> Instruction {
        self.instructions[value.0 as usize]
    }

    /// Returns the value of an operation that a result depends on. The operands of a sum or a
    /// product may be exchanged, which changes no bit.
    pub(super) fn value_of(&self, operation: Operation) -> Option<Value> {
        let exchanged = match operation {
            Operation::Add(a, b) => Operation::Add(b, a),
            Operation::Mul(a, b) => Operation::Mul(b, a),
            other => other,
        };
        let value = self.numbers.get(&operation);
        let value = *value.or_else(|| self.numbers.get(&exchanged))?;
        self.live[value.index()].then_some(value)
    }

    /// Returns the instructions of a tier, operands first.
    pub(crate) fn of_tier(&self, tier: Tier) -> impl Iterator<Item = (Value, Operation)> + '_ {
        self.instructions
            .iter()
            .enumerate()
            .filter(move |(at, i)| i.tier == tier && self.live[*at])
            .map(|(at, i)| (Value(at as u32), i.operation))
    }

    /// Returns all instructions, operands first.
    pub(crate) fn all(&self) -> impl Iterator<Item = (Value, Instruction)> + '_ {
        self.instructions
            .iter()
            .enumerate()
            .filter(|(at, _)| self.live[*at])
            .map(|(at, i)| (Value(at as u32), *i))
    }

    /// Returns all instructions in the order of their tiers, operands first.
    pub(crate) fn in_order(&self) -> Vec<(Value, Instruction)> {
        let mut list: Vec<_> = self.all().collect();
        list.sort_by_key(|(_, i)| i.tier.rank());
        list
    }

    /// Returns the current number of instructions, for [`undo`](Self::undo).
    pub(super) fn checkpoint(&self) -> usize {
        self.instructions.len()
    }

    /// Counts the instructions that were added after a checkpoint and run in every step. Negations
    /// are not counted, since most of them become subtractions in a sum.
    pub(super) fn work_since(&self, checkpoint: usize) -> usize {
        let is_counted =
            |i: &&Instruction| i.tier != Tier::Prepare && !matches!(i.operation, Operation::Neg(_));
        self.instructions[checkpoint..]
            .iter()
            .filter(is_counted)
            .count()
    }

    /// Removes the instructions that were added after a checkpoint.
    pub(super) fn undo(&mut self, checkpoint: usize) {
        for instruction in self.instructions.drain(checkpoint..) {
            self.numbers.remove(&instruction.operation);
        }
    }

    /// Marks the instructions on which `results` depend.
    pub(super) fn mark_live(&mut self, results: &[Value]) {
        self.live = vec![false; self.instructions.len()];
        self.uses = vec![Some(0); self.instructions.len()];
        for result in results {
            self.live[result.index()] = true;
            self.uses[result.index()] = None;
        }
        for at in (0..self.instructions.len()).rev() {
            if self.live[at] {
                for operand in operands(self.instructions[at].operation) {
                    self.live[operand.index()] = true;
                    if let Some(count) = &mut self.uses[operand.index()] {
                        *count += 1;
                    }
                }
            }
        }
    }

    /// Returns the values that are computed within the statement of the only instruction that uses
    /// them: an instruction of the same tier. `is_named` holds for values that have a statement of
    /// their own, since their name tells what they are.
    pub(crate) fn inlined(&self, is_named: impl Fn(Value) -> bool) -> BTreeSet<Value> {
        let mut inlined = BTreeSet::new();
        let mut operations = vec![1; self.instructions.len()];
        for (user, instruction) in self.all() {
            for value in operands(instruction.operation) {
                let is_candidate = self.uses[value.index()] == Some(1)
                    && self.get(value).tier == instruction.tier
                    && self.get(value).operation.is_arithmetic()
                    && !is_named(value);
                let together = operations[user.index()] + operations[value.index()];
                if is_candidate && together <= OPERATIONS_OF_STATEMENT {
                    inlined.insert(value);
                    operations[user.index()] = together;
                }
            }
        }
        inlined
    }
}

impl Value {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Returns the operands of an operation.
pub(crate) fn operands(operation: Operation) -> impl Iterator<Item = Value> {
    let list = match operation {
        Operation::Constant(_) | Operation::Input(_) => [None, None, None],
        Operation::Add(a, b)
        | Operation::Sub(a, b)
        | Operation::Mul(a, b)
        | Operation::Div(a, b)
        | Operation::Call2(_, a, b) => [Some(a), Some(b), None],
        Operation::AngleAddition(a, b, c) => [Some(a), Some(b), Some(c)],
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

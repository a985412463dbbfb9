//! Values that a step computes at q₁ and the next step would compute again at q₀: the force at the
//! end of a step is the force at the start of the next.
//!
//! Input: a scheduled step. Output: pairs of values, of which the next step takes the second in
//! place of the first. Invariant: the second value comes from q₁ by the same operations as the
//! first from q₀. The q₁ of vectors is rounded as the state is, so that carrying changes no bit.
//! The rotation at the end is the matrix of the equations, and that of the state is the matrix of a
//! quaternion: they differ by rounding errors.

use std::collections::{HashMap, HashSet};

use super::instructions::{Operation, Program, Tier, Value, operands};
use super::limits::{CALL, DIVISION};
use super::step::Step;
use crate::algebra::Function;
use crate::model::configuration::Factor;
use crate::model::{Meaning, Quantity, Symbols};
use crate::structure::{Returns, Solution};

/// Work that a carried value has to save, in additions: it is stored and loaded between two steps.
const WORTH: usize = 3;

/// The values that a trajectory carries from a step to the next.
pub(crate) struct Carried {
    /// The value at q₀, and the same function of q₁.
    pub(crate) pairs: Vec<(Value, Value)>,
    /// Instructions that compute nothing but these values, the inputs among them excepted.
    pub(crate) sources: HashSet<Value>,
}

impl Carried {
    /// Returns what a step carries; `None` if it carries nothing.
    pub(crate) fn of(step: &Step, symbols: &Symbols) -> Option<Self> {
        let scheme = &step.scheme;
        let is_iterated = |solution: &Solution<_, _>| matches!(solution, Solution::Iteration(_));
        if scheme.returns != Returns::Increment
            || step.turned.is_empty() && scheme.blocks.iter().any(|b| is_iterated(&b.solution))
        {
            return None;
        }
        let program = &step.program;
        let images = images(step, symbols);
        let is_input = |v: &Value| matches!(program.get(*v).operation, Operation::Input(_));
        let sources: HashSet<Value> = images.keys().copied().filter(|v| !is_input(v)).collect();
        let used_outside: HashSet<Value> = program
            .all()
            .filter(|(value, _)| !sources.contains(value))
            .flat_map(|(_, instruction)| operands(instruction.operation))
            .chain(step.results())
            .collect();
        let mut pairs: Vec<(Value, Value)> = images
            .into_iter()
            .filter(|(value, _)| sources.contains(value) && used_outside.contains(value))
            .collect();
        pairs.sort_unstable();
        let is_pair = |v: Value| matches!(program.get(v).operation, Operation::SinCos(_));
        if pairs.is_empty() || pairs.iter().any(|&(value, _)| is_pair(value)) {
            return None;
        }
        let work: usize = sources.iter().map(|&v| weight(program, v)).sum();
        (work >= WORTH * pairs.len()).then_some(Self { pairs, sources })
    }
}

/// Returns the work of an instruction, in additions.
fn weight(program: &Program, value: Value) -> usize {
    match program.get(value).operation {
        Operation::Call(Function::Sqrt, _) | Operation::Div(..) | Operation::Recip(_) => DIVISION,
        Operation::Call(..) | Operation::Call2(..) | Operation::SinCos(_) => CALL,
        Operation::SinOf(_) | Operation::CosOf(_) => 0,
        _ => 1,
    }
}

/// Returns, for each value that depends on q₀ and the parameters alone, the value that the same
/// operations give at q₁, if the step computes it.
fn images(step: &Step, symbols: &Symbols) -> HashMap<Value, Value> {
    let program = &step.program;
    let mut images = HashMap::new();
    let mut fixed = HashSet::new();
    for (value, instruction) in program.all() {
        let operation = instruction.operation;
        let image = match operation {
            Operation::Constant(_) => {
                fixed.insert(value);
                None
            }
            Operation::Input(symbol) => match *symbols.meaning(symbol) {
                // inputs have other values in the next step
                Meaning::Parameter { input: None, .. } => {
                    fixed.insert(value);
                    None
                }
                Meaning::Start(Quantity::Position, i) => match moving(i, symbols) {
                    Some(direction) => end(program, value, step.scheme.dq[direction]),
                    None => step.turned.get(&i).copied(),
                },
                _ => None,
            },
            _ if operands(operation).all(|v| fixed.contains(&v)) => {
                fixed.insert(value);
                None
            }
            _ if instruction.tier == Tier::State => {
                let image = |v: Value| fixed.contains(&v).then_some(v).or(images.get(&v).copied());
                mapped(operation, image).and_then(|operation| program.value_of(operation))
            }
            _ => None,
        };
        if let Some(image) = image {
            images.insert(value, image);
        }
    }
    images
}

/// Returns the direction in which an entry of a vector moves; `None` for an entry of a rotation.
fn moving(entry: usize, symbols: &Symbols) -> Option<usize> {
    let blocks = symbols.configuration.blocks().into_iter();
    let mut vectors = blocks.filter(|block| block.factor != Factor::Rotation);
    let block = vectors.find(|block| block.entries.contains(&entry))?;
    Some(block.directions.start + (entry - block.entries.start))
}

/// Returns the value q₀ + dq, if the step computes it by the addition that updates the state.
fn end(program: &Program, q: Value, dq: Value) -> Option<Value> {
    let sum = program.value_of(Operation::Add(q, dq));
    sum.or_else(|| match program.get(dq).operation {
        Operation::Neg(x) => program.value_of(Operation::Sub(q, x)),
        _ => None,
    })
}

/// Returns the operation with images in place of its operands.
fn mapped(operation: Operation, image: impl Fn(Value) -> Option<Value>) -> Option<Operation> {
    Some(match operation {
        Operation::Constant(_) | Operation::Input(_) => return None,
        Operation::Add(a, b) => Operation::Add(image(a)?, image(b)?),
        Operation::Sub(a, b) => Operation::Sub(image(a)?, image(b)?),
        Operation::Mul(a, b) => Operation::Mul(image(a)?, image(b)?),
        Operation::Div(a, b) => Operation::Div(image(a)?, image(b)?),
        Operation::Neg(a) => Operation::Neg(image(a)?),
        Operation::Abs(a) => Operation::Abs(image(a)?),
        Operation::Recip(a) => Operation::Recip(image(a)?),
        Operation::Call(function, a) => Operation::Call(function, image(a)?),
        Operation::Call2(function, a, b) => Operation::Call2(function, image(a)?, image(b)?),
        Operation::SinCos(a) => Operation::SinCos(image(a)?),
        Operation::SinOf(a) => Operation::SinOf(image(a)?),
        Operation::CosOf(a) => Operation::CosOf(image(a)?),
        Operation::AngleAddition(a, b, c) => {
            Operation::AngleAddition(image(a)?, image(b)?, image(c)?)
        }
    })
}

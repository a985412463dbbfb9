//! Value numbering: equal operations are one value, and trivial operations are simplified away.
//!
//! Negations move outwards until they reach a sum, where an addition becomes a subtraction.
//! Constant factors move outwards, so that products which differ by a constant factor share their
//! other factors.

use super::instructions::{Instruction, Operation, Tier, Value, operands};
use super::scheduler::{Scheduler, tier_of};

impl Scheduler<'_> {
    /// Multiplies values in the order of their tiers, then of their creation, so that equal factors
    /// give equal partial products.
    pub(super) fn chain(&mut self, mut values: Vec<Value>) -> Value {
        values.sort_by_key(|&v| (self.program.get(v).tier.rank(), v));
        let mut product = None;
        for value in values {
            product = Some(self.times(product, value));
        }
        product.unwrap_or_else(|| self.constant(1.0))
    }

    pub(super) fn times(&mut self, product: Option<Value>, factor: Value) -> Value {
        match product {
            Some(product) => self.push(Operation::Mul(product, factor)),
            None => factor,
        }
    }

    /// Computes `x^k` by repeated squaring.
    pub(super) fn power(&mut self, x: Value, k: u32) -> Value {
        let (mut square, mut k, mut power) = (x, k, None);
        loop {
            if k % 2 == 1 {
                power = Some(self.times(power, square));
            }
            k /= 2;
            if k == 0 {
                break;
            }
            square = self.push(Operation::Mul(square, square));
        }
        power.unwrap_or(x)
    }

    pub(super) fn constant(&mut self, value: f64) -> Value {
        self.push(Operation::Constant(value.to_bits()))
    }

    /// Returns the operand of a negation.
    pub(super) fn negated(&self, value: Value) -> Option<Value> {
        match self.program.get(value).operation {
            Operation::Neg(x) => Some(x),
            _ => None,
        }
    }

    /// Computes `(c·x)·y` as `c·(x·y)` if y is known as early as x, so that products which differ
    /// by a constant factor share `x·y`. Values that are prepared once for all steps stay as they
    /// are.
    fn constant_outwards(&mut self, operation: Operation) -> Option<Value> {
        let Operation::Mul(a, b) = operation else {
            return None;
        };
        let is_constant =
            |v: Value| matches!(self.program.get(v).operation, Operation::Constant(_));
        for (scaled, other) in [(a, b), (b, a)] {
            let instruction = self.program.get(scaled);
            let Operation::Mul(x, y) = instruction.operation else {
                continue;
            };
            if self.is_kept(scaled) {
                continue;
            }
            let (c, x) = if is_constant(x) { (x, y) } else { (y, x) };
            let early = self.program.get(other).tier.rank() <= instruction.tier.rank();
            let prepared = instruction.tier == Tier::Prepare;
            if early && !prepared && is_constant(c) && !is_constant(other) {
                let bare = self.multiply(vec![x, other]);
                return Some(self.push(Operation::Mul(c, bare)));
            }
        }
        None
    }

    /// Returns the value of an operation that needs no instruction: equal operands that cancel, or
    /// an operand 0 or 1.
    fn trivial(&mut self, operation: Operation) -> Option<Value> {
        let constant = |v: Value| match self.program.get(v).operation {
            Operation::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        };
        match operation {
            Operation::Sub(a, b) if a == b => Some(self.constant(0.0)),
            Operation::Add(a, b) if constant(a) == Some(0.0) => Some(b),
            Operation::Sub(a, b) if constant(a) == Some(0.0) => Some(self.push(Operation::Neg(b))),
            Operation::Add(a, b) | Operation::Sub(a, b) if constant(b) == Some(0.0) => Some(a),
            Operation::Mul(a, b) | Operation::Mul(b, a) if constant(a) == Some(1.0) => Some(b),
            Operation::Mul(a, b) if constant(a) == Some(0.0) || constant(b) == Some(0.0) => {
                Some(self.constant(0.0))
            }
            _ => None,
        }
    }

    /// Adds an operation after the simplifications of this module.
    pub(super) fn push(&mut self, operation: Operation) -> Value {
        if let Some(known) = self.trivial(operation) {
            return known;
        }
        if let Some(product) = self.constant_outwards(operation) {
            return product;
        }
        let inner = |v: Value| self.negated(v);
        match operation {
            Operation::Neg(a) => {
                if let Some(x) = inner(a) {
                    return x;
                }
            }
            Operation::Add(a, b) => match (inner(a), inner(b)) {
                (_, Some(y)) => return self.push(Operation::Sub(a, y)),
                (Some(x), None) => return self.push(Operation::Sub(b, x)),
                (None, None) => {}
            },
            Operation::Sub(a, b) => match (inner(a), inner(b)) {
                (_, Some(y)) => return self.push(Operation::Add(a, y)),
                (Some(x), None) => {
                    let sum = self.push(Operation::Add(x, b));
                    return self.push(Operation::Neg(sum));
                }
                (None, None) => {}
            },
            Operation::Mul(a, b) | Operation::Div(a, b) => {
                let (x, y) = (inner(a), inner(b));
                if x.is_some() || y.is_some() {
                    let (a, b) = (x.unwrap_or(a), y.unwrap_or(b));
                    let product = self.push(match operation {
                        Operation::Mul(..) => Operation::Mul(a, b),
                        _ => Operation::Div(a, b),
                    });
                    return if x.is_some() && y.is_some() {
                        product
                    } else {
                        self.push(Operation::Neg(product))
                    };
                }
            }
            Operation::Recip(a) => {
                if let Some(x) = inner(a) {
                    let inverse = self.push(Operation::Recip(x));
                    return self.push(Operation::Neg(inverse));
                }
            }
            Operation::Abs(a) => {
                if let Some(x) = inner(a) {
                    return self.push(Operation::Abs(x));
                }
            }
            _ => {}
        }
        self.number(operation)
    }

    /// Returns the value of an operation. Adds an instruction if there is none for this operation.
    pub(super) fn number(&mut self, operation: Operation) -> Value {
        // a + b and b + a are one value
        let operation = match operation {
            Operation::Add(a, b) if b < a => Operation::Add(b, a),
            Operation::Mul(a, b) if b < a => Operation::Mul(b, a),
            other => other,
        };
        if let Some(&value) = self.program.numbers.get(&operation) {
            return value;
        }
        let tier = match operation {
            Operation::Input(symbol) => tier_of(self.symbols, &self.tiers, symbol),
            _ => operands(operation)
                .map(|v| self.program.get(v).tier)
                .max_by_key(|t| t.rank())
                .unwrap_or(Tier::Prepare),
        };
        let value = Value(self.program.instructions.len() as u32);
        self.program
            .instructions
            .push(Instruction { operation, tier });
        self.program.numbers.insert(operation, value);
        value
    }
}

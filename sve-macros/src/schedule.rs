//! Expressions → straight-line instructions in tiers, each computed once and as early as its inputs are known.
//!
//! Input: expressions wanted by the emitter. Output: a [`Program`] of two-operand instructions. Sums and products of many
//! operands are cut so that the operands known earliest come first: what depends on parameters and h alone leaves the step,
//! what depends on the state leaves the iteration. Invariant: an instruction's operands precede it and are of its tier or
//! an earlier one.

use std::collections::{HashMap, HashSet};

use crate::model::{Meaning, Symbols};
use crate::structure::is_state;
use crate::symbolic::{Arena, Binary, Expr, Function, Node, Symbol};

/// When a value is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Tier {
    /// From parameters and step size alone.
    Prepare,
    /// With time and Wiener increments.
    Noise,
    /// With the state.
    State,
    /// In each iteration of a block.
    Iterate(usize),
    /// After a block is solved.
    Solved(usize),
}

impl Tier {
    /// Position in the order of computation.
    fn rank(self) -> usize {
        match self {
            Self::Prepare => 0,
            Self::Noise => 1,
            Self::State => 2,
            Self::Iterate(block) => 3 + 2 * block,
            Self::Solved(block) => 4 + 2 * block,
        }
    }
}

/// The result of an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Value(u32);

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
    Recip(Value),
    Call(Function, Value),
    Call2(Binary, Value, Value),
    /// Sine and cosine together, of which the two below are the components.
    SinCos(Value),
    SinOf(Value),
    CosOf(Value),
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
    instructions: Vec<Instruction>,
    numbers: HashMap<Operation, Value>,
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
            .filter(move |(_, i)| i.tier == tier)
            .map(|(at, i)| (Value(at as u32), i.operation))
    }

    /// All instructions, operands first.
    pub(crate) fn all(&self) -> impl Iterator<Item = (Value, Instruction)> + '_ {
        self.instructions
            .iter()
            .enumerate()
            .map(|(at, i)| (Value(at as u32), *i))
    }
}

impl Value {
    pub(crate) fn index(self) -> usize {
        self.0 as usize
    }
}

/// Operands of an operation.
pub(crate) fn operands(operation: Operation) -> impl Iterator<Item = Value> {
    let pair = match operation {
        Operation::Constant(_) | Operation::Input(_) => [None, None],
        Operation::Add(a, b)
        | Operation::Sub(a, b)
        | Operation::Mul(a, b)
        | Operation::Div(a, b)
        | Operation::Call2(_, a, b) => [Some(a), Some(b)],
        Operation::Neg(a)
        | Operation::Recip(a)
        | Operation::Call(_, a)
        | Operation::SinCos(a)
        | Operation::SinOf(a)
        | Operation::CosOf(a) => [Some(a), None],
    };
    pair.into_iter().flatten()
}

/// Where the unknowns of the blocks are known.
pub(crate) type Tiers = HashMap<Symbol, Tier>;

/// Builds a [`Program`].
pub(crate) struct Scheduler<'a> {
    arena: &'a Arena,
    symbols: &'a Symbols,
    tiers: Tiers,
    program: Program,
    done: HashMap<Expr, Value>,
    /// Arguments of which both sine and cosine are wanted.
    paired: HashSet<Expr>,
    /// Bases that stand in the denominator of more than one product.
    shared_denominators: HashSet<Expr>,
}

impl<'a> Scheduler<'a> {
    /// A scheduler for everything in `roots`.
    pub(crate) fn new(
        arena: &'a Arena,
        symbols: &'a Symbols,
        tiers: Tiers,
        roots: &[Expr],
    ) -> Self {
        let wanted = arena.reachable(roots, |_| true);
        let mut calls: HashMap<Expr, (bool, bool)> = HashMap::new();
        let mut denominators: HashMap<Expr, usize> = HashMap::new();
        for &e in &wanted {
            match arena.node(e) {
                Node::Call(Function::Sin, x) => calls.entry(*x).or_default().0 = true,
                Node::Call(Function::Cos, x) => calls.entry(*x).or_default().1 = true,
                Node::Product(factors) => {
                    for &(base, _) in factors.iter().filter(|f| f.1 < 0) {
                        *denominators.entry(base).or_default() += 1;
                    }
                }
                _ => {}
            }
        }
        Self {
            arena,
            symbols,
            tiers,
            program: Program::default(),
            done: HashMap::new(),
            paired: calls
                .into_iter()
                .filter(|(_, both)| *both == (true, true))
                .map(|(x, _)| x)
                .collect(),
            shared_denominators: denominators
                .into_iter()
                .filter(|d| d.1 > 1)
                .map(|d| d.0)
                .collect(),
        }
    }

    pub(crate) fn finish(self) -> Program {
        self.program
    }

    /// The value of an expression; operands first, so nothing recurses deeply.
    pub(crate) fn value(&mut self, expr: Expr) -> Value {
        let todo = self
            .arena
            .reachable(&[expr], |e| !self.done.contains_key(&e));
        for e in todo {
            let value = self.lower(e);
            self.done.insert(e, value);
        }
        self.done[&expr]
    }

    pub(crate) fn values(&mut self, exprs: &[Expr]) -> Vec<Value> {
        exprs.iter().map(|&e| self.value(e)).collect()
    }

    fn lower(&mut self, expr: Expr) -> Value {
        match self.arena.node(expr) {
            Node::Constant(bits) => self.constant(bits.get()),
            Node::Symbol(symbol) => self.push(Operation::Input(*symbol)),
            Node::Opaque(x) => self.done[x],
            Node::Sum(constant, terms) => {
                let terms: Vec<(Expr, f64)> = terms.iter().map(|t| (t.0, t.1.get())).collect();
                self.lower_sum(constant.get(), &terms)
            }
            Node::Product(factors) => self.lower_product(1.0, factors),
            Node::Call(function, x) => {
                let (function, x) = (*function, *x);
                let value = self.done[&x];
                match function {
                    Function::Sin | Function::Cos if self.paired.contains(&x) => {
                        let pair = self.push(Operation::SinCos(value));
                        let sin = self.push(Operation::SinOf(pair));
                        let cos = self.push(Operation::CosOf(pair));
                        if function == Function::Sin { sin } else { cos }
                    }
                    Function::Abs => self.lower_magnitude(x),
                    _ => self.push(Operation::Call(function, value)),
                }
            }
            Node::Call2(function, x, y) => {
                let operation = Operation::Call2(*function, self.done[x], self.done[y]);
                self.push(operation)
            }
        }
    }

    /// `|x|`, without a multiplication by −1 inside.
    fn lower_magnitude(&mut self, x: Expr) -> Value {
        let value = match self.arena.node(x) {
            Node::Sum(constant, terms) if constant.get() == 0.0 && terms.len() == 1 => {
                let (term, c) = (terms[0].0, terms[0].1.get());
                self.scaled(c.abs(), term)
            }
            _ => self.done[&x],
        };
        self.push(Operation::Call(Function::Abs, value))
    }

    /// A sum, its terms in the order in which they become known.
    fn lower_sum(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Value {
        let mut parts: Vec<(Value, bool)> = terms
            .iter()
            .map(|&(term, c)| (self.scaled(c.abs(), term), c < 0.0))
            .collect();
        if constant != 0.0 {
            parts.push((self.constant(constant.abs()), constant < 0.0));
        }
        parts.sort_by_key(|p| self.program.get(p.0).tier.rank());
        // start with a positive term of the earliest tier, where there is one
        let first_rank = self.program.get(parts[0].0).tier.rank();
        let start = parts
            .iter()
            .position(|p| !p.1 && self.program.get(p.0).tier.rank() == first_rank)
            .unwrap_or(0);
        let (mut sum, negative) = parts.remove(start);
        if negative {
            // −a + b is b − a; only a sum without a positive term needs the negation
            if let Some(at) = parts.iter().position(|p| !p.1) {
                let all_negative_before = parts[..at].to_vec();
                let (positive, _) = parts[at];
                parts.drain(..=at);
                for (value, _) in all_negative_before {
                    sum = self.push(Operation::Add(sum, value));
                }
                sum = self.push(Operation::Sub(positive, sum));
            } else {
                for (value, _) in std::mem::take(&mut parts) {
                    sum = self.push(Operation::Add(sum, value));
                }
                sum = self.push(Operation::Neg(sum));
            }
        }
        for (value, negative) in parts {
            sum = self.push(if negative {
                Operation::Sub(sum, value)
            } else {
                Operation::Add(sum, value)
            });
        }
        sum
    }

    /// `c · term`, the constant taken in by the factors known earliest.
    fn scaled(&mut self, c: f64, term: Expr) -> Value {
        if c == 1.0 {
            return self.done[&term];
        }
        match self.arena.node(term) {
            Node::Product(factors) => self.lower_product(c, factors),
            _ => self.lower_product(c, &[(term, 1)]),
        }
    }

    /// `c Π base^k`, the factors in the order in which they become known.
    fn lower_product(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
        let rank = |this: &Self, e: Expr| this.program.get(this.done[&e]).tier.rank();
        let last = factors.iter().map(|f| rank(self, f.0)).max().unwrap_or(0);
        let mut sorted = factors.to_vec();
        sorted.sort_by_key(|f| rank(self, f.0));
        let mut product = (c != 1.0).then(|| self.constant(c));
        let mut below: Option<Value> = None;
        for (base, k) in sorted {
            let value = self.done[&base];
            let early = rank(self, base) < last;
            if k < 0 && !early && !self.shared_denominators.contains(&base) {
                let power = self.power(value, k.unsigned_abs());
                below = Some(self.times(below, power));
                continue;
            }
            let value = if k < 0 {
                self.push(Operation::Recip(value))
            } else {
                value
            };
            let power = self.power(value, k.unsigned_abs());
            product = Some(self.times(product, power));
        }
        match (product, below) {
            (Some(product), Some(below)) => self.push(Operation::Div(product, below)),
            (None, Some(below)) => self.push(Operation::Recip(below)),
            (Some(product), None) => product,
            (None, None) => self.constant(1.0),
        }
    }

    fn times(&mut self, product: Option<Value>, factor: Value) -> Value {
        match product {
            Some(product) => self.push(Operation::Mul(product, factor)),
            None => factor,
        }
    }

    /// `x^k` by squaring.
    fn power(&mut self, x: Value, k: u32) -> Value {
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

    fn constant(&mut self, value: f64) -> Value {
        self.push(Operation::Constant(value.to_bits()))
    }

    fn push(&mut self, operation: Operation) -> Value {
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
            Operation::Input(symbol) => self.tier_of(symbol),
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

    fn tier_of(&self, symbol: Symbol) -> Tier {
        if let Some(&tier) = self.tiers.get(&symbol) {
            return tier;
        }
        match self.symbols.meaning(symbol) {
            Meaning::Parameter { .. } | Meaning::StepSize => Tier::Prepare,
            _ if is_state(self.symbols, symbol) => Tier::State,
            _ => Tier::Noise,
        }
    }
}

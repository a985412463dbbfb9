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

    fn mark_live(&mut self, results: &[Value]) {
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
    /// In how many ways a product is wanted: bare, or with each constant in front.
    scalings: HashMap<Factors, usize>,
}

/// `Π base^exponent`.
type Factors = Vec<(Expr, i32)>;

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
        let mut scalings: HashMap<Factors, HashSet<u64>> = HashMap::new();
        for &e in &wanted {
            match arena.node(e) {
                Node::Call(Function::Sin, x) => calls.entry(*x).or_default().0 = true,
                Node::Call(Function::Cos, x) => calls.entry(*x).or_default().1 = true,
                Node::Product(factors) => {
                    for &(base, _) in factors.iter().filter(|f| f.1 < 0) {
                        *denominators.entry(base).or_default() += 1;
                    }
                }
                Node::Sum(_, terms) => {
                    for &(term, c) in terms {
                        if let Node::Product(factors) = arena.node(term) {
                            scalings
                                .entry(factors.clone())
                                .or_default()
                                .insert(c.get().abs().to_bits());
                        }
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
            scalings: scalings
                .into_iter()
                .map(|(factors, ways)| (factors, ways.len()))
                .collect(),
            shared_denominators: denominators
                .into_iter()
                .filter(|d| d.1 > 1)
                .map(|d| d.0)
                .collect(),
        }
    }

    /// The program that computes `results`.
    pub(crate) fn finish(mut self, results: &[Value]) -> Program {
        self.program.mark_live(results);
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
                let (early, late) = self.split(terms[0].0, 0);
                let factors: Factors = early.into_iter().chain(late).collect();
                self.scaled(terms[0].1.get().abs(), &factors)
            }
            _ => self.done[&x],
        };
        self.push(Operation::Call(Function::Abs, value))
    }

    /// A sum, its terms in the order in which they become known. Terms with the same late factors are put together,
    /// `a·x + b·x = (a + b)·x`, so that `a + b` is computed as early as a and b are known.
    fn lower_sum(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Value {
        let late = terms.iter().map(|t| self.rank(t.0)).max().unwrap_or(0);
        let mut groups: Vec<(Factors, Vec<(Factors, f64)>)> = Vec::new();
        for &(term, c) in terms {
            let (early, last) = self.split(term, late);
            match groups.iter_mut().find(|g| g.0 == last && !last.is_empty()) {
                Some(group) => group.1.push((early, c)),
                None => groups.push((last, vec![(early, c)])),
            }
        }
        let mut parts: Vec<(Value, bool)> = Vec::new();
        for (last, members) in groups {
            if let [(early, c)] = members.as_slice() {
                let whole: Factors = early.iter().chain(&last).copied().collect();
                parts.push((self.scaled(c.abs(), &whole), *c < 0.0));
                continue;
            }
            let mut coefficients: Vec<(Value, bool)> = members
                .iter()
                .map(|(early, c)| (self.lower_product(c.abs(), early), *c < 0.0))
                .collect();
            let coefficient = self.add_up(&mut coefficients);
            let last = self.lower_product(1.0, &last);
            parts.push((self.push(Operation::Mul(coefficient, last)), false));
        }
        if constant != 0.0 {
            parts.push((self.constant(constant.abs()), constant < 0.0));
        }
        self.add_up(&mut parts)
    }

    /// The factors of a term that are known before `late`, and those that are not.
    fn split(&self, term: Expr, late: usize) -> (Factors, Factors) {
        let factors = match self.arena.node(term) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(term, 1)],
        };
        factors.into_iter().partition(|f| self.rank(f.0) < late)
    }

    fn rank(&self, expr: Expr) -> usize {
        self.program.get(self.done[&expr]).tier.rank()
    }

    /// Adds values, each with whether it is to be subtracted, in the order in which they become known.
    fn add_up(&mut self, parts: &mut [(Value, bool)]) -> Value {
        for part in parts.iter_mut() {
            if let Some(x) = self.negated(part.0) {
                *part = (x, !part.1);
            }
        }
        parts.sort_by_key(|p| self.program.get(p.0).tier.rank());
        let mut sum: Option<Value> = None;
        for &(value, negative) in parts.iter() {
            sum = Some(match (sum, negative) {
                (None, false) => value,
                (None, true) => self.push(Operation::Neg(value)),
                (Some(sum), false) => self.push(Operation::Add(sum, value)),
                (Some(sum), true) => self.push(Operation::Sub(sum, value)),
            });
        }
        sum.unwrap_or_else(|| self.constant(0.0))
    }

    /// `c · Π factors`, the constant taken in by the factors known earliest; but where the bare product is wanted too,
    /// or with other constants, one multiplication of it.
    fn scaled(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
        if c != 1.0 && factors.len() > 1 && self.scalings.get(factors).is_some_and(|n| *n > 1) {
            let bare = self.lower_product(1.0, factors);
            if self.program.get(bare).tier != Tier::Prepare {
                let constant = self.constant(c);
                return self.push(Operation::Mul(constant, bare));
            }
        }
        self.lower_product(c, factors)
    }

    /// `c Π base^k`, the factors in the order in which they become known.
    fn lower_product(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
        let last = factors.iter().map(|f| self.rank(f.0)).max().unwrap_or(0);
        let mut sorted = factors.to_vec();
        sorted.sort_by_key(|f| self.rank(f.0));
        let mut product = (c != 1.0).then(|| self.constant(c));
        let mut below: Option<Value> = None;
        for (base, k) in sorted {
            let value = self.done[&base];
            let early = self.rank(base) < last;
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

    /// The operand of a negation.
    fn negated(&self, value: Value) -> Option<Value> {
        match self.program.get(value).operation {
            Operation::Neg(x) => Some(x),
            _ => None,
        }
    }

    /// The value of an operation that needs none: equal operands that cancel, and zeros and ones among them.
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

    /// Adds an operation; negations move outwards, to where a sum takes them in.
    fn push(&mut self, operation: Operation) -> Value {
        if let Some(known) = self.trivial(operation) {
            return known;
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
                if let (x, y) = (inner(a), inner(b))
                    && (x.is_some() || y.is_some())
                {
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
            Operation::Call(Function::Abs, a) => {
                if let Some(x) = inner(a) {
                    return self.push(Operation::Call(Function::Abs, x));
                }
            }
            _ => {}
        }
        self.number(operation)
    }

    /// The value of an operation, which is computed once.
    fn number(&mut self, operation: Operation) -> Value {
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

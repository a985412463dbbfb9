//! Expressions → instructions: sums and products of many operands are cut so that the operands known earliest come first.

use std::collections::{HashMap, HashSet};

use super::angles::Angles;
use super::program::{Instruction, Operation, Program, Tier, Value, operands};
use crate::model::{Meaning, Symbols};
use crate::structure::is_state;
use crate::symbolic::{Arena, Expr, Function, Node, Symbol};

/// Where the unknowns of the blocks are known.
pub(crate) type Tiers = HashMap<Symbol, Tier>;

/// Builds a [`Program`].
pub(crate) struct Scheduler<'a> {
    pub(super) arena: &'a Arena,
    symbols: &'a Symbols,
    tiers: Tiers,
    pub(super) program: Program,
    pub(super) done: HashMap<Expr, Value>,
    /// Angles of which sine or cosine are wanted.
    pub(super) angles: Angles,
    /// Bases that stand in the denominator of more than one product.
    pub(super) shared_denominators: HashSet<Expr>,
}

/// `Π base^exponent`.
pub(super) type Factors = Vec<(Expr, i32)>;

impl<'a> Scheduler<'a> {
    /// A scheduler for everything in `roots`.
    pub(crate) fn new(
        arena: &'a Arena,
        symbols: &'a Symbols,
        tiers: Tiers,
        roots: &[Expr],
    ) -> Self {
        let wanted = arena.reachable(roots, |_| true);
        let mut denominators: HashMap<Expr, usize> = HashMap::new();
        for &e in &wanted {
            match arena.node(e) {
                Node::Product(factors) => {
                    for &(base, _) in factors.iter().filter(|f| f.1 < 0) {
                        *denominators.entry(base).or_default() += 1;
                    }
                }
                _ => {}
            }
        }
        let angles = Angles::new(arena, &wanted, |symbol| tier_of(symbols, &tiers, symbol));
        Self {
            arena,
            symbols,
            tiers,
            program: Program::default(),
            done: HashMap::new(),
            angles,
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
                    Function::Sin | Function::Cos => self.lower_angle(function, x),
                    _ => self.push(Operation::Call(function, value)),
                }
            }
            Node::Call2(function, x, y) => {
                let operation = Operation::Call2(*function, self.done[x], self.done[y]);
                self.push(operation)
            }
        }
    }

    pub(super) fn rank(&self, expr: Expr) -> usize {
        self.program.get(self.done[&expr]).tier.rank()
    }

    /// `c · Π factors`: with the constant taken in by the factors known earliest, or of the bare product where that exists.
    pub(super) fn scaled(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
        if c == 1.0 || factors.len() < 2 {
            return self.lower_product(c, factors);
        }
        self.cheaper(
            |this| this.lower_product(c, factors),
            |this| {
                let bare = this.lower_product(1.0, factors);
                let constant = this.constant(c);
                this.push(Operation::Mul(constant, bare))
            },
        )
    }

    /// `c Π base^k`, the factors in the order in which they become known.
    pub(super) fn lower_product(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
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

    pub(super) fn times(&mut self, product: Option<Value>, factor: Value) -> Value {
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

    pub(super) fn constant(&mut self, value: f64) -> Value {
        self.push(Operation::Constant(value.to_bits()))
    }

    /// The operand of a negation.
    pub(super) fn negated(&self, value: Value) -> Option<Value> {
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
    pub(super) fn push(&mut self, operation: Operation) -> Value {
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
            Operation::Abs(a) => {
                if let Some(x) = inner(a) {
                    return self.push(Operation::Abs(x));
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

fn tier_of(symbols: &Symbols, tiers: &Tiers, symbol: Symbol) -> Tier {
    if let Some(&tier) = tiers.get(&symbol) {
        return tier;
    }
    match symbols.meaning(symbol) {
        Meaning::Parameter { .. } | Meaning::StepSize => Tier::Prepare,
        _ if is_state(symbols, symbol) => Tier::State,
        _ => Tier::Noise,
    }
}

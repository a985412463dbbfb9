//! Expressions → instructions: sums and products of many operands are cut so that the operands known earliest come first.

use std::collections::{HashMap, HashSet};

use super::angles::Angles;
use super::instructions::{Operation, Program, Tier, Value};
use crate::algebra::{Arena, Expr, Function, Map, Node, Symbol};
use crate::structure::is_state;
use crate::system::model::{Meaning, Symbols};

/// Where the unknowns of the blocks are known.
pub(crate) type Tiers = HashMap<Symbol, Tier>;

/// Builds a [`Program`].
pub(crate) struct Scheduler<'a> {
    pub(super) arena: &'a Arena,
    pub(super) symbols: &'a Symbols,
    pub(super) tiers: Tiers,
    pub(super) program: Program,
    pub(super) done: Map<Expr, Value>,
    /// Angles of which sine or cosine are wanted.
    pub(super) angles: Angles,
    /// Bases that stand in the denominator of more than one product.
    pub(super) shared_denominators: HashSet<Expr>,
}

/// Products of more factors than this are not opened to look for shorter ways.
const OPENED: usize = 8;

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
            if let Node::Product(factors) = arena.node(e) {
                for &(base, _) in factors.iter().filter(|f| f.1 < 0) {
                    *denominators.entry(base).or_default() += 1;
                }
            }
        }
        let angles = Angles::new(arena, &wanted, |symbol| tier_of(symbols, &tiers, symbol));
        Self {
            arena,
            symbols,
            tiers,
            program: Program::default(),
            done: Map::default(),
            angles,
            shared_denominators: denominators
                .into_iter()
                .filter(|d| d.1 > 1)
                .map(|d| d.0)
                .collect(),
        }
    }

    /// Has no function of an angle follow from those of others.
    pub(crate) fn keep_angles_apart(&mut self) {
        self.angles.keep_apart();
    }

    /// The program that computes `results`.
    pub(crate) fn finish(mut self, results: &[Value]) -> Program {
        self.program.mark_live(results);
        self.program
    }

    /// The value of an expression that was asked for, or is part of one that was.
    pub(crate) fn known(&self, expr: Expr) -> Option<Value> {
        self.done.get(&expr).copied()
    }

    pub(crate) fn operation(&self, value: Value) -> Operation {
        self.program.get(value).operation
    }

    /// The value of an expression; operands first, so nothing recurses deeply.
    pub(crate) fn value(&mut self, expr: Expr) -> Value {
        if let Some(&known) = self.done.get(&expr) {
            return known;
        }
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
            Node::Opaque(x, _) => self.done[x],
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
                    Function::Abs => self.push(Operation::Abs(value)),
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
        let below_line = |this: &Self, &(base, k): &(Expr, i32)| {
            k < 0 && this.rank(base) == last && !this.shared_denominators.contains(&base)
        };
        let (below, above): (Factors, Factors) = factors.iter().partition(|f| below_line(self, f));
        let mut values = self.factors(&above);
        if c != 1.0 || (values.is_empty() && below.is_empty()) {
            values.push(self.constant(c));
        }
        let below: Vec<Value> = below
            .iter()
            .map(|&(base, k)| self.power(self.done[&base], k.unsigned_abs()))
            .collect();
        match (values.is_empty(), below.is_empty()) {
            (_, true) => self.multiply(values),
            (true, false) => {
                let below = self.multiply(below);
                self.push(Operation::Recip(below))
            }
            (false, false) => {
                let (values, below) = (self.multiply(values), self.multiply(below));
                self.push(Operation::Div(values, below))
            }
        }
    }

    /// The values of factors, denominators as reciprocals.
    pub(super) fn factors(&mut self, factors: &[(Expr, i32)]) -> Vec<Value> {
        let mut values = Vec::with_capacity(factors.len());
        for &(base, k) in factors {
            let value = self.done[&base];
            let value = if k < 0 {
                self.push(Operation::Recip(value))
            } else {
                value
            };
            values.push(self.power(value, k.unsigned_abs()));
        }
        values
    }

    /// The product of values, with the products among them opened or as they stand, whichever is less work.
    pub(super) fn multiply(&mut self, values: Vec<Value>) -> Value {
        let opened = self.open_products(&values);
        if opened.len() == values.len() || opened.len() > OPENED {
            return self.chain(values);
        }
        self.cheaper(
            |this| this.chain(opened.clone()),
            |this| this.chain(values.clone()),
        )
    }

    /// The factors of values of the last tier among them.
    fn open_products(&self, values: &[Value]) -> Vec<Value> {
        let tier = |v: Value| self.program.get(v).tier;
        let last = values.iter().map(|&v| tier(v).rank()).max().unwrap_or(0);
        let mut open = values.to_vec();
        let mut found = Vec::new();
        while let Some(value) = open.pop() {
            match self.program.get(value).operation {
                Operation::Mul(a, b)
                    if tier(value).rank() == last
                        && tier(value) != Tier::Prepare
                        && found.len() <= OPENED =>
                {
                    open.extend([a, b]);
                }
                _ => found.push(value),
            }
        }
        found
    }
}

pub(super) fn tier_of(symbols: &Symbols, tiers: &Tiers, symbol: Symbol) -> Tier {
    if let Some(&tier) = tiers.get(&symbol) {
        return tier;
    }
    match symbols.meaning(symbol) {
        Meaning::Parameter { .. } | Meaning::StepSize => Tier::Prepare,
        _ if is_state(symbols, symbol) => Tier::State,
        _ => Tier::Noise,
    }
}

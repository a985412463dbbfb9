//! Expressions → instructions. In sums and products of many operands, the operands of the earliest
//! tiers are combined first.

use std::collections::{HashMap, HashSet};

use super::angles::Angles;
use super::instructions::{Operation, Program, Tier, Value};
use crate::algebra::{Arena, Expr, Function, Map, Node, Symbol};
use crate::model::{Meaning, Symbols};
use crate::structure::is_state;

/// The tier of each unknown of the blocks.
pub(crate) type Tiers = HashMap<Symbol, Tier>;

/// Builds a [`Program`].
pub(crate) struct Scheduler<'a> {
    pub(super) arena: &'a Arena,
    pub(super) symbols: &'a Symbols,
    pub(super) tiers: Tiers,
    pub(super) program: Program,
    pub(super) done: Map<Expr, Value>,
    /// The angles whose sine or cosine is needed.
    pub(super) angles: Angles,
    /// Bases that are denominators of more than one product.
    pub(super) shared_denominators: HashSet<Expr>,
    /// The expressions that the program computes.
    pub(super) roots: Vec<Expr>,
    /// True if the denominators of a product that are shared have one reciprocal together. A
    /// division in vectors takes as long as many multiplications.
    joins_reciprocals: bool,
    /// The intermediate results, if their products stay as they are.
    pub(super) kept: Option<HashSet<Value>>,
}

/// Largest number of factors of a product that is multiplied in two ways to choose the cheaper one.
const MAX_FACTORS: usize = 8;

/// `Π base^exponent`.
pub(super) type Factors = Vec<(Expr, i32)>;

impl<'a> Scheduler<'a> {
    /// Creates a scheduler for the expressions in `roots`.
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
            roots: roots.to_vec(),
            joins_reciprocals: false,
            kept: None,
        }
    }

    /// Creates a scheduler of one tier: all is computed where the code stands.
    pub(crate) fn of_one_tier(arena: &'a Arena, symbols: &'a Symbols, roots: &[Expr]) -> Self {
        let inputs = roots.iter().flat_map(|&e| arena.symbols_of(e));
        let tiers = inputs.map(|symbol| (symbol, Tier::State)).collect();
        Self::new(arena, symbols, tiers, roots)
    }

    /// Disables the computation of sines and cosines by angle addition.
    pub(crate) fn disable_angle_addition(&mut self) {
        self.angles.disable_addition();
    }

    /// Has the shared denominators of a product computed as one reciprocal.
    pub(crate) fn join_reciprocals(&mut self) {
        self.joins_reciprocals = true;
    }

    /// Has products that are intermediate results computed as they are, and not factor by factor
    /// with the other factors of each product that uses them.
    pub(crate) fn keep_intermediate_results(&mut self) {
        self.kept = Some(HashSet::new());
    }

    /// Returns whether a value is an intermediate result that stays as it is.
    pub(super) fn is_kept(&self, value: Value) -> bool {
        self.kept.as_ref().is_some_and(|kept| kept.contains(&value))
    }

    /// Returns the program that computes `results`.
    pub(crate) fn finish(mut self, results: &[Value]) -> Program {
        self.program.mark_live(results);
        self.program
    }

    /// Returns the value of an expression that has already been scheduled, alone or as part of
    /// another one.
    pub(crate) fn known(&self, expr: Expr) -> Option<Value> {
        self.done.get(&expr).copied()
    }

    pub(crate) fn operation(&self, value: Value) -> Operation {
        self.program.get(value).operation
    }

    /// Schedules an expression and returns its value. Operands are scheduled first, so the
    /// recursion is shallow.
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
            Node::Opaque(x, _) => {
                let value = self.done[x];
                if let Some(kept) = &mut self.kept {
                    kept.insert(value);
                }
                value
            }
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

    /// Computes `c · Π factors`: as one product, or as `c` times the product without it, whichever
    /// adds less work.
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

    /// Computes `c Π base^k`, with the factors in the order of their tiers. Denominators of the
    /// last tier become one division.
    pub(super) fn lower_product(&mut self, c: f64, factors: &[(Expr, i32)]) -> Value {
        let last = factors.iter().map(|f| self.rank(f.0)).max().unwrap_or(0);
        let is_divisor = |this: &Self, &(base, k): &(Expr, i32)| {
            k < 0 && this.rank(base) == last && !this.shared_denominators.contains(&base)
        };
        let (divisors, others): (Factors, Factors) =
            factors.iter().partition(|f| is_divisor(self, f));
        let mut values = self.factors(&others);
        if c != 1.0 || (values.is_empty() && divisors.is_empty()) {
            values.push(self.constant(c));
        }
        let divisors: Vec<Value> = divisors
            .iter()
            .map(|&(base, k)| self.power(self.done[&base], k.unsigned_abs()))
            .collect();
        match (values.is_empty(), divisors.is_empty()) {
            (_, true) => self.multiply(values),
            (true, false) => {
                let divisor = self.multiply(divisors);
                self.push(Operation::Recip(divisor))
            }
            (false, false) => {
                let (dividend, divisor) = (self.multiply(values), self.multiply(divisors));
                self.push(Operation::Div(dividend, divisor))
            }
        }
    }

    /// Computes the values of factors. A negative power is a power of the reciprocal.
    pub(super) fn factors(&mut self, factors: &[(Expr, i32)]) -> Vec<Value> {
        let mut values = Vec::with_capacity(factors.len());
        let last = factors.iter().map(|f| self.rank(f.0)).max().unwrap_or(0);
        let is_joined = |this: &Self, f: &(Expr, i32)| {
            this.joins_reciprocals && f.1 < 0 && this.rank(f.0) == last
        };
        let (joined, factors): (Factors, Factors) =
            factors.iter().partition(|f| is_joined(self, f));
        if !joined.is_empty() {
            let powers = joined.iter();
            let powers = powers.map(|&(base, k)| self.power(self.done[&base], k.unsigned_abs()));
            let powers: Vec<Value> = powers.collect();
            let divisor = self.multiply(powers);
            values.push(self.push(Operation::Recip(divisor)));
        }
        for (base, k) in factors {
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

    /// Multiplies values: with the products among them split into their factors, or as they are,
    /// whichever adds less work.
    pub(super) fn multiply(&mut self, values: Vec<Value>) -> Value {
        let factors = self.split_products(&values);
        if factors.len() == values.len() || factors.len() > MAX_FACTORS {
            return self.chain(values);
        }
        self.cheaper(
            |this| this.chain(factors.clone()),
            |this| this.chain(values.clone()),
        )
    }

    /// Splits the values that are products of the last tier into their factors.
    fn split_products(&self, values: &[Value]) -> Vec<Value> {
        let tier = |v: Value| self.program.get(v).tier;
        let last = values.iter().map(|&v| tier(v).rank()).max().unwrap_or(0);
        let mut open = values.to_vec();
        let mut found = Vec::new();
        while let Some(value) = open.pop() {
            match self.program.get(value).operation {
                Operation::Mul(a, b)
                    if tier(value).rank() == last
                        && tier(value) != Tier::Prepare
                        && !self.is_kept(value)
                        && found.len() <= MAX_FACTORS =>
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
        Meaning::Parameter { input: None, .. } | Meaning::StepSize => Tier::Prepare,
        Meaning::Parameter { .. } => Tier::State,
        _ if is_state(symbols, symbol) => Tier::State,
        _ => Tier::Noise,
    }
}

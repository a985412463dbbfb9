//! What values are, as far as it is known: the material for their names.

use std::collections::HashMap;

use super::names::symbol_name;
use super::{Operation, Scheduler, Value};
use crate::algebra::{self, Arena, Expr};
use crate::structure::Matrix;
use crate::system::model::{AtNode, Meaning, Quantity, Symbols};

/// Longest name of an angle or argument.
const WORD: usize = 40;

/// What values are, as far as it is known.
#[derive(Default)]
pub(crate) struct Labels {
    pub(super) values: HashMap<Value, String>,
    /// Angles of pairs of sine and cosine.
    pub(super) pairs: HashMap<Value, String>,
}

impl Labels {
    /// Calls a value; the first name stays.
    pub(crate) fn call(&mut self, value: Value, name: String) {
        self.values.entry(value).or_insert(name);
    }

    /// Calls the values of a vector `name_0`, `name_1`, …, counted from `first`.
    pub(crate) fn vector(&mut self, name: &str, first: usize, values: &[Value]) {
        for (i, &value) in values.iter().enumerate() {
            self.call(value, format!("{name}_{}", first + i));
        }
    }

    /// Calls the stored entries of a matrix `name_0_1`, rows and columns counted from `first`.
    pub(crate) fn matrix(&mut self, name: &str, first: usize, matrix: &Matrix<Value>) {
        for (i, row) in matrix.rows.iter().enumerate() {
            let column = first + matrix.first_column(i);
            for (k, &value) in row.iter().enumerate() {
                self.call(value, format!("{name}_{}_{}", first + i, column + k));
            }
        }
    }

    /// Calls the entries of rows `name_0_1`, rows and columns counted from `first`.
    pub(crate) fn rows(&mut self, name: &str, first: usize, rows: &[Vec<Value>]) {
        for (i, row) in rows.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                self.call(value, format!("{name}_{}_{}", first + i, first + j));
            }
        }
    }

    /// Calls the entries of a matrix that is applied to the state `map_0_1`, rows and columns in the order q, p.
    pub(crate) fn map(
        &mut self,
        scheduler: &Scheduler<'_>,
        arena: &Arena,
        symbols: &Symbols,
        rows: &[Expr],
    ) {
        let column = |e: Expr| match arena.node(e) {
            algebra::Node::Symbol(symbol) => match symbols.meaning(*symbol) {
                Meaning::Start(Quantity::Position, j) => Some(*j),
                Meaning::Start(Quantity::Momentum, j) => Some(rows.len() / 2 + j),
                _ => None,
            },
            _ => None,
        };
        for (i, &row) in rows.iter().enumerate() {
            for term in arena.operands_of(row) {
                if let algebra::Node::Product(factors) = arena.node(term)
                    && let [(a, 1), (b, 1)] = factors.as_slice()
                    && let (Some(j), entry) = match column(*a) {
                        Some(j) => (Some(j), *b),
                        None => (column(*b), *a),
                    }
                    && let Some(value) = scheduler.known(entry)
                {
                    self.call(value, format!("map_{i}_{j}"));
                    // sums take negations in
                    if let Operation::Neg(opposite) = scheduler.operation(value) {
                        self.call(opposite, format!("minus_map_{i}_{j}"));
                    }
                }
            }
        }
    }

    /// Calls nodes, given expressions and functions of them by their names, of all that `roots` are made of.
    pub(crate) fn expressions(
        &mut self,
        scheduler: &Scheduler<'_>,
        arena: &Arena,
        symbols: &Symbols,
        given: &[(Expr, String)],
        roots: &[Expr],
    ) {
        let words = Words {
            arena,
            symbols,
            given,
        };
        for e in arena.reachable(roots, |_| true) {
            let Some(value) = scheduler.known(e) else {
                continue;
            };
            match *arena.node(e) {
                algebra::Node::Opaque(..) => {
                    if let Some(word) = words.named(e) {
                        self.call(value, word);
                    }
                }
                algebra::Node::Call(function, x) => {
                    if let Some(word) = words.of(x) {
                        match scheduler.operation(value) {
                            Operation::SinOf(pair) | Operation::CosOf(pair) => {
                                self.pairs.entry(pair).or_insert(word);
                            }
                            _ => self.call(value, format!("{}_{word}", function.name())),
                        }
                    }
                }
                _ => {}
            }
        }
    }
}

/// Words for expressions that are short to say.
struct Words<'a> {
    arena: &'a Arena,
    symbols: &'a Symbols,
    given: &'a [(Expr, String)],
}

impl Words<'_> {
    /// Given names, and `q_node_0` for a node.
    fn named(&self, expr: Expr) -> Option<String> {
        if let Some((_, name)) = self.given.iter().find(|g| g.0 == expr) {
            return Some(name.clone());
        }
        AtNode::of(expr, self.arena).map(|quantity| quantity.to_string())
    }

    /// A symbol, a name, or `a_minus_b`.
    fn of(&self, expr: Expr) -> Option<String> {
        let word = match self.arena.node(expr) {
            algebra::Node::Sum(constant, terms) if constant.get() == 0.0 => {
                match terms.as_slice() {
                    [(a, c), (b, d)] if c.get() == 1.0 && d.get().abs() == 1.0 => {
                        let between = if d.get() < 0.0 { "minus" } else { "plus" };
                        format!("{}_{between}_{}", self.word(*a)?, self.word(*b)?)
                    }
                    _ => return None,
                }
            }
            _ => self.word(expr)?,
        };
        (word.len() <= WORD).then_some(word)
    }

    fn word(&self, expr: Expr) -> Option<String> {
        match self.arena.node(expr) {
            algebra::Node::Symbol(symbol) => Some(symbol_name(self.symbols, *symbol)),
            algebra::Node::Opaque(..) => self.named(expr),
            _ => None,
        }
    }
}

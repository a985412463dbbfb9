//! Labels of values: words for what a value is, from which its name in the generated code is made.

use std::collections::HashMap;

use super::names::symbol_name;
use super::{Operation, Scheduler, Value};
use crate::algebra::{self, Arena, Expr};
use crate::model::{AtNode, Meaning, Quantity, Symbols};
use crate::structure::Matrix;

/// Longest label of an angle or argument, in bytes.
const LONGEST: usize = 40;

/// The labels of the values that have one.
#[derive(Default)]
pub(crate) struct Labels {
    pub(super) values: HashMap<Value, String>,
    /// For each pair of sine and cosine, the label of its angle.
    pub(super) pairs: HashMap<Value, String>,
}

impl Labels {
    /// Labels a value that has no label yet.
    pub(crate) fn call(&mut self, value: Value, name: String) {
        self.values.entry(value).or_insert(name);
    }

    /// Labels the values of a vector `name_0`, `name_1`, …, counted from `first`.
    pub(crate) fn vector(&mut self, name: &str, first: usize, values: &[Value]) {
        for (i, &value) in values.iter().enumerate() {
            self.call(value, format!("{name}_{}", first + i));
        }
    }

    /// Labels the stored entries of a matrix `name_0_1`, rows and columns counted from `first`.
    pub(crate) fn matrix(&mut self, name: &str, first: usize, matrix: &Matrix<Value>) {
        for (i, row) in matrix.rows.iter().enumerate() {
            let column = first + matrix.first_column(i);
            for (k, &value) in row.iter().enumerate() {
                self.call(value, format!("{name}_{}_{}", first + i, column + k));
            }
        }
    }

    /// Labels the entries of rows `name_0_1`, rows and columns counted from `first`.
    pub(crate) fn rows(&mut self, name: &str, first: usize, rows: &[Vec<Value>]) {
        for (i, row) in rows.iter().enumerate() {
            for (j, &value) in row.iter().enumerate() {
                self.call(value, format!("{name}_{}_{}", first + i, first + j));
            }
        }
    }

    /// Labels the entries of the matrix that is multiplied with the state `map_0_1`, rows and
    /// columns in the order q, p.
    pub(crate) fn map(&mut self, scheduler: &Scheduler<'_>, rows: &[Expr]) {
        let (arena, symbols) = (scheduler.arena, scheduler.symbols);
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
                    // a sum with a negation is a subtraction, which uses the negation's operand
                    if let Operation::Neg(opposite) = scheduler.operation(value) {
                        self.call(opposite, format!("minus_map_{i}_{j}"));
                    }
                }
            }
        }
    }

    /// Labels all subexpressions of the scheduler's roots that are quantities at a node, are in
    /// `given`, or are functions of such expressions.
    pub(crate) fn expressions(&mut self, scheduler: &Scheduler<'_>, given: &[(Expr, String)]) {
        let (arena, symbols) = (scheduler.arena, scheduler.symbols);
        let words = Words {
            arena,
            symbols,
            given,
        };
        for e in arena.reachable(&scheduler.roots, |_| true) {
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

/// Makes labels for expressions.
struct Words<'a> {
    arena: &'a Arena,
    symbols: &'a Symbols,
    given: &'a [(Expr, String)],
}

impl Words<'_> {
    /// Returns the given name of an expression, or the name of a quantity at a node, such as
    /// `q_node_0`.
    fn named(&self, expr: Expr) -> Option<String> {
        if let Some((_, name)) = self.given.iter().find(|g| g.0 == expr) {
            return Some(name.clone());
        }
        AtNode::of(expr, self.arena).map(|quantity| quantity.to_string())
    }

    /// Returns the label of a symbol, of a named expression, or of a sum or difference of two of
    /// them, such as `a_minus_b`.
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
        (word.len() <= LONGEST).then_some(word)
    }

    fn word(&self, expr: Expr) -> Option<String> {
        match self.arena.node(expr) {
            algebra::Node::Symbol(symbol) => Some(symbol_name(self.symbols, *symbol)),
            algebra::Node::Opaque(..) => self.named(expr),
            _ => None,
        }
    }
}

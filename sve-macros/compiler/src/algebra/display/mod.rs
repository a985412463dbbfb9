//! Expressions as readable mathematics: `v²/(2·a) − a·q²/2`.
//!
//! Input: an expression, and a [`Notation`] that gives the names of symbols and of subexpressions.
//! Output: text that means the expression under the usual rules: `·` and `/` from left to right,
//! powers before them; `√` applies to the operand directly behind it. Negative powers stand in the
//! denominator, and sums begin with a positive term. The length of the text is limited, and no
//! expression is walked as a tree beyond this limit.

mod printer;

use printer::{Inside, Printer, Product};

use super::expr::{Arena, Expr, Node, Symbol};

/// The names of symbols and subexpressions in a text.
pub(crate) trait Notation {
    fn symbol(&self, symbol: Symbol) -> String;
    /// Returns the rank of a symbol among the factors of a product; the smallest comes first.
    fn place(&self, symbol: Symbol) -> u8;
    /// Returns the name that is written instead of an expression.
    fn name(&self, expr: Expr) -> Option<&str>;
}

/// A printed text, and the expressions in it that were printed as their names.
pub(crate) struct Text {
    pub(crate) text: String,
    pub(crate) named: Vec<Expr>,
}

/// `constant + Σ coefficient · term`, in this order.
#[derive(Default)]
pub(crate) struct Sum {
    pub(crate) constant: f64,
    pub(crate) terms: Vec<(Expr, f64)>,
}

impl Sum {
    /// Adds a multiple of an expression. Like terms are collected at the position of the first of
    /// them.
    pub(crate) fn add(&mut self, c: f64, expr: Expr, arena: &Arena) {
        let terms: Vec<(Expr, f64)> = match arena.node(expr) {
            Node::Constant(value) => {
                self.constant += c * value.get();
                return;
            }
            Node::Sum(constant, terms) => {
                self.constant += c * constant.get();
                terms.iter().map(|t| (t.0, c * t.1.get())).collect()
            }
            _ => vec![(expr, c)],
        };
        if self.terms.is_empty() {
            self.terms = terms;
            return;
        }
        for (term, c) in terms {
            match self.terms.iter_mut().find(|t| t.0 == term) {
                Some(known) => known.1 += c,
                None => self.terms.push((term, c)),
            }
        }
        self.terms.retain(|t| t.1 != 0.0);
    }

    pub(crate) fn is_zero(&self) -> bool {
        self.constant == 0.0 && self.terms.is_empty()
    }
}

impl Arena {
    /// Prints `expr`; returns `None` if the text has more than `limit` characters.
    pub(crate) fn display(
        &self,
        expr: Expr,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.print(expr, Inside::Sum))
    }

    /// Prints the operation that a named expression stands for, instead of its name.
    pub(crate) fn display_definition(
        &self,
        expr: Expr,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.open(expr, Inside::Sum))
    }

    /// Prints a sum.
    pub(crate) fn display_sum(
        &self,
        sum: &Sum,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.sum(sum))
    }

    /// Prints a sum as a factor of the text that follows it. Returns whether a minus sign stands in
    /// front, and the text without the sign.
    pub(crate) fn display_factor(
        &self,
        sum: &Sum,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<(bool, Text)> {
        let Sum { constant, terms } = sum;
        let (negative, text) = match terms.as_slice() {
            [] => {
                let print =
                    |p: &mut Printer<'_>| p.scaled(constant.abs(), Vec::new(), Inside::Term);
                (*constant < 0.0, self.printed(limit, notation, print))
            }
            [(term, c)] if *constant == 0.0 => {
                let product = self.signed(*c, self.factors_of(*term, notation), notation);
                let print = |p: &mut Printer<'_>| p.quotient(&product, Inside::Term);
                (product.negative, self.printed(limit, notation, print))
            }
            _ => {
                let negative = *constant <= 0.0 && terms.iter().all(|t| t.1 < 0.0);
                let sign = if negative { -1.0 } else { 1.0 };
                let sum = Sum {
                    constant: sign * constant,
                    terms: terms.iter().map(|&(x, c)| (x, sign * c)).collect(),
                };
                let print = |p: &mut Printer<'_>| p.bracketed(true, |p| p.sum(&sum));
                (negative, self.printed(limit, notation, print))
            }
        };
        Some((negative, text?))
    }

    /// Returns the number of operations in `roots`; a shared expression counts once.
    pub(crate) fn operations(&self, roots: &[Expr]) -> usize {
        let count = |e: &Expr| match self.node(*e) {
            Node::Constant(_) | Node::Symbol(_) | Node::Opaque(..) => 0,
            Node::Sum(constant, terms) => {
                let scaled = terms.iter().filter(|t| t.1.get().abs() != 1.0).count();
                terms.len() - 1 + scaled + usize::from(constant.get() != 0.0)
            }
            Node::Product(factors) => {
                let powers = factors
                    .iter()
                    .map(|f| f.1.unsigned_abs() as usize)
                    .sum::<usize>();
                powers.max(2) - 1
            }
            Node::Call(..) | Node::Call2(..) => 1,
        };
        self.reachable(roots, |_| true).iter().map(count).sum()
    }

    fn printed(
        &self,
        limit: usize,
        notation: &dyn Notation,
        print: impl FnOnce(&mut Printer<'_>),
    ) -> Option<Text> {
        let mut printer = Printer {
            arena: self,
            notation,
            left: limit,
            depth: 0,
            too_long: false,
            text: String::new(),
            named: Vec::new(),
        };
        print(&mut printer);
        let Printer {
            text,
            named,
            too_long,
            ..
        } = printer;
        (!too_long).then_some(Text { text, named })
    }

    /// Returns `c Π base^exponent` with its sign. A minus sign in front of a difference is removed
    /// by exchanging its two terms.
    fn signed(&self, c: f64, factors: Vec<(Expr, i32)>, notation: &dyn Notation) -> Product {
        let is_difference = |&&(base, k): &&(Expr, i32)| match self.node(base) {
            Node::Sum(constant, terms) if k == 1 && notation.name(base).is_none() => {
                let signs = terms.iter().map(|t| t.1).chain([*constant]);
                terms.len() + usize::from(constant.get() != 0.0) > 1
                    && signs.into_iter().any(|c| c.get() < 0.0)
            }
            _ => false,
        };
        let turned = match factors.iter().find(is_difference) {
            Some(&(base, _)) if c < 0.0 => Some(base),
            _ => None,
        };
        Product {
            negative: c < 0.0 && turned.is_none(),
            magnitude: c.abs(),
            factors,
            turned,
        }
    }

    /// Returns the factors of a term.
    fn factors_of(&self, term: Expr, notation: &dyn Notation) -> Vec<(Expr, i32)> {
        match self.node(term) {
            Node::Product(factors) if notation.name(term).is_none() => factors.clone(),
            _ => vec![(term, 1)],
        }
    }
}

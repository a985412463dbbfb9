//! Expressions → text: signs, quotients, powers and brackets.

use super::{Notation, Sum};
use crate::algebra::expr::{Arena, Binary, Expr, Function, Node};
use crate::algebra::functions::{BinaryNotation as BinaryWritten, Notation as Written};
use crate::algebra::number::{decimal, fraction, superscript};

/// The operation that an expression is an operand of, in the order in which more operands need
/// brackets.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Inside {
    Sum,
    /// Beside plus or minus.
    Term,
    /// Beside `·` or `/`.
    Factor,
    /// Below an exponent.
    Base,
}

/// Nesting beyond which a formula is not printed, since nobody could read it.
const DEPTH: usize = 40;

/// `± magnitude Π base^exponent`. The base `turned` is printed with its sign reversed.
pub(super) struct Product {
    pub(super) negative: bool,
    pub(super) magnitude: f64,
    pub(super) factors: Vec<(Expr, i32)>,
    pub(super) turned: Option<Expr>,
}

pub(super) struct Printer<'a> {
    pub(super) arena: &'a Arena,
    pub(super) notation: &'a dyn Notation,
    /// Characters that may still be written.
    pub(super) left: usize,
    pub(super) depth: usize,
    pub(super) too_long: bool,
    pub(super) text: String,
    pub(super) named: Vec<Expr>,
}

impl Printer<'_> {
    pub(super) fn put(&mut self, text: &str) {
        let length = text.chars().count();
        self.too_long |= length > self.left;
        self.left = self.left.saturating_sub(length);
        if !self.too_long {
            self.text.push_str(text);
        }
    }

    pub(super) fn print(&mut self, expr: Expr, inside: Inside) {
        if let Some(name) = self.notation.name(expr) {
            self.named.push(expr);
            self.put(name);
        } else {
            self.open(expr, inside);
        }
    }

    /// Prints the operation of an expression, even if the expression has a name.
    pub(super) fn open(&mut self, expr: Expr, inside: Inside) {
        if self.too_long || self.depth == DEPTH {
            self.too_long = true;
            return;
        }
        self.depth += 1;
        match self.arena.node(expr) {
            Node::Constant(bits) => self.scaled(bits.get(), Vec::new(), inside),
            Node::Symbol(symbol) => self.put(&self.notation.symbol(*symbol)),
            Node::Opaque(x, _) => self.print(*x, inside),
            Node::Sum(constant, terms) => match terms.as_slice() {
                [(term, c)] if constant.get() == 0.0 => {
                    let factors = self.arena.factors_of(*term, self.notation);
                    self.scaled(c.get(), factors, inside);
                }
                _ => {
                    let mut sum = Sum::default();
                    sum.add(1.0, expr, self.arena);
                    self.bracketed(inside > Inside::Sum, |p| p.sum(&sum));
                }
            },
            Node::Product(factors) => self.scaled(1.0, factors.clone(), inside),
            Node::Call(function, x) => self.call(*function, *x, inside),
            Node::Call2(function, x, y) => self.call2(*function, *x, *y, inside),
        }
        self.depth -= 1;
    }

    /// Prints a sum. A positive constant stands before the terms and a negative one behind them;
    /// positive terms stand before negative ones.
    pub(super) fn sum(&mut self, sum: &Sum) {
        let Sum { constant, terms } = sum;
        let mut first = true;
        if *constant > 0.0 || terms.is_empty() {
            self.scaled(*constant, Vec::new(), Inside::Sum);
            first = false;
        }
        let lead = terms.iter().position(|t| t.1 > 0.0).unwrap_or(0);
        let lead = if first { lead } else { 0 };
        let rest = terms.iter().enumerate().filter(|(at, _)| *at != lead);
        for (term, c) in terms.get(lead).into_iter().chain(rest.map(|(_, t)| t)) {
            if self.too_long {
                return;
            }
            let factors = self.arena.factors_of(*term, self.notation);
            let product = self.arena.signed(*c, factors, self.notation);
            self.sign(product.negative, first);
            self.quotient(&product, Inside::Term);
            first = false;
        }
        if *constant < 0.0 && !terms.is_empty() {
            self.sign(true, false);
            self.scaled(-constant, Vec::new(), Inside::Term);
        }
    }

    pub(super) fn sign(&mut self, negative: bool, first: bool) {
        match (first, negative) {
            (true, true) => self.put("−"),
            (true, false) => {}
            (false, true) => self.put(" − "),
            (false, false) => self.put(" + "),
        }
    }

    /// Prints `c Π base^exponent` for any sign of `c`.
    pub(super) fn scaled(&mut self, c: f64, factors: Vec<(Expr, i32)>, inside: Inside) {
        if c == 0.0 {
            self.put("0");
            return;
        }
        let product = self.arena.signed(c, factors, self.notation);
        if product.negative {
            self.bracketed(inside > Inside::Sum, |p| {
                p.put("−");
                p.quotient(&product, Inside::Term);
            });
        } else {
            self.quotient(&product, inside);
        }
    }

    /// Prints a product without its sign, with negative powers in the denominator.
    pub(super) fn quotient(&mut self, product: &Product, inside: Inside) {
        let Product {
            negative: _,
            magnitude,
            factors,
            turned,
        } = product;
        let number = fraction(*magnitude);
        if let [(base, k)] = *factors.as_slice()
            && k > 0
            && *magnitude == 1.0
        {
            let open = k > 1 && inside == Inside::Base;
            let around = if k == 1 { inside } else { Inside::Base };
            self.bracketed(open, |p| p.power(base, k, around, *turned));
            return;
        }
        let mut sorted = factors.clone();
        sorted.sort_by_key(|f| self.place(f.0));
        let (above, below): (Vec<_>, Vec<_>) = sorted.into_iter().partition(|f| f.1 > 0);
        let below: Vec<_> = below.into_iter().map(|(x, k)| (x, -k)).collect();
        let alone = factors.is_empty() && number.below.is_empty() && !number.above.contains('·');
        self.bracketed(inside > Inside::Term && !alone, |p| {
            let nothing = number.above.is_empty() && above.is_empty();
            p.factors(if nothing { "1" } else { &number.above }, &above, *turned);
            let count = usize::from(!number.below.is_empty()) + below.len();
            if count > 0 {
                p.put("/");
                p.bracketed(count > 1, |p| p.factors(&number.below, &below, None));
            }
        });
    }

    pub(super) fn factors(&mut self, number: &str, factors: &[(Expr, i32)], turned: Option<Expr>) {
        self.put(number);
        let mut first = number.is_empty();
        for &(base, k) in factors {
            if !first {
                self.put("·");
            }
            first = false;
            let inside = if k == 1 { Inside::Factor } else { Inside::Base };
            self.power(base, k, inside, turned);
        }
    }

    pub(super) fn power(&mut self, base: Expr, k: i32, inside: Inside, turned: Option<Expr>) {
        if turned == Some(base) {
            let mut sum = Sum::default();
            sum.add(-1.0, base, self.arena);
            self.bracketed(inside > Inside::Sum, |p| p.sum(&sum));
        } else {
            self.print(base, inside);
        }
        if k != 1 {
            let raised: String = k.to_string().chars().map(superscript).collect();
            self.put(&raised);
        }
    }

    /// Returns the rank of a factor in a product: parameters come first, then symbols of the step,
    /// functions and sums.
    pub(super) fn place(&self, expr: Expr) -> u8 {
        const FUNCTION: u8 = 100;
        const SUM: u8 = 101;
        match self.arena.node(expr) {
            _ if self.notation.name(expr).is_some() => FUNCTION,
            Node::Symbol(symbol) => self.notation.place(*symbol),
            Node::Sum(..) => SUM,
            _ => FUNCTION,
        }
    }

    /// Prints a call of two arguments.
    fn call2(&mut self, function: Binary, x: Expr, y: Expr, inside: Inside) {
        match function.entry().notation {
            BinaryWritten::Power => self.bracketed(inside == Inside::Base, |p| {
                p.print(x, Inside::Base);
                p.put("^");
                p.print(y, Inside::Base);
            }),
            BinaryWritten::Name => {
                self.put(function.name());
                self.bracketed(true, |p| {
                    p.print(x, Inside::Sum);
                    p.put(", ");
                    p.print(y, Inside::Sum);
                });
            }
        }
    }

    pub(super) fn call(&mut self, function: Function, x: Expr, inside: Inside) {
        let name = match function.entry().notation {
            Written::Name(name) => name,
            Written::Radical(root) => {
                let short = matches!(self.arena.node(x), Node::Symbol(_))
                    || self.notation.name(x).is_some();
                self.bracketed(inside == Inside::Base, |p| {
                    p.put(root);
                    p.bracketed(!short, |p| p.print(x, Inside::Sum));
                });
                return;
            }
            Written::PowerOf(base) => {
                self.bracketed(inside == Inside::Base, |p| {
                    p.put(base);
                    p.put("^");
                    p.print(x, Inside::Base);
                });
                return;
            }
            Written::Power => {
                let k = function.exponent();
                self.bracketed(inside == Inside::Base, |p| {
                    p.print(x, Inside::Base);
                    p.put("^");
                    p.bracketed(k < 0.0, |p| {
                        p.put(if k < 0.0 { "−" } else { "" });
                        p.put(&decimal(k.abs()));
                    });
                });
                return;
            }
            Written::ExpMinusOne => {
                self.bracketed(inside > Inside::Sum, |p| {
                    p.put("exp");
                    p.bracketed(true, |p| p.print(x, Inside::Sum));
                    p.put(" − 1");
                });
                return;
            }
            Written::LogOfOnePlus => {
                self.put("ln(1 + ");
                self.print(x, Inside::Term);
                self.put(")");
                return;
            }
        };
        self.put(name);
        self.bracketed(true, |p| p.print(x, Inside::Sum));
    }

    pub(super) fn bracketed(&mut self, open: bool, print: impl FnOnce(&mut Self)) {
        if open {
            self.put("(");
        }
        print(self);
        if open {
            self.put(")");
        }
    }
}

//! Expressions as readable mathematics: `v²/(2·a) − a·q²/2`.
//!
//! Input: an expression, and a [`Notation`] that says how symbols are called and which subexpressions have names. Output:
//! text that means the expression under the usual rules: `·` and `/` from left to right, powers before them, `√` takes what
//! stands right behind it. Negative powers are written below the line, sums with a positive term first. Text has a limit;
//! nothing is walked as a tree beyond it.

use super::expr::{Arena, Binary, Expr, Function, Node, Symbol};
use super::functions::Notation as Written;
use super::number::{decimal, fraction, superscript};

/// How things are called.
pub(crate) trait Notation {
    fn symbol(&self, symbol: Symbol) -> String;
    /// Where a symbol stands among the factors of a product: the smallest first.
    fn place(&self, symbol: Symbol) -> u8;
    /// The name that is written instead of an expression.
    fn name(&self, expr: Expr) -> Option<&str>;
}

/// A text, and the expressions in it that were written as their names.
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
    /// Adds a multiple of an expression; like terms are collected, where the first of them stands.
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

/// What surrounds an expression: from the one that needs no brackets to the one that needs them most.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Inside {
    Sum,
    /// Beside plus or minus.
    Term,
    /// Beside `·` or `/`.
    Factor,
    /// Below an exponent.
    Base,
}

/// Nesting beyond which nobody reads on.
const DEPTH: usize = 40;

impl Arena {
    /// `expr`, or nothing where it has more than `limit` characters.
    pub(crate) fn display(
        &self,
        expr: Expr,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.print(expr, Inside::Sum))
    }

    /// What a named expression is.
    pub(crate) fn display_definition(
        &self,
        expr: Expr,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.open(expr, Inside::Sum))
    }

    /// A sum.
    pub(crate) fn display_sum(
        &self,
        sum: &Sum,
        limit: usize,
        notation: &dyn Notation,
    ) -> Option<Text> {
        self.printed(limit, notation, |p| p.sum(sum))
    }

    /// A sum as a factor of what follows it: whether a minus stands in front, and the rest.
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

    /// Operations that expressions are made of, each counted once.
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

    /// `c Π base^exponent` with its sign: a minus in front of a difference turns the difference round.
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

    /// The factors of a term.
    fn factors_of(&self, term: Expr, notation: &dyn Notation) -> Vec<(Expr, i32)> {
        match self.node(term) {
            Node::Product(factors) if notation.name(term).is_none() => factors.clone(),
            _ => vec![(term, 1)],
        }
    }
}

/// `± magnitude Π base^exponent`, one of the bases with its sign turned round.
struct Product {
    negative: bool,
    magnitude: f64,
    factors: Vec<(Expr, i32)>,
    turned: Option<Expr>,
}

struct Printer<'a> {
    arena: &'a Arena,
    notation: &'a dyn Notation,
    /// Characters that may still be written.
    left: usize,
    depth: usize,
    too_long: bool,
    text: String,
    named: Vec<Expr>,
}

impl Printer<'_> {
    fn put(&mut self, text: &str) {
        let length = text.chars().count();
        self.too_long |= length > self.left;
        self.left = self.left.saturating_sub(length);
        if !self.too_long {
            self.text.push_str(text);
        }
    }

    fn print(&mut self, expr: Expr, inside: Inside) {
        if let Some(name) = self.notation.name(expr) {
            self.named.push(expr);
            self.put(name);
        } else {
            self.open(expr, inside);
        }
    }

    /// Prints what an expression is made of, even where it has a name.
    fn open(&mut self, expr: Expr, inside: Inside) {
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
            Node::Call2(Binary::Pow, x, y) => self.bracketed(inside == Inside::Base, |p| {
                p.print(*x, Inside::Base);
                p.put("^");
                p.print(*y, Inside::Base);
            }),
            Node::Call2(function, x, y) => {
                self.put(function.name());
                self.bracketed(true, |p| {
                    p.print(*x, Inside::Sum);
                    p.put(", ");
                    p.print(*y, Inside::Sum);
                });
            }
        }
        self.depth -= 1;
    }

    /// A positive constant stands before the terms, a negative one behind them; a positive term before negative ones.
    fn sum(&mut self, sum: &Sum) {
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

    fn sign(&mut self, negative: bool, first: bool) {
        match (first, negative) {
            (true, true) => self.put("−"),
            (true, false) => {}
            (false, true) => self.put(" − "),
            (false, false) => self.put(" + "),
        }
    }

    /// `c Π base^exponent` for any sign of `c`.
    fn scaled(&mut self, c: f64, factors: Vec<(Expr, i32)>, inside: Inside) {
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

    /// A product without its sign, negative powers below the line.
    fn quotient(&mut self, product: &Product, inside: Inside) {
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

    fn factors(&mut self, number: &str, factors: &[(Expr, i32)], turned: Option<Expr>) {
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

    fn power(&mut self, base: Expr, k: i32, inside: Inside, turned: Option<Expr>) {
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

    /// Parameters, then symbols of the step, functions, sums.
    fn place(&self, expr: Expr) -> u8 {
        const FUNCTION: u8 = 100;
        const SUM: u8 = 101;
        match self.arena.node(expr) {
            _ if self.notation.name(expr).is_some() => FUNCTION,
            Node::Symbol(symbol) => self.notation.place(*symbol),
            Node::Sum(..) => SUM,
            _ => FUNCTION,
        }
    }

    fn call(&mut self, function: Function, x: Expr, inside: Inside) {
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

    fn bracketed(&mut self, open: bool, print: impl FnOnce(&mut Self)) {
        if open {
            self.put("(");
        }
        print(self);
        if open {
            self.put(")");
        }
    }
}

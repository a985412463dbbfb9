//! Differences in sums that cancel by their form, and the stable forms that replace them.
//!
//! Input: the terms of a sum. Output: the sum in stable form, or `None` if it contains no
//! difference of the table in [`super`]. A difference is a pair of terms `c a f` and `−c u a`,
//! where f comes close to the constant u.

use super::{Factors, Forms, divided};
use crate::algebra::expr::{Expr, Function, Node};
use crate::algebra::functions::Form;
use crate::algebra::simplify::times_divisible;

/// The form in which the factor f of `a f − a` is recognised.
#[derive(Clone, Copy)]
enum Reading {
    /// `√radicand^k`, k = ±1.
    Root(Expr, i32),
    /// A function or its square, with the form of its difference from 1 and the argument.
    Form(Form, Expr),
    /// `exp(x)^k`, with the form of `exp(x) − 1`.
    Power(Form, Expr, i32),
    /// `sinh²/cosh²`, with the form of `tanh² − 1` and the call of cosh.
    QuotientSquare(Form, Expr),
    /// The square of one leg over the square of the hypotenuse. Holds the reciprocal of the
    /// constant factor of this leg, and the other leg.
    Leg(f64, Expr),
}

/// The part of a sum that a term cancels with.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Beside {
    Constant,
    Term(usize),
}

/// A term `scale · a · f` of a sum that cancels with a part `−scale · value · a`.
struct Difference {
    /// The position of the term.
    at: usize,
    /// The part that it cancels with.
    beside: Beside,
    /// The factors of `a`; empty if `a` is 1.
    common: Factors,
    /// `scale · value`.
    balance: f64,
    scale: f64,
    /// `f − value`.
    rest: Expr,
}

impl Forms<'_> {
    /// Returns the stable form of a sum in which terms cancel.
    pub(super) fn sum(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Option<Expr> {
        let mut used = vec![false; terms.len()];
        let mut constant = constant;
        let mut new: Vec<(f64, Expr)> = Vec::new();
        let mut waiting: Vec<(Beside, Vec<Difference>)> = Vec::new();
        for at in 0..terms.len() {
            for difference in self.differences(at, constant, terms) {
                match waiting.iter_mut().find(|w| w.0 == difference.beside) {
                    Some(group) => group.1.push(difference),
                    None => waiting.push((difference.beside, vec![difference])),
                }
            }
        }
        for (beside, group) in waiting {
            let (value, taken) = match beside {
                Beside::Constant => (constant, false),
                Beside::Term(at) => (terms[at].1, used[at]),
            };
            if taken {
                continue;
            }
            let group: Vec<&Difference> = group.iter().filter(|d| !used[d.at]).collect();
            for difference in cancelling(value, &group) {
                used[difference.at] = true;
                match beside {
                    Beside::Constant => constant = 0.0,
                    Beside::Term(at) => used[at] = true,
                }
                let common = self.product(&difference.common);
                let whole = self.arena.mul(common, difference.rest);
                new.push((difference.scale, whole));
            }
        }
        if new.is_empty() {
            return self.square_from_one(constant, terms);
        }
        let left = terms.iter().zip(&used).filter(|t| !t.1);
        new.extend(left.map(|(t, _)| (t.1, self.of(t.0))));
        Some(self.arena.sum(constant, &new))
    }

    /// Finds the part of a sum that is a multiple of `common`: a term, or the constant. Creates no
    /// expression, since most terms belong to no difference.
    fn beside(&self, common: &Factors, constant: f64, terms: &[(Expr, f64)]) -> Option<Beside> {
        let common = match common.as_slice() {
            [] => return (constant != 0.0).then_some(Beside::Constant),
            &[(base, 1)] => base,
            _ => self.arena.known_product(common)?,
        };
        terms.iter().position(|t| t.0 == common).map(Beside::Term)
    }

    /// Returns the stable form of `a − a x²` if x is a symbol and so without rounding error.
    fn square_from_one(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Option<Expr> {
        let &[(term, c)] = terms else { return None };
        let Node::Product(factors) = self.arena.node(term) else {
            return None;
        };
        let &[(x, 2)] = factors.as_slice() else {
            return None;
        };
        if c != -constant || !matches!(self.arena.node(x), Node::Symbol(_)) {
            return None;
        }
        let minus = self.arena.sum(1.0, &[(-1.0, x)]);
        let plus = self.arena.sum(1.0, &[(1.0, x)]);
        let both = self.arena.mul(minus, plus);
        Some(self.arena.scale(constant, both))
    }

    /// Returns all readings of a term as part of a difference of the table.
    fn differences(&mut self, at: usize, constant: f64, terms: &[(Expr, f64)]) -> Vec<Difference> {
        let (term, c) = terms[at];
        let factors = match self.arena.node(term) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(term, 1)],
        };
        let mut found = Vec::new();
        for &(base, k) in &factors {
            for (reading, taken) in self.readings(&factors, base, k) {
                let common = taken.iter().fold(factors.clone(), |left, &(base, power)| {
                    divided(&left, &[(base, 1)], power)
                });
                let Some(beside) = self.beside(&common, constant, terms) else {
                    continue;
                };
                if let Some((value, scale, rest)) = self.rest(reading, base) {
                    found.push(Difference {
                        at,
                        beside,
                        common,
                        balance: c * scale * value,
                        scale: c * scale,
                        rest,
                    });
                }
            }
        }
        found
    }

    /// Returns the readings of `base^k` and other factors as f, each with the factors that f
    /// consumes.
    fn readings(&mut self, factors: &[(Expr, i32)], base: Expr, k: i32) -> Vec<(Reading, Factors)> {
        let mut found = Vec::new();
        let square = vec![(base, 2)];
        match *self.arena.node(base) {
            Node::Call(Function::Sqrt, radicand) if k.abs() == 1 => {
                found.push((Reading::Root(radicand, k), vec![(base, k)]));
            }
            Node::Call(function, x) => {
                let stable = &function.entry().stable;
                if let (Some(form), 2..) = (stable.square_less_one, k) {
                    found.push((Reading::Form(form, x), square));
                }
                if let (Some((divisor, quotient)), 2..) = (stable.quotient, k) {
                    let divisor = self.arena.call(divisor, x);
                    if times_divisible(factors, &[(divisor, 1)], -1) >= 2
                        && let Some(form) = quotient.entry().stable.square_less_one
                    {
                        let taken = vec![(base, 2), (divisor, -2)];
                        found.push((Reading::QuotientSquare(form, divisor), taken));
                    }
                }
                if let (Some(form), 1..) = (stable.less_one, k) {
                    found.push((Reading::Form(form, x), vec![(base, 1)]));
                }
                // powers of two scale the argument without rounding
                if let Some(form) = stable.less_one
                    && stable.power_scales_argument
                    && [-4, -2, -1, 2, 4].contains(&k)
                {
                    found.push((Reading::Power(form, x, k), vec![(base, k)]));
                }
            }
            Node::Call2(function, x, y) if k <= -2 && function.entry().is_norm => {
                for (x, y) in [(x, y), (y, x)] {
                    let (c, bare) = self.arena.as_factors(x);
                    if times_divisible(factors, &bare, 1) >= 2 {
                        let mut taken: Factors = bare.iter().map(|&(x, k)| (x, 2 * k)).collect();
                        taken.push((base, -2));
                        found.push((Reading::Leg(c, y), taken));
                    }
                }
            }
            _ => {}
        }
        found
    }

    /// Returns the constant `value` that f comes close to, the scale of f in the term, and
    /// `f − value`.
    fn rest(&mut self, reading: Reading, base: Expr) -> Option<(f64, f64, Expr)> {
        Some(match reading {
            Reading::Root(radicand, k) => {
                let (u, rest) = self.root(radicand, k)?;
                (u, 1.0, rest)
            }
            Reading::Form(form, x) => {
                let x = self.of(x);
                (1.0, 1.0, self.as_form(form, base, x)?)
            }
            Reading::QuotientSquare(form, divisor) => {
                let divisor = self.of(divisor);
                (1.0, 1.0, self.power_of(form, divisor))
            }
            Reading::Power(form, x, k) => {
                let x = self.of(x);
                let x = self.arena.scale(f64::from(k), x);
                (1.0, 1.0, self.as_form(form, base, x)?)
            }
            Reading::Leg(c, y) => {
                let ratio = self.ratio(y, base);
                let square = self.arena.pow(ratio, 2);
                (1.0, 1.0 / (c * c), self.arena.neg(square))
            }
        })
    }

    /// Returns a form of `call`. The argument of `call` has the stable form `x`.
    pub(super) fn as_form(&mut self, form: Form, call: Expr, x: Expr) -> Option<Expr> {
        let argument = self.arena.scale(form.factor, x);
        let other = if form.is_further_call {
            self.instead(call, form.function, argument)?
        } else {
            self.arena.call(form.function, argument)
        };
        Some(self.power_of(form, other))
    }

    /// Returns a form whose function is called already.
    fn power_of(&mut self, form: Form, call: Expr) -> Expr {
        let power = self.arena.pow(call, form.power);
        self.arena.scale(form.scale, power)
    }

    /// Returns a call that replaces the call `old`; `None` if `old` is kept.
    fn instead(&mut self, old: Expr, function: Function, x: Expr) -> Option<Expr> {
        if self.kept.contains(&old) {
            return None;
        }
        let new = self.arena.call(function, x);
        // a call of an odd function may have a negative sign in front
        let bare = self.arena.as_factors(new).1;
        self.replaced.extend(bare.first().map(|f| (old, f.0)));
        Some(new)
    }

    /// Returns u and `(u² + y)^(k/2) − u^k` for k = ±1.
    fn root(&mut self, radicand: Expr, k: i32) -> Option<(f64, Expr)> {
        let Node::Sum(constant, terms) = self.arena.node(radicand).clone() else {
            return None;
        };
        let u = constant.get().sqrt();
        if !(u > 0.0 && u * u == constant.get() && (k > 0 || u == 1.0)) {
            return None;
        }
        let terms: Vec<_> = terms.iter().map(|t| (t.1.get(), self.of(t.0))).collect();
        let y = self.arena.sum(0.0, &terms);
        let root = self.arena.call(Function::Sqrt, self.of(radicand));
        let sum = self.arena.sum(u, &[(1.0, root)]);
        // the quotient is formed before any other factor can make the product overflow
        let ratio = self.arena.div(y, sum);
        let ratio = self.arena.opaque(ratio);
        if k > 0 {
            return Some((u, ratio));
        }
        let inverse = self.arena.div(ratio, root);
        Some((u, self.arena.neg(inverse)))
    }
}

/// Returns the differences that cancel with `value`: all of them together, or else the first one
/// that cancels alone.
fn cancelling<'a>(value: f64, group: &[&'a Difference]) -> Vec<&'a Difference> {
    let mut all: Vec<&Difference> = Vec::new();
    for &difference in group {
        if all.iter().all(|d| d.at != difference.at) {
            all.push(difference);
        }
    }
    let total: f64 = all.iter().map(|d| d.balance).sum();
    // the sum of several constants was rounded when it was formed
    let rounding = if all.len() > 1 {
        f64::EPSILON * all.len() as f64 * value.abs()
    } else {
        0.0
    };
    if !all.is_empty() && (value + total).abs() <= rounding {
        return all;
    }
    let alone = group.iter().find(|d| d.balance == -value);
    alone.copied().into_iter().collect()
}

//! Sums of products, with common factors taken out.
//!
//! Terms are put together by their late factors, those of the tier of the whole sum: `a·x + b·x = (a + b)·x`, so that `a + b`
//! is computed as early as a and b are known, and `x·y + x·z = x·(y + z)`, which saves a multiplication.

use super::instructions::{Operation, Value};
use super::scheduler::{Factors, Scheduler};
use crate::algebra::{Expr, Node};

/// A value, and whether it is to be subtracted.
pub(super) type Part = (Value, bool);

/// Sums of more items than this are not written in two ways to compare.
const COMPARED: usize = 4;

/// `(Σ c · early factors) · late factors`.
#[derive(Clone)]
struct Item {
    coefficients: Vec<(Factors, f64)>,
    late: Factors,
}

impl Scheduler<'_> {
    /// An equation's residual with the sum of the magnitudes of its parts, which is what its rounding is relative to.
    pub(crate) fn residual(&mut self, expr: Expr) -> (Value, Value) {
        let value = self.value(expr);
        let Node::Sum(constant, terms) = self.arena.node(expr) else {
            return (value, self.push(Operation::Abs(value)));
        };
        let terms: Vec<(Expr, f64)> = terms.iter().map(|t| (t.0, t.1.get())).collect();
        let parts = self.parts(constant.get(), &terms);
        let mut sizes: Vec<Part> = parts
            .iter()
            .map(|part| (self.push(Operation::Abs(part.0)), false))
            .collect();
        (value, self.add_up(&mut sizes))
    }

    /// The value of a sum.
    pub(super) fn lower_sum(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Value {
        let items = self.items(terms);
        if constant == 0.0 {
            return self.sum_items(&items);
        }
        let mut parts = self.parts(constant, terms);
        self.add_up(&mut parts)
    }

    /// The parts of a sum.
    fn parts(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Vec<Part> {
        let items = self.items(terms);
        let mut parts = self.factor(items);
        if constant != 0.0 {
            parts.push((self.constant(constant.abs()), constant < 0.0));
        }
        parts
    }

    /// Terms put together by their late factors.
    fn items(&self, terms: &[(Expr, f64)]) -> Vec<Item> {
        let last = terms.iter().map(|t| self.rank(t.0)).max().unwrap_or(0);
        let mut items: Vec<Item> = Vec::new();
        for &(term, c) in terms {
            let (early, late) = self.split(term, last);
            match items
                .iter_mut()
                .find(|item| item.late == late && !late.is_empty())
            {
                Some(item) => item.coefficients.push((early, c)),
                None => items.push(Item {
                    coefficients: vec![(early, c)],
                    late,
                }),
            }
        }
        items
    }

    /// The sum of items. Where all constants are equal but for their signs, their modulus may be taken out: a sum that exists
    /// already is then used again.
    fn sum_items(&mut self, items: &[Item]) -> Value {
        let folded = |this: &mut Self| {
            let mut parts = this.factor(items.to_vec());
            this.add_up(&mut parts)
        };
        let mut constants = items
            .iter()
            .flat_map(|item| item.coefficients.iter().map(|c| c.1.abs()));
        let common = constants.next().unwrap_or(1.0);
        if common == 1.0 || items.len() > COMPARED || constants.any(|c| c != common) {
            return folded(self);
        }
        let mut bare = items.to_vec();
        for item in &mut bare {
            for coefficient in &mut item.coefficients {
                coefficient.1 = coefficient.1.signum();
            }
        }
        self.cheaper(folded, |this| {
            let mut parts = this.factor(bare.clone());
            let sum = this.add_up(&mut parts);
            let common = this.constant(common);
            this.push(Operation::Mul(common, sum))
        })
    }

    /// The factors of a term that are known before `last`, and those that are not.
    fn split(&self, term: Expr, last: usize) -> (Factors, Factors) {
        let factors = match self.arena.node(term) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(term, 1)],
        };
        factors.into_iter().partition(|f| self.rank(f.0) < last)
    }

    /// Takes out the factor that most items share, as long as one is shared.
    fn factor(&mut self, mut items: Vec<Item>) -> Vec<Part> {
        let mut parts = Vec::new();
        while let Some((base, sign)) = common_factor(&items) {
            let shared = |item: &Item| {
                item.late
                    .iter()
                    .any(|&(b, k)| b == base && k.signum() == sign)
            };
            let (mut with, without): (Vec<Item>, Vec<Item>) = items.into_iter().partition(shared);
            items = without;
            // all that these items share at once: one factor after the other would double the ways to compare each time
            let common = shared_factors(&with);
            for item in &mut with {
                for factor in &mut item.late {
                    factor.1 -= common.iter().find(|c| c.0 == factor.0).map_or(0, |c| c.1);
                }
                item.late.retain(|f| f.1 != 0);
            }
            let inner = self.sum_items(&with);
            let product = match common.as_slice() {
                &[(base, -1)] if !self.shared_denominators.contains(&base) => {
                    Operation::Div(inner, self.done[&base])
                }
                _ => {
                    let mut values = self.factors(&common);
                    values.push(inner);
                    parts.push((self.multiply(values), false));
                    continue;
                }
            };
            parts.push((self.push(product), false));
        }
        for Item { coefficients, late } in items {
            if let [(early, c)] = coefficients.as_slice() {
                let whole: Factors = early.iter().chain(&late).copied().collect();
                parts.push((self.scaled(c.abs(), &whole), *c < 0.0));
                continue;
            }
            let early: Vec<Item> = coefficients
                .into_iter()
                .map(|(late, c)| Item {
                    coefficients: vec![(Vec::new(), c)],
                    late,
                })
                .collect();
            let coefficient = self.sum_items(&early);
            let late = self.lower_product(1.0, &late);
            parts.push((self.multiply(vec![coefficient, late]), false));
        }
        parts
    }

    /// The value of whichever way of writing it adds less work to a step; of the first where both add the same.
    pub(super) fn cheaper(
        &mut self,
        a: impl Fn(&mut Self) -> Value,
        b: impl Fn(&mut Self) -> Value,
    ) -> Value {
        let mut price = |way: &dyn Fn(&mut Self) -> Value| {
            let before = self.program.checkpoint();
            way(self);
            let price = self.program.work_since(before);
            self.program.undo(before);
            price
        };
        if price(&b) < price(&a) {
            b(self)
        } else {
            a(self)
        }
    }

    /// Adds values in the order in which they become known.
    pub(super) fn add_up(&mut self, parts: &mut [Part]) -> Value {
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
}

/// The late factor, with the sign of its exponent, that most items have, if two or more do.
fn common_factor(items: &[Item]) -> Option<(Expr, i32)> {
    let mut counts: Vec<((Expr, i32), usize)> = Vec::new();
    for item in items {
        for &(base, k) in &item.late {
            match counts.iter_mut().find(|c| c.0 == (base, k.signum())) {
                Some(count) => count.1 += 1,
                None => counts.push(((base, k.signum()), 1)),
            }
        }
    }
    // of equally frequent ones the first in order of creation
    counts.sort_by_key(|&(key, count)| (std::cmp::Reverse(count), key));
    counts.first().filter(|c| c.1 > 1).map(|c| c.0)
}

/// What the late factors of all items have in common.
fn shared_factors(items: &[Item]) -> Factors {
    let Some((first, rest)) = items.split_first() else {
        return Factors::new();
    };
    let power = |item: &Item, base: Expr| item.late.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
    let least = |&(base, k): &(Expr, i32)| {
        let common = rest.iter().fold(k.abs(), |least, item| {
            least.min((power(item, base) * k.signum()).max(0))
        });
        (common > 0).then_some((base, common * k.signum()))
    };
    first.late.iter().filter_map(least).collect()
}

//! Sums of products, with common factors taken out.
//!
//! The late factors of a term are those in the tier of the whole sum. Terms with equal late factors
//! are collected, `a·x + b·x = (a + b)·x`, so that `a + b` is computed in the tier of a and b. Late
//! factors that several terms share are factored out, `x·y + x·z = x·(y + z)`, which saves a
//! multiplication.

use super::instructions::{Operation, Value};
use super::scheduler::{Factors, Scheduler};
use crate::algebra::{Expr, Node};

/// A term of a sum: a value, and whether it is subtracted.
pub(super) type SignedValue = (Value, bool);

/// Largest number of items of a sum that is computed in two ways to choose the cheaper one.
const MAX_ITEMS: usize = 4;

/// `(Σ c · early factors) · late factors`.
#[derive(Clone)]
struct Item {
    coefficients: Vec<(Factors, f64)>,
    late: Factors,
}

impl Scheduler<'_> {
    /// Computes a residual and the sum of the magnitudes of its terms. The rounding error of the
    /// residual is relative to this sum.
    pub(crate) fn residual(&mut self, expr: Expr) -> (Value, Value) {
        let value = self.value(expr);
        let Node::Sum(constant, terms) = self.arena.node(expr) else {
            return (value, self.push(Operation::Abs(value)));
        };
        let terms: Vec<(Expr, f64)> = terms.iter().map(|t| (t.0, t.1.get())).collect();
        let terms = self.signed_values(constant.get(), &terms);
        let mut magnitudes: Vec<SignedValue> = terms
            .iter()
            .map(|term| (self.push(Operation::Abs(term.0)), false))
            .collect();
        (value, self.add_up(&mut magnitudes))
    }

    /// Computes a sum.
    pub(super) fn lower_sum(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Value {
        let items = self.items(terms);
        if constant == 0.0 {
            return self.sum_items(&items);
        }
        let mut values = self.signed_values(constant, terms);
        self.add_up(&mut values)
    }

    /// Computes the terms of a sum after common factors have been taken out.
    fn signed_values(&mut self, constant: f64, terms: &[(Expr, f64)]) -> Vec<SignedValue> {
        let items = self.items(terms);
        let mut values = self.factor(items);
        if constant != 0.0 {
            values.push((self.constant(constant.abs()), constant < 0.0));
        }
        values
    }

    /// Collects the terms with equal late factors.
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

    /// Adds items. If all constants have the same modulus, the modulus is factored out where this
    /// adds less work, for example because the sum without it exists already.
    fn sum_items(&mut self, items: &[Item]) -> Value {
        let with_constants = |this: &mut Self| {
            let mut values = this.factor(items.to_vec());
            this.add_up(&mut values)
        };
        let mut constants = items
            .iter()
            .flat_map(|item| item.coefficients.iter().map(|c| c.1.abs()));
        let common = constants.next().unwrap_or(1.0);
        if common == 1.0 || items.len() > MAX_ITEMS || constants.any(|c| c != common) {
            return with_constants(self);
        }
        let mut bare = items.to_vec();
        for item in &mut bare {
            for coefficient in &mut item.coefficients {
                coefficient.1 = coefficient.1.signum();
            }
        }
        self.cheaper(with_constants, |this| {
            let mut values = this.factor(bare.clone());
            let sum = this.add_up(&mut values);
            let common = this.constant(common);
            this.push(Operation::Mul(common, sum))
        })
    }

    /// Splits the factors of a term into factors of earlier tiers than `last` and factors of
    /// `last`.
    fn split(&self, term: Expr, last: usize) -> (Factors, Factors) {
        let factors = match self.arena.node(term) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(term, 1)],
        };
        factors.into_iter().partition(|f| self.rank(f.0) < last)
    }

    /// Repeatedly factors out the late factor that most items share. Returns the terms of the
    /// remaining sum.
    fn factor(&mut self, mut items: Vec<Item>) -> Vec<SignedValue> {
        let mut found = Vec::new();
        while let Some((base, sign)) = common_factor(&items) {
            let shared = |item: &Item| {
                item.late
                    .iter()
                    .any(|&(b, k)| b == base && k.signum() == sign)
            };
            let (mut with, without): (Vec<Item>, Vec<Item>) = items.into_iter().partition(shared);
            items = without;
            // all common factors of these items at once: each single factor would double the number
            // of ways to compare
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
                    found.push((self.multiply(values), false));
                    continue;
                }
            };
            found.push((self.push(product), false));
        }
        for Item { coefficients, late } in items {
            if let [(early, c)] = coefficients.as_slice() {
                let factors: Factors = early.iter().chain(&late).copied().collect();
                found.push((self.scaled(c.abs(), &factors), *c < 0.0));
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
            found.push((self.multiply(vec![coefficient, late]), false));
        }
        found
    }

    /// Computes a value in the way that adds less work to a step, in the first way if both add the
    /// same.
    pub(super) fn cheaper(
        &mut self,
        a: impl Fn(&mut Self) -> Value,
        b: impl Fn(&mut Self) -> Value,
    ) -> Value {
        let mut cost = |compute: &dyn Fn(&mut Self) -> Value| {
            let before = self.program.checkpoint();
            compute(self);
            let cost = self.program.work_since(before);
            self.program.undo(before);
            cost
        };
        if cost(&b) < cost(&a) {
            b(self)
        } else {
            a(self)
        }
    }

    /// Adds values in the order of their tiers.
    pub(super) fn add_up(&mut self, terms: &mut [SignedValue]) -> Value {
        for term in terms.iter_mut() {
            if let Some(x) = self.negated(term.0) {
                *term = (x, !term.1);
            }
        }
        terms.sort_by_key(|term| self.program.get(term.0).tier.rank());
        let mut sum: Option<Value> = None;
        for &(value, negative) in terms.iter() {
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

/// Returns the late factor that most items have, with the sign of its exponent; `None` if no two
/// items have a common factor.
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
    // among equally frequent factors, the one that was created first
    counts.sort_by_key(|&(key, count)| (std::cmp::Reverse(count), key));
    counts.first().filter(|c| c.1 > 1).map(|c| c.0)
}

/// Returns the late factors that all items have in common.
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

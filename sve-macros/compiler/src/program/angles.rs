//! Sines and cosines. They are the most expensive operations of most mechanical systems, so each is
//! computed in the cheapest way that its angle allows.
//!
//! - Sine and cosine of one angle are one call.
//! - If sine and cosine of both `a` and `b` are needed anyway, sine and cosine of `a ± b` follow by
//!   the addition theorems.
//! - In an iteration an angle is `base + increment`, where the base is known before the iteration.
//!   Sine and cosine of the base are computed once. The increment is small, so its sine and cosine
//!   are short polynomials (`sin_cos_of_sum` in the runtime).
//!
//! The absolute error of the results is a few units of rounding of 1, as large as the error that
//! rounding the angle causes.

use std::collections::{HashMap, HashSet};

use super::instructions::{Operation, Tier, Value};
use super::scheduler::Scheduler;
use crate::algebra::{Arena, Expr, Function, Node, Symbol};

/// The angles whose sine or cosine is needed.
pub(super) struct Angles {
    /// For each angle, whether its sine and whether its cosine is needed.
    needed: HashMap<Expr, (bool, bool)>,
    /// Angles that are known before an iteration and to which the iteration adds an increment. Sine
    /// and cosine of each are needed.
    bases: HashSet<Expr>,
    /// True if sines and cosines may be computed by angle addition.
    has_addition: bool,
}

impl Angles {
    /// Collects the angles among `exprs`.
    pub(super) fn new(arena: &Arena, exprs: &[Expr], tier: impl Fn(Symbol) -> Tier) -> Self {
        let mut needed: HashMap<Expr, (bool, bool)> = HashMap::new();
        for &e in exprs {
            match arena.node(e) {
                Node::Call(Function::Sin, x) => needed.entry(*x).or_default().0 = true,
                Node::Call(Function::Cos, x) => needed.entry(*x).or_default().1 = true,
                _ => {}
            }
        }
        let early = |e: Expr| arena.symbols_of(e).all(|s| !tier(s).is_late());
        let mut bases = HashSet::new();
        for &angle in needed.keys().filter(|&&angle| !early(angle)) {
            let (base, _): (Vec<Term>, Vec<Term>) =
                terms(arena, angle).into_iter().partition(|t| early(t.0));
            if let [(term, 1.0)] = base.as_slice() {
                bases.insert(*term);
            }
        }
        Self {
            needed,
            bases,
            has_addition: true,
        }
    }

    pub(super) fn disable_addition(&mut self) {
        self.has_addition = false;
    }

    /// Returns whether both sine and cosine of an angle are needed.
    fn is_pair(&self, angle: Expr) -> bool {
        self.bases.contains(&angle) || self.needed.get(&angle) == Some(&(true, true))
    }
}

/// `coefficient · expression`.
type Term = (Expr, f64);

/// Returns the terms of an angle, with intermediate results replaced by their terms.
fn terms(arena: &Arena, angle: Expr) -> Vec<Term> {
    let mut open = vec![(angle, 1.0)];
    let mut found: Vec<Term> = Vec::new();
    while let Some((e, c)) = open.pop() {
        match arena.node(e) {
            Node::Opaque(x, _) => open.push((*x, c)),
            Node::Sum(constant, list) if constant.get() == 0.0 => {
                open.extend(list.iter().rev().map(|&(x, k)| (x, c * k.get())));
            }
            _ => found.push((e, c)),
        }
    }
    found
}

impl Scheduler<'_> {
    /// Computes the sine or the cosine of an angle.
    pub(super) fn lower_angle(&mut self, function: Function, angle: Expr) -> Value {
        if let Some((a, b, sign)) = self.two_angles(angle) {
            return self.combine(function, a, b, sign);
        }
        if self.angles.is_pair(angle) || self.is_late(angle) {
            let (sin, cos) = self.sin_cos(angle);
            return if function == Function::Sin { sin } else { cos };
        }
        let value = self.done[&angle];
        self.push(Operation::Call(function, value))
    }

    /// Computes the sine or the cosine of `a ± b` by the addition theorems.
    fn combine(&mut self, function: Function, a: Expr, b: Expr, sign: f64) -> Value {
        let ((sin_a, cos_a), (sin_b, cos_b)) = (self.sin_cos(a), self.sin_cos(b));
        let pairs = match function {
            Function::Sin => [(sin_a, cos_b, false), (cos_a, sin_b, sign < 0.0)],
            _ => [(cos_a, cos_b, false), (sin_a, sin_b, sign > 0.0)],
        };
        let mut parts = pairs.map(|(x, y, negative)| (self.push(Operation::Mul(x, y)), negative));
        self.add_up(&mut parts)
    }

    /// Computes sine and cosine of an angle.
    fn sin_cos(&mut self, angle: Expr) -> (Value, Value) {
        let both = match self.angle_addition(angle) {
            Some(addition) => addition,
            None => Operation::SinCos(self.done[&angle]),
        };
        let both = self.push(both);
        (
            self.push(Operation::SinOf(both)),
            self.push(Operation::CosOf(both)),
        )
    }

    /// Splits an angle into `a ± b` if sine and cosine of both `a` and `b` are computed anyway.
    fn two_angles(&self, angle: Expr) -> Option<(Expr, Expr, f64)> {
        if !self.angles.has_addition {
            return None;
        }
        let mut angle = angle;
        while let Node::Opaque(x, _) = self.arena.node(angle) {
            angle = *x;
        }
        let Node::Sum(constant, terms) = self.arena.node(angle) else {
            return None;
        };
        match terms.as_slice() {
            [(a, c), (b, d)] if constant.get() == 0.0 && c.get() == 1.0 && d.get().abs() == 1.0 => {
                let known = |x: Expr| {
                    self.angles.is_pair(x)
                        || (self.is_late(x) && self.angles.needed.contains_key(&x))
                };
                (known(*a) && known(*b)).then_some((*a, *b, d.get()))
            }
            _ => None,
        }
    }

    /// Returns the operation that adds the increment of an iteration to the base of an angle.
    /// Returns `None` if the angle does not change in an iteration or has no base.
    fn angle_addition(&mut self, angle: Expr) -> Option<Operation> {
        if !self.is_late(angle) {
            return None;
        }
        let all = terms(self.arena, angle);
        let (base, increment): (Vec<Term>, Vec<Term>) =
            all.into_iter().partition(|t| !self.is_late(t.0));
        let (sin, cos) = match base.as_slice() {
            [] => return None,
            &[(a, 1.0), (b, sign)]
                if sign.abs() == 1.0 && self.angles.is_pair(a) && self.angles.is_pair(b) =>
            {
                let sin = self.combine(Function::Sin, a, b, sign);
                (sin, self.combine(Function::Cos, a, b, sign))
            }
            base => {
                let base = match base {
                    [(term, 1.0)] => self.done[term],
                    _ => self.add_terms(base),
                };
                let both = self.push(Operation::SinCos(base));
                (
                    self.push(Operation::SinOf(both)),
                    self.push(Operation::CosOf(both)),
                )
            }
        };
        let increment = self.add_terms(&increment);
        Some(Operation::AngleAddition(sin, cos, increment))
    }

    fn add_terms(&mut self, terms: &[Term]) -> Value {
        let mut parts: Vec<(Value, bool)> = terms
            .iter()
            .map(|&(term, c)| {
                let factors = match self.arena.node(term) {
                    Node::Product(factors) => factors.clone(),
                    _ => vec![(term, 1)],
                };
                (self.scaled(c.abs(), &factors), c < 0.0)
            })
            .collect();
        self.add_up(&mut parts)
    }

    /// Returns whether an expression depends on the unknowns of a block.
    fn is_late(&self, expr: Expr) -> bool {
        self.program.get(self.done[&expr]).tier.is_late()
    }
}

//! Forms of expressions that do not cancel, for expressions that are about to be computed.
//!
//! The constructors keep plain forms, which derivatives share (sin and cos of one angle). One walk
//! over the requested expressions replaces each difference that vanishes by its form with a stable
//! expression. With any common factor a:
//!
//! | difference | becomes | cancels at |
//! | --- | --- | --- |
//! | a − a cos x | 2a sin²(x/2) | x = 0 |
//! | a − a cos² x, a − a sin² x | a sin² x, a cos² x | x = 0, π/2 |
//! | a cosh x − a, a cosh² x − a | 2a sinh²(x/2), a sinh² x | x = 0 |
//! | a − a tanh² x | a / cosh² x | large x |
//! | a exp(x) − a | a expm1(x) | x = 0 |
//! | a √(u² + y) − u a | a y / (√(u² + y) + u) | y = 0 |
//! | a / √(1 + y) − a | −a y / (√(1 + y) + 1) / √(1 + y) | y = 0 |
//! | a − a x² / hypot(x, y)² | a (y / hypot(x, y))² | y = 0 |
//! | ln(1 + y), ln cosh x | ln1p(y), ln1p(2 sinh²(x/2)) | y = 0, x = 0 |
//! | a − a x², x a symbol | a (1 − x)(1 + x) | x = ±1 |
//!
//! A sum may contain several differences, as in `2 − cos x − cos y`. Two quotients are written so
//! that they do not overflow: `sinh x / cosh x` as tanh x, and powers of `x / hypot(x, y)` as
//! powers of this ratio.
//!
//! Each form is everywhere as accurate as the plain one, to a rounding or two, and costs about as
//! much. The exceptions call `exp_m1`, sinh or cosh in addition to a function that is computed
//! anyway; a step does not use these forms.

mod differences;

use std::collections::{HashMap, HashSet};

use super::expr::{Arena, Expr, Function, Node, each_operand};
use super::simplify::times_divisible;

/// The use of the forms.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Purpose {
    /// Energies and derivatives that users see. Accuracy comes first.
    Values,
    /// A step. Functions of angles aside, no function is called that is not called anyway.
    Step,
}

/// Powers of `base`, as factors.
type Factors = Vec<(Expr, i32)>;

/// A rewriting of expressions into stable forms.
struct Forms<'a> {
    arena: &'a mut Arena,
    done: HashMap<Expr, Expr>,
    /// Calls that are not replaced, since their replacement would cost more.
    kept: &'a HashSet<Expr>,
    /// Calls that were replaced, each with the call that replaced it.
    replaced: Vec<(Expr, Expr)>,
}

impl Arena {
    /// Puts expressions into stable forms.
    pub(crate) fn stabilise(&mut self, purpose: Purpose, exprs: Vec<&mut Expr>) {
        let roots: Vec<Expr> = exprs.iter().map(|e| **e).collect();
        let mut kept = HashSet::new();
        let mut done = self.stable_forms(&roots, &kept);
        if purpose == Purpose::Step {
            kept = self.still_called(&roots, &done.0, &done.1);
            if !kept.is_empty() {
                done = self.stable_forms(&roots, &kept);
            }
        }
        for expr in exprs {
            *expr = done.0[&*expr];
        }
    }

    fn stable_forms(
        &mut self,
        roots: &[Expr],
        kept: &HashSet<Expr>,
    ) -> (HashMap<Expr, Expr>, Vec<(Expr, Expr)>) {
        let todo = self.reachable(roots, |_| true);
        let mut forms = Forms {
            arena: self,
            done: HashMap::with_capacity(todo.len()),
            kept,
            replaced: Vec::new(),
        };
        for e in todo {
            let form = forms.form(e);
            forms.done.insert(e, form);
        }
        // a walk without budget finds nothing, so the roots stay unchanged
        for &root in roots {
            forms.done.entry(root).or_insert(root);
        }
        (forms.done, forms.replaced)
    }

    /// Returns the calls that were replaced but are still needed elsewhere, while their
    /// replacements are new: these replacements cost an additional call.
    fn still_called(
        &self,
        roots: &[Expr],
        forms: &HashMap<Expr, Expr>,
        replaced: &[(Expr, Expr)],
    ) -> HashSet<Expr> {
        let before: HashSet<Expr> = self.reachable(roots, |_| true).into_iter().collect();
        let after: Vec<Expr> = roots.iter().map(|e| forms[e]).collect();
        let after: HashSet<Expr> = self.reachable(&after, |_| true).into_iter().collect();
        let costs_more =
            |&&(old, new): &&(Expr, Expr)| after.contains(&forms[&old]) && !before.contains(&new);
        replaced.iter().filter(costs_more).map(|r| r.0).collect()
    }
}

impl Forms<'_> {
    fn of(&self, expr: Expr) -> Expr {
        self.done.get(&expr).copied().unwrap_or(expr)
    }

    fn form(&mut self, expr: Expr) -> Expr {
        let node = self.arena.node(expr).clone();
        let special = match &node {
            Node::Sum(constant, terms) => {
                let terms: Vec<(Expr, f64)> = terms.iter().map(|t| (t.0, t.1.get())).collect();
                self.sum(constant.get(), &terms)
            }
            Node::Product(factors) => self.quotients(factors),
            Node::Call(function, x) => match function.entry().stable.of_one_plus {
                Some(shifted) => self.logarithm(shifted, *x),
                None => None,
            },
            _ => None,
        };
        special.unwrap_or_else(|| self.plain(expr, node))
    }

    /// Rebuilds a node from the stable forms of its operands.
    fn plain(&mut self, expr: Expr, node: Node) -> Expr {
        let mut same = true;
        each_operand(&node, |x| same &= self.of(x) == x);
        if same {
            return expr;
        }
        match node {
            Node::Constant(_) | Node::Symbol(_) => expr,
            Node::Sum(constant, terms) => {
                let terms: Vec<_> = terms.iter().map(|t| (t.1.get(), self.of(t.0))).collect();
                self.arena.sum(constant.get(), &terms)
            }
            Node::Product(factors) => self.product(&factors),
            Node::Call(function, x) => self.arena.call(function, self.of(x)),
            Node::Call2(function, x, y) => self.arena.call2(function, self.of(x), self.of(y)),
            Node::Opaque(x, identity) => self.arena.intermediate(self.of(x), identity),
        }
    }

    fn product(&mut self, factors: &[(Expr, i32)]) -> Expr {
        let factors: Factors = factors.iter().map(|&(x, k)| (self.of(x), k)).collect();
        self.arena.product(&factors)
    }

    /// Returns `x / hypot`, where `hypot` is in plain form.
    fn ratio(&mut self, x: Expr, hypot: Expr) -> Expr {
        let (x, hypot) = (self.of(x), self.of(hypot));
        let ratio = self.arena.div(x, hypot);
        self.arena.opaque(ratio)
    }

    /// Rewrites a product whose quotients may overflow.
    fn quotients(&mut self, factors: &[(Expr, i32)]) -> Option<Expr> {
        let mut left = factors.to_vec();
        let mut new: Factors = Vec::new();
        let mut scale = 1.0;
        for &(base, k) in factors.iter().filter(|f| f.1 < 0) {
            match *self.arena.node(base) {
                Node::Call(divisor, x) => {
                    for (dividend, quotient) in divisor.quotients() {
                        let dividend = self.arena.call(dividend, x);
                        let n = times_divisible(&left, &[(dividend, 1)], 1).min(-k);
                        if n > 0 {
                            left = divided(&divided(&left, &[(dividend, 1)], n), &[(base, 1)], -n);
                            new.push((self.arena.call(quotient, self.of(x)), n));
                        }
                    }
                }
                Node::Call2(function, x, y) if function.entry().is_norm => {
                    let mut available = -k;
                    for x in [x, y] {
                        let (c, bare) = self.arena.as_factors(x);
                        let n = times_divisible(&left, &bare, 1).min(available);
                        if n > 0 {
                            left = divided(&divided(&left, &bare, n), &[(base, 1)], -n);
                            scale *= c.powi(-n);
                            new.push((self.ratio(x, base), n));
                            available -= n;
                        }
                    }
                }
                _ => {}
            }
        }
        if new.is_empty() {
            return None;
        }
        new.extend(left.iter().map(|&(x, k)| (self.of(x), k)));
        let product = self.arena.product(&new);
        Some(self.arena.scale(scale, product))
    }

    /// Returns the stable form of `ln(1 + y)` or `ln cosh x`. The function `shifted` is ln1p.
    fn logarithm(&mut self, shifted: Function, x: Expr) -> Option<Expr> {
        let y = match self.arena.node(x).clone() {
            Node::Sum(constant, terms) if constant.get() == 1.0 => {
                let form = self.of(x);
                let whole = match self.arena.node(form) {
                    Node::Sum(constant, _) if constant.get() == 1.0 => form,
                    // the logarithm of 1 − x² is small at x = 0
                    _ if terms.len() == 1 => x,
                    _ => return None,
                };
                self.arena.sum(-1.0, &[(1.0, whole)])
            }
            Node::Call(function, z) if function.entry().stable.is_at_least_one => {
                let z = self.of(z);
                self.as_form(function.entry().stable.less_one?, x, z)?
            }
            _ => return None,
        };
        Some(self.arena.call(shifted, y))
    }
}

/// Returns `product / factors^n`.
fn divided(product: &[(Expr, i32)], factors: &[(Expr, i32)], n: i32) -> Factors {
    let power = |base: Expr| factors.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
    product
        .iter()
        .map(|&(base, k)| (base, k - n * power(base)))
        .filter(|f| f.1 != 0)
        .collect()
}

//! Quotients by the step size that have a limit: `φ(q₀ + d)/h`, in the form `Σ ∂φ/∂q_i · d_i/h`
//! with `d_i = h v_i + …`.
//!
//! Input: expressions with negative powers of h. Output: the same expressions without such powers,
//! if h is a factor of each dividend or of each term of a dividend that is a sum. Displacements by
//! noise are divided by the whole step size: on the path from the limit to a step, noise occurs
//! only at the whole step size.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Node, Symbol};

/// Cancels the step size in expressions.
pub(super) struct Cancellation<'a> {
    pub(super) arena: &'a mut Arena,
    /// The step size on the path from the limit to the step; `whole` is the whole step size.
    pub(super) h: Expr,
    pub(super) whole: Expr,
    /// The increments of the noise, each mapped to zero.
    pub(super) still: &'a HashMap<Symbol, Expr>,
    pub(super) done: HashMap<Expr, Expr>,
}

impl Cancellation<'_> {
    /// Returns the expressions without negative powers of the step size; `None` if one has no
    /// limit.
    pub(super) fn all(&mut self, exprs: &[Expr]) -> Option<Vec<Expr>> {
        exprs.iter().map(|&e| self.of(e)).collect()
    }

    fn of(&mut self, e: Expr) -> Option<Expr> {
        if let Some(&done) = self.done.get(&e) {
            return Some(done);
        }
        let new = match self.arena.node(e).clone() {
            Node::Constant(_) | Node::Symbol(_) => e,
            Node::Sum(constant, terms) => {
                let mut parts = Vec::new();
                for &(x, c) in &*terms {
                    parts.push((c.get(), self.of(x)?));
                }
                self.arena.sum(constant.get(), &parts)
            }
            Node::Product(factors) => self.product(&factors)?,
            Node::Opaque(x, identity) => {
                let x = self.of(x)?;
                self.arena.intermediate(x, identity)
            }
            Node::Call(function, x) => {
                let x = self.of(x)?;
                self.arena.call(function, x)
            }
            Node::Call2(function, x, y) => {
                let (x, y) = (self.of(x)?, self.of(y)?);
                self.arena.call2(function, x, y)
            }
        };
        self.done.insert(e, new);
        Some(new)
    }

    fn product(&mut self, factors: &[(Expr, i32)]) -> Option<Expr> {
        let h = self.h;
        let mut power = factors.iter().find(|f| f.0 == h).map_or(0, |f| f.1);
        let others: Vec<(Expr, i32)> = factors.iter().copied().filter(|f| f.0 != h).collect();
        let mut rest = self.arena.product(&others);
        while power < 0
            && let Some(quotient) = divided(rest, h, self.arena)
        {
            (rest, power) = (quotient, power + 1);
        }
        let factors: Vec<(Expr, i32)> = match self.arena.node(rest) {
            Node::Product(factors) => factors.clone(),
            _ => vec![(rest, 1)],
        };
        let mut product = Vec::new();
        if power < 0 && self.is_zero_without_noise(rest) {
            product.push((self.whole, power));
        } else if power < 0 {
            // a displacement that consists of a part proportional to the step and a part of noise
            let at = (0..factors.len()).find(|&i| self.is_displacement(factors[i]))?;
            let mut parts = Vec::new();
            for (c, x) in self.terms(factors[at].0)? {
                let quotient = self.arena.product(&[(x, 1), (h, power)]);
                parts.push((c, self.of(quotient)?));
            }
            product.push((self.arena.sum(0.0, &parts), 1));
            for (i, &(base, k)) in factors.iter().enumerate() {
                if i != at {
                    product.push((self.of(base)?, k));
                }
            }
            return Some(self.arena.product(&product));
        } else {
            product.push((h, power));
        }
        for (base, k) in factors {
            product.push((self.of(base)?, k));
        }
        Some(self.arena.product(&product))
    }

    fn is_zero_without_noise(&mut self, e: Expr) -> bool {
        let without_noise = self.arena.substitute(e, self.still);
        self.arena.constant_value(without_noise) == Some(0.0)
    }

    /// Returns whether a factor is a sum that vanishes without noise and step.
    fn is_displacement(&mut self, (base, k): (Expr, i32)) -> bool {
        let mut resting = self.still.clone();
        if let Node::Symbol(h) = *self.arena.node(self.h) {
            resting.insert(h, self.arena.constant(0.0));
        }
        let at_rest = self.arena.substitute(base, &resting);
        k == 1 && self.arena.constant_value(at_rest) == Some(0.0) && self.terms(base).is_some()
    }

    /// Returns the terms of a sum.
    fn terms(&self, e: Expr) -> Option<Vec<(f64, Expr)>> {
        match self.arena.node(e) {
            Node::Opaque(inner, _) => self.terms(*inner),
            Node::Sum(constant, terms) if constant.get() == 0.0 => {
                Some(terms.iter().map(|&(x, c)| (c.get(), x)).collect())
            }
            _ => None,
        }
    }
}

/// Returns the quotient by the step size, if the step size is a factor.
fn divided(e: Expr, h: Expr, arena: &mut Arena) -> Option<Expr> {
    if e == h {
        return Some(arena.constant(1.0));
    }
    match arena.node(e).clone() {
        Node::Constant(c) => (c.get() == 0.0).then_some(e),
        Node::Opaque(inner, _) => divided(inner, h, arena),
        Node::Sum(constant, terms) if constant.get() == 0.0 => {
            let mut parts = Vec::new();
            for &(x, c) in &terms {
                parts.push((c.get(), divided(x, h, arena)?));
            }
            Some(arena.sum(0.0, &parts))
        }
        Node::Product(factors) => {
            let mut factors: Vec<(Expr, i32)> = factors.clone();
            // the step size itself comes first
            factors.sort_by_key(|f| f.0 != h);
            for at in 0..factors.len() {
                let (base, k) = factors[at];
                if k <= 0 {
                    continue;
                }
                if let Some(quotient) = divided(base, h, arena) {
                    factors[at].1 -= 1;
                    factors.push((quotient, 1));
                    return Some(arena.product(&factors));
                }
            }
            None
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashMap;

    use super::Cancellation;
    use crate::algebra::{Arena, Expr, Symbol};

    const NOISE: Symbol = Symbol(4);

    fn symbols(arena: &mut Arena) -> [Expr; 6] {
        core::array::from_fn(|i| arena.symbol(Symbol(i as u32)))
    }

    fn cancelled(e: Expr, [h, whole]: [Expr; 2], arena: &mut Arena) -> Option<Expr> {
        let zero = arena.constant(0.0);
        let still = HashMap::from([(NOISE, zero)]);
        let mut cancellation = Cancellation {
            arena,
            h,
            whole,
            still: &still,
            done: HashMap::new(),
        };
        cancellation.all(&[e]).map(|all| all[0])
    }

    /// `((q + h v) · h v + h² a) / h`, with the displacement as an intermediate result.
    #[test]
    fn the_step_size_cancels_in_sums_and_intermediate_results() {
        let arena = &mut Arena::new();
        let [h, q, v, a, _, whole] = symbols(arena);
        let hv = arena.mul(h, v);
        let d = arena.opaque(hv);
        let at = arena.add(q, d);
        let first = arena.product(&[(at, 1), (d, 1)]);
        let second = arena.product(&[(h, 2), (a, 1)]);
        let sum = arena.add(first, second);
        let quotient = arena.product(&[(sum, 1), (h, -1)]);
        let expected = {
            let first = arena.mul(at, v);
            let second = arena.mul(h, a);
            arena.add(first, second)
        };
        assert_eq!(cancelled(quotient, [h, whole], arena), Some(expected));
        let times = arena.product(&[(q, 1), (quotient, 1)]);
        let expected = arena.mul(q, expected);
        assert_eq!(cancelled(times, [h, whole], arena), Some(expected));
    }

    #[test]
    fn what_the_step_size_does_not_divide_has_no_limit() {
        let arena = &mut Arena::new();
        let [h, q, v, _, _, whole] = symbols(arena);
        let hv = arena.mul(h, v);
        let sum = arena.add(q, hv);
        let quotient = arena.product(&[(sum, 1), (h, -1)]);
        assert_eq!(cancelled(quotient, [h, whole], arena), None);
        assert_eq!(cancelled(sum, [h, whole], arena), Some(sum));
    }

    /// `q (h v + w)/h`
    #[test]
    fn noise_is_divided_by_the_whole_step_size() {
        let arena = &mut Arena::new();
        let [h, q, v, _, w, whole] = symbols(arena);
        let hv = arena.mul(h, v);
        let d = arena.add(hv, w);
        let parts = [
            arena.product(&[(hv, 1), (h, -1)]),
            arena.product(&[(w, 1), (h, -1)]),
        ];
        let rate = arena.sum(0.0, &parts.map(|part| (1.0, part)));
        let expected = {
            let noise = arena.product(&[(w, 1), (whole, -1)]);
            arena.add(v, noise)
        };
        assert_eq!(cancelled(rate, [h, whole], arena), Some(expected));
        let displacement = arena.opaque(d);
        let times = arena.product(&[(q, 1), (displacement, 1), (h, -1)]);
        let expected = arena.mul(q, expected);
        assert_eq!(cancelled(times, [h, whole], arena), Some(expected));
    }
}

//! Constructors of expressions, which apply the local rules of simplification.
//!
//! Each rule holds wherever its left side is defined; some right sides are defined at more points
//! (x·x⁻¹ → 1). There is no rule √(x²) → x, which is wrong at x < 0.

use super::expr::{Arena, Binary, Bits, Expr, Function, Identity, Node, Symbol};
use super::functions::{Parity, Sign};

/// Length beyond which a sum stays one term of another sum instead of being merged into it.
const MERGE_LIMIT: usize = 64;

/// Smallest exponent that is not merged, lest the merged exponent overflow.
const EXPONENT: i32 = 1 << 20;

/// Largest exponent of a power that is a product of its base and of roots.
const MOST_POWER: f64 = 64.0;

impl Arena {
    pub(crate) fn constant(&mut self, value: f64) -> Expr {
        self.intern(Node::Constant(Bits::new(value)))
    }

    pub(crate) fn symbol(&mut self, symbol: Symbol) -> Expr {
        self.intern(Node::Symbol(symbol))
    }

    /// Returns a named intermediate result. The rules of sums and products do not expand it.
    pub(crate) fn opaque(&mut self, expr: Expr) -> Expr {
        self.intermediate(expr, None)
    }

    /// Returns an intermediate result. If it has an identity, later stages recognise it.
    pub(crate) fn intermediate(&mut self, expr: Expr, identity: Option<Identity>) -> Expr {
        match self.node(expr) {
            Node::Constant(_) | Node::Symbol(_) | Node::Opaque(..) => expr,
            _ => self.intern(Node::Opaque(expr, identity)),
        }
    }

    /// Returns `constant + Σ coefficient · term` with like terms collected.
    pub(crate) fn sum(&mut self, constant: f64, terms: &[(f64, Expr)]) -> Expr {
        let mut constant = constant;
        let mut flat: Vec<(Expr, f64)> = Vec::with_capacity(terms.len());
        for &(c, term) in terms {
            match self.node(term) {
                Node::Constant(value) => {
                    constant = self.folded_sum(constant, self.folded_product(c, value.get()));
                }
                Node::Sum(inner, list) if list.len() <= MERGE_LIMIT || terms.len() == 1 => {
                    constant = self.folded_sum(constant, self.folded_product(c, inner.get()));
                    let scaled = |&(x, k): &(Expr, Bits)| (x, self.folded_product(c, k.get()));
                    flat.extend(list.iter().map(scaled));
                }
                _ => flat.push((term, c)),
            }
        }
        self.spend(flat.len());
        flat.sort_by_key(|t| t.0);
        let mut merged: Vec<(Expr, f64)> = Vec::with_capacity(flat.len());
        for (term, c) in flat {
            match merged.last_mut() {
                Some(last) if last.0 == term => last.1 = self.folded_sum(last.1, c),
                _ => merged.push((term, c)),
            }
        }
        merged.retain(|t| t.1 != 0.0);
        match merged.as_slice() {
            [] => self.constant(constant),
            [(term, c)] if constant == 0.0 && *c == 1.0 => *term,
            _ => {
                let terms = merged.iter().map(|&(x, c)| (x, Bits::new(c))).collect();
                self.intern(Node::Sum(Bits::new(constant), terms))
            }
        }
    }

    /// Returns the sum of two constants, and records whether one of them is lost in it.
    fn folded_sum(&self, a: f64, b: f64) -> f64 {
        let sum = a + b;
        if (sum == a && b != 0.0) || (sum == b && a != 0.0) {
            self.has_lost_constants.set(true);
        }
        sum
    }

    /// Returns the product of two constants, and records whether it is lost by underflow.
    fn folded_product(&self, a: f64, b: f64) -> f64 {
        let product = a * b;
        if product == 0.0 && a != 0.0 && b != 0.0 {
            self.has_lost_constants.set(true);
        }
        product
    }

    pub(crate) fn add(&mut self, a: Expr, b: Expr) -> Expr {
        self.sum(0.0, &[(1.0, a), (1.0, b)])
    }

    pub(crate) fn sub(&mut self, a: Expr, b: Expr) -> Expr {
        self.sum(0.0, &[(1.0, a), (-1.0, b)])
    }

    pub(crate) fn neg(&mut self, a: Expr) -> Expr {
        self.scale(-1.0, a)
    }

    pub(crate) fn scale(&mut self, c: f64, a: Expr) -> Expr {
        self.sum(0.0, &[(c, a)])
    }

    pub(crate) fn mul(&mut self, a: Expr, b: Expr) -> Expr {
        self.product(&[(a, 1), (b, 1)])
    }

    pub(crate) fn div(&mut self, a: Expr, b: Expr) -> Expr {
        self.product(&[(a, 1), (b, -1)])
    }

    pub(crate) fn pow(&mut self, a: Expr, k: i32) -> Expr {
        self.product(&[(a, k)])
    }

    /// Returns the absolute value. Factors that are known to be nonnegative stay unchanged.
    pub(crate) fn abs(&mut self, a: Expr) -> Expr {
        match self.node(a).clone() {
            Node::Constant(value) => self.constant(value.get().abs()),
            Node::Call(function, _) if function.entry().sign != Sign::Unknown => a,
            Node::Sum(constant, terms) => match terms.as_slice() {
                [(term, c)] if constant.get() == 0.0 => {
                    let size = self.abs(*term);
                    self.scale(c.get().abs(), size)
                }
                _ => self.call(Function::Abs, a),
            },
            Node::Product(factors) => {
                let sizes: Vec<_> = factors
                    .iter()
                    .map(|&(base, k)| {
                        // no factor of a product is a product, so this recursion is only as deep as
                        // sums of one term are nested
                        let base = if k % 2 == 0 { base } else { self.abs(base) };
                        (base, k)
                    })
                    .collect();
                self.product(&sizes)
            }
            _ => self.call(Function::Abs, a),
        }
    }

    /// Returns `Π base^exponent` with equal bases collected.
    pub(crate) fn product(&mut self, factors: &[(Expr, i32)]) -> Expr {
        let mut coefficient = 1.0;
        let mut flat: Vec<(Expr, i32)> = Vec::with_capacity(factors.len());
        let mut open: Vec<(Expr, i32)> = factors.iter().rev().copied().collect();
        loop {
            while let Some((base, k)) = open.pop() {
                self.spend(1);
                match self.node(base).clone() {
                    Node::Constant(value) => {
                        coefficient = self.folded_product(coefficient, value.get().powi(k));
                    }
                    Node::Product(list) if list.iter().all(|f| moderate(f.1, k)) => {
                        open.extend(list.iter().map(|&(x, j)| (x, j * k)));
                    }
                    Node::Product(_) => {
                        // a power with an exponent of absurd size stays a power of a power
                        let base = self.opaque(base);
                        flat.push((base, k));
                    }
                    Node::Sum(constant, terms) => match terms.as_slice() {
                        [(term, c)] if constant.get() == 0.0 => {
                            coefficient = self.folded_product(coefficient, c.get().powi(k));
                            open.push((*term, k));
                        }
                        _ => {
                            let (unit, base) = self.leading_one(base);
                            coefficient = self.folded_product(coefficient, unit.powi(k));
                            flat.push((base, k));
                        }
                    },
                    _ => flat.push((base, k)),
                }
            }
            collect_powers(&mut flat);
            let Some((radicand, k)) = self.take_radicand(&mut flat) else {
                break;
            };
            if self.stands_as_it_is(radicand, &flat) {
                flat.push((radicand, k));
            } else {
                open.push((radicand, k));
            }
        }
        let bare = match flat.as_slice() {
            [] => return self.constant(coefficient),
            [(base, 1)] => *base,
            _ => self.intern(Node::Product(flat)),
        };
        if coefficient == 0.0 {
            return self.constant(0.0);
        }
        self.scale(coefficient, bare)
    }

    /// Returns a sum as `unit · base`. The leading coefficient of the base is in [1, 2), so that
    /// x + y, −x − y and (x + y)/2 share their base. The unit is a signed power of two, so the
    /// division is exact.
    fn leading_one(&mut self, sum: Expr) -> (f64, Expr) {
        match self.node(sum) {
            Node::Sum(_, terms) if !(1.0..2.0).contains(&terms[0].1.get()) => {
                let unit = power_of_two(terms[0].1.get());
                (unit, self.scale(1.0 / unit, sum))
            }
            _ => (1.0, sum),
        }
    }

    /// Splits `expr` into a constant and bases with exponents.
    pub(super) fn as_factors(&mut self, expr: Expr) -> (f64, Vec<(Expr, i32)>) {
        let bare = |node: &Node, base: Expr| match node {
            Node::Product(list) => list.clone(),
            _ => vec![(base, 1)],
        };
        match self.node(expr) {
            Node::Sum(constant, terms) => match terms.as_slice() {
                &[(term, c)] if constant.get() == 0.0 => (c.get(), bare(self.node(term), term)),
                _ => {
                    let (unit, base) = self.leading_one(expr);
                    (unit, vec![(base, 1)])
                }
            },
            node => (1.0, bare(node, expr)),
        }
    }

    /// Returns whether the radicand occurs unscaled as the argument of its root. The root is
    /// computed from this radicand anyway, so keeping it unscaled shares its value.
    fn stands_as_it_is(&mut self, radicand: Expr, flat: &[(Expr, i32)]) -> bool {
        let (_, factors) = self.as_factors(radicand);
        match factors.as_slice() {
            &[(base, 1)] => {
                matches!(self.node(base), Node::Sum(..)) && flat.iter().all(|f| f.0 != base)
            }
            _ => false,
        }
    }

    /// Moves powers from a root to its radicand where this simplifies the product:
    /// `√x^k = x^(k/2) √x^(k%2)`. Beside a power of x of the other sign, `√x⁻¹ = x⁻¹ √x` and
    /// `√x = x √x⁻¹`, so that no form 0/0 remains at x = 0.
    fn take_radicand(&mut self, flat: &mut [(Expr, i32)]) -> Option<(Expr, i32)> {
        for at in 0..flat.len() {
            let (root, k) = flat[at];
            let Node::Call(Function::Sqrt, radicand) = *self.node(root) else {
                continue;
            };
            if k.abs() >= 2 {
                flat[at].1 = k % 2;
                return Some((radicand, k / 2));
            }
            if flat.len() > 1 {
                let (_, factors) = self.as_factors(radicand);
                if times_divisible(flat, &factors, -k) > 0
                    || times_divisible(flat, &[(radicand, 1)], -k) > 0
                {
                    flat[at].1 = -k;
                    return Some((radicand, k));
                }
            }
        }
        None
    }

    pub(crate) fn call(&mut self, function: Function, x: Expr) -> Expr {
        if let Some(value) = self.constant_value(x) {
            let folded = function.evaluate(value);
            if folded.is_finite() {
                return self.constant(folded);
            }
        }
        let negative = match self.node(x) {
            Node::Sum(_, terms) => terms[0].1.get() < 0.0,
            _ => false,
        };
        if negative && function.entry().parity != Parity::None {
            let mirrored = self.neg(x);
            let value = self.intern(Node::Call(function, mirrored));
            return match function.entry().parity {
                Parity::Odd => self.neg(value),
                Parity::Even | Parity::None => value,
            };
        }
        self.intern(Node::Call(function, x))
    }

    pub(crate) fn call2(&mut self, function: Binary, x: Expr, y: Expr) -> Expr {
        if let (Some(a), Some(b)) = (self.constant_value(x), self.constant_value(y)) {
            let folded = function.evaluate(a, b);
            if folded.is_finite() {
                return self.constant(folded);
            }
        }
        match (function.entry().with_constant, self.constant_value(y)) {
            (Some(form), Some(y)) => form(self, x, y),
            _ => self.intern(Node::Call2(function, x, y)),
        }
    }

    /// Returns a power with a constant exponent. Integer exponents give products; exponents of
    /// halves and quarters give square roots and products, which cost a fraction of a power.
    pub(super) fn constant_power(&mut self, x: Expr, exponent: f64) -> Expr {
        let is_integer = |x: f64| x == x.round();
        if exponent.abs() <= MOST_POWER && is_integer(4.0 * exponent) {
            if is_integer(exponent) {
                return self.pow(x, exponent as i32);
            }
            let root = self.call(Function::Sqrt, x);
            if is_integer(2.0 * exponent) {
                return self.pow(root, (2.0 * exponent) as i32);
            }
            // the root of the root, with the whole powers apart, whose roundings are fewer
            let fourth = self.call(Function::Sqrt, root);
            let rest = self.pow(fourth, (4.0 * exponent.fract()) as i32);
            let power = self.pow(x, exponent.trunc() as i32);
            return self.mul(power, rest);
        }
        self.call(Function::Powf(Bits::new(exponent)), x)
    }
}

/// Sorts the factors and adds the exponents of equal bases.
fn collect_powers(flat: &mut Vec<(Expr, i32)>) {
    flat.sort_by_key(|f| f.0);
    let mut merged: Vec<(Expr, i32)> = Vec::with_capacity(flat.len());
    for &(base, k) in flat.iter() {
        match merged.last_mut() {
            Some(last) if last.0 == base && last.1.abs() < EXPONENT => last.1 += k,
            _ => merged.push((base, k)),
        }
    }
    merged.retain(|f| f.1 != 0);
    *flat = merged;
}

/// Returns how often `product` contains all of `factors`, to the power `sign` = ±1.
pub(super) fn times_divisible(product: &[(Expr, i32)], factors: &[(Expr, i32)], sign: i32) -> i32 {
    let power = |base: Expr| product.iter().find(|f| f.0 == base).map_or(0, |f| f.1);
    let times = |&(base, e): &(Expr, i32)| {
        let same_sign = i64::from(power(base)) * i64::from(e) * i64::from(sign) > 0;
        if same_sign {
            power(base).abs() / e.abs()
        } else {
            0
        }
    };
    factors.iter().map(times).min().unwrap_or(0)
}

/// Returns whether the exponents of a power of a power may be multiplied.
fn moderate(j: i32, k: i32) -> bool {
    j.checked_mul(k).is_some_and(|jk| jk.abs() < EXPONENT)
}

/// Returns the power of two, with the sign of `c`, whose quotient with `c` is in [1, 2). If it
/// over- or underflows, returns 1.
fn power_of_two(c: f64) -> f64 {
    let exponent = c.abs().log2().floor();
    let exponent = if c.abs() < exponent.exp2() {
        exponent - 1.0
    } else {
        exponent
    };
    if exponent.abs() < 1000.0 {
        exponent.exp2().copysign(c)
    } else {
        1.0
    }
}

//! Derivatives, memoised over the arena: input an expression and a symbol, output the partial derivative.
//!
//! Each node is differentiated once for each symbol, operands first, so shared subexpressions stay shared.

use super::expr::{Arena, Binary, Expr, Node, Symbol};

impl Arena {
    /// `∂expr/∂symbol`.
    pub(crate) fn diff(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        if !self.contains(expr, symbol) {
            return self.constant(0.0);
        }
        let todo = self.reachable(&[expr], |e| {
            self.contains(e, symbol) && !self.derivatives.contains_key(&(e, symbol))
        });
        for e in todo {
            let derivative = self.diff_node(e, symbol);
            self.derivatives.insert((e, symbol), derivative);
        }
        self.known(expr, symbol)
    }

    /// The derivative of an operand: zero where the symbol does not occur.
    fn known(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        match self.derivatives.get(&(expr, symbol)) {
            Some(&derivative) => derivative,
            None => self.constant(0.0),
        }
    }

    fn diff_node(&mut self, expr: Expr, symbol: Symbol) -> Expr {
        match self.node(expr).clone() {
            Node::Constant(_) => self.constant(0.0),
            Node::Symbol(s) => self.constant(f64::from(u8::from(s == symbol))),
            Node::Opaque(x, _) => self.known(x, symbol),
            Node::Sum(_, terms) => {
                let mut slopes = Vec::new();
                for &(x, c) in &terms {
                    if self.contains(x, symbol) {
                        slopes.push((c.get(), self.known(x, symbol)));
                    }
                }
                self.sum(0.0, &slopes)
            }
            Node::Product(factors) => {
                let mut terms = Vec::new();
                for (at, &(base, k)) in factors.iter().enumerate() {
                    if !self.contains(base, symbol) {
                        continue;
                    }
                    let mut rest = factors.clone();
                    rest[at].1 -= 1;
                    rest.push((self.known(base, symbol), 1));
                    terms.push((f64::from(k), self.product(&rest)));
                }
                self.sum(0.0, &terms)
            }
            Node::Call(function, x) => {
                let outer = function.derivative(self, x, expr);
                let inner = self.known(x, symbol);
                self.mul(outer, inner)
            }
            Node::Call2(function, x, y) => {
                let (dx, dy) = self.diff_binary(function, x, y, expr);
                let (ix, iy) = (self.known(x, symbol), self.known(y, symbol));
                let (a, b) = (self.mul(dx, ix), self.mul(dy, iy));
                self.add(a, b)
            }
        }
    }

    fn diff_binary(&mut self, function: Binary, x: Expr, y: Expr, value: Expr) -> (Expr, Expr) {
        match function {
            Binary::Atan2 => {
                // the squares of x and y may overflow where their root does not
                let norm = self.call2(Binary::Hypot, x, y);
                let (dx, dy) = (
                    self.product(&[(y, 1), (norm, -2)]),
                    self.product(&[(x, 1), (norm, -2)]),
                );
                (dx, self.neg(dy))
            }
            Binary::Hypot => (self.div(x, value), self.div(y, value)),
            // 0^y is 0 where it has a derivative, y > 0
            Binary::Pow | Binary::PowLog(_) if self.constant_value(x) == Some(0.0) => {
                let zero = self.constant(0.0);
                (zero, zero)
            }
            Binary::Pow => self.diff_power(x, y, 0),
            Binary::PowLog(n) => self.diff_power(x, y, n),
        }
    }

    /// The derivatives of `x^y lnⁿ x`: `y x^(y−1) lnⁿ x + n x^(y−1) lnⁿ⁻¹ x` and `x^y lnⁿ⁺¹ x`.
    fn diff_power(&mut self, x: Expr, y: Expr, n: i32) -> (Expr, Expr) {
        let lower = self.sum(-1.0, &[(1.0, y)]);
        let power = self.power_log(x, lower, n);
        let mut terms = vec![(1.0, self.mul(y, power))];
        if n > 0 {
            terms.push((f64::from(n), self.power_log(x, lower, n - 1)));
        }
        (self.sum(0.0, &terms), self.power_log(x, y, n + 1))
    }

    /// `x^y lnⁿ x`.
    fn power_log(&mut self, x: Expr, y: Expr, n: i32) -> Expr {
        match self.constant_value(x) {
            _ if n == 0 => self.call2(Binary::Pow, x, y),
            Some(base) if base > 0.0 => {
                let power = self.call2(Binary::Pow, x, y);
                self.scale(base.ln().powi(n), power)
            }
            _ => self.call2(Binary::PowLog(n), x, y),
        }
    }
}

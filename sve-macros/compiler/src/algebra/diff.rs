//! Derivatives, memoised over the arena: input an expression and a symbol, output the partial
//! derivative.
//!
//! Each node is differentiated once for each symbol, operands first, so shared subexpressions stay
//! shared.

use super::expr::{Arena, Expr, Identity, Node, Slope, Symbol};

impl Arena {
    /// Returns `∂expr/∂symbol`.
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

    /// Records a derivative in a shorter form than the rules give. The form must equal the
    /// derivative.
    pub(crate) fn record_derivative(&mut self, expr: Expr, symbol: Symbol, derivative: Expr) {
        self.derivatives.insert((expr, symbol), derivative);
    }

    /// Differentiates intermediate results with an identity by a shorter rule than that of their
    /// operands. The two must give equal derivatives.
    pub(crate) fn differentiate_by(&mut self, identity: Identity, slope: Slope) {
        self.slopes.insert(identity, slope);
    }

    /// Returns the derivative of an intermediate result by the rule of its identity.
    fn by_rule(&mut self, expr: Expr, identity: Identity, symbol: Symbol) -> Option<Expr> {
        let slope = *self.slopes.get(&identity)?;
        let [argument, outer] = slope(self, expr)?;
        let inner = self.known(argument, symbol);
        Some(self.mul(outer, inner))
    }

    /// Returns the derivative of an operand; zero if the symbol does not occur in it.
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
            Node::Opaque(x, identity) => identity
                .and_then(|identity| self.by_rule(expr, identity, symbol))
                .unwrap_or_else(|| self.known(x, symbol)),
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
                let (dx, dy) = function.derivatives(self, x, y, expr);
                let (ix, iy) = (self.known(x, symbol), self.known(y, symbol));
                let (a, b) = (self.mul(dx, ix), self.mul(dy, iy));
                self.add(a, b)
            }
        }
    }
}

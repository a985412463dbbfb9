//! Derivatives, memoised over the arena: input an expression and a symbol, output the partial derivative.
//!
//! Each node is differentiated once for each symbol, operands first, so shared subexpressions stay shared.

use super::expr::{Arena, Binary, Bits, Expr, Function, Node, Symbol};

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
            Node::Opaque(x) => self.known(x, symbol),
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
                let outer = self.diff_function(function, x, expr);
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

    /// `f′(x)`, with `value = f(x)` at hand.
    fn diff_function(&mut self, function: Function, x: Expr, value: Expr) -> Expr {
        let squared = self.pow(x, 2);
        match function {
            Function::Sqrt => {
                let inverse = self.pow(value, -1);
                self.scale(0.5, inverse)
            }
            Function::Cbrt => {
                let inverse = self.pow(value, -2);
                self.scale(1.0 / 3.0, inverse)
            }
            Function::Exp => value,
            Function::Exp2 => self.scale(std::f64::consts::LN_2, value),
            Function::ExpM1 => self.sum(1.0, &[(1.0, value)]),
            Function::Ln => self.pow(x, -1),
            Function::Ln1p => {
                let y = self.sum(1.0, &[(1.0, x)]);
                self.pow(y, -1)
            }
            Function::Log2 => {
                let inverse = self.pow(x, -1);
                self.scale(std::f64::consts::LOG2_E, inverse)
            }
            Function::Log10 => {
                let inverse = self.pow(x, -1);
                self.scale(std::f64::consts::LOG10_E, inverse)
            }
            Function::Sin => self.call(Function::Cos, x),
            Function::Cos => {
                let sin = self.call(Function::Sin, x);
                self.neg(sin)
            }
            Function::Tan => {
                let square = self.pow(value, 2);
                self.sum(1.0, &[(1.0, square)])
            }
            Function::Asin => self.inverse_root(1.0, -1.0, squared),
            Function::Acos => {
                let asin = self.inverse_root(1.0, -1.0, squared);
                self.neg(asin)
            }
            Function::Atan => {
                let y = self.sum(1.0, &[(1.0, squared)]);
                self.pow(y, -1)
            }
            Function::Sinh => self.call(Function::Cosh, x),
            Function::Cosh => self.call(Function::Sinh, x),
            Function::Tanh => {
                let square = self.pow(value, 2);
                self.sum(1.0, &[(-1.0, square)])
            }
            Function::Asinh => self.inverse_root(1.0, 1.0, squared),
            Function::Acosh => self.inverse_root(-1.0, 1.0, squared),
            Function::Atanh => {
                let y = self.sum(1.0, &[(-1.0, squared)]);
                self.pow(y, -1)
            }
            Function::Powf(k) => {
                let lower = self.call(Function::Powf(Bits::new(k.get() - 1.0)), x);
                self.scale(k.get(), lower)
            }
        }
    }

    /// `1/√(a + b x²)`.
    fn inverse_root(&mut self, a: f64, b: f64, squared: Expr) -> Expr {
        let y = self.sum(a, &[(b, squared)]);
        let root = self.call(Function::Sqrt, y);
        self.pow(root, -1)
    }

    fn diff_binary(&mut self, function: Binary, x: Expr, y: Expr, value: Expr) -> (Expr, Expr) {
        match function {
            Binary::Atan2 => {
                let (xx, yy) = (self.pow(x, 2), self.pow(y, 2));
                let norm = self.add(xx, yy);
                let (dx, dy) = (self.div(y, norm), self.div(x, norm));
                (dx, self.neg(dy))
            }
            Binary::Hypot => (self.div(x, value), self.div(y, value)),
            // 0^y is 0 where it has a derivative, y > 0; `ln 0` would make that 0 · ∞
            Binary::Pow if self.constant_value(x) == Some(0.0) => {
                let zero = self.constant(0.0);
                (zero, zero)
            }
            Binary::Pow => {
                let lower = self.sum(-1.0, &[(1.0, y)]);
                let power = self.call2(Binary::Pow, x, lower);
                let ln = self.call(Function::Ln, x);
                (self.mul(y, power), self.mul(ln, value))
            }
        }
    }
}

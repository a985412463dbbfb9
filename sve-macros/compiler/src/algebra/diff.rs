//! Derivatives, memoised over the arena: input an expression and a symbol, output the partial derivative.
//!
//! Each node is differentiated once for each symbol, operands first, so shared subexpressions stay shared.

use super::expr::{Arena, Binary, Expr, Function, Node, Symbol};

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
            Function::Asin => {
                let y = self.factored(1.0, -1.0, x);
                self.inverse_root(y)
            }
            Function::Acos => {
                let y = self.factored(1.0, -1.0, x);
                let asin = self.inverse_root(y);
                self.neg(asin)
            }
            Function::Atan => {
                let y = self.one_and_square(x);
                self.pow(y, -1)
            }
            Function::Sinh => self.call(Function::Cosh, x),
            Function::Cosh => self.call(Function::Sinh, x),
            Function::Tanh => {
                let square = self.pow(value, 2);
                self.sum(1.0, &[(-1.0, square)])
            }
            Function::Asinh => {
                let y = self.one_and_square(x);
                self.inverse_root(y)
            }
            Function::Acosh => {
                let y = self.factored(-1.0, 1.0, x);
                self.inverse_root(y)
            }
            Function::Atanh => {
                let y = self.factored(1.0, -1.0, x);
                self.pow(y, -1)
            }
            // the sign, which is NaN at 0
            Function::Abs => self.div(x, value),
            Function::Powf(k) => {
                let lower = self.constant_power(x, k.get() - 1.0);
                self.scale(k.get(), lower)
            }
        }
    }

    /// `1 + x²`.
    fn one_and_square(&mut self, x: Expr) -> Expr {
        let squared = self.pow(x, 2);
        self.sum(1.0, &[(1.0, squared)])
    }

    /// `(a + b x)(1 + x)`, which is ±(1 − x²) and does not cancel next to x = ±1.
    fn factored(&mut self, a: f64, b: f64, x: Expr) -> Expr {
        let (minus, plus) = (self.sum(a, &[(b, x)]), self.sum(1.0, &[(1.0, x)]));
        self.mul(minus, plus)
    }

    /// `1/√x`.
    fn inverse_root(&mut self, x: Expr) -> Expr {
        let root = self.call(Function::Sqrt, x);
        self.pow(root, -1)
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

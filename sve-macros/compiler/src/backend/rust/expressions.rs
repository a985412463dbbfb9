//! Operations → expressions.

use proc_macro2::{Literal, TokenStream};
use quote::quote;

use super::calls::{call, call_in_lane, call2, call2_in_lane};
use super::code::{Place, Printer};
use crate::program::{Operation, Value};

/// How strongly an expression binds.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Level {
    Sum,
    Product,
    Sign,
    Atom,
}

impl Printer<'_> {
    /// The expression of a value: its name, or what computes it.
    pub(super) fn operand(&self, value: Value) -> TokenStream {
        self.expression(value).1
    }

    fn expression(&self, value: Value) -> (Level, TokenStream) {
        match self.program.get(value).operation {
            Operation::Constant(bits) => (Level::Atom, constant(f64::from_bits(bits))),
            operation if self.inlined.contains(&value) => self.computed(operation),
            _ => {
                let name = self.name(value);
                (Level::Atom, quote!(#name))
            }
        }
    }

    /// The expression of an operand, in parentheses where it binds less than `level`.
    fn operand_of(&self, value: Value, level: Level) -> TokenStream {
        let (own, expression) = self.expression(value);
        if own < level {
            quote!((#expression))
        } else {
            expression
        }
    }

    /// The expression of an operation on numbers.
    pub(super) fn computed(&self, operation: Operation) -> (Level, TokenStream) {
        if self.place == Place::Rounded {
            return (Level::Atom, self.rounded(operation));
        }
        let of = |v: Value| self.operand(v);
        let private = self.formulas.private;
        let infix = |a, operator, b, level, right| {
            let (a, b) = (self.operand_of(a, level), self.operand_of(b, right));
            (level, quote!(#a #operator #b))
        };
        let (sum, product, sign) = (Level::Sum, Level::Product, Level::Sign);
        match operation {
            Operation::Add(a, b) => infix(a, quote!(+), b, sum, product),
            Operation::Sub(a, b) => infix(a, quote!(-), b, sum, product),
            Operation::Mul(a, b) => infix(a, quote!(*), b, product, sign),
            Operation::Div(a, b) => infix(a, quote!(/), b, product, sign),
            Operation::Recip(a) => {
                let a = self.operand_of(a, sign);
                (product, quote!(1f64 / #a))
            }
            Operation::Neg(a) => {
                let a = self.operand_of(a, Level::Atom);
                (sign, quote!(-#a))
            }
            Operation::Abs(a) => {
                let a = of(a);
                (Level::Atom, quote!(f64::abs(#a)))
            }
            Operation::Call(function, a) if self.is_vector() => {
                (Level::Atom, call_in_lane(function, &of(a), private))
            }
            Operation::Call(function, a) => (Level::Atom, call(function, &of(a))),
            Operation::Call2(function, a, b) if self.is_vector() => (
                Level::Atom,
                call2_in_lane(function, &of(a), &of(b), private),
            ),
            Operation::Call2(function, a, b) => {
                (Level::Atom, call2(function, &of(a), &of(b), private))
            }
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinCos(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_)
            | Operation::AngleAddition(..) => (Level::Atom, TokenStream::new()),
        }
    }

    /// The expression of a pair of sine and cosine.
    pub(super) fn sin_cos(&self, operation: Operation) -> TokenStream {
        let private = self.formulas.private;
        let module = self.is_vector().then(|| quote!(lane::));
        match operation {
            _ if self.place == Place::Rounded => self.rounded(operation),
            Operation::AngleAddition(sin, cos, by) => {
                let [sin, cos, by] = [sin, cos, by].map(|v| self.operand(v));
                quote!(#private::#module sin_cos_of_sum(#sin, #cos, #by))
            }
            Operation::SinCos(a) => {
                let a = self.operand(a);
                if self.is_vector() {
                    quote!(#private::lane::sin_cos(#a))
                } else {
                    quote!(f64::sin_cos(#a))
                }
            }
            _ => TokenStream::new(),
        }
    }
}

/// A literal; a negative one in parentheses.
pub(super) fn constant(value: f64) -> TokenStream {
    if !value.is_finite() {
        // a constant of a derivative overflowed: the step will report a result that is not finite
        let bits = Literal::u64_suffixed(value.to_bits());
        return quote!(f64::from_bits(#bits));
    }
    let literal = Literal::f64_suffixed(value.abs());
    if value.is_sign_negative() {
        quote!((-#literal))
    } else {
        quote!(#literal)
    }
}

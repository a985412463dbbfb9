//! Expressions → code that bounds the rounding errors with which they are evaluated, by the numbers
//! of the runtime's module `rounded`.
//!
//! The emitted code runs only where an iteration does not settle.

use proc_macro2::TokenStream;
use quote::quote;

use super::calls::{call, call2};
use super::code::{Place, Printer};
use super::function::Formulas;
use super::ident;
use crate::algebra::Expr;
use crate::program::{Array, Kernel, Operation, Tier};

/// Statements, and the array of the bounds.
pub(super) fn rounding(exprs: &[Expr], formulas: Formulas<'_>) -> TokenStream {
    let kernel = Kernel::new(formulas.scheduler(exprs), &[Array::unnamed(exprs)]);
    let printer = formulas.printer(&kernel, Place::Rounded);
    let [constants, statements] = [Tier::Prepare, Tier::State].map(|tier| printer.statements(tier));
    let results = kernel.arrays[0]
        .entries()
        .map(|value| printer.operand(value));
    let private = formulas.private;
    quote! {
        use #private::rounded::*;
        #constants
        #statements
        [#(error(#results)),*]
    }
}

impl Printer<'_> {
    /// An operation on numbers with bounds of their errors.
    pub(super) fn rounded(&self, operation: Operation) -> TokenStream {
        let x = quote!(x);
        let (name, function, operands) = match operation {
            Operation::Add(a, b) => ("add", None, vec![a, b]),
            Operation::Sub(a, b) => ("sub", None, vec![a, b]),
            Operation::Mul(a, b) => ("mul", None, vec![a, b]),
            Operation::Div(a, b) => ("div", None, vec![a, b]),
            Operation::Neg(a) => ("neg", None, vec![a]),
            Operation::Abs(a) => ("abs", None, vec![a]),
            Operation::Recip(a) => ("recip", None, vec![a]),
            Operation::SinCos(a) => ("sin_cos", None, vec![a]),
            Operation::AngleAddition(sin, cos, by) => ("sin_cos_of_sum", None, vec![sin, cos, by]),
            Operation::Call(function, a) => {
                let function = call(function, &x);
                ("call", Some(quote!(|x| #function,)), vec![a])
            }
            Operation::Call2(function, a, b) => {
                let function = call2(function, &x, &quote!(y), self.formulas.private);
                ("call2", Some(quote!(|x, y| #function,)), vec![a, b])
            }
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_) => return TokenStream::new(),
        };
        let name = ident(name);
        let operands = operands.into_iter().map(|value| self.operand(value));
        quote!(#name(#function #(#operands),*))
    }
}

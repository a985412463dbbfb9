//! Expressions → code that bounds the rounding errors with which they are evaluated.
//!
//! A running error analysis (Higham, Accuracy and Stability of Numerical Algorithms, section 3.3): beside each operation
//! stands a bound of the error of its result, to first order, with the inputs taken as exact. The emitted code runs only where an
//! iteration does not settle.

use proc_macro2::{Ident, TokenStream};
use quote::{format_ident, quote};

use super::calls::{call, call2};
use super::code::{Place, Printer};
use super::function::Formulas;
use crate::algebra::Expr;
use crate::program::{Array, Kernel, Labels, Operation, Program, Value};

/// Statements, and the array of the bounds.
pub(super) fn rounding(exprs: &[Expr], formulas: Formulas<'_>) -> TokenStream {
    let kernel = Kernel::new(formulas.scheduler(exprs), &[Array::unnamed(exprs)]);
    let program = &kernel.program;
    let printer = Printer::new(Place::Single, program, &Labels::default(), formulas);
    let private = formulas.private;
    let bounds = Bounds {
        program,
        printer: &printer,
        private,
    };
    let statements = program.all().map(|(value, instruction)| {
        let computed = printer.statement(value, instruction.operation);
        let bound = bounds.statement(value, instruction.operation);
        quote!(#computed #bound)
    });
    let results = kernel.arrays[0].entries();
    let results = results.map(|value| bounds.of(value).unwrap_or_else(|| quote!(0f64)));
    quote!(#(#statements)* [#(#results),*])
}

struct Bounds<'a> {
    program: &'a Program,
    printer: &'a Printer<'a>,
    private: &'a TokenStream,
}

impl Bounds<'_> {
    /// The bound of a value; nothing where it is exact.
    fn of(&self, value: Value) -> Option<TokenStream> {
        let named = match self.program.get(value).operation {
            Operation::Constant(_) | Operation::Input(_) => return None,
            Operation::SinOf(both) | Operation::CosOf(both) => both,
            _ => value,
        };
        let name = name(named);
        Some(quote!(#name))
    }

    /// The statement of a bound: what the operands bring with them, and the rounding of the result.
    fn statement(&self, value: Value, operation: Operation) -> TokenStream {
        let inherited = self.inherited(value, operation);
        let own = match operation {
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_) => return TokenStream::new(),
            Operation::SinCos(_) | Operation::AngleAddition(..) => quote!(f64::EPSILON),
            _ => {
                let result = self.printer.operand(value);
                quote!(f64::EPSILON * f64::abs(#result))
            }
        };
        let name = name(value);
        quote!(let #name = #(#inherited +)* #own;)
    }

    fn inherited(&self, value: Value, operation: Operation) -> Vec<TokenStream> {
        let of = |v: Value| self.of(v);
        let x = |v: Value| self.printer.operand(v);
        let private = self.private;
        let parts = match operation {
            Operation::Constant(_)
            | Operation::Input(_)
            | Operation::SinOf(_)
            | Operation::CosOf(_) => [None, None, None],
            Operation::Add(a, b) | Operation::Sub(a, b) => [of(a), of(b), None],
            Operation::Mul(a, b) => {
                let times = |bound: Option<TokenStream>, factor: TokenStream| {
                    bound.map(|d| quote!(f64::abs(#factor) * #d))
                };
                [times(of(a), x(b)), times(of(b), x(a)), None]
            }
            Operation::Div(a, b) => {
                let (divisor, ratio) = (x(b), x(value));
                let above = of(a).map(|d| quote!(#d / f64::abs(#divisor)));
                let below = of(b).map(|d| quote!(f64::abs(#ratio / #divisor) * #d));
                [above, below, None]
            }
            Operation::Recip(a) => {
                let inverse = x(value);
                [of(a).map(|d| quote!(#inverse * #inverse * #d)), None, None]
            }
            Operation::Neg(a) | Operation::Abs(a) | Operation::SinCos(a) => [of(a), None, None],
            Operation::Call(function, a) => {
                let (call, at) = (call(function, &quote!(x)), x(a));
                let error = of(a).map(|d| quote!(#private::propagated_error(|x| #call, #at, #d)));
                [error, None, None]
            }
            Operation::Call2(function, a, b) => {
                let (a_at, b_at) = (x(a), x(b));
                let along_a = call2(function, &quote!(x), &b_at, private);
                let along_b = call2(function, &a_at, &quote!(x), private);
                let first =
                    of(a).map(|d| quote!(#private::propagated_error(|x| #along_a, #a_at, #d)));
                let second =
                    of(b).map(|d| quote!(#private::propagated_error(|x| #along_b, #b_at, #d)));
                [first, second, None]
            }
            Operation::AngleAddition(sin, cos, by) => [of(sin), of(cos), of(by)],
        };
        parts.into_iter().flatten().collect()
    }
}

fn name(value: Value) -> Ident {
    format_ident!("error_{}", value.index())
}

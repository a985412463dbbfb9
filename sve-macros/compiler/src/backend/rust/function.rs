//! Functions as data → code: the statements of named arrays of expressions, computed where they
//! stand.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::{Place, Printer};
use super::ident;
use crate::algebra::{Arena, Expr};
use crate::model::Symbols;
use crate::program::{Array, Kernel, Operations, Scheduler, Tier, entries};

/// The context of formulas in print: the owner of their expressions, the meanings of their symbols,
/// and the path of the functions that generated code calls.
#[derive(Clone, Copy)]
pub(super) struct Formulas<'a> {
    pub(super) arena: &'a Arena,
    pub(super) symbols: &'a Symbols,
    pub(super) private: &'a TokenStream,
}

/// A function in print.
pub(super) struct Printed {
    pub(super) statements: TokenStream,
    /// The arrays, in the order in which they were given.
    pub(super) arrays: Vec<TokenStream>,
    pub(super) operations: Operations,
}

impl<'a> Formulas<'a> {
    /// Prints a function: the statements, and its arrays.
    pub(super) fn arrays<const N: usize>(
        self,
        arrays: &[Array<Expr>; N],
    ) -> (TokenStream, [TokenStream; N]) {
        let Printed {
            statements, arrays, ..
        } = self.list(arrays);
        let mut arrays = arrays.into_iter();
        let arrays = std::array::from_fn(|_| arrays.next().unwrap_or_default());
        (statements, arrays)
    }

    /// Prints a function of any number of arrays.
    pub(super) fn list(self, arrays: &[Array<Expr>]) -> Printed {
        self.print(&Kernel::new(self.scheduler(&entries(arrays)), arrays))
    }

    /// A scheduler of code that is computed where it stands.
    pub(super) fn scheduler(self, roots: &[Expr]) -> Scheduler<'a> {
        Scheduler::of_one_tier(self.arena, self.symbols, roots)
    }

    /// Prints a part of the body of a loop that the compiler turns into vector instructions: the
    /// statements, and an array.
    pub(super) fn within_loop(self, values: &[Expr]) -> (TokenStream, Vec<TokenStream>) {
        let mut scheduler = self.scheduler(values);
        scheduler.keep_intermediate_results();
        let kernel = Kernel::new(scheduler, &[Array::unnamed(values)]);
        let printer = self.printer(&kernel, Place::WithinLoop);
        let tiers = [Tier::Prepare, Tier::State];
        let statements = tiers.map(|tier| printer.statements(tier));
        let values = kernel.arrays[0].entries();
        let values = values.map(|value| printer.operand(value)).collect();
        (quote!(#(#statements)*), values)
    }

    /// Counts the operations of values that are computed together.
    pub(super) fn operations(self, values: &[Expr]) -> Operations {
        let kernel = Kernel::new(self.scheduler(values), &[Array::unnamed(values)]);
        Operations::of(&kernel.program, |_| true)
    }

    /// Prints a function of one tier.
    pub(super) fn print(self, kernel: &Kernel) -> Printed {
        let printer = self.printer(kernel, Place::Single);
        let [constants, statements] =
            [Tier::Prepare, Tier::State].map(|tier| printer.statements(tier));
        Printed {
            statements: quote!(#constants #statements),
            arrays: (kernel.arrays.iter())
                .map(|array| printer.shaped(array))
                .collect(),
            operations: Operations::of(&kernel.program, |_| true),
        }
    }

    pub(super) fn printer<'b>(self, kernel: &'b Kernel, place: Place) -> Printer<'b>
    where
        'a: 'b,
    {
        Printer::new(place, &kernel.program, &kernel.labels, self)
    }
}

/// A value of a struct of the runtime, with an array in each field.
pub(super) fn record(ty: &TokenStream, fields: &[&str], arrays: &[TokenStream]) -> TokenStream {
    let fields = fields.iter().map(|field| ident(field));
    quote!(#ty { #(#fields: #arrays),* })
}

//! Loops over an axis: each pass of the loop is a state of an ensemble, or a stage of a Gauss rule.
//!
//! A quantity over an axis is an array of rows, with one number for each pass: `rows[i][pass]`. The
//! axis decides where a pass reads the inputs of its program and where it writes its results.
//! Invariant: the body of a loop has no branches, so that the compiler turns the loop into vector
//! instructions.

use proc_macro2::{Ident, Literal, TokenStream};
use quote::{format_ident, quote};

use crate::model::{Meaning, Quantity, Symbols};

/// The kind of the passes of a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// States, which are the argument `states`.
    Lanes,
    /// Stages of a Gauss rule, which are the argument `stages`.
    Stages,
}

impl Axis {
    /// The loop.
    pub(super) fn sweep(self, body: &TokenStream, private: &TokenStream) -> TokenStream {
        let pass = self.pass();
        let count = match self {
            Self::Lanes => quote!(#private::lane::LANES),
            Self::Stages => quote!(__S),
        };
        quote!(for #pass in 0..#count { #body })
    }

    /// The rows of the inputs, which the loops over lanes read.
    pub(super) fn inputs(symbols: &Symbols, private: &TokenStream) -> Option<TokenStream> {
        (symbols.inputs() > 0).then(|| quote!(let inputs = #private::lane::inputs(&self.u);))
    }

    /// The number of a pass in a row.
    pub(super) fn entry(self, rows: &TokenStream, row: usize) -> TokenStream {
        let (row, pass) = (Literal::usize_unsuffixed(row), self.pass());
        quote!(#rows[#row][#pass])
    }

    /// The numbers of a pass in the first rows.
    pub(super) fn entries(self, rows: &TokenStream, count: usize) -> TokenStream {
        let entries = (0..count).map(|row| self.entry(rows, row));
        quote!([#(#entries),*])
    }

    /// The statements that write a number of a pass to each row.
    pub(super) fn store(
        self,
        rows: &TokenStream,
        values: impl IntoIterator<Item = TokenStream>,
    ) -> TokenStream {
        let values = values.into_iter().enumerate();
        values
            .map(|(row, value)| {
                let entry = self.entry(rows, row);
                quote!(#entry = #value;)
            })
            .collect()
    }

    /// The number that a loop has kept for later loops in a row of `kept`.
    pub(super) fn kept(self, row: usize) -> TokenStream {
        self.entry(&quote!(kept.0), row)
    }

    /// Where a pass reads an input of its program; nothing where it is bound before the loop, or by
    /// a solve within it.
    pub(super) fn input(self, meaning: &Meaning) -> Option<TokenStream> {
        match self {
            Self::Lanes => self.input_of_state(meaning),
            Self::Stages => self.input_of_stage(meaning),
        }
    }

    fn input_of_state(self, meaning: &Meaning) -> Option<TokenStream> {
        let (rows, i) = match meaning {
            Meaning::Time => return Some(quote!(states.t[lane])),
            Meaning::Position(i) | Meaning::Start(Quantity::Position, i) => (quote!(states.q), i),
            Meaning::Momentum(i) | Meaning::Start(Quantity::Momentum, i) => (quote!(states.p), i),
            Meaning::Wiener(i) => (quote!(dw), i),
            Meaning::Parameter { input: Some(k), .. } => (quote!(inputs), k),
            _ => return None,
        };
        Some(self.entry(&rows, *i))
    }

    /// A stage has its own time, weight and increments; its position and momentum are stored
    /// relative to the start.
    fn input_of_stage(self, meaning: &Meaning) -> Option<TokenStream> {
        let (start, rows, i) = match meaning {
            Meaning::Time => return Some(quote!(stages.times[stage])),
            Meaning::StepSize => return Some(quote!(stages.weights[stage])),
            Meaning::Wiener(i) => return Some(self.entry(&quote!(stages.noise), *i)),
            Meaning::Position(i) => (quote!(stages.q), quote!(stages.moves), i),
            Meaning::Momentum(i) => (quote!(stages.p), quote!(kicks), i),
            _ => return None,
        };
        let (row, moved) = (Literal::usize_unsuffixed(*i), self.entry(&rows, *i));
        Some(quote!(#start[#row] + #moved))
    }

    fn pass(self) -> Ident {
        match self {
            Self::Lanes => format_ident!("lane"),
            Self::Stages => format_ident!("stage"),
        }
    }
}

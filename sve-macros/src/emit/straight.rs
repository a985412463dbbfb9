//! Expressions → code that computes them where it stands, in one piece.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Printer;
use crate::model::Symbols;
use crate::schedule::{Program, Scheduler, Tier, Tiers, Value};
use crate::symbolic::{Arena, Expr};

/// Code of one tier: everything in it is computed where it is called.
pub(super) struct Straight<'a> {
    scheduler: Scheduler<'a>,
    symbols: &'a Symbols,
}

impl<'a> Straight<'a> {
    pub(super) fn new(arena: &'a Arena, symbols: &'a Symbols, roots: &[Expr]) -> Self {
        let tiers: Tiers = roots
            .iter()
            .flat_map(|&e| arena.symbols_of(e))
            .map(|s| (s, Tier::State))
            .collect();
        Self {
            scheduler: Scheduler::new(arena, symbols, tiers, roots),
            symbols,
        }
    }

    /// The program, and the values of `exprs` in it.
    pub(super) fn program(mut self, exprs: &[Expr]) -> (Program, Vec<Value>) {
        let values = self.scheduler.values(exprs);
        (self.scheduler.finish(&values), values)
    }

    /// The statements, and each array of expressions as tokens.
    pub(super) fn finish(
        mut self,
        private: &TokenStream,
        matrices: &[&[Vec<Expr>]],
    ) -> (TokenStream, Vec<TokenStream>) {
        let values: Vec<Vec<Vec<_>>> = matrices
            .iter()
            .map(|rows| rows.iter().map(|row| self.scheduler.values(row)).collect())
            .collect();
        let results: Vec<_> = values.iter().flatten().flatten().copied().collect();
        let program = self.scheduler.finish(&results);
        let mut printer = Printer::new(&program, self.symbols, private);
        printer.split_prepared(&[]);
        let constants = printer.prepare();
        let statements = printer.statements(Tier::State);
        (
            quote!(#constants #statements),
            values.iter().map(|rows| printer.matrix(rows)).collect(),
        )
    }
}

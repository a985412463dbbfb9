//! Expressions → code that computes them where it stands, in one piece.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Printer;
use super::names::Labels;
use crate::model::Symbols;
use crate::schedule::{Program, Scheduler, Tier, Tiers, Value};
use crate::symbolic::{Arena, Expr};

/// Code of one tier: everything in it is computed where it is called.
pub(super) struct Straight<'a> {
    arena: &'a Arena,
    roots: &'a [Expr],
    scheduler: Scheduler<'a>,
    symbols: &'a Symbols,
}

impl<'a> Straight<'a> {
    pub(super) fn new(arena: &'a Arena, symbols: &'a Symbols, roots: &'a [Expr]) -> Self {
        let tiers: Tiers = roots
            .iter()
            .flat_map(|&e| arena.symbols_of(e))
            .map(|s| (s, Tier::State))
            .collect();
        Self {
            arena,
            roots,
            scheduler: Scheduler::new(arena, symbols, tiers, roots),
            symbols,
        }
    }

    /// The program, and the values of `exprs` in it.
    pub(super) fn program(mut self, exprs: &[Expr]) -> (Program, Vec<Value>) {
        let values = self.scheduler.values(exprs);
        (self.scheduler.finish(&values), values)
    }

    /// The statements, and each array of expressions as tokens. The entries of a row are called `row_0`, `row_1`, ….
    pub(super) fn finish(
        mut self,
        private: &TokenStream,
        matrices: &[(&[Vec<Expr>], Vec<String>)],
    ) -> (TokenStream, Vec<TokenStream>) {
        let values: Vec<Vec<Vec<_>>> = matrices
            .iter()
            .map(|(rows, _)| rows.iter().map(|row| self.scheduler.values(row)).collect())
            .collect();
        let mut labels = Labels::default();
        for (rows, (_, names)) in values.iter().zip(matrices) {
            for (row, name) in rows.iter().zip(names) {
                labels.vector(name, 0, row);
            }
        }
        labels.expressions(&self.scheduler, self.arena, self.symbols, &[], self.roots);
        let results: Vec<_> = values.iter().flatten().flatten().copied().collect();
        let program = self.scheduler.finish(&results);
        let mut printer = Printer::new(&program, self.symbols, &labels, private);
        printer.split_prepared(&[]);
        let constants = printer.prepare();
        let statements = printer.statements(Tier::State);
        (
            quote!(#constants #statements),
            values.iter().map(|rows| printer.matrix(rows)).collect(),
        )
    }
}

/// `name_0`, `name_1`, …: the names of the rows of a matrix.
pub(super) fn rows(name: &str, count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{name}_{i}")).collect()
}

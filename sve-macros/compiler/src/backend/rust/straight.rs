//! Expressions → code that computes them where it stands, in one piece.

use proc_macro2::TokenStream;
use quote::quote;

use super::code::Printer;
use crate::algebra::{Arena, Expr};
use crate::model::Symbols;
use crate::program::{Labels, Operations, Program, Scheduler, Tier, Tiers, Value};

/// Code of one tier: everything in it is computed where it is called.
pub(super) struct Straight<'a> {
    arena: &'a Arena,
    roots: &'a [Expr],
    scheduler: Scheduler<'a>,
    symbols: &'a Symbols,
}

/// Rows of something, with what they are called: the entries of a row are `row_0`, `row_1`, ….
pub(super) type Named<T> = (T, Vec<String>);

/// What is printed.
pub(super) struct Printed {
    pub(super) statements: TokenStream,
    /// The arrays that were asked for.
    pub(super) arrays: Vec<TokenStream>,
    pub(super) operations: Operations,
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

    /// Disables the computation of sines and cosines by angle addition, so that each angle has a call of its own.
    pub(super) fn without_angle_addition(mut self) -> Self {
        self.scheduler.disable_angle_addition();
        self
    }

    /// The values of rows of expressions.
    pub(super) fn values(&mut self, rows: &[Vec<Expr>]) -> Vec<Vec<Value>> {
        rows.iter().map(|row| self.scheduler.values(row)).collect()
    }

    /// The values of residuals, and of the magnitudes of their terms.
    pub(super) fn residuals(&mut self, exprs: &[Expr]) -> (Vec<Value>, Vec<Value>) {
        exprs.iter().map(|&e| self.scheduler.residual(e)).unzip()
    }

    /// The statements, and each array of expressions as tokens.
    pub(super) fn finish(
        mut self,
        private: &TokenStream,
        matrices: &[Named<&[Vec<Expr>]>],
    ) -> (TokenStream, Vec<TokenStream>) {
        let named = matrices
            .iter()
            .map(|(rows, names)| (self.values(rows), names.clone()));
        let values: Vec<Named<Vec<Vec<Value>>>> = named.collect();
        let printed = self.print(private, &values);
        (printed.statements, printed.arrays)
    }

    /// The code of values.
    pub(super) fn print(self, private: &TokenStream, values: &[Named<Vec<Vec<Value>>>]) -> Printed {
        let mut labels = Labels::default();
        for (rows, names) in values {
            for (row, name) in rows.iter().zip(names) {
                labels.vector(name, 0, row);
            }
        }
        labels.expressions(&self.scheduler, self.arena, self.symbols, &[], self.roots);
        let results: Vec<Value> = values
            .iter()
            .flat_map(|v| &v.0)
            .flatten()
            .copied()
            .collect();
        let program = self.scheduler.finish(&results);
        let mut printer = Printer::new(&program, self.symbols, &labels, private);
        printer.split_prepared(&[]);
        let constants = printer.prepare();
        let statements = printer.statements(Tier::State);
        Printed {
            statements: quote!(#constants #statements),
            arrays: values
                .iter()
                .map(|(rows, _)| printer.matrix(rows))
                .collect(),
            operations: Operations::of(&program, |_| true),
        }
    }
}

/// `name_0`, `name_1`, …: the names of the rows of a matrix.
pub(super) fn rows(name: &str, count: usize) -> Vec<String> {
    (0..count).map(|i| format!("{name}_{i}")).collect()
}

//! Numbers that are computed from reads: those that are rounded, and the values of inner sums.

use proc_macro2::TokenStream;
use quote::quote;

use super::{Leaf, Walk, where_defined};
use crate::algebra::{Expr, Symbol};
use crate::model::scene::SumId;

impl Walk<'_> {
    /// Returns a number as a block, after `code` that reads its symbols. It is NaN where one of
    /// `conditions` is not positive.
    pub(super) fn number(
        &mut self,
        number: Expr,
        conditions: &[Expr],
        code: &mut TokenStream,
    ) -> TokenStream {
        for &read in conditions.iter().chain([&number]) {
            for symbol in self.formulas.arena.symbols_of(read) {
                self.symbol(symbol, code);
            }
        }
        let (statements, values) = where_defined(&[number], conditions, self.formulas);
        quote!({ #statements #(#values)* })
    }

    /// Computes what the instances of a sum need of its inner sums.
    pub(super) fn inner_totals(&mut self, sum: Option<SumId>, code: &mut TokenStream) {
        let derived = self.derived;
        let before = derived.inner.before.iter();
        for &(_, symbol) in before.filter(|(outer, _)| Some(*outer) == sum) {
            if self.is_needed(symbol, sum) {
                self.symbol(symbol, code);
            }
        }
    }

    /// Returns whether a summand within a sum depends on a symbol.
    fn is_needed(&self, symbol: Symbol, sum: Option<SumId>) -> bool {
        let scene = self.scene();
        let within = |leaf: &&Leaf| scene.around(leaf.sum).any(|around| Some(around) == sum);
        let mut leaves = self.leaves.iter().filter(within);
        leaves.any(|leaf| {
            let mut values = leaf.values.iter().chain(&leaf.conditions);
            values.any(|&value| scene.depends(value, symbol, self.formulas.arena))
        })
    }

    /// Returns the value of an inner sum as a block.
    pub(super) fn inner_total(&mut self, number: usize) -> TokenStream {
        let (sum, summands) = &self.derived.inner.all[number];
        let leaves = summands.iter().map(Leaf::value);
        let outer = std::mem::replace(&mut self.leaves, leaves.collect());
        let [known, symbols] = [self.known.len(), self.symbols.len()];
        let rows = self.rows.clone();
        let mut loops = TokenStream::new();
        self.sum(*sum, &mut loops);
        self.leaves = outer;
        self.known.truncate(known);
        self.symbols.truncate(symbols);
        self.rows = rows;
        quote!({ let mut value = 0f64; #loops value })
    }
}

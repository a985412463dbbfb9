//! Inner sums that enter formulas of the sum around them, such as the density at an atom.
//!
//! In an instance of the outer sum, such a sum S is computed first, in a pass of its own. The
//! formula f(q, S) then is a term whose derivatives take S for a constant. The summands of S are
//! terms with the weight ∂f/∂S, which their derivatives take for a constant too.

use std::collections::HashMap;

use super::{Summand, Terms};
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;
use crate::model::scene::{Slot, SlotArray, SumId};

/// The inner sums that enter formulas of the sum around them.
#[derive(Clone, Default)]
pub(crate) struct InnerTotals {
    /// Each with its summands.
    pub(crate) all: Vec<(SumId, Vec<Summand>)>,
    /// For each outer sum, those in its formula, with the symbols of their values.
    within: HashMap<SumId, Vec<(SumId, Symbol)>>,
    /// The values and weights that are computed at the start of an instance of an outer sum, in
    /// the order of their computation.
    pub(crate) before: Vec<(SumId, Symbol)>,
    /// Expressions that must be positive: the weight is NaN elsewhere.
    pub(crate) conditions: HashMap<Symbol, Vec<Expr>>,
}

impl Terms<'_> {
    /// Replaces the inner sums that enter the summand of a sum by their values. Returns them with
    /// their weights, for a weight of the sum itself.
    pub(super) fn inner_totals(&mut self, outer: SumId, weight: Expr) -> Vec<(SumId, Expr)> {
        if !self.inner.within.contains_key(&outer) {
            self.hold(outer);
        }
        let summand = self.scene.sums[outer.0].summand;
        let held = self.inner.within.get(&outer).cloned().unwrap_or_default();
        let weights = held.into_iter().map(|(sum, symbol)| {
            let slope = self.arena.diff(summand, symbol);
            let number = self.arena.mul(weight, slope);
            let symbol = self.computed(SlotArray::Weight(number));
            self.inner.before.push((outer, symbol));
            (sum, self.arena.symbol(symbol))
        });
        weights.collect()
    }

    fn hold(&mut self, outer: SumId) {
        let summand = self.scene.sums[outer.0].summand;
        let one = self.arena.constant(1.0);
        let (mut by, mut held) = (HashMap::new(), Vec::new());
        for (sum, of_sum) in self.entering(summand) {
            let mut summands = Vec::new();
            // the root of a sum within an instance is that of the instance
            self.sum(0, sum, one, [&mut summands, &mut Vec::new()]);
            self.check_rest(&summands);
            let number = self.inner.all.len();
            self.inner.all.push((sum, summands));
            let symbol = self.computed(SlotArray::Sum(number));
            self.inner.before.push((outer, symbol));
            by.insert(of_sum, self.arena.symbol(symbol));
            held.push((sum, symbol));
        }
        self.scene.sums[outer.0].summand = self.arena.substitute(summand, &by);
        self.inner.within.insert(outer, held);
    }

    /// Returns the symbol of a number that is computed from reads.
    fn computed(&mut self, array: SlotArray) -> Symbol {
        let component = 0;
        self.slot(Slot { array, component })
    }

    /// Returns the symbol of a new slot.
    pub(super) fn slot(&mut self, slot: Slot) -> Symbol {
        self.scene.slots.push(slot);
        let meaning = Meaning::Slot(self.scene.slots.len() - 1);
        self.scene.symbols.declare(meaning)
    }
}

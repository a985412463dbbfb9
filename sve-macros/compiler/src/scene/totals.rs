//! Sums that enter formulas in another way than with a factor, such as a mean field.
//!
//! Such a sum S in a function f is a *total*: a number that is known before the loops whose terms
//! read it. So is the derivative ∂f/∂S, the weight with which the derivatives of the summands of S
//! enter the impulses.

use std::collections::HashMap;

use super::{Summand, Terms};
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;
use crate::model::scene::{SlotArray, SumId};

/// A sum whose value the terms of other loops, or its own ones, read.
#[derive(Clone)]
pub(crate) struct Total {
    /// Its number among all numbers that are known before the loops.
    pub(crate) number: usize,
    pub(crate) symbol: Symbol,
    pub(crate) summands: Vec<Summand>,
}

impl Terms<'_> {
    /// Returns the summand of `home` with symbols of totals in the place of the sums whose factors
    /// contain sums. The derivatives with respect to these sums are totals too: they are the
    /// weights of the summands that are added to `slopes`.
    pub(super) fn with_totals(
        &mut self,
        name: &str,
        value: Expr,
        home: Option<SumId>,
        slopes: &mut Vec<Summand>,
    ) -> Expr {
        let one = self.arena.constant(1.0);
        let (mut by, mut found) = (HashMap::new(), Vec::new());
        for (sum, of_sum) in self.entering(value) {
            self.scene.sums[sum.0].parent = None;
            let (root, mut summands) = (self.root(Some(sum), name), Vec::new());
            // the slopes of inner totals come with those of this one
            self.sum(root, sum, one, [&mut summands, &mut Vec::new()]);
            self.check_rest(&summands);
            let symbol = self.total(summands);
            by.insert(of_sum, self.arena.symbol(symbol));
            found.push((symbol, sum, root));
        }
        let value = self.arena.substitute(value, &by);
        for (symbol, sum, root) in found {
            let root_of_weight = self.root(home, name);
            let weight = Summand::new(root_of_weight, home, self.arena.diff(value, symbol));
            let weight = self.total(vec![weight]);
            let weight = self.arena.symbol(weight);
            let mut inner = Vec::new();
            self.sum(root, sum, weight, [&mut *slopes, &mut inner]);
            slopes.extend(inner);
        }
        value
    }

    /// Appends a total. Returns its symbol.
    fn total(&mut self, summands: Vec<Summand>) -> Symbol {
        let number = self.totals.len();
        let symbol = self.scene.symbols.declare(Meaning::Total(number));
        self.totals.push(Total {
            number,
            symbol,
            summands,
        });
        symbol
    }

    /// Checks that the summands of a sum that enters a formula do not read velocities or momenta.
    pub(super) fn check_rest(&mut self, summands: &[Summand]) {
        for Summand { sum, value, .. } in summands {
            let slots = self.slots_of(*value);
            let is_of_motion =
                |array| matches!(array, &SlotArray::Velocity(_) | &SlotArray::Momentum(_));
            if slots.iter().any(|s| is_of_motion(s.1)) {
                let message = "this sum of velocities or momenta enters another formula: a term reads them where it is added, as `l += 0.5 * self.m[i] * v[i] * v[i]` in the kinetic energy, or `f -= self.nu * (v[i] - v[j])` in a force";
                self.errors.push(self.place(*sum), message);
            }
        }
    }
}

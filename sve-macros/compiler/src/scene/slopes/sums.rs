//! Bounds of sums that enter formulas, and of their derivatives.
//!
//! The value S of such a sum moves with the sites that it reads. In the place of S there are three
//! numbers: the middle and the half width of an interval that contains S for all sites in their
//! boxes, and a bound of `Σ |∂S/∂q|` over all coordinates. An impulse that reads S adds to its row
//! sum at most `|∂I/∂S| Σ |∂S/∂q|`.

use std::collections::HashMap;

use super::super::{Derived, InnerTotals, Summand, Total};
use super::Bounds;
use crate::algebra::intervals::{Intervals, Range};
use crate::algebra::{Expr, Symbol};
use crate::model::Meaning;
use crate::model::scene::{Condition, Head, Scene, Slot, SlotArray, SumId};

/// The bounds of the value of a sum.
#[derive(Clone, Copy)]
pub(super) struct OfSum {
    radius: Symbol,
    /// The bound of the sum of the magnitudes of its derivatives.
    pub(super) slope: Symbol,
}

/// The bounds of a number.
struct Bounded {
    /// The middle, the radius, and the bound of the magnitudes of the derivatives.
    parts: [Expr; 3],
    /// Expressions that must be positive.
    conditions: Vec<Expr>,
}

/// Declares what bounds the sums of a scene. The slots of inner sums and their weights get the
/// arrays that [`bound`] gives them.
pub(super) fn declare(scene: &mut Scene, derived: &Derived) -> HashMap<Symbol, OfSum> {
    let count = derived.totals.len();
    let mut sums = HashMap::new();
    for total in &derived.totals {
        let part = |part| Meaning::Total(part * count + total.number);
        let [radius, slope] = [1, 2].map(|number| scene.symbols.declare(part(number)));
        sums.insert(total.symbol, OfSum { radius, slope });
    }
    for &(_, symbol) in &derived.inner.before {
        let Some(slot) = scene.slot(symbol).cloned() else {
            continue;
        };
        let [radius, slope] = [0, 1].map(|_| {
            scene.slots.push(slot.clone());
            let meaning = Meaning::Slot(scene.slots.len() - 1);
            scene.symbols.declare(meaning)
        });
        sums.insert(symbol, OfSum { radius, slope });
    }
    sums
}

/// Replaces the sums of a scene by their bounds. `read` is the scene with the conditions of the
/// user. Returns `None` if a function has no bounds.
pub(super) fn bound(derived: &mut Derived, read: &Scene, bounds: &mut Bounds<'_>) -> Option<()> {
    let (totals, inner) = (derived.totals.clone(), derived.inner.clone());
    derived.totals.clear();
    let count = totals.len();
    for Total {
        number,
        symbol,
        summands,
    } in totals
    {
        let of_sum = bounds.sums[&symbol];
        let symbols = [symbol, of_sum.radius, of_sum.slope];
        let summands = bounds.summands(&summands, read, &mut derived.scene)?;
        for ((part, symbol), summands) in symbols.into_iter().enumerate().zip(summands) {
            let number = part * count + number;
            derived.totals.push(Total {
                number,
                symbol,
                summands,
            });
        }
    }
    derived.inner = bounds.inner(&inner, read, &mut derived.scene)?;
    Some(())
}

impl Bounds<'_> {
    fn inner(&mut self, of: &InnerTotals, read: &Scene, scene: &mut Scene) -> Option<InnerTotals> {
        let mut inner = InnerTotals::default();
        for (sum, summands) in &of.all {
            let parts = self.summands(summands, read, scene)?;
            inner.all.extend(parts.map(|summands| (*sum, summands)));
        }
        for &(outer, symbol) in &of.before {
            let OfSum { radius, slope } = self.sums[&symbol];
            let arrays = match scene.slot(symbol)?.array {
                SlotArray::Sum(number) => [0, 1, 2].map(|part| SlotArray::Sum(3 * number + part)),
                SlotArray::Weight(number) => {
                    let Bounded { parts, conditions } = self.number(number, false)?;
                    for symbol in [symbol, radius, slope] {
                        inner.conditions.insert(symbol, conditions.clone());
                    }
                    parts.map(SlotArray::Weight)
                }
                _ => return None,
            };
            for (symbol, array) in [symbol, radius, slope].into_iter().zip(arrays) {
                let component = 0;
                *scene.slot_mut(symbol)? = Slot { array, component };
                inner.before.push((outer, symbol));
            }
        }
        Some(inner)
    }

    /// Returns the summands of the bounds of a sum. A summand that vanishes somewhere in the box,
    /// since a condition on numbers does not hold there, has another interval than one that does
    /// not.
    fn summands(
        &mut self,
        summands: &[Summand],
        read: &Scene,
        scene: &mut Scene,
    ) -> Option<[Vec<Summand>; 3]> {
        let mut all = [const { Vec::new() }; 3];
        for summand in summands {
            let cases = match (summand.sum, self.may_fail(summand.sum, read)) {
                (Some(sum), Some(may_fail)) => {
                    let holds = Condition::Not(Box::new(may_fail.clone()));
                    let mut under = |condition| Some(scene.child(sum, Head::If(condition)));
                    vec![(under(holds), false), (under(may_fail), true)]
                }
                (sum, _) => vec![(sum, false)],
            };
            for (sum, may_vanish) in cases {
                let Bounded { parts, conditions } = self.number(summand.value, may_vanish)?;
                for (to, value) in all.iter_mut().zip(parts) {
                    to.push(Summand {
                        root: summand.root,
                        sum,
                        value,
                        conditions: conditions.clone(),
                    });
                }
            }
        }
        Some(all)
    }

    /// Returns a condition that is true if one of those around a summand, on numbers, does not hold
    /// somewhere in the box; `None` if there are none.
    fn may_fail(&mut self, sum: Option<SumId>, read: &Scene) -> Option<Condition> {
        let heads = read.heads(sum).filter(|head| !head.numbers().is_empty());
        let conditions = heads.filter_map(|head| match head {
            Head::If(condition) => Some(self.may_hold(condition, false)),
            Head::For { .. } => None,
        });
        conditions.reduce(|a, b| Condition::Or(Box::new(a), Box::new(b)))
    }

    /// Returns the bounds of a number.
    fn number(&mut self, number: Expr, may_vanish: bool) -> Option<Bounded> {
        let moving = self.moving(number);
        let slopes = moving.iter().map(|&symbol| self.arena.diff(number, symbol));
        let mut entries: Vec<Expr> = slopes.collect();
        entries.push(number);
        let Intervals {
            mut middle,
            mut radii,
            conditions,
        } = self.intervals(entries)?;
        let [mut value, mut radius] = [middle.pop()?, radii.pop()?];
        if may_vanish {
            let [low, high] = [self.arena.sub(value, radius), self.arena.add(value, radius)];
            let [low, high] = [self.half(low, -0.5), self.half(high, 0.5)];
            value = self.arena.sum(0.0, &[(0.5, low), (0.5, high)]);
            radius = self.arena.sum(0.0, &[(-0.5, low), (0.5, high)]);
        }
        let mut slope = Vec::new();
        for (&symbol, (&middle, &radius)) in moving.iter().zip(middle.iter().zip(&radii)) {
            let middle = self.arena.abs(middle);
            for part in [middle, radius] {
                slope.push((1.0, self.times_slope(part, symbol)));
            }
        }
        let slope = self.arena.sum(0.0, &slope);
        Some(Bounded {
            parts: [value, radius, slope],
            conditions,
        })
    }

    /// Returns the coordinates and the sums in a number.
    pub(super) fn moving(&self, number: Expr) -> Vec<Symbol> {
        let symbols = self.arena.symbols_of(number);
        symbols.filter(|s| self.ranges.contains_key(s)).collect()
    }

    /// Returns the magnitude of a derivative times the bound of the derivatives of its variable, if
    /// this is a sum and no coordinate.
    pub(super) fn times_slope(&mut self, magnitude: Expr, symbol: Symbol) -> Expr {
        match self.sums.get(&symbol) {
            Some(of_sum) => {
                let slope = self.arena.symbol(of_sum.slope);
                self.arena.mul(magnitude, slope)
            }
            None => magnitude,
        }
    }
}

/// Returns whether there is a condition on numbers around a summand.
pub(super) fn may_vanish(sum: Option<SumId>, scene: &Scene) -> bool {
    scene.heads(sum).any(|head| !head.numbers().is_empty())
}

impl OfSum {
    pub(super) fn range(self) -> Range {
        Range::Within(self.radius)
    }
}

//! The kinetic energy of a scene: `½ Σ m v²` with masses that do not depend on the motion.

use super::{Coefficient, Summand, Terms};
use crate::algebra::{Expr, Symbol};
use crate::model::scene::{Condition, Head, Int, SlotArray, SumId};
use proc_macro2::Span;

/// Returns the masses. Velocities that occur in another way are mistakes.
pub(super) fn masses(terms: &mut Terms<'_>, summands: &[Summand]) -> Vec<Coefficient> {
    for sum in 0..terms.scene.sums.len() {
        terms.check_condition(SumId(sum));
    }
    let mut masses = Vec::new();
    for summand in summands {
        masses.extend(terms.masses_of(summand));
    }
    if masses.is_empty() && terms.errors.count() == 0 {
        let message = "this Lagrangian has no kinetic energy: a loop over sites needs terms `0.5 * m * v[i] * v[i]`";
        terms.errors.push(Span::call_site(), message);
    }
    masses
}

const WORKS: &str =
    "kept loops need the kinetic energy `0.5 * m * v[i] * v[i]` of each component of each site";

impl Terms<'_> {
    /// Checks that the condition of a sum does not read velocities.
    fn check_condition(&mut self, sum: SumId) {
        let sum = &self.scene.sums[sum.0];
        let Head::If(condition) = &sum.head else {
            return;
        };
        let numbers = numbers(condition);
        let reads_velocity = numbers.iter().any(|&number| {
            let slots = self.slots_of(number);
            slots.iter().any(|s| matches!(s.1, SlotArray::Velocity(_)))
        });
        if reads_velocity {
            let message = format!("this condition depends on a velocity: {WORKS}");
            self.errors.push(sum.at, message);
        }
    }

    /// Returns the masses in a summand.
    fn masses_of(&mut self, summand: &Summand) -> Vec<Coefficient> {
        let Summand { root, sum, value } = *summand;
        let velocities: Vec<(Symbol, Int, usize)> = self
            .slots_of(value)
            .into_iter()
            .filter_map(|(symbol, array, component)| match array {
                SlotArray::Velocity(site) => Some((symbol, *site, component)),
                _ => None,
            })
            .collect();
        let zero = self.arena.constant(0.0);
        let at_rest = velocities.iter().map(|v| (v.0, zero)).collect();
        let mut masses = Vec::new();
        for &(symbol, site, component) in &velocities {
            let momentum = self.arena.diff(value, symbol);
            let slope = self.arena.diff(momentum, symbol);
            let mass = self.arena.substitute(slope, &at_rest);
            let linear = self.arena.substitute(momentum, &at_rest);
            let mistake = self.mistake(
                summand,
                &velocities,
                symbol,
                [momentum, slope, mass, linear],
            );
            if let Some(mistake) = mistake {
                self.errors.push(self.place(sum), mistake);
                return Vec::new();
            }
            masses.push(Coefficient {
                root,
                sum,
                site,
                component,
                value: mass,
            });
        }
        masses
    }

    /// Returns what a velocity has that a kinetic energy may not have.
    fn mistake(
        &mut self,
        summand: &Summand,
        velocities: &[(Symbol, Int, usize)],
        symbol: Symbol,
        [momentum, slope, mass, linear]: [Expr; 4],
    ) -> Option<String> {
        let own = self.text(symbol);
        for &(other, ..) in velocities.iter().filter(|v| v.0 != symbol) {
            let mixed = self.arena.diff(momentum, other);
            if !self.arena.is_zero(mixed) {
                let [first, second] = [symbol.min(other), symbol.max(other)].map(|v| self.text(v));
                return Some(format!(
                    "the velocities `{first}` and `{second}` occur in one term: {WORKS}"
                ));
            }
        }
        let cubic = self.arena.diff(slope, symbol);
        if !self.arena.is_zero(cubic) {
            return Some(format!(
                "the Lagrangian is not quadratic in the velocity `{own}`: {WORKS}"
            ));
        }
        if !self.arena.is_zero(linear) {
            return Some(format!(
                "the velocity `{own}` occurs in a term that is linear in it: {WORKS}"
            ));
        }
        let reads = self.varies(summand.sum, mass);
        reads.map(|read| {
            format!("the mass of the velocity `{own}` depends on {read}: masses of kept loops are constants, which may differ from site to site")
        })
    }

    /// Returns a slot as the source may spell it.
    pub(super) fn text(&self, symbol: Symbol) -> String {
        let Some(slot) = self.scene.slot(symbol) else {
            return self.scene.symbols.name(symbol);
        };
        let component = match self.scene.row.len() {
            1 => String::new(),
            _ => format!("[{}]", slot.component),
        };
        format!("{}{component}", self.scene.text(slot))
    }

    /// Returns the place of a sum.
    pub(super) fn place(&self, sum: Option<SumId>) -> Span {
        sum.map_or_else(Span::call_site, |sum| self.scene.sums[sum.0].at)
    }
}

/// Returns the numbers that a condition compares.
pub(super) fn numbers(condition: &Condition) -> Vec<Expr> {
    match condition {
        Condition::Integers(..) => Vec::new(),
        Condition::Numbers(_, a, b) => vec![*a, *b],
        Condition::Not(inner) => numbers(inner),
        Condition::And(a, b) | Condition::Or(a, b) => {
            let mut found = numbers(a);
            found.extend(numbers(b));
            found
        }
    }
}

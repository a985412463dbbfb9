//! Terms: summands with their derivatives.

use std::collections::BTreeSet;

use super::{Summand, Terms};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::scene::{Int, SlotArray, SumId};

/// A term that adds to the impulses of sites: a term of a potential or a noise, which depends on
/// them, or a force on the first one.
#[derive(Clone)]
pub(crate) struct Term {
    pub(crate) root: usize,
    pub(crate) sum: Option<SumId>,
    /// True for a term of a noise, which is multiplied by increments; false for a term of the
    /// Lagrangian, whose derivative the step size multiplies.
    pub(crate) is_noise: bool,
    /// The sites that the term reads.
    pub(crate) sites: Vec<Int>,
    /// The fields and integers that the derivatives read.
    pub(crate) columns: Vec<Symbol>,
    /// For each site, the derivative in each component, or the force, as it was derived.
    pub(crate) slopes: Vec<Vec<Expr>>,
    /// For each site, expressions that must be positive: the impulse is not defined elsewhere.
    pub(crate) conditions: Vec<Vec<Expr>>,
    /// The same derivatives in stable forms.
    pub(crate) gradient: Vec<Vec<Expr>>,
    /// For each site, the impulse in each component: the derivative, times h for a term of the
    /// Lagrangian.
    pub(crate) impulses: Vec<Vec<Expr>>,
    /// For a noise with a process for each instance, its number in [`Derived::each`].
    pub(crate) increment: Option<usize>,
}

impl Terms<'_> {
    /// Returns the fields and integers that numbers read.
    pub(super) fn columns_of(&self, numbers: &[Expr]) -> Vec<Symbol> {
        let read = numbers.iter().flat_map(|&number| self.slots_of(number));
        let is_column = |array| matches!(array, &SlotArray::Field(_) | &SlotArray::Number(_));
        let columns: BTreeSet<Symbol> =
            read.filter(|slot| is_column(slot.1)).map(|s| s.0).collect();
        columns.into_iter().collect()
    }

    /// Returns a term with its derivatives; `None` if it does not depend on the configuration.
    pub(super) fn term(&mut self, summand: &Summand, is_noise: bool) -> Option<Term> {
        self.slopes(summand, is_noise, |array| match array {
            SlotArray::Configuration(site) => Some(*site),
            _ => None,
        })
    }

    /// Returns the terms of an H₁ in the impulses, `−∂H₁/∂q`, and in the displacements, `∂H₁/∂p`.
    pub(super) fn h1_terms(&mut self, summand: &Summand) -> [Option<Term>; 2] {
        let value = self.arena.scale(-1.0, summand.value);
        let kick = self.term(
            &Summand {
                value,
                ..summand.clone()
            },
            true,
        );
        let shift = self.slopes(summand, true, |array| match array {
            SlotArray::Momentum(site) => Some(*site),
            _ => None,
        });
        [kick, shift]
    }

    /// Returns a term with its derivatives by the rows that `site_of` accepts.
    fn slopes(
        &mut self,
        summand: &Summand,
        is_noise: bool,
        site_of: impl Fn(&SlotArray) -> Option<Int>,
    ) -> Option<Term> {
        let Summand {
            root, sum, value, ..
        } = *summand;
        let slots = self.slots_of(value).into_iter();
        let slots = slots
            .filter_map(|(symbol, array, component)| Some((symbol, site_of(array)?, component)));
        let coordinates: Vec<(Symbol, Int, usize)> = slots.collect();
        let mut sites: Vec<Int> = Vec::new();
        for &(_, site, _) in &coordinates {
            if !sites.contains(&site) {
                sites.push(site);
            }
        }
        let zero = self.arena.constant(0.0);
        let mut gradient = vec![vec![zero; self.scene.row.len()]; sites.len()];
        for (symbol, site, component) in coordinates {
            let slope = self.arena.diff(value, symbol);
            let at = sites.iter().position(|s| *s == site)?;
            gradient[at][component] = slope;
        }
        let slopes: Vec<Expr> = gradient.iter().flatten().copied().collect();
        if self.arena.zeros(&slopes).into_iter().all(|is_zero| is_zero) {
            return None;
        }
        let of_each = self.each.iter();
        let mut of_each = of_each.map(|each| self.scene.depends(value, each.increment, self.arena));
        Some(Term {
            root,
            sum,
            is_noise,
            sites,
            columns: self.columns_of(&slopes),
            slopes: Vec::new(),
            conditions: Vec::new(),
            impulses: Vec::new(),
            gradient,
            increment: of_each.position(|is_read| is_read),
        })
    }

    /// Returns the slots in an expression, in the order of their symbols.
    pub(super) fn slots_of(&self, value: Expr) -> Vec<(Symbol, &SlotArray, usize)> {
        let slot = |symbol| {
            let slot = self.scene.slot(symbol)?;
            Some((symbol, &slot.array, slot.component))
        };
        self.arena.symbols_of(value).filter_map(slot).collect()
    }
}

impl Term {
    /// Returns the sites whose impulses the term adds to.
    pub(crate) fn receivers<'a>(&'a self, arena: &'a Arena) -> impl Iterator<Item = usize> + 'a {
        let is_zero = |slope: &Expr| arena.constant_value(*slope) == Some(0.0);
        (0..self.sites.len()).filter(move |&site| !self.gradient[site].iter().all(is_zero))
    }
}

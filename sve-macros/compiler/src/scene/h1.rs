//! Noises H₁: their terms, and whether they commute, an H₁ of each site with those of other sites.

use super::{Derived, Summand, Term, Terms};
use crate::algebra::Arena;
use crate::model::scene::{Head, Int, IntNode, Processes, SceneNoise, SlotArray};

impl Terms<'_> {
    /// Returns the terms of all H₁ in the impulses and in the displacements.
    pub(super) fn h1(&mut self, summands: &[Summand]) -> [Vec<Term>; 2] {
        let mut all = [Vec::new(), Vec::new()];
        for summand in summands {
            for (all, term) in all.iter_mut().zip(self.h1_terms(summand)) {
                all.extend(term);
            }
        }
        all
    }
}

impl Derived {
    /// Returns the names of two noises that may not commute; `None` if all do by their form: there
    /// is one process, or there are γ and forces alone, or one function with a process for each
    /// site that reads this site alone.
    pub(crate) fn pair(&self, arena: &Arena) -> Option<[&str; 2]> {
        let noises = &self.scene.noises;
        let h1 = noises.iter().find(|noise| noise.is_h1)?;
        if let Some(other) = noises.iter().find(|noise| noise.name != h1.name) {
            return Some([&h1.name, &other.name]);
        }
        if let Some(force) = self.scene.forces.iter().find(|force| force.is_noise) {
            return Some([&h1.name, &force.name]);
        }
        let commutes = match &h1.processes {
            Processes::Listed(list) => list.len() == 1,
            Processes::Each(sums) => sums.len() == 1 && self.reads_own_site(h1, arena),
        };
        (!commutes).then_some([&h1.name, &h1.name])
    }

    /// Returns whether each process of an H₁ reads the site of its number alone.
    fn reads_own_site(&self, h1: &SceneNoise, arena: &Arena) -> bool {
        let Processes::Each(ref sums) = h1.processes else {
            return false;
        };
        let sum = sums[0];
        let Head::For { counter, .. } = self.scene.sums[sum.0].head else {
            return false;
        };
        let is_own = |site: Int| *self.scene.integers.node(site) == IntNode::Counter(counter);
        let mut terms = self.h1.iter().flatten();
        terms.all(|term| {
            let slopes = term.gradient.iter().flatten();
            let mut symbols = slopes.flat_map(|&slope| arena.symbols_of(slope));
            let read = symbols.all(|symbol| match self.scene.slot(symbol).map(|s| &s.array) {
                Some(&SlotArray::Configuration(site) | &SlotArray::Momentum(site)) => is_own(site),
                Some(other) => !other.is_computed(),
                None => true,
            });
            read && term.sum == Some(sum)
        })
    }
}

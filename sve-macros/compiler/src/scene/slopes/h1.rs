//! Bounds of the derivatives of impulses and displacements by H₁.

use std::collections::BTreeSet;

use super::super::Term;
use super::Bounds;
use crate::algebra::intervals::Intervals;
use crate::algebra::{Expr, Symbol};

impl Bounds<'_> {
    /// Replaces the impulses or displacements of a term of H₁ by bounds of the row sums of the
    /// magnitudes of their derivatives: by places, and by momenta. Returns `None` if a function has
    /// no bounds.
    pub(super) fn bound_h1(&mut self, term: &mut Term) -> Option<()> {
        let mut bounds = Vec::new();
        for slopes in &term.slopes {
            let read = slopes.iter().flat_map(|&slope| self.moving(slope));
            let read: BTreeSet<Symbol> = read.collect();
            let read: Vec<Symbol> = read.into_iter().collect();
            let entries = slopes
                .iter()
                .flat_map(|&slope| read.iter().map(move |&s| (slope, s)));
            let entries: Vec<(Expr, Symbol)> = entries.collect();
            let entries = entries
                .into_iter()
                .map(|(slope, s)| self.arena.diff(slope, s));
            let entries = entries.collect();
            let Intervals {
                middle,
                radii,
                conditions,
            } = self.intervals(entries)?;
            let mut of_site = [Vec::new(), Vec::new()];
            for component in 0..slopes.len() {
                let here = component * read.len()..(component + 1) * read.len();
                let rows = middle[here.clone()].iter().zip(&radii[here]);
                let mut sums = [Vec::new(), Vec::new()];
                for (&symbol, (&middle, &radius)) in read.iter().zip(rows) {
                    let middle = self.arena.abs(middle);
                    let magnitude = self.arena.add(middle, radius);
                    let magnitude = self.times_slope(magnitude, symbol);
                    let is_momentum = self.momenta.contains(&symbol);
                    sums[usize::from(is_momentum)].push((1.0, magnitude));
                }
                for (of_site, sum) in of_site.iter_mut().zip(sums) {
                    of_site.push(self.arena.sum(0.0, &sum));
                }
            }
            bounds.push(of_site.concat());
            term.conditions.push(conditions);
        }
        term.gradient.clone_from(&bounds);
        term.impulses = bounds;
        Some(())
    }
}

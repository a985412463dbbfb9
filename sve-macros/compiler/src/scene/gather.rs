//! The impulse of a node as a function of what the node reads: its own row, the rows of other
//! nodes, columns of fields, and increments.

use std::collections::HashMap;

use super::share::share;
use super::{Derived, Pair};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Meaning;

/// The values that a node reads.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Read {
    /// A component of the node itself.
    Own(usize),
    /// A component of the row in a stream.
    Row(usize, usize),
    Column(usize),
    Increment(usize),
}

/// The impulse of a node.
#[derive(Clone, Default)]
pub(crate) struct Gather {
    /// The symbols in the impulse.
    pub(crate) reads: Vec<(Symbol, Read)>,
    /// Each component.
    pub(crate) impulse: Vec<Expr>,
    /// Expressions that must be positive: the impulse is NaN elsewhere.
    pub(crate) conditions: Vec<Expr>,
    /// Numbers of streams: of rows, columns and increments.
    pub(crate) counts: [usize; 3],
}

impl Derived {
    /// Derives the impulses of nodes.
    pub(super) fn gather(&mut self, arena: &mut Arena) {
        let pairs = self.pairs(arena).into_iter();
        self.pairs = pairs.map(|pair| (pair, Gather::default())).collect();
        self.common = (self.pairs.iter())
            .filter(|(pair, _)| pair.is_common)
            .count();
        self.gather_pairs(arena);
    }

    /// Derives the impulses of nodes from the impulses of the terms.
    pub(super) fn gather_pairs(&mut self, arena: &mut Arena) {
        let mut pairs = std::mem::take(&mut self.pairs);
        let common: Vec<&Pair> = pairs[..self.common].iter().map(|p| &p.0).collect();
        self.node = self.impulse_of(&common, arena);
        for (pair, gather) in &mut pairs {
            *gather = self.impulse_of(&[pair], arena);
        }
        self.pairs = pairs;
    }

    /// Returns the impulse of a node to which each of `pairs` contributes once.
    fn impulse_of(&mut self, pairs: &[&Pair], arena: &mut Arena) -> Gather {
        let size = self.scene.row.len();
        let mut gather = Gather::default();
        let own: Vec<Expr> = (0..size)
            .map(|component| self.read(Read::Own(component), &mut gather, arena))
            .collect();
        // of the Lagrangian, and of the noises
        let mut sums = vec![[Vec::new(), Vec::new()]; size];
        for pair in pairs {
            let mut by: HashMap<Symbol, Expr> = HashMap::new();
            for (symbol, component) in self.row_of(pair, pair.site) {
                by.insert(symbol, own[component]);
            }
            for &site in &pair.rows {
                for (symbol, component) in self.row_of(pair, site) {
                    let read = Read::Row(gather.counts[0], component);
                    by.insert(symbol, self.read(read, &mut gather, arena));
                }
                gather.counts[0] += 1;
            }
            for &column in &pair.columns {
                let symbol = self.terms[pair.term].columns[column];
                let read = Read::Column(gather.counts[1]);
                by.insert(symbol, self.read(read, &mut gather, arena));
                gather.counts[1] += 1;
            }
            let increment = self.terms[pair.term].increment;
            if let Some(each) = increment.filter(|_| pair.reads_increment) {
                let read = Read::Increment(gather.counts[2]);
                by.insert(
                    self.each[each].increment,
                    self.read(read, &mut gather, arena),
                );
                gather.counts[2] += 1;
            }
            let term = &self.terms[pair.term];
            let mut slopes = arena.substitute_all(&term.gradient[pair.site], &by);
            share(slopes.iter_mut().collect(), arena);
            if let Some(conditions) = term.conditions.get(pair.site) {
                let conditions = arena.substitute_all(conditions, &by);
                gather.conditions.extend(conditions);
            }
            for (sums, slope) in sums.iter_mut().zip(slopes) {
                // terms stay apart: `(a - b) + (a - c)` has smaller rounding errors than
                // `2 a - b - c`
                sums[usize::from(term.is_noise)].push((1.0, arena.opaque(slope)));
            }
        }
        let step = arena.symbol(self.step);
        for [lagrangian, noises] in sums {
            let lagrangian = arena.sum(0.0, &lagrangian);
            let noises = arena.sum(0.0, &noises);
            let impulse = arena.mul(step, lagrangian);
            gather.impulse.push(arena.add(impulse, noises));
        }
        gather
    }

    /// Returns the symbols of a site of a pair, with their components.
    fn row_of(&self, pair: &Pair, site: usize) -> Vec<(Symbol, usize)> {
        let site = self.terms[pair.term].sites[site];
        self.scene.row_of(site).collect()
    }

    /// Declares what a node reads.
    fn read(&mut self, read: Read, gather: &mut Gather, arena: &mut Arena) -> Expr {
        let number = self.scene.symbols.meanings().len();
        let symbol = self.scene.symbols.declare(Meaning::Read(number));
        gather.reads.push((symbol, read));
        arena.symbol(symbol)
    }
}

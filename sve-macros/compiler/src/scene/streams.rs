//! The loops whose instances can be made ahead and executed by consecutive nodes.

use super::{Derived, Term};
use crate::algebra::Arena;
use crate::model::scene::{Array, Comparison, Condition, Counter, Head, Int, IntNode, Scene, Step};

/// A term with one of its sites, whose impulse the term adds to.
#[derive(Clone)]
pub(crate) struct Pair {
    pub(crate) term: usize,
    pub(crate) site: usize,
    /// The other sites, the columns and the increment that the derivative reads.
    pub(crate) rows: Vec<usize>,
    pub(crate) columns: Vec<usize>,
    pub(crate) reads_increment: bool,
    /// True for a term that most nodes have.
    pub(crate) is_common: bool,
}

impl Derived {
    /// Determines which loops are streams.
    pub(super) fn mark_streams(&mut self, arena: &Arena) {
        let is_stream = |root: usize| {
            let mut terms = self.terms.iter().filter(|term| term.root == root);
            terms.all(|term| self.scene.is_stream(term) && !self.scene.reads_computed(term, arena))
        };
        let are_streams: Vec<bool> = (0..self.roots.len()).map(is_stream).collect();
        for (root, is_stream) in self.roots.iter_mut().zip(are_streams) {
            root.is_stream = is_stream;
        }
    }

    /// Returns the pairs of the streams, those of common terms first.
    pub(super) fn pairs(&self, arena: &Arena) -> Vec<Pair> {
        let mut pairs = Vec::new();
        for (at, term) in self.terms.iter().enumerate() {
            if !self.roots[term.root].is_stream {
                continue;
            }
            for site in term.receivers(arena) {
                let slopes = &term.gradient[site];
                let reads = |symbol| slopes.iter().any(|&slope| arena.contains(slope, symbol));
                let rows = (0..term.sites.len()).filter(|&other| {
                    let mut slots = self.scene.row_of(term.sites[other]);
                    other != site && slots.any(|(symbol, _)| reads(symbol))
                });
                let columns = (0..term.columns.len()).filter(|&c| reads(term.columns[c]));
                let increment = term.increment.map(|each| self.each[each].increment);
                pairs.push(Pair {
                    term: at,
                    site,
                    rows: rows.collect(),
                    columns: columns.collect(),
                    reads_increment: increment.is_some_and(reads),
                    is_common: self.scene.is_common(term),
                });
            }
        }
        pairs.sort_by_key(|pair| !pair.is_common);
        pairs
    }
}

impl Scene {
    /// Returns whether the loops around a term are a stream: the bounds are those of no other
    /// counter, the sites move with the innermost loop, and no condition reads the configuration.
    /// Sites from a list are known when the program runs: the list may have runs.
    fn is_stream(&self, term: &Term) -> bool {
        let loops: Vec<_> = self.loops(term).collect();
        let mut heads = self.heads(term.sum);
        let has_cut_off = heads.any(|head| !head.numbers().is_empty());
        let is_free =
            |bound: &Int| !self.reads(*bound, &|node| matches!(node, IntNode::Counter(_)));
        let moves = |site: &Int| {
            let innermost = loops.first();
            innermost.is_none_or(|(counter, _)| self.has_counter(*site, *counter))
        };
        !has_cut_off
            && loops.iter().all(|(_, bounds)| bounds.iter().all(is_free))
            && term.sites.iter().all(moves)
    }

    /// Returns whether the derivatives of a term read a number that is computed from others.
    fn reads_computed(&self, term: &Term, arena: &Arena) -> bool {
        let numbers = term.gradient.iter().flatten();
        let mut symbols = numbers.flat_map(|&number| arena.symbols_of(number));
        symbols.any(|symbol| {
            self.slot(symbol)
                .is_some_and(|slot| slot.array.is_computed())
        })
    }

    /// Returns whether most nodes have a term: it is in a loop, under no equation.
    fn is_common(&self, term: &Term) -> bool {
        let is_equation =
            |head: &Head| matches!(head, Head::If(Condition::Integers(Comparison::Equal, ..)));
        self.loops(term).next().is_some() && !self.heads(term.sum).any(is_equation)
    }

    /// Returns the loops around a term with their bounds, the innermost first. A loop of constant
    /// bounds stands for what is outside of loops.
    fn loops(&self, term: &Term) -> impl Iterator<Item = (Counter, [Int; 2])> + '_ {
        let is_constant = |bound: Int| self.integers.value(bound).is_some();
        self.heads(term.sum).filter_map(move |head| match *head {
            Head::For { counter, from, to } if !is_constant(from) || !is_constant(to) => {
                Some((counter, [from, to]))
            }
            _ => None,
        })
    }

    /// Returns whether an integer depends on a counter.
    pub(crate) fn has_counter(&self, int: Int, counter: Counter) -> bool {
        self.reads(int, &|node| *node == IntNode::Counter(counter))
    }

    /// Returns whether a node of an integer satisfies a condition.
    pub(crate) fn reads(&self, int: Int, is_wanted: &impl Fn(&IntNode) -> bool) -> bool {
        let mut open = vec![int];
        while let Some(int) = open.pop() {
            let node = self.integers.node(int);
            if is_wanted(node) {
                return true;
            }
            match node {
                IntNode::Constant(_) | IntNode::Counter(_) | IntNode::Length(Array::Sites) => {}
                IntNode::Length(Array::Field(access)) | IntNode::Field(access) => {
                    open.extend(access.steps.iter().flat_map(indices));
                }
                IntNode::Add(a, b)
                | IntNode::Sub(a, b)
                | IntNode::Mul(a, b)
                | IntNode::Div(a, b)
                | IntNode::Rem(a, b)
                | IntNode::Min(a, b)
                | IntNode::Max(a, b) => open.extend([*a, *b]),
            }
        }
        false
    }
}

/// Returns the integers in a step of a path.
pub(crate) fn indices(step: &Step) -> Vec<Int> {
    match step {
        Step::Member(_) => Vec::new(),
        Step::Index(index) => vec![*index],
        Step::Pair(row, column) => vec![*row, *column],
    }
}

//! Pieces of segments: consecutive nodes, or copied ones, with contributions from the same pairs.

use core::ops::Range;

/// The base of a stream that a piece does not have.
pub(super) const NONE: u32 = u32::MAX;

/// Consecutive nodes with contributions from the same pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    pub(super) start: u32,
    pub(super) length: u32,
    /// All nodes that the piece reads are below this one.
    pub(super) ready: u32,
    /// True if all pairs of `Scene::node` contribute.
    pub(super) is_full: bool,
    /// True if pairs contribute that are not in `Scene::node`, or if that function is not called.
    pub(super) has_others: bool,
    /// The number of the batch, for nodes that are copied.
    pub(super) batch: Option<u32>,
}

/// Nodes that are copied to consecutive places, with what their impulses read.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pub(super) nodes: Vec<u32>,
    /// For each stream of rows that is there, its place, and the row of each node.
    pub(super) rows: Vec<(usize, Vec<u32>)>,
    /// For each stream of increments that is there, its place, and the increment of each node.
    pub(super) increments: Vec<(usize, Vec<u32>)>,
}

impl Piece {
    #[inline(always)]
    pub(super) fn nodes(&self) -> Range<usize> {
        self.start as usize..(self.start + self.length) as usize
    }

    #[inline(always)]
    pub(super) fn ready(&self) -> usize {
        self.ready as usize
    }
}

/// The places of the streams of a pair among all streams of one kind.
#[derive(Clone, Debug)]
pub(super) struct PairStreams {
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
    pub(super) increments: Range<usize>,
}

/// The bases of the streams of a piece.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bases<'a> {
    /// One for each pair.
    pub(super) pairs: &'a [u32],
    pub(super) rows: &'a [u32],
    pub(super) columns: &'a [u32],
    pub(super) increments: &'a [u32],
}

impl Bases<'_> {
    /// Returns whether a pair contributes to the piece.
    #[inline(always)]
    pub(super) fn has(&self, pair: usize) -> bool {
        self.pairs[pair] != NONE
    }
}

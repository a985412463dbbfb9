//! The runs of all loops, seen from the nodes that they contribute to.
//!
//! Within a segment each node gets contributions from the same pairs, and the other indices of each
//! pair advance with the node. Segments are cut into pieces that stay in the first cache. A step
//! moves the nodes in order and visits a piece as soon as all that it reads has moved; pieces are
//! sorted once by the nodes that they wait for.

use core::ops::Range;

use super::indices::{Run, Runs};
use super::{IndexError, Instances, Scene, Stop};

/// Nodes of a piece, at most, and of a tile of a drift: the arrays of a tile stay in the first
/// cache.
pub(super) const TILE: usize = 512;

/// The base of a stream that a piece does not have.
const NONE: u32 = u32::MAX;

/// Consecutive nodes with contributions from the same pairs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    start: u32,
    length: u32,
    /// All nodes that the piece reads are below this one.
    ready: u32,
    /// True if all pairs of `Scene::node` contribute.
    pub(super) is_full: bool,
    /// True if pairs contribute that are not in `Scene::node`, or if that function is not called.
    pub(super) has_others: bool,
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
    pairs: &'a [u32],
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

/// What is known about the loops of a scene for a number of sites.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    /// In the order in which a sweep visits them.
    pub(super) pieces: Vec<Piece>,
    /// For each piece the bases of its pairs, rows, columns and increments.
    bases: Vec<u32>,
    /// For each pair.
    pub(super) streams: Vec<PairStreams>,
    /// The columns of all terms.
    pub(super) columns: Vec<f64>,
    /// The loops that are made as they are written.
    pub(super) nests: Vec<usize>,
    /// Number of instances of the other loops.
    pub(super) instances: usize,
    /// Number of segments, before they are cut into pieces.
    pub(super) count: usize,
}

impl Segments {
    /// Executes the indices of a scene of `n` sites.
    pub(super) fn new<S: Scene>(scene: &S, n: usize) -> Result<Self, IndexError> {
        // bases of all streams are numbers of 32 bits
        let columns: usize = S::TERMS.iter().map(|term| term.columns).sum();
        let is_addressed = n < (u32::MAX / 8) as usize / (columns + 1);
        let mut instances = Instances::new(n, S::TERMS);
        let mut nests = Vec::new();
        for (number, root) in S::LOOPS.iter().enumerate() {
            let visited = if root.is_stream && is_addressed {
                scene.instances(number, n, &mut instances)
            } else {
                Err(Stop::AsWritten)
            };
            match visited {
                Ok(()) if instances.are_long(number) && is_gathered::<S>(number, &instances) => {}
                Err(Stop::Index(error)) => return Err(error),
                Ok(()) | Err(Stop::AsWritten) => {
                    instances.forget(number);
                    nests.push(number);
                }
            }
        }
        Ok(Self::of_runs::<S>(&instances.runs, nests))
    }

    fn of_runs<S: Scene>(runs: &[Runs], nests: Vec<usize>) -> Self {
        let mut columns = Vec::new();
        let columns_at: Vec<u32> = (runs.iter().flat_map(|runs| &runs.columns))
            .map(|column| {
                columns.extend_from_slice(column);
                (columns.len() - column.len()) as u32
            })
            .collect();
        let of_pairs: Vec<Vec<Run>> = (S::PAIRS.iter())
            .map(|pair| runs[pair.term].by_index(pair.slot))
            .collect();
        let mut cuts: Vec<u32> = (of_pairs.iter().flatten())
            .flat_map(|run| [run.start, run.end()])
            .collect();
        cuts.sort_unstable();
        cuts.dedup();

        let streams = streams::<S>();
        let width = width(&streams);
        let mut next = vec![0; S::PAIRS.len()];
        let (mut found, mut bases) = (Vec::new(), Vec::new());
        let mut segments = 0;
        for cut in cuts.windows(2) {
            let [start, end] = [cut[0], cut[1]];
            let here: Vec<Option<&Run>> = (of_pairs.iter().zip(&mut next))
                .map(|(list, next)| {
                    *next += list[*next..].partition_point(|run| run.end() <= start);
                    list.get(*next).filter(|run| run.start <= start)
                })
                .collect();
            if here.iter().all(Option::is_none) {
                continue;
            }
            segments += 1;
            let (of_node, others) = here.split_at(S::NODE_PAIRS);
            let is_full = !of_node.is_empty() && of_node.iter().all(Option::is_some);
            let has_others = !is_full || others.iter().any(Option::is_some);
            let mut from = start;
            while from < end {
                // cut at multiples of the tile
                let to = end.min((from / TILE as u32 + 1) * TILE as u32);
                let at = bases.len();
                push_bases::<S>(&mut bases, runs, &here, &columns_at, from);
                let rows =
                    &bases[at + S::PAIRS.len()..][..streams.last().map_or(0, |s| s.rows.end)];
                let read = rows.iter().filter(|&&base| base != NONE);
                let piece = Piece {
                    start: from,
                    length: to - from,
                    ready: read.fold(to, |ready, base| ready.max(base + (to - from))),
                    is_full,
                    has_others,
                };
                found.push((piece, at));
                from = to;
            }
        }
        found.sort_by_key(|(piece, _)| piece.ready.div_ceil(TILE as u32));
        Self {
            bases: (found.iter())
                .flat_map(|&(_, at)| &bases[at..at + width])
                .copied()
                .collect(),
            pieces: found.into_iter().map(|(piece, _)| piece).collect(),
            streams,
            columns,
            nests,
            instances: runs.iter().map(Runs::instances).sum(),
            count: segments,
        }
    }

    /// Returns the size of the tables.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.pieces) + size_of_val(&*self.bases) + size_of_val(&*self.columns)
    }

    /// Returns the pieces with the bases of their streams.
    #[inline(always)]
    pub(super) fn pieces(&self) -> impl Iterator<Item = (&Piece, Bases<'_>)> {
        let of_pairs = self.streams.len();
        let last = self.streams.last();
        let rows = last.map_or(0, |streams| streams.rows.end);
        let columns = last.map_or(0, |streams| streams.columns.end);
        let bases = self.bases.chunks_exact(width(&self.streams).max(1));
        self.pieces.iter().zip(bases.map(move |bases| {
            let (pairs, bases) = bases.split_at(of_pairs);
            let (rows, bases) = bases.split_at(rows);
            let (columns, increments) = bases.split_at(columns);
            Bases {
                pairs,
                rows,
                columns,
                increments,
            }
        }))
    }
}

/// Returns whether each pair of a loop contributes to a node at most once, so that the loop is a
/// function of the node.
fn is_gathered<S: Scene>(number: usize, instances: &Instances) -> bool {
    let mut pairs = (S::PAIRS.iter()).filter(|pair| S::TERMS[pair.term].in_loop == number);
    pairs.all(|pair| {
        let runs = instances.runs[pair.term].by_index(pair.slot);
        runs.windows(2).all(|two| two[0].end() <= two[1].start)
    })
}

/// Returns the places of the streams of each pair.
fn streams<S: Scene>() -> Vec<PairStreams> {
    let (mut rows, mut columns, mut increments) = (0, 0, 0);
    let range = |end: &mut usize, length: usize| {
        *end += length;
        *end - length..*end
    };
    (S::PAIRS.iter())
        .map(|pair| PairStreams {
            rows: range(&mut rows, pair.rows.len()),
            columns: range(&mut columns, pair.columns.len()),
            increments: range(&mut increments, usize::from(pair.reads_increment)),
        })
        .collect()
}

/// Returns the number of bases of a piece.
fn width(streams: &[PairStreams]) -> usize {
    let last = streams.last();
    let ends = last.map_or(0, |last| {
        last.rows.end + last.columns.end + last.increments.end
    });
    streams.len() + ends
}

/// Adds the bases of a piece that begins at a node: of pairs, rows, columns and increments.
fn push_bases<S: Scene>(
    bases: &mut Vec<u32>,
    runs: &[Runs],
    here: &[Option<&Run>],
    columns_at: &[u32],
    node: u32,
) {
    let base = |pair: usize, of: &dyn Fn(&Run) -> u32| {
        here[pair].map_or(NONE, |run| of(run) + (node - run.start))
    };
    let pairs = || S::PAIRS.iter().enumerate();
    bases.extend(pairs().map(|(number, _)| base(number, &|run| run.instance)));
    for (number, pair) in pairs() {
        for &slot in pair.rows {
            bases.push(base(number, &|run| runs[pair.term].first(run.number, slot)));
        }
    }
    for (number, pair) in pairs() {
        let before = S::TERMS[..pair.term].iter().map(|term| term.columns);
        let before: usize = before.sum();
        for &column in pair.columns {
            let at = columns_at[before + column];
            bases.push(base(number, &|run| at + run.instance));
        }
    }
    for (number, pair) in pairs().filter(|(_, pair)| pair.reads_increment) {
        let last = S::TERMS[pair.term].slots.len();
        bases.push(base(number, &|run| runs[pair.term].first(run.number, last)));
    }
}

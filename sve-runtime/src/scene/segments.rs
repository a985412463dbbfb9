//! The runs of all loops, seen from the nodes that they contribute to.
//!
//! Within a segment each node gets contributions from the same pairs, and the other indices of each
//! pair advance with the node. Segments are cut into pieces that stay in the first cache. A step
//! moves the nodes in order and visits a piece as soon as all that it reads has moved; pieces are
//! sorted once by the nodes that they wait for.

use core::ops::Range;

use super::indices::{Run, Runs};
use super::pieces::{Bases, Batch, NONE, PairStreams, Piece};
use super::{IndexError, Instances, Pair, Scene, Stop, Term};

/// Nodes of a piece, at most, and of a tile of a drift: the arrays of a tile stay in the first
/// cache.
pub(super) const TILE: usize = 1024;

/// Nodes of a segment from which it is a piece of its own. Nodes of shorter ones, such as the
/// borders of a lattice, are copied to consecutive places, many with contributions of the same
/// pairs.
const SHORT: u32 = 8;

/// Nodes that are copied together, at most and at least.
pub(super) const BATCH: usize = 64;
const FEW: usize = 4;

/// Nodes that a drift passes before the copied ones among them get their impulses: they are then
/// many, and still in the second cache.
const WINDOW: usize = 8 * TILE;

/// A node of a short segment.
struct Single {
    node: u32,
    ready: u32,
    bases: Vec<u32>,
}

/// The facts about the loops of a scene for a number of sites.
#[derive(Clone, Debug)]
pub(super) struct Segments {
    /// In the order in which a sweep visits them.
    pub(super) pieces: Vec<Piece>,
    /// For each piece the bases of its pairs, rows, columns and increments.
    bases: Vec<u32>,
    pub(super) batches: Vec<Batch>,
    /// For each pair.
    pub(super) streams: Vec<PairStreams>,
    /// The numbers of rows, columns and increments that all pairs read.
    pub(super) counts: [usize; 3],
    /// The columns of all terms.
    pub(super) columns: Vec<f64>,
    /// The loops that are made as they are written.
    pub(super) nests: Vec<usize>,
    /// Nodes without contributions of the other loops.
    pub(super) free: Vec<Range<usize>>,
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
        let terms = TermsOf::of::<S>();
        let mut nests = Vec::new();
        for (number, root) in S::LOOPS.iter().enumerate() {
            let visited = if root.is_stream && is_addressed {
                scene.instances(number, n, &mut instances)
            } else {
                Err(Stop::AsWritten)
            };
            match visited {
                Ok(()) if instances.are_long(number) && terms.is_gathered(number, &instances) => {}
                Err(Stop::Index(error)) => return Err(error),
                Ok(()) | Err(Stop::AsWritten) => {
                    instances.forget(number);
                    nests.push(number);
                }
            }
        }
        Ok(Self::of_runs(terms, n, &instances.runs, nests))
    }

    fn of_runs(terms: TermsOf, n: usize, runs: &[Runs], nests: Vec<usize>) -> Self {
        let mut columns = Vec::new();
        let columns_at: Vec<u32> = (runs.iter().flat_map(|runs| &runs.columns))
            .map(|column| {
                columns.extend_from_slice(column);
                (columns.len() - column.len()) as u32
            })
            .collect();
        let of_pairs: Vec<Vec<Run>> = (terms.pairs.iter())
            .map(|pair| runs[pair.term].by_index(pair.slot))
            .collect();
        let mut cuts: Vec<u32> = (of_pairs.iter().flatten())
            .flat_map(|run| [run.start, run.end()])
            .chain([0, n as u32])
            .collect();
        cuts.sort_unstable();
        cuts.dedup();

        let mut all = Self {
            pieces: Vec::new(),
            bases: Vec::new(),
            batches: Vec::new(),
            streams: terms.streams(),
            counts: counts(terms.pairs),
            columns,
            nests,
            free: Vec::new(),
            instances: runs.iter().map(Runs::instances).sum(),
            count: 0,
        };
        let mut next = vec![0; terms.pairs.len()];
        let mut singles = Vec::new();
        for cut in cuts.windows(2) {
            let [start, end] = [cut[0], cut[1]];
            let here: Vec<Option<&Run>> = (of_pairs.iter().zip(&mut next))
                .map(|(list, next)| {
                    *next += list[*next..].partition_point(|run| run.end() <= start);
                    list.get(*next).filter(|run| run.start <= start)
                })
                .collect();
            if here.iter().all(Option::is_none) {
                all.free.push(start as usize..end as usize);
                continue;
            }
            all.count += 1;
            let length = if end - start < SHORT { 1 } else { TILE as u32 };
            let mut node = start;
            while node < end {
                let to = end.min(node + length);
                let bases = terms.bases(runs, &here, &columns_at, node);
                let read = bases[all.places()[0].clone()]
                    .iter()
                    .filter(|&&base| base != NONE);
                let ready = read.fold(to, |ready, base| ready.max(base + (to - node)));
                if length == 1 {
                    singles.push(Single { node, ready, bases });
                } else {
                    all.push(terms, [node, to - node, ready], &bases, None);
                }
                node = to;
            }
        }
        all.push_batches(terms, singles);
        all.sort();
        all
    }

    /// Returns the places of rows, columns and increments among the bases of a piece.
    fn places(&self) -> [Range<usize>; 3] {
        let mut end = self.streams.len();
        self.counts.map(|length| {
            end += length;
            end - length..end
        })
    }

    fn push(
        &mut self,
        terms: TermsOf,
        [start, length, ready]: [u32; 3],
        bases: &[u32],
        batch: Option<u32>,
    ) {
        let (of_node, others) = bases[..self.streams.len()].split_at(terms.node_pairs);
        let is_full = !of_node.is_empty() && !of_node.contains(&NONE);
        self.pieces.push(Piece {
            start,
            length,
            ready,
            is_full,
            has_others: !is_full || others.iter().any(|&base| base != NONE),
            batch,
        });
        self.bases.extend(bases);
    }

    /// Adds the nodes of short segments.
    fn push_batches(&mut self, terms: TermsOf, mut singles: Vec<Single>) {
        let pairs = self.streams.len();
        let [rows, columns, increments] = self.places();
        let key = |single: &Single| {
            let has = |base: &u32| *base != NONE;
            let pairs: Vec<bool> = single.bases[..pairs].iter().map(has).collect();
            (single.ready.div_ceil(WINDOW as u32), pairs)
        };
        singles.sort_by_cached_key(key);
        for group in singles.chunk_by(|a, b| key(a) == key(b)) {
            if group.len() < FEW {
                for Single { node, ready, bases } in group {
                    self.push(terms, [*node, 1, *ready], bases, None);
                }
                continue;
            }
            for nodes in group.chunks(BATCH) {
                let of = |place: usize| nodes.iter().map(move |single| single.bases[place]);
                let listed = |places: &Range<usize>| {
                    let there = places
                        .clone()
                        .filter(|&place| nodes[0].bases[place] != NONE);
                    let lists = there.map(|place| (place - places.start, of(place).collect()));
                    lists.collect::<Vec<(usize, Vec<u32>)>>()
                };
                let batch = Batch {
                    nodes: nodes.iter().map(|single| single.node).collect(),
                    rows: listed(&rows),
                    increments: listed(&increments),
                };
                let mut bases = nodes[0].bases.clone();
                for (at, _) in &batch.rows {
                    bases[rows.start + at] = (BATCH * (1 + at)) as u32;
                }
                for (at, _) in &batch.increments {
                    bases[increments.start + at] = (BATCH * at) as u32;
                }
                for place in columns
                    .clone()
                    .filter(|&place| nodes[0].bases[place] != NONE)
                {
                    bases[place] = self.columns.len() as u32;
                    for base in of(place) {
                        self.columns.push(self.columns[base as usize]);
                    }
                }
                let ready = nodes
                    .iter()
                    .fold(0, |ready, single| ready.max(single.ready));
                let number = self.batches.len() as u32;
                self.push(terms, [0, nodes.len() as u32, ready], &bases, Some(number));
                self.batches.push(batch);
            }
        }
    }

    /// Sorts the pieces by the tile after which they are ready.
    fn sort(&mut self) {
        let width = self.places()[2].end;
        let mut order: Vec<usize> = (0..self.pieces.len()).collect();
        order.sort_by_key(|&at| self.pieces[at].ready.div_ceil(TILE as u32));
        let bases = order
            .iter()
            .flat_map(|&at| &self.bases[at * width..][..width]);
        self.bases = bases.copied().collect();
        self.pieces = order.iter().map(|&at| self.pieces[at]).collect();
    }

    /// Returns the size of the tables.
    pub(super) fn bytes(&self) -> usize {
        let of_batch = |batch: &Batch| {
            (1 + batch.rows.len() + batch.increments.len()) * size_of_val(&*batch.nodes)
        };
        let batches: usize = self.batches.iter().map(of_batch).sum();
        let columns = size_of_val(&*self.columns);
        size_of_val(&*self.pieces) + size_of_val(&*self.bases) + batches + columns
    }

    /// Returns the pieces with the bases of their streams.
    #[inline(always)]
    pub(super) fn pieces<S: Scene>(&self) -> impl Iterator<Item = (&Piece, Bases<'_>)> {
        let bases = self.bases.chunks_exact(const { width(S::PAIRS) });
        self.pieces.iter().zip(bases).map(
            #[inline(always)]
            |(piece, bases)| {
                let [rows, columns, _] = const { counts(S::PAIRS) };
                let (pairs, bases) = bases.split_at(S::PAIRS.len());
                let (rows, bases) = bases.split_at(rows);
                let (columns, increments) = bases.split_at(columns);
                let bases = Bases {
                    pairs,
                    rows,
                    columns,
                    increments,
                };
                (piece, bases)
            },
        )
    }
}

/// Returns the numbers of rows, columns and increments that all pairs read.
const fn counts(pairs: &[Pair]) -> [usize; 3] {
    let (mut counts, mut at) = ([0; 3], 0);
    while at < pairs.len() {
        counts[0] += pairs[at].rows.len();
        counts[1] += pairs[at].columns.len();
        counts[2] += pairs[at].reads_increment as usize;
        at += 1;
    }
    counts
}

/// Returns the number of bases of a piece; 1 without pairs, where there are no pieces.
const fn width(pairs: &[Pair]) -> usize {
    let [rows, columns, increments] = counts(pairs);
    let width = pairs.len() + rows + columns + increments;
    if width == 0 { 1 } else { width }
}

/// The terms of a scene and what they read. The tables are made of these data, not for each type of
/// scene anew.
#[derive(Clone, Copy)]
struct TermsOf {
    terms: &'static [Term],
    pairs: &'static [Pair],
    node_pairs: usize,
}

impl TermsOf {
    const fn of<S: Scene>() -> Self {
        Self {
            terms: S::TERMS,
            pairs: S::PAIRS,
            node_pairs: S::NODE_PAIRS,
        }
    }

    /// Returns whether each pair of a loop contributes to a node at most once, so that the loop is
    /// a function of the node.
    fn is_gathered(self, number: usize, instances: &Instances) -> bool {
        let mut pairs = (self.pairs.iter()).filter(|pair| self.terms[pair.term].in_loop == number);
        pairs.all(|pair| {
            let runs = instances.runs[pair.term].by_index(pair.slot);
            runs.windows(2).all(|two| two[0].end() <= two[1].start)
        })
    }

    /// Returns the places of the streams of each pair.
    fn streams(self) -> Vec<PairStreams> {
        let (mut rows, mut columns, mut increments) = (0, 0, 0);
        let range = |end: &mut usize, length: usize| {
            *end += length;
            *end - length..*end
        };
        (self.pairs.iter())
            .map(|pair| PairStreams {
                rows: range(&mut rows, pair.rows.len()),
                columns: range(&mut columns, pair.columns.len()),
                increments: range(&mut increments, usize::from(pair.reads_increment)),
            })
            .collect()
    }

    /// Returns the bases of a piece that begins at a node: of pairs, rows, columns and increments.
    fn bases(
        self,
        runs: &[Runs],
        here: &[Option<&Run>],
        columns_at: &[u32],
        node: u32,
    ) -> Vec<u32> {
        let mut bases = Vec::new();
        let base = |pair: usize, of: &dyn Fn(&Run) -> u32| {
            here[pair].map_or(NONE, |run| of(run) + (node - run.start))
        };
        let pairs = || self.pairs.iter().enumerate();
        bases.extend(pairs().map(|(number, _)| base(number, &|run| run.instance)));
        for (number, pair) in pairs() {
            for &slot in pair.rows {
                bases.push(base(number, &|run| runs[pair.term].first(run.number, slot)));
            }
        }
        for (number, pair) in pairs() {
            let before = self.terms[..pair.term].iter().map(|term| term.columns);
            let before: usize = before.sum();
            for &column in pair.columns {
                let at = columns_at[before + column];
                bases.push(base(number, &|run| at + run.instance));
            }
        }
        for (number, pair) in pairs().filter(|(_, pair)| pair.reads_increment) {
            let last = self.terms[pair.term].slots.len();
            bases.push(base(number, &|run| runs[pair.term].first(run.number, last)));
        }
        bases
    }
}

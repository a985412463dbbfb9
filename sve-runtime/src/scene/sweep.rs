//! A sweep: nodes move, and the impulses of all loops at their new places are added to the momenta.
//!
//! Both are done in place, tile by tile. The drift leads by what a piece of nodes reads, so that
//! the momenta of a tile are still in the first cache when its impulses are added.

use core::marker::PhantomData;

use super::drift::{Drift, are_finite, drift};
use super::pieces::{Bases, Batch, Piece};
use super::segments::{BATCH, Segments, TILE};
use super::streams::Impulse;
use super::{Contributions, IndexError, Reads, Row, Scene, StreamCounts, Streams};
use crate::lanes::dispatch::Kernel;

/// The impulse over the time `h` at the time `t`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kick<'a> {
    pub(super) h: f64,
    pub(super) t: f64,
    pub(super) dw: &'a [f64],
}

/// Arrays that a sweep needs, of the components of rows.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    /// Impulses of the pairs of one piece: zeros between pieces.
    pub(super) of_piece: Vec<f64>,
    /// The rows of copied nodes, of `BATCH` nodes each, and of what their impulses read.
    pub(super) of_batch: Vec<f64>,
    /// The increments that the impulses of copied nodes read.
    pub(super) dw: Vec<f64>,
    /// Impulses of all loops, if one of them is made as it is written: zeros between sweeps.
    pub(super) of_nests: Vec<f64>,
}

impl Buffers {
    pub(super) fn new<R: Row>(segments: &Segments, n: usize) -> Self {
        let of_nests = if segments.nests.is_empty() { 0 } else { n };
        Self {
            of_piece: vec![0.0; TILE * R::LENGTH],
            of_nests: vec![0.0; of_nests * R::LENGTH],
            of_batch: vec![0.0; BATCH * (1 + segments.rows().len()) * R::LENGTH],
            dw: vec![0.0; BATCH * segments.increments().len()],
        }
    }

    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        self.of_piece.len() + self.of_nests.len() + self.of_batch.len() + self.dw.len()
    }
}

/// A drift, if there is one, and then the contributions `W` of all loops, added `TWICE` or once to
/// `p`.
pub(super) struct Sweep<'a, S: Contributions<W>, W, const TWICE: bool> {
    pub(super) scene: &'a S,
    pub(super) segments: &'a Segments,
    pub(super) drift: Option<Drift<'a>>,
    pub(super) kick: Kick<'a>,
    pub(super) q: &'a mut [S::Numbers],
    pub(super) p: &'a mut [S::Numbers],
    pub(super) buffers: &'a mut Buffers,
    /// Whether numbers are tested as long as they are in the first cache.
    pub(super) is_tested: bool,
}

impl<S, W, const TWICE: bool> Kernel for Sweep<'_, S, W, TWICE>
where
    S: Scene + Contributions<W>,
{
    /// Whether all numbers are finite, as far as they were tested.
    type Output = Result<bool, IndexError>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            scene,
            segments,
            drift: motion,
            kick,
            q,
            p,
            buffers:
                Buffers {
                    of_piece,
                    of_nests,
                    of_batch,
                    dw: of_increments,
                },
            is_tested,
        } = self;
        let of_piece = NumbersOf::<S, W>::rows_mut(of_piece);
        let of_nests = NumbersOf::<S, W>::rows_mut(of_nests);
        let mut visit = Visit::<S, W>::new(scene, segments, kick, [of_batch, of_increments]);
        let Kick { h, t, dw } = kick;
        let n = q.len();
        let mut is_finite = true;
        let mut moved = 0;
        let has_nests = !segments.nests.is_empty();
        for (piece, bases) in segments.pieces() {
            if let Some(motion) = &motion
                && moved < piece.ready()
            {
                let tiles = moved..piece.ready().next_multiple_of(TILE).min(n);
                moved = tiles.end;
                is_finite &= drift::<NumbersOf<S, W>>(q, p, tiles, motion, is_tested);
            }
            let nodes = piece.nodes();
            if !piece.has_others && piece.batch.is_none() {
                let streams = streams(q, nodes.start, segments, bases, dw);
                let node = &visit.node;
                if has_nests {
                    let to = &mut of_nests[nodes.clone()];
                    CountsOf::<S, W>::add::<false, _>(&streams, to, node);
                } else {
                    CountsOf::<S, W>::add::<TWICE, _>(&streams, &mut p[nodes.clone()], node);
                }
                if is_tested && !has_nests {
                    is_finite &= are_finite(NumbersOf::<S, W>::numbers(&p[nodes]));
                }
                continue;
            }
            // The impulse of a node is added as one number: two kicks in one have the bits of two.
            let sum = &mut of_piece[..nodes.len()];
            let batch = visit.add(q, piece, bases, sum);
            let to = if has_nests { &mut *of_nests } else { &mut *p };
            let is_twice = TWICE && !has_nests;
            if let Some(batch) = batch {
                is_finite &= move_to_nodes(&batch.nodes, to, sum, is_twice, is_tested);
                continue;
            }
            let to = &mut to[nodes];
            if is_twice {
                move_all::<true, _>(to, sum);
            } else {
                move_all::<false, _>(to, sum);
            }
            if is_tested {
                is_finite &= are_finite(NumbersOf::<S, W>::numbers(to));
            }
        }
        if let Some(motion) = &motion {
            is_finite &= drift::<NumbersOf<S, W>>(q, p, moved..n, motion, is_tested);
        }
        if !has_nests {
            return Ok(is_finite);
        }
        for &number in &segments.nests {
            if let Err(error) = Contributions::<W>::nest(scene, number, h, t, dw, q, of_nests) {
                of_nests.fill(NumbersOf::<S, W>::ZERO);
                return Err(error);
            }
        }
        is_finite &= move_to::<TWICE, _>(p, of_nests, is_tested);
        Ok(is_finite)
    }
}

/// A visit of pieces, with what their contributions need.
pub(super) struct Visit<'a, S: Contributions<W>, W> {
    node: Node<'a, S, W>,
    segments: &'a Segments,
    /// The copied nodes of a batch with what they read, and the increments that they read.
    of_batch: &'a mut [S::Numbers],
    of_increments: &'a mut [f64],
}

impl<'a, S: Scene + Contributions<W>, W> Visit<'a, S, W> {
    /// Begins a visit. The arrays are `of_batch` and `dw` of [`Buffers`].
    #[inline(always)]
    pub(super) fn new(
        scene: &'a S,
        segments: &'a Segments,
        kick: Kick<'a>,
        [of_batch, of_increments]: [&'a mut [f64]; 2],
    ) -> Self {
        let what = PhantomData;
        Self {
            node: Node { scene, kick, what },
            segments,
            of_batch: NumbersOf::<S, W>::rows_mut(of_batch),
            of_increments,
        }
    }

    /// Adds the contributions to the nodes of a piece to `sum`. Returns the batch of a piece of
    /// copied nodes.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        q: &[NumbersOf<S, W>],
        piece: &Piece,
        bases: Bases<'_>,
        sum: &mut [NumbersOf<S, W>],
    ) -> Option<&'a Batch> {
        let (segments, Kick { h, t, dw }) = (self.segments, self.node.kick);
        let batch = piece.batch.map(|number| &segments.batches[number as usize]);
        let streams = if let Some(batch) = batch {
            copy(batch, q, self.of_batch, dw, self.of_increments);
            streams(self.of_batch, 0, segments, bases, self.of_increments)
        } else {
            streams(q, piece.nodes().start, segments, bases, dw)
        };
        let mut first = 0;
        if piece.is_full {
            CountsOf::<S, W>::add::<false, _>(&streams, sum, &self.node);
            first = S::NODE_PAIRS;
        }
        for pair in (first..S::PAIRS.len()).filter(|&pair| bases.has(pair)) {
            let streams = streams.of(&segments.streams[pair]);
            let scene = self.node.scene;
            Contributions::<W>::contribution(scene, pair, h, t, dw, &streams, sum);
        }
        batch
    }
}

/// The impulse of a node to which the first pairs contribute.
struct Node<'a, S, W> {
    scene: &'a S,
    kick: Kick<'a>,
    what: PhantomData<W>,
}

impl<S: Contributions<W>, W> Impulse<S::Numbers> for Node<'_, S, W> {
    #[inline(always)]
    fn at(&self, reads: &impl Reads<S::Numbers>) -> S::Numbers {
        let Kick { h, t, dw } = self.kick;
        self.scene.node(h, t, dw, reads)
    }
}

pub(super) type NumbersOf<S, W> = <S as Contributions<W>>::Numbers;
type CountsOf<S, W> = <S as Contributions<W>>::Counts;

/// Copies the nodes of a batch, and what their impulses read, to consecutive places.
#[inline(always)]
fn copy<R: Row>(batch: &Batch, q: &[R], rows: &mut [R], dw: &[f64], increments: &mut [f64]) {
    for (to, &node) in rows.iter_mut().zip(&batch.nodes) {
        *to = q[node as usize];
    }
    for (at, list) in &batch.rows {
        for (to, &node) in rows[BATCH * (1 + at)..].iter_mut().zip(list) {
            *to = q[node as usize];
        }
    }
    for (at, list) in &batch.increments {
        for (to, &number) in increments[BATCH * at..].iter_mut().zip(list) {
            *to = dw[number as usize];
        }
    }
}

#[inline(always)]
fn streams<'a, R>(
    q: &'a [R],
    node: usize,
    segments: &'a Segments,
    bases: Bases<'a>,
    dw: &'a [f64],
) -> Streams<'a, R> {
    Streams {
        q,
        node,
        rows: bases.rows,
        fields: &segments.columns,
        columns: bases.columns,
        dw,
        increments: bases.increments,
    }
}

/// Adds impulses to listed nodes, and leaves zeros. Returns whether the results are finite, if they
/// are tested.
#[inline(always)]
fn move_to_nodes<R: Row>(
    nodes: &[u32],
    to: &mut [R],
    sum: &mut [R],
    is_twice: bool,
    is_tested: bool,
) -> bool {
    let mut is_finite = true;
    for (&node, sum) in nodes.iter().zip(sum) {
        let to = &mut to[node as usize];
        to.add(*sum);
        if is_twice {
            to.add(*sum);
        }
        *sum = R::ZERO;
        is_finite &= !is_tested || are_finite(R::numbers(core::slice::from_ref(to)));
    }
    is_finite
}

/// Adds all impulses to the momenta, and leaves zeros. Returns whether the momenta are finite, if
/// they are tested.
#[inline(always)]
fn move_to<const TWICE: bool, R: Row>(p: &mut [R], sum: &mut [R], is_tested: bool) -> bool {
    let mut is_finite = true;
    for (p, sum) in p.chunks_mut(TILE).zip(sum.chunks_mut(TILE)) {
        move_all::<TWICE, _>(p, sum);
        is_finite &= !is_tested || are_finite(R::numbers(p));
    }
    is_finite
}

/// Adds impulses once or twice, and leaves zeros.
#[inline(always)]
fn move_all<const TWICE: bool, R: Row>(to: &mut [R], sum: &mut [R]) {
    let (to, sum) = (R::numbers_mut(to), R::numbers_mut(sum));
    for (to, sum) in to.iter_mut().zip(sum) {
        *to += *sum;
        if TWICE {
            *to += *sum;
        }
        *sum = 0.0;
    }
}

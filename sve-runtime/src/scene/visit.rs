//! Visits of pieces: the impulses of their nodes, from slices.

use core::marker::PhantomData;

use super::pieces::{Bases, Batch, Piece};
use super::segments::{BATCH, Segments};
use super::streams::{Impulse, Write};
use super::sweep::Kick;
use super::{Contributions, Reads, Row, Scene, StreamCounts, Streams};

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
        Self {
            node: Node::new(scene, [kick; 2]),
            segments,
            of_batch: NumbersOf::<S, W>::rows_mut(of_batch),
            of_increments,
        }
    }

    /// Writes the sums of the contributions to the nodes of a piece. Returns the batch of a piece
    /// of copied nodes.
    #[inline(always)]
    pub(super) fn write(
        &mut self,
        q: &[NumbersOf<S, W>],
        piece: &Piece,
        bases: Bases<'_>,
        sum: &mut [NumbersOf<S, W>],
    ) -> Option<&'a Batch> {
        let (segments, &Node { h, t, dw, .. }) = (self.segments, &self.node);
        let batch = piece.batch.map(|number| &segments.batches[number as usize]);
        let streams = if let Some(batch) = batch {
            copy(batch, q, self.of_batch, dw[0], self.of_increments);
            streams(self.of_batch, 0, segments, bases, [self.of_increments; 2])
        } else {
            streams(q, piece.nodes().start, segments, bases, dw)
        };
        let mut first = 0;
        if piece.is_full {
            CountsOf::<S, W>::put::<Write, _>(&streams, sum, &mut [], &self.node);
            first = S::NODE_PAIRS;
        } else {
            sum.fill(NumbersOf::<S, W>::ZERO);
        }
        for pair in (first..S::PAIRS.len()).filter(|&pair| bases.has(pair)) {
            let streams = streams.of(&segments.streams[pair]);
            let scene = self.node.scene;
            Contributions::<W>::contribution(scene, pair, h, t, dw[0], &streams, sum);
        }
        batch
    }
}

/// The impulses of a node to which the first pairs contribute, by a kick and a second one.
pub(super) struct Node<'a, S, W> {
    scene: &'a S,
    h: f64,
    t: f64,
    pub(super) dw: [&'a [f64]; 2],
    what: PhantomData<W>,
}

impl<'a, S, W> Node<'a, S, W> {
    /// Takes two kicks of one length at one time.
    #[inline(always)]
    pub(super) fn new(scene: &'a S, kicks: [Kick<'a>; 2]) -> Self {
        let [Kick { h, t, .. }, _] = kicks;
        Self {
            scene,
            h,
            t,
            dw: [kicks[0].dw, kicks[1].dw],
            what: PhantomData,
        }
    }
}

impl<S: Contributions<W>, W> Impulse<S::Numbers> for Node<'_, S, W> {
    #[inline(always)]
    fn at(&self, kick: usize, reads: &impl Reads<S::Numbers>) -> S::Numbers {
        self.scene.node(self.h, self.t, self.dw[kick], reads)
    }
}

pub(super) type NumbersOf<S, W> = <S as Contributions<W>>::Numbers;
pub(super) type CountsOf<S, W> = <S as Contributions<W>>::Counts;

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
pub(super) fn streams<'a, R>(
    q: &'a [R],
    node: usize,
    segments: &'a Segments,
    bases: Bases<'a>,
    dw: [&'a [f64]; 2],
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

//! A sweep: nodes move, and the impulses of all loops at their new places are added to the momenta.
//!
//! Both are done in place, tile by tile. The drift leads by what a piece of nodes reads, so that
//! the momenta of a tile are still in the first cache when its impulses are added.

use core::marker::PhantomData;

use super::additions::{first_not_finite, move_all, move_to_nodes};
use super::drift::Drift;
use super::pieces::{Bases, Batch, Piece};
use super::segments::{BATCH, Segments, TILE};
use super::streams::{Add, AddTwice, Impulse, Write};
use super::{Contributions, Impulses, IndexError, Reads, Row, Scene, StreamCounts, Streams};
use crate::lanes::dispatch::Kernel;

/// The impulse over the time `h` at the time `t`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kick<'a> {
    pub(super) h: f64,
    pub(super) t: f64,
    pub(super) dw: &'a [f64],
}

/// A number that is not finite. The tile in which it is has its old values, unless a loop is made
/// as it is written or there is friction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) array: &'static str,
    pub(super) component: usize,
    /// The nodes below this one have moved.
    pub(super) moved: usize,
    /// The pieces before this one have their impulses.
    pub(super) pieces: usize,
}

impl Place {
    #[cold]
    pub(super) fn new(
        (array, component): (&'static str, usize),
        moved: usize,
        pieces: usize,
    ) -> Self {
        Self {
            array,
            component,
            moved,
            pieces,
        }
    }
}

/// Arrays that a sweep needs, of the components of rows.
#[derive(Clone, Debug)]
pub(super) struct Buffers {
    /// Impulses of the pairs of one piece.
    pub(super) of_piece: Vec<f64>,
    /// The rows of copied nodes, of `BATCH` nodes each, and of what their impulses read.
    pub(super) of_batch: Vec<f64>,
    /// The increments that the impulses of copied nodes read.
    pub(super) dw: Vec<f64>,
    /// Impulses of all loops, if one of them is made as it is written: zeros between sweeps.
    pub(super) of_nests: Vec<f64>,
    /// Increments, and totals, of midpoint steps.
    pub(super) with_totals: Vec<f64>,
    /// The momenta of a piece before its impulses, until these are tested.
    pub(super) kept: Vec<f64>,
}

impl Buffers {
    pub(super) fn new<R: Row>(segments: &Segments, n: usize) -> Self {
        let of_nests = if segments.nests.is_empty() { 0 } else { n };
        let [rows, _, increments] = segments.counts;
        Self {
            of_piece: vec![0.0; TILE * R::LENGTH],
            of_nests: vec![0.0; of_nests * R::LENGTH],
            of_batch: vec![0.0; BATCH * (1 + rows) * R::LENGTH],
            dw: vec![0.0; BATCH * increments],
            with_totals: Vec::new(),
            kept: vec![0.0; TILE * R::LENGTH],
        }
    }

    /// Returns a kick with the totals of the last sweep.
    pub(super) fn with_totals<'a, S: Contributions<W>, W>(&'a self, kick: Kick<'a>) -> Kick<'a> {
        match S::TOTALS {
            0 => kick,
            _ => Kick {
                dw: &self.with_totals,
                ..kick
            },
        }
    }

    /// Returns the number of numbers.
    pub(super) fn len(&self) -> usize {
        let Self {
            of_piece,
            of_batch,
            dw,
            of_nests,
            with_totals,
            kept,
        } = self;
        let arrays = [of_piece, of_batch, dw, of_nests, with_totals, kept];
        arrays.iter().map(|array| array.len()).sum()
    }
}

/// A drift, if there is one, and then the impulses of all loops, added `TWICE` or once to the
/// momenta.
pub(super) struct Sweep<'a, S: Scene, const TWICE: bool> {
    pub(super) scene: &'a S,
    pub(super) segments: &'a Segments,
    pub(super) drift: Option<Drift<'a>>,
    pub(super) kick: Kick<'a>,
    pub(super) q: &'a mut [S::Row],
    pub(super) p: &'a mut [S::Row],
    pub(super) buffers: &'a mut Buffers,
    /// True if numbers are tested as long as they are in the first cache.
    pub(super) is_tested: bool,
    /// The pieces that get their contributions: the first ones.
    pub(super) pieces: usize,
}

impl<S: Scene, const TWICE: bool> Kernel for Sweep<'_, S, TWICE> {
    /// A number that is not finite, if numbers are tested.
    type Output = Result<Option<Place>, IndexError>;

    #[inline(always)]
    fn run(mut self) -> Self::Output {
        let mut moved = 0;
        let gathered = self.gathered(&mut moved);
        if self.segments.nests.is_empty() {
            return Ok(gathered.err());
        }
        let result = match gathered {
            Ok(()) => self.nests(moved),
            Err(place) => Ok(Some(place)),
        };
        if !matches!(result, Ok(None)) {
            self.buffers.of_nests.fill(0.0);
        }
        result
    }
}

impl<S: Scene, const TWICE: bool> Sweep<'_, S, TWICE> {
    /// Moves the sites and adds the contributions of gathered loops.
    #[inline(always)]
    fn gathered(&mut self, moved: &mut usize) -> Result<(), Place> {
        let (n, segments, is_tested) = (self.q.len(), self.segments, self.is_tested);
        let has_nests = !segments.nests.is_empty();
        for (number, (piece, bases)) in segments.pieces::<S>().enumerate().take(self.pieces) {
            if let Some(drift) = &self.drift
                && *moved < piece.ready()
            {
                let nodes = *moved..piece.ready().next_multiple_of(TILE).min(n);
                let result = drift.nodes(self.q, self.p, nodes.clone(), is_tested);
                result.map_err(|at| Place::new(at, *moved, number))?;
                *moved = nodes.end;
            }
            let result = if TWICE && !has_nests {
                self.piece::<true>(piece, bases)
            } else {
                self.piece::<false>(piece, bases)
            };
            result.map_err(|component| Place::new(("p", component), *moved, number))?;
        }
        if let Some(drift) = &self.drift {
            let result = drift.nodes(self.q, self.p, *moved..n, is_tested);
            result.map_err(|at| Place::new(at, *moved, self.pieces))?;
        }
        Ok(())
    }

    /// Adds the contributions of gathered loops to the nodes of a piece.
    ///
    /// # Errors
    /// The number of a component that is not finite, if numbers are tested. The piece is then
    /// unchanged.
    #[inline(always)]
    fn piece<const TO_P_TWICE: bool>(
        &mut self,
        piece: &Piece,
        bases: Bases<'_>,
    ) -> Result<(), usize> {
        let (segments, dw) = (self.segments, self.kick.dw);
        let has_nests = !segments.nests.is_empty();
        let Buffers {
            of_piece,
            of_batch,
            dw: of_increments,
            of_nests,
            kept,
            ..
        } = &mut *self.buffers;
        let mut visit =
            Visit::<S, Impulses>::new(self.scene, segments, self.kick, [of_batch, of_increments]);
        let q = &*self.q;
        let to = if has_nests {
            Row::rows_mut(of_nests)
        } else {
            &mut *self.p
        };
        let is_tested = self.is_tested && !has_nests;
        let nodes = piece.nodes();
        let first = nodes.start * S::Row::LENGTH;
        if !piece.has_others && piece.batch.is_none() {
            let streams = streams(q, nodes.start, segments, bases, dw);
            let length = if is_tested { nodes.len() } else { 0 };
            let (to, kept) = (&mut to[nodes], &mut Row::rows_mut(kept)[..length]);
            let are_finite = if TO_P_TWICE {
                CountsOf::<S, Impulses>::put::<AddTwice, _>(&streams, to, kept, &visit.node)
            } else {
                CountsOf::<S, Impulses>::put::<Add, _>(&streams, to, kept, &visit.node)
            };
            if are_finite {
                return Ok(());
            }
            let component = first + first_not_finite(Row::numbers(to));
            to.copy_from_slice(kept);
            return Err(component);
        }
        // The impulse of a node is added as one number: two kicks in one have the bits of two.
        let sum = &mut S::Row::rows_mut(of_piece)[..nodes.len()];
        if let Some(batch) = visit.write(q, piece, bases, sum) {
            return move_to_nodes::<TO_P_TWICE, _>(&batch.nodes, to, sum, is_tested);
        }
        let moved = move_all::<TO_P_TWICE, _>(&mut to[nodes], sum, is_tested);
        moved.map_err(|component| first + component)
    }

    /// Adds the contributions of all loops, some of them made as they are written.
    #[inline(always)]
    fn nests(&mut self, moved: usize) -> Result<Option<Place>, IndexError> {
        let (Kick { h, t, dw }, q) = (self.kick, &*self.q);
        let of_nests = S::Row::rows_mut(&mut self.buffers.of_nests);
        for &number in &self.segments.nests {
            Contributions::<Impulses>::nest(self.scene, number, h, t, dw, q, of_nests)?;
        }
        let tiles = self.p.chunks_mut(TILE).zip(of_nests.chunks_mut(TILE));
        for (number, (p, sum)) in tiles.enumerate() {
            if let Err(at) = move_all::<TWICE, _>(p, sum, self.is_tested) {
                let at = number * TILE * S::Row::LENGTH + at;
                return Ok(Some(Place::new(("p", at), moved, self.pieces)));
            }
            sum.fill(S::Row::ZERO);
        }
        Ok(None)
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
            CountsOf::<S, W>::put::<Write, _>(&streams, sum, &mut [], &self.node);
            first = S::NODE_PAIRS;
        } else {
            sum.fill(NumbersOf::<S, W>::ZERO);
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

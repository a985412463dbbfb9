//! A sweep: nodes move, and the impulses of all loops at their new places are added to the momenta,
//! once or, with other increments, a second time.
//!
//! Both are done in place, tile by tile. The drift leads by what a piece of nodes reads, so that
//! the momenta of a tile are still in the first cache when its impulses are added.

use super::additions::{first_not_finite, move_all, move_to_nodes};
use super::drift::Drift;
use super::pieces::{Bases, Piece};
use super::segments::{BATCH, Segments, TILE};
use super::streams::{Add, AddTwice};
use super::visit::{CountsOf, Node, Visit, streams};
use super::{Contributions, Impulses, IndexError, Row, Scene, StreamCounts};
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
    /// Impulses of the pairs of one piece, by two kicks.
    pub(super) of_piece: Vec<f64>,
    /// The rows of copied nodes, of `BATCH` nodes each, and of what their impulses read.
    pub(super) of_batch: Vec<f64>,
    /// The increments that the impulses of copied nodes read.
    pub(super) dw: Vec<f64>,
    /// Impulses of all loops, if one of them is made as it is written: zeros between sweeps.
    pub(super) of_nests: Vec<f64>,
    /// Impulses of all loops by a second kick.
    pub(super) of_second: Vec<f64>,
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
            of_piece: vec![0.0; 2 * TILE * R::LENGTH],
            of_nests: vec![0.0; of_nests * R::LENGTH],
            of_second: Vec::new(),
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
            of_second,
            with_totals,
            kept,
        } = self;
        let of_piece = [of_piece, of_batch, dw, kept];
        let arrays = of_piece
            .into_iter()
            .chain([of_nests, of_second, with_totals]);
        arrays.map(Vec::len).sum()
    }
}

/// A drift, if there is one, and then the impulses of all loops, added to the momenta; `TWICE` with
/// the increments of two kicks. In a scene with loops that are made as they are written the sites
/// have already moved.
pub(super) struct Sweep<'a, S: Scene, const TWICE: bool> {
    pub(super) scene: &'a S,
    pub(super) segments: &'a Segments,
    pub(super) drift: Option<Drift<'a>>,
    pub(super) kick: Kick<'a>,
    /// The increments of a second kick, if impulses read increments.
    pub(super) second: Option<&'a [f64]>,
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
        let has_nests = !self.segments.nests.is_empty();
        let last = if has_nests { self.kicks() } else { 1 };
        for round in usize::from(!has_nests)..=last {
            let result = self.round(round);
            if !matches!(result, Ok(None)) {
                self.buffers.of_nests.fill(0.0);
                return result;
            }
        }
        Ok(if has_nests { self.add_nests() } else { None })
    }
}

impl<'a, S: Scene, const TWICE: bool> Sweep<'a, S, TWICE> {
    /// Returns the number of kicks with impulses of their own.
    #[inline(always)]
    fn kicks(&self) -> usize {
        if TWICE && self.second.is_some() { 2 } else { 1 }
    }

    /// Returns the kick, or the second one.
    #[inline(always)]
    fn kick(&self, number: usize) -> Kick<'a> {
        let dw = match self.second {
            Some(second) if number == 1 => second,
            _ => self.kick.dw,
        };
        Kick { dw, ..self.kick }
    }

    /// Adds contributions: in round 0 of the loops that are made as they are written and read no
    /// increments, and then of the others, with the increments of a kick in each round.
    #[inline(always)]
    fn round(&mut self, round: usize) -> Result<Option<Place>, IndexError> {
        let kick = round.max(1) - 1;
        self.nests(round, kick)?;
        let result = if round == 0 {
            Ok(())
        } else {
            self.gathered(kick)
        };
        Ok(result.err())
    }

    /// Moves the sites and adds the contributions of gathered loops.
    #[inline(always)]
    fn gathered(&mut self, kick: usize) -> Result<(), Place> {
        let (n, segments, is_tested) = (self.q.len(), self.segments, self.is_tested);
        let has_nests = !segments.nests.is_empty();
        let mut moved = 0;
        for (number, (piece, bases)) in segments.pieces::<S>().enumerate().take(self.pieces) {
            if let Some(drift) = &self.drift
                && moved < piece.ready()
            {
                let nodes = moved..piece.ready().next_multiple_of(TILE).min(n);
                let result = drift.nodes(self.q, self.p, nodes.clone(), is_tested);
                result.map_err(|at| Place::new(at, moved, number))?;
                moved = nodes.end;
            }
            let result = if TWICE && !has_nests {
                self.piece::<true>(piece, bases, kick)
            } else {
                self.piece::<false>(piece, bases, kick)
            };
            result.map_err(|component| Place::new(("p", component), moved, number))?;
        }
        if let Some(drift) = &self.drift {
            let result = drift.nodes(self.q, self.p, moved..n, is_tested);
            result.map_err(|at| Place::new(at, moved, self.pieces))?;
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
        kick: usize,
    ) -> Result<(), usize> {
        let (scene, segments) = (self.scene, self.segments);
        let count = if TO_P_TWICE { self.kicks() } else { 1 };
        let kicks = [
            self.kick(kick),
            self.kick(kick.max(usize::from(TO_P_TWICE))),
        ];
        let has_nests = !segments.nests.is_empty();
        let Buffers {
            of_piece,
            of_batch,
            dw: of_increments,
            of_nests,
            of_second,
            kept,
            ..
        } = &mut *self.buffers;
        let q = &*self.q;
        let to = match (has_nests, kick) {
            (false, _) => &mut *self.p,
            (true, 0) => Row::rows_mut(of_nests),
            (true, _) => Row::rows_mut(of_second),
        };
        let is_tested = self.is_tested && !has_nests;
        let nodes = piece.nodes();
        let first = nodes.start * S::Row::LENGTH;
        if !piece.has_others && piece.batch.is_none() {
            let node = Node::<S, Impulses>::new(scene, kicks);
            let streams = streams(q, nodes.start, segments, bases, node.dw);
            let length = if is_tested { nodes.len() } else { 0 };
            let (to, kept) = (&mut to[nodes], &mut Row::rows_mut(kept)[..length]);
            let are_finite = if TO_P_TWICE {
                CountsOf::<S, Impulses>::put::<AddTwice, _>(&streams, to, kept, &node)
            } else {
                CountsOf::<S, Impulses>::put::<Add, _>(&streams, to, kept, &node)
            };
            if are_finite {
                return Ok(());
            }
            let component = first + first_not_finite(Row::numbers(to));
            to.copy_from_slice(kept);
            return Err(component);
        }
        // The impulse of a node is added as one number: two kicks in one have the bits of two.
        let (sum, second) = S::Row::rows_mut(of_piece).split_at_mut(TILE);
        let mut sums = [sum, second].map(|sum| &mut sum[..nodes.len()]);
        let mut batch = None;
        for (kick, sum) in kicks.into_iter().zip(&mut sums).take(count) {
            let mut visit = Visit::new(scene, segments, kick, [of_batch, of_increments]);
            batch = visit.write(q, piece, bases, sum);
        }
        let sums = [&*sums[0], &*sums[count - 1]];
        if let Some(batch) = batch {
            return move_to_nodes::<TO_P_TWICE, _>(&batch.nodes, to, sums, is_tested);
        }
        let moved = move_all::<TO_P_TWICE, _>(&mut to[nodes], sums, is_tested);
        moved.map_err(|component| first + component)
    }

    /// Adds the contributions of loops that are made as they are written.
    #[inline(always)]
    fn nests(&mut self, round: usize, kick: usize) -> Result<(), IndexError> {
        let (Kick { h, t, dw }, kicks) = (self.kick(kick), self.kicks());
        let Buffers {
            of_nests,
            of_second,
            ..
        } = &mut *self.buffers;
        if round == 1 && kicks == 2 {
            of_second.clear();
            of_second.extend_from_slice(of_nests);
        }
        let to = S::Row::rows_mut(if kick == 0 { of_nests } else { of_second });
        for &number in &self.segments.nests {
            if S::LOOPS[number].has_noise == (round > 0) {
                Contributions::<Impulses>::nest(self.scene, number, h, t, dw, &*self.q, to)?;
            }
        }
        Ok(())
    }

    /// Adds the impulses of all loops, some of them made as they are written, to the momenta.
    /// Returns the place of a sum that is not finite, if sums are tested.
    #[inline(always)]
    fn add_nests(&mut self) -> Option<Place> {
        let kicks = self.kicks();
        let Buffers {
            of_nests,
            of_second,
            ..
        } = &mut *self.buffers;
        let tiles = self
            .p
            .chunks_mut(TILE)
            .zip(of_nests.chunks_mut(TILE * S::Row::LENGTH));
        for (number, (p, first)) in tiles.enumerate() {
            let at = number * TILE * S::Row::LENGTH;
            let second = if kicks == 2 {
                &of_second[at..at + first.len()]
            } else {
                &*first
            };
            let impulses = [&*first, second].map(S::Row::rows);
            if let Err(component) = move_all::<TWICE, _>(p, impulses, self.is_tested) {
                of_nests.fill(0.0);
                return Some(Place::new(("p", at + component), self.q.len(), self.pieces));
            }
            first.fill(0.0);
        }
        None
    }
}

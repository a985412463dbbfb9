//! A sweep whose sums are used piece by piece: a sink takes the contributions of all loops to the
//! nodes of a piece while they are in the first cache.

use core::marker::PhantomData;
use core::ops::Range;

use super::passes::{Factor, Pass};
use super::segments::{Segments, TILE};
use super::sweep::{Buffers, Kick};
use super::visit::{NumbersOf, Visit};
use super::{Contributions, InDrift, IndexError, Row, Scene, reads_motion};

/// The use of the contributions. All functions are `#[inline(always)]`.
pub(super) trait Sink<R> {
    /// Returns the nodes at which the contributions are computed, of which those below `ready` are
    /// read. The number never decreases.
    fn nodes(&mut self, ready: usize, factors: impl Factor) -> &[R];

    /// Returns all nodes with their velocities, in a scene with forces of velocities.
    fn motion(&mut self) -> [&[R]; 2];

    /// Returns all nodes with their momenta, if the impulses of H₁ are to be added to the sums.
    fn with_momenta(&mut self) -> Option<[&[R]; 2]>;

    /// Sees what forces of velocities contribute to all nodes, which is a part of their sums.
    fn see_drags(&mut self, drags: &[R], factors: impl Factor);

    /// Takes the sums of consecutive nodes.
    fn take(&mut self, nodes: Range<usize>, sums: &[R], factors: impl Factor);
}

/// A sweep over the contributions `W`, in which the sink takes the sums of each node once. Returns
/// the sink.
pub(super) struct Gather<'a, S, W, K> {
    pub(super) scene: &'a S,
    pub(super) segments: &'a Segments,
    pub(super) kick: Kick<'a>,
    pub(super) buffers: &'a mut Buffers,
    pub(super) sink: K,
    pub(super) what: PhantomData<W>,
}

impl<S, W, K> Pass for Gather<'_, S, W, K>
where
    S: Scene + Contributions<W>,
    K: Sink<NumbersOf<S, W>>,
{
    type Output = Result<K, IndexError>;

    #[inline(always)]
    fn run(self, factors: impl Factor) -> Self::Output {
        let Self {
            scene,
            segments,
            kick,
            buffers:
                Buffers {
                    of_piece,
                    of_nests,
                    of_batch,
                    dw: of_increments,
                    with_totals,
                    ..
                },
            mut sink,
            ..
        } = self;
        let kick = if <S as Contributions<W>>::TOTALS > 0 {
            with_totals.clear();
            with_totals.extend_from_slice(kick.dw);
            with_totals.resize(kick.dw.len() + <S as Contributions<W>>::TOTALS, 0.0);
            let all = sink.nodes(0, factors).len();
            let nodes = sink.nodes(all, factors);
            Contributions::<W>::totals(scene, kick.t, nodes, with_totals)?;
            let dw = &**with_totals;
            Kick { dw, ..kick }
        } else {
            kick
        };
        let of_piece = NumbersOf::<S, W>::rows_mut(of_piece);
        if reads_motion::<S>() {
            let all = sink.nodes(0, factors).len();
            of_nests.resize(all * NumbersOf::<S, W>::LENGTH, 0.0);
        }
        let of_nests = NumbersOf::<S, W>::rows_mut(of_nests);
        if reads_motion::<S>() {
            let _ = sink.nodes(of_nests.len(), factors);
            let made = in_motion::<S, W, K>(scene, kick, &mut sink, of_nests, factors);
            if made.is_err() {
                of_nests.fill(NumbersOf::<S, W>::ZERO);
            }
            made?;
        }
        let has_nests = !segments.nests.is_empty() || reads_motion::<S>();
        let mut visit = Visit::<S, W>::new(scene, segments, kick, [of_batch, of_increments]);
        for (piece, bases) in segments.pieces::<S>() {
            let sums = &mut of_piece[..piece.length as usize];
            let nodes = sink.nodes(piece.ready(), factors);
            let batch = visit.write(nodes, piece, bases, sums);
            match batch {
                _ if has_nests => add(of_nests, piece.nodes(), batch.map(|b| &*b.nodes), sums),
                None => sink.take(piece.nodes(), sums, factors),
                Some(batch) => {
                    for (&node, sum) in batch.nodes.iter().zip(&*sums) {
                        let node = node as usize;
                        sink.take(node..node + 1, core::slice::from_ref(sum), factors);
                    }
                }
            }
        }
        if !has_nests {
            if !segments.free.is_empty() {
                of_piece.fill(NumbersOf::<S, W>::ZERO);
            }
            for range in &segments.free {
                let _ = sink.nodes(range.end, factors);
                take_all(
                    &mut sink,
                    range.clone(),
                    |here| &of_piece[..here.len()],
                    factors,
                );
            }
            return Ok(sink);
        }
        let Kick { h, t, dw } = kick;
        let all = 0..of_nests.len();
        let nodes = sink.nodes(all.end, factors);
        let mut nests = segments.nests.iter();
        let made = nests
            .try_for_each(|&nest| Contributions::<W>::nest(scene, nest, h, t, dw, nodes, of_nests));
        if made.is_ok() {
            take_all(&mut sink, all, |here| &of_nests[here], factors);
        }
        of_nests.fill(NumbersOf::<S, W>::ZERO);
        made.map(|()| sink)
    }
}

/// Adds what reads velocities or momenta to zeros.
#[inline(always)]
fn in_motion<S, W, K>(
    scene: &S,
    Kick { h, t, dw }: Kick<'_>,
    sink: &mut K,
    to: &mut [NumbersOf<S, W>],
    factors: impl Factor,
) -> Result<(), IndexError>
where
    S: Scene + Contributions<W>,
    K: Sink<NumbersOf<S, W>>,
{
    if S::HAS_DRAGS {
        let [nodes, v] = sink.motion();
        Contributions::<W>::in_drift(scene, InDrift::Drags, h, t, dw, nodes, v, to)?;
        sink.see_drags(to, factors);
    }
    match sink.with_momenta() {
        Some([nodes, p]) if S::HAS_H1 => {
            Contributions::<W>::in_drift(scene, InDrift::Kicks, h, t, dw, nodes, p, to)
        }
        _ => Ok(()),
    }
}

/// Lets the sink take nodes tile by tile.
#[inline(always)]
fn take_all<'a, R: Row>(
    sink: &mut impl Sink<R>,
    nodes: Range<usize>,
    sums: impl Fn(Range<usize>) -> &'a [R],
    factors: impl Factor,
) {
    for first in nodes.clone().step_by(TILE) {
        let here = first..nodes.end.min(first + TILE);
        sink.take(here.clone(), sums(here), factors);
    }
}

/// Adds sums to consecutive nodes, or to listed ones.
#[inline(always)]
fn add<R: Row>(to: &mut [R], nodes: Range<usize>, listed: Option<&[u32]>, sums: &[R]) {
    match listed {
        None => {
            for (to, sum) in to[nodes].iter_mut().zip(sums) {
                to.add(*sum);
            }
        }
        Some(listed) => {
            for (&node, sum) in listed.iter().zip(sums) {
                to[node as usize].add(*sum);
            }
        }
    }
}

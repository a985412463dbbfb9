//! A sweep of the iteration of a midpoint step: the impulses at all nodes, and the update of the
//! displacements by them. The impulses of a piece of nodes are still in the first cache when its
//! displacements are updated. The new nodes go into an array of their own, since other pieces read
//! the old ones.

use core::ops::Range;

use super::passes::{Pass, keep_larger, largest};
use super::segments::{Segments, TILE};
use super::sweep::{Buffers, Kick, Visit};
use super::{Impulses, IndexError, Row, Scene};

/// A sweep, with the updates Δ ← β Δ − α g of the displacements, where g is the residual. Returns
/// the largest update and the largest displacement.
pub(super) struct Relax<'a, S: Scene> {
    pub(super) scene: &'a S,
    pub(super) segments: &'a Segments,
    pub(super) kick: Kick<'a>,
    pub(super) buffers: &'a mut Buffers,
    /// The nodes at which the impulses are computed.
    pub(super) nodes: &'a [S::Row],
    pub(super) solution: Solution<'a>,
}

/// What an update reads and writes, of the components of rows.
pub(super) struct Solution<'a> {
    pub(super) d: &'a mut [f64],
    pub(super) update: &'a mut [f64],
    /// The nodes after the update.
    pub(super) fresh: &'a mut [f64],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// α and β.
    pub(super) weights: [f64; 2],
}

impl<S: Scene> Pass for Relax<'_, S> {
    type Output = Result<[f64; 2], IndexError>;

    #[inline(always)]
    fn components(&self) -> usize {
        self.solution.d.len()
    }

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> Self::Output {
        let Self {
            scene,
            segments,
            kick,
            buffers,
            nodes,
            mut solution,
        } = self;
        let size = S::Row::LENGTH;
        let Buffers {
            of_piece,
            of_nests,
            of_batch,
            dw,
        } = buffers;
        let of_nests = S::Row::rows_mut(of_nests);
        let of_piece = S::Row::rows_mut(of_piece);
        let has_nests = !segments.nests.is_empty();
        let mut visit = Visit::<S, Impulses>::new(scene, segments, kick, [of_batch, dw]);
        let mut most = [0.0; 2];
        for (piece, bases) in segments.pieces() {
            let sum = &mut of_piece[..piece.length as usize];
            let batch = visit.add(nodes, piece, bases, sum);
            match batch {
                _ if has_nests => add(of_nests, piece.nodes(), batch.map(|b| &*b.nodes), sum),
                None => {
                    let nodes = piece.nodes();
                    let here = nodes.start * size..nodes.end * size;
                    solution.update(here, S::Row::numbers(sum), &factor, &mut most);
                }
                Some(batch) => {
                    for (&node, sum) in batch.nodes.iter().zip(&*sum) {
                        let here = node as usize * size..(node as usize + 1) * size;
                        let sum = S::Row::numbers(core::slice::from_ref(sum));
                        solution.update(here, sum, &factor, &mut most);
                    }
                }
            }
            sum.fill(S::Row::ZERO);
        }
        if has_nests {
            let mut nests = segments.nests.iter();
            let Kick { h, t, dw } = kick;
            let made = nests.try_for_each(|&nest| scene.nest(nest, h, t, dw, nodes, of_nests));
            if made.is_ok() {
                solution.update_all(S::Row::numbers(of_nests), &factor, &mut most);
            }
            of_nests.fill(S::Row::ZERO);
            made?;
        }
        Ok(most)
    }
}

/// Adds impulses to consecutive nodes, or to listed ones.
#[inline(always)]
fn add<R: Row>(to: &mut [R], nodes: Range<usize>, listed: Option<&[u32]>, sum: &[R]) {
    match listed {
        None => {
            for (to, sum) in to[nodes].iter_mut().zip(sum) {
                to.add(*sum);
            }
        }
        Some(listed) => {
            for (&node, sum) in listed.iter().zip(sum) {
                to[node as usize].add(*sum);
            }
        }
    }
}

impl Solution<'_> {
    /// Updates all components by their impulses.
    #[inline(always)]
    fn update_all(&mut self, impulse: &[f64], factor: &impl Fn(usize) -> f64, most: &mut [f64; 2]) {
        let n = self.d.len();
        for first in (0..n).step_by(TILE) {
            let here = first..n.min(first + TILE);
            self.update(here.clone(), &impulse[here], factor, most);
        }
    }

    /// Updates some components by their impulses.
    #[inline(always)]
    fn update(
        &mut self,
        here: Range<usize>,
        impulse: &[f64],
        factor: &impl Fn(usize) -> f64,
        most: &mut [f64; 2],
    ) {
        let first = here.start;
        let d = &mut self.d[here.clone()];
        let (update, fresh) = (
            &mut self.update[here.clone()],
            &mut self.fresh[here.clone()],
        );
        let [q, p] = [self.q, self.p].map(|x| &x[here.clone()]);
        let factor = |at| factor(first + at);
        update_tile(d, update, fresh, [q, p, impulse], factor, self.weights);
        for (most, tile) in most.iter_mut().zip([update, d]) {
            keep_larger(most, largest(tile));
        }
    }
}

/// Updates components. The slices are arguments, so that the compiler knows that they do not
/// overlap.
#[inline(always)]
fn update_tile(
    d: &mut [f64],
    update: &mut [f64],
    fresh: &mut [f64],
    [q, p, impulse]: [&[f64]; 3],
    factor: impl Fn(usize) -> f64,
    [alpha, beta]: [f64; 2],
) {
    let n = d.len();
    let (update, fresh) = (&mut update[..n], &mut fresh[..n]);
    let (q, p, impulse) = (&q[..n], &p[..n], &impulse[..n]);
    for at in 0..n {
        let residual = d[at] - factor(at) * (p[at] + 0.5 * impulse[at]);
        let change = beta * update[at] - alpha * residual;
        let new = d[at] + change;
        (update[at], d[at], fresh[at]) = (change, new, q[at] + 0.5 * new);
    }
}

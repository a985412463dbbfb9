//! What the sweeps of a midpoint step do with the impulses at the nodes.
//!
//! The displacement of a site is `d = f p₀ + e` with the part e of the impulse, `e = f I/2`. The
//! iteration is one for e. The nodes `c + e/2`, with c = q₀ + f p₀/2, go into an array of their own,
//! since other pieces read the old ones.

use core::ops::Range;

use super::Row;
use super::gather::Sink;
use super::passes::{Factor, PARTS, keep_larger, largest_part};
use super::spectrum::is_in_box;

/// The updates Δ ← β Δ − α g of the displacements, where g is the residual.
pub(super) struct Relax<'a, R> {
    /// The nodes at which the impulses are computed.
    pub(super) nodes: &'a [R],
    /// The nodes after the update.
    pub(super) fresh: &'a mut [f64],
    /// The nodes of displacements without impulses.
    pub(super) centres: &'a [f64],
    /// The part e of each displacement.
    pub(super) e: &'a [f64],
    /// e before the last update; then e after this one.
    pub(super) other: &'a mut [f64],
    /// α and β.
    pub(super) weights: [f64; 2],
    pub(super) most: Most,
}

/// Partial maxima of the magnitudes of updates and of e.
#[derive(Clone, Copy, Default)]
pub(super) struct Most {
    changes: [u64; PARTS],
    e: [u64; PARTS],
}

impl Most {
    /// Returns the largest update and the largest e.
    pub(super) fn values(&self) -> [f64; 2] {
        [largest_part(&self.changes), largest_part(&self.e)]
    }
}

impl<R: Row> Sink<R> for Relax<'_, R> {
    #[inline(always)]
    fn nodes(&mut self, _: usize, _: impl Factor) -> &[R] {
        self.nodes
    }

    #[inline(always)]
    fn take(&mut self, nodes: Range<usize>, sums: &[R], factors: impl Factor) {
        let here = nodes.start * R::LENGTH..nodes.end * R::LENGTH;
        update_tile(
            &mut self.other[here.clone()],
            &mut self.fresh[here.clone()],
            [
                &self.e[here.clone()],
                &self.centres[here.clone()],
                R::numbers(sums),
            ],
            factors.within(here),
            self.weights,
            &mut self.most,
        );
    }
}

/// Updates components. The slices are arguments, so that the compiler knows that they do not
/// overlap.
#[inline(always)]
fn update_tile(
    other: &mut [f64],
    fresh: &mut [f64],
    [e, centres, impulse]: [&[f64]; 3],
    factors: impl Factor,
    [alpha, beta]: [f64; 2],
    most: &mut Most,
) {
    let (others, other) = other.as_chunks_mut::<PARTS>();
    let (freshes, fresh) = fresh.as_chunks_mut::<PARTS>();
    let [(es, e), (cs, centres), (impulses, impulse)] =
        [e, centres, impulse].map(|x| x.as_chunks::<PARTS>());
    let updated = |e: f64, other: f64, of_impulse: f64| {
        let change = beta * (e - other) - alpha * (e - of_impulse);
        [change, e + change]
    };
    let first = others.len() * PARTS;
    if first > 0 {
        // in registers, since all their indices are constants once the loop is unrolled
        let mut parts = *most;
        for (at, (other, fresh)) in others.iter_mut().zip(freshes).enumerate() {
            let (e, c, impulse) = (&es[at], &cs[at], &impulses[at]);
            let factor = factors.chunk(at);
            for k in 0..PARTS {
                let [change, new] = updated(e[k], other[k], factor[k] * (0.5 * impulse[k]));
                (other[k], fresh[k]) = (new, c[k] + 0.5 * new);
                keep_larger(&mut parts.changes[k], change);
                keep_larger(&mut parts.e[k], new);
            }
        }
        *most = parts;
    }
    for k in 0..other.len() {
        let of_impulse = factors.of(first + k) * (0.5 * impulse[k]);
        let [change, new] = updated(e[k], other[k], of_impulse);
        (other[k], fresh[k]) = (new, centres[k] + 0.5 * new);
        keep_larger(&mut most.changes[k], change);
        keep_larger(&mut most.e[k], new);
    }
}

/// The momenta at the end, with tests of the end.
pub(super) struct End<'a, R> {
    pub(super) nodes: &'a [R],
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    pub(super) e: &'a [f64],
    /// The momenta at the end.
    pub(super) to: &'a mut [f64],
    /// e of the displacements around which the boxes are; zeros if it is empty.
    pub(super) around: &'a [f64],
    /// The largest displacement among these.
    pub(super) largest: f64,
    /// The friction of each component divided by its mass, and the inverse masses; nothing without
    /// friction.
    pub(super) friction: Option<(&'a [f64], &'a super::masses::InverseMasses)>,
    /// Zero if all numbers at the end are finite.
    pub(super) bits: u64,
    /// Whether the boxes contain the displacements.
    pub(super) is_in_boxes: bool,
}

impl<R: Row> Sink<R> for End<'_, R> {
    #[inline(always)]
    fn nodes(&mut self, _: usize, _: impl Factor) -> &[R] {
        self.nodes
    }

    #[inline(always)]
    fn take(&mut self, nodes: Range<usize>, sums: &[R], factors: impl Factor) {
        let here = nodes.start * R::LENGTH..nodes.end * R::LENGTH;
        let factors = factors.within(here.clone());
        let [q, p, e] = [self.q, self.p, self.e].map(|x| &x[here.clone()]);
        let to = &mut self.to[here.clone()];
        let read = [q, p, e, R::numbers(sums)];
        let (bits, is_in_boxes) = if self.around.is_empty() {
            end_tile(to, read, factors, |_| 0.0, self.largest)
        } else {
            let around = &self.around[here.clone()];
            end_tile(to, read, factors, |at| around[at], self.largest)
        };
        self.bits |= bits;
        self.is_in_boxes &= is_in_boxes;
        if let Some((rates, masses)) = self.friction {
            let (first, rates) = (here.start, &rates[here]);
            for at in 0..to.len() {
                let d = factors.of(at) * p[at] + e[at];
                to[at] -= rates[at] / masses.of(first + at) * d;
                // the difference of two infinite numbers is NaN
                #[allow(clippy::eq_op)]
                let difference = to[at] - to[at];
                self.bits |= difference.to_bits();
            }
        }
    }
}

/// Writes the momenta p₀ + I. Returns bits that are zero if the end is finite, and whether the boxes
/// contain the displacements.
#[inline(always)]
#[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
fn end_tile(
    to: &mut [f64],
    [q, p, e, impulse]: [&[f64]; 4],
    factors: impl Factor,
    around: impl Fn(usize) -> f64,
    largest: f64,
) -> (u64, bool) {
    let n = to.len();
    let (q, p, e, impulse) = (&q[..n], &p[..n], &e[..n], &impulse[..n]);
    let (mut bits, mut outside) = (0, 0);
    for at in 0..n {
        let straight = factors.of(at) * p[at];
        let d = straight + e[at];
        let end = p[at] + impulse[at];
        to[at] = end;
        bits |= ((q[at] + d) - (q[at] + d)).to_bits() | (end - end).to_bits();
        outside |= u64::from(!is_in_box(d, straight + around(at), largest));
    }
    (bits, outside == 0)
}

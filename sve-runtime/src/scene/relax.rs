//! The use of the impulses at the nodes in the sweeps of a midpoint step.
//!
//! The iteration is one for the nodes m = q₀ + d/2, whose equations are `m = c + f I(m)/4` with c =
//! q₀ + f p₀/2. The new nodes go in the place of those before the last update, since other pieces
//! read the old ones. The end makes one update more, of the displacements: these are as exact as
//! the impulse, however small they are beside the places.

use core::ops::Range;

use super::Row;
use super::gather::Sink;
use super::passes::{Factor, Largest};
use super::spectrum::{is_in_box, is_in_box_of_motion};

/// The updates Δ ← β Δ − α g of the nodes, where g is the residual.
pub(super) struct Relax<'a, R> {
    /// The nodes at which the impulses are computed.
    pub(super) nodes: &'a [R],
    /// The nodes before the last update, which are not read if β is 0; then those after this one.
    pub(super) other: &'a mut [f64],
    /// The nodes c of displacements without impulses.
    pub(super) centres: &'a [f64],
    /// The velocities of the nodes, in a scene with forces of velocities or H₁.
    pub(super) velocities: Option<NodeVelocities<'a>>,
    /// The momenta of the nodes, in a scene with H₁: its nodes are moved after the sweep.
    pub(super) momenta: &'a [R],
    /// α and β.
    pub(super) weights: [f64; 2],
    pub(super) largest: Largest,
}

/// Velocities of nodes with their own updates, since v = 2 (m − q₀)/h has few digits where h is
/// small. In a scene with forces of velocities or H₁ the iteration is Richardson's.
pub(super) struct NodeVelocities<'a> {
    pub(super) v: &'a mut [f64],
    pub(super) p: &'a [f64],
    pub(super) h: f64,
    /// The largest update.
    pub(super) largest: Largest,
}

impl<R: Row> Sink<R> for Relax<'_, R> {
    #[inline(always)]
    fn nodes(&mut self, _: usize, _: impl Factor) -> &[R] {
        self.nodes
    }

    #[inline(always)]
    fn motion(&mut self) -> [&[R]; 2] {
        let v = self.velocities.as_mut();
        [self.nodes, v.map_or(&[], |of| R::rows_mut(of.v))]
    }

    #[inline(always)]
    fn with_momenta(&mut self) -> Option<[&[R]; 2]> {
        Some([self.nodes, self.momenta])
    }

    #[inline(always)]
    fn see_drags(&mut self, _: &[R], _: impl Factor) {}

    #[inline(always)]
    fn take(&mut self, nodes: Range<usize>, sums: &[R], factors: impl Factor) {
        let here = nodes.start * R::LENGTH..nodes.end * R::LENGTH;
        if let Some(NodeVelocities { v, p, h, largest }) = &mut self.velocities {
            let (v, p, sums) = (&mut v[here.clone()], &p[here.clone()], R::numbers(sums));
            let factors = factors.within(here.clone());
            for at in 0..v.len() {
                let new = factors.of(at) * (p[at] + 0.5 * sums[at]) / *h;
                let change = self.weights[0] * (new - v[at]);
                v[at] += change;
                largest.add(change);
            }
        }
        if !self.momenta.is_empty() {
            return;
        }
        update_tile(
            &mut self.other[here.clone()],
            [
                R::numbers(&self.nodes[nodes]),
                &self.centres[here.clone()],
                R::numbers(sums),
            ],
            factors.within(here),
            self.weights,
            &mut self.largest,
        );
    }
}

/// Updates components. The slices are arguments, so that the compiler knows that they do not
/// overlap.
#[inline(always)]
fn update_tile(
    other: &mut [f64],
    [nodes, centres, impulse]: [&[f64]; 3],
    factors: impl Factor,
    [alpha, beta]: [f64; 2],
    largest: &mut Largest,
) {
    let n = other.len();
    let (nodes, centres, impulse) = (&nodes[..n], &centres[..n], &impulse[..n]);
    let factors = factors.within(0..n);
    let mut most = *largest;
    let plain = |at| {
        let residual = (nodes[at] - centres[at]) - (0.25 * factors.of(at)) * impulse[at];
        -(alpha * residual)
    };
    if beta == 0.0 {
        // what is in `other` may be of another step, and not be finite
        for at in 0..n {
            let change = plain(at);
            other[at] = nodes[at] + change;
            most.add(change);
        }
    } else {
        for at in 0..n {
            let change = beta * (nodes[at] - other[at]) + plain(at);
            other[at] = nodes[at] + change;
            most.add(change);
        }
    }
    *largest = most;
}

/// The displacements and the momenta at the end, with tests of the end.
pub(super) struct End<'a, R> {
    pub(super) nodes: &'a [R],
    /// The velocities of the nodes, in a scene with forces of velocities or H₁.
    pub(super) velocities: &'a mut [f64],
    pub(super) h1: OfH1<'a, R>,
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// The displacements.
    pub(super) d: &'a mut [f64],
    /// The momenta at the end.
    pub(super) to: &'a mut [f64],
    /// The weight α of an update of the displacements.
    pub(super) alpha: f64,
    /// The displacements around which the boxes are; those without impulses if it is empty.
    pub(super) around: &'a [f64],
    /// The largest of these.
    pub(super) largest: f64,
    /// The friction of each component divided by its mass, and the inverse masses; nothing without
    /// friction.
    pub(super) friction: Option<(&'a [f64], &'a super::masses::InverseMasses)>,
    pub(super) tests: Tests,
}

/// The arrays of a scene with H₁ beside velocities; empty arrays for other scenes.
pub(super) struct OfH1<'a, R> {
    pub(super) h: f64,
    /// The momenta of the nodes.
    pub(super) momenta: &'a [R],
    /// The displacements X.
    pub(super) shifts: &'a [f64],
    /// The velocities around which the boxes are.
    pub(super) around: &'a [f64],
    /// The largest difference of their motions from those without impulses.
    pub(super) largest: f64,
}

/// The tests of the displacements after a sweep.
#[derive(Clone, Copy, Default)]
pub(super) struct Tests {
    /// Zero if all numbers are finite.
    bits: u64,
    /// Zero if the boxes contain the displacements.
    outside: u64,
    pub(super) displacements: Largest,
    /// The differences of motions h v from those without impulses, in a scene with H₁.
    pub(super) motions: Largest,
    /// The updates of the displacements.
    pub(super) changes: Largest,
}

impl<R: Row> Sink<R> for End<'_, R> {
    #[inline(always)]
    fn nodes(&mut self, _: usize, _: impl Factor) -> &[R] {
        self.nodes
    }

    #[inline(always)]
    fn motion(&mut self) -> [&[R]; 2] {
        [self.nodes, R::rows_mut(self.velocities)]
    }

    #[inline(always)]
    fn with_momenta(&mut self) -> Option<[&[R]; 2]> {
        Some([self.nodes, self.h1.momenta])
    }

    #[inline(always)]
    fn see_drags(&mut self, _: &[R], _: impl Factor) {}

    #[inline(always)]
    fn take(&mut self, nodes: Range<usize>, sums: &[R], factors: impl Factor) {
        let here = nodes.start * R::LENGTH..nodes.end * R::LENGTH;
        let factors = factors.within(here.clone());
        let [q, p] = [self.q, self.p].map(|x| &x[here.clone()]);
        let [d, to] = [&mut *self.d, &mut *self.to].map(|x| &mut x[here.clone()]);
        // first, the displacements around which the boxes are
        if self.around.is_empty() {
            for at in 0..d.len() {
                d[at] = factors.of(at) * p[at];
            }
        } else {
            d.copy_from_slice(&self.around[here.clone()]);
        }
        let read = [q, p, R::numbers(&self.nodes[nodes]), R::numbers(sums)];
        let has_h1 = !self.h1.momenta.is_empty();
        if has_h1 {
            let v = &mut self.velocities[here.clone()];
            let (largest, tests) = (self.largest, &mut self.tests);
            self.h1
                .end(here.start, [d, to, v], read, factors, largest, tests);
        } else {
            end_tile(
                [d, to],
                read,
                factors,
                [self.alpha, self.largest],
                &mut self.tests,
            );
        }
        if let Some((rates, masses)) = self.friction {
            let [d, to] = [&mut *self.d, &mut *self.to].map(|x| &mut x[here.clone()]);
            let v = has_h1.then(|| &self.velocities[here.clone()]);
            let (first, rates) = (here.start, &rates[here]);
            for at in 0..to.len() {
                let motion = v.map_or(d[at], |v| self.h1.h * v[at]);
                to[at] -= rates[at] / masses.of(first + at) * motion;
                // the difference of two infinite numbers is NaN
                #[allow(clippy::eq_op)]
                let difference = to[at] - to[at];
                self.tests.bits |= difference.to_bits();
            }
        }
    }
}

/// Writes the displacements of some components, in the place of those around which the boxes are,
/// and the momenta p₀ + I.
#[inline(always)]
#[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
fn end_tile(
    [d, to]: [&mut [f64]; 2],
    [q, p, m, impulse]: [&[f64]; 4],
    factors: impl Factor,
    [alpha, largest]: [f64; 2],
    tests: &mut Tests,
) {
    let n = to.len();
    let (d, q, p, m, impulse) = (&mut d[..n], &q[..n], &p[..n], &m[..n], &impulse[..n]);
    let factors = factors.within(0..n);
    let mut tested = *tests;
    for at in 0..n {
        let of_node = 2.0 * (m[at] - q[at]);
        let change = alpha * (factors.of(at) * (p[at] + 0.5 * impulse[at]) - of_node);
        let around = d[at];
        d[at] = of_node + change;
        to[at] = p[at] + impulse[at];
        let end = q[at] + d[at];
        tested.bits |= (end - end).to_bits() | (to[at] - to[at]).to_bits();
        tested.outside |= u64::from(!is_in_box(d[at], around, largest));
        tested.changes.add(change);
        tested.displacements.add(d[at]);
    }
    *tests = tested;
}

impl<R> OfH1<'_, R> {
    /// Writes the displacements h v + X, the momenta, and the velocities of some components, like
    /// [`end_tile`].
    #[inline(always)]
    #[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
    fn end(
        &self,
        first: usize,
        [d, to, v]: [&mut [f64]; 3],
        [q, p, m, impulse]: [&[f64]; 4],
        factors: impl Factor,
        largest: f64,
        tests: &mut Tests,
    ) {
        for at in 0..to.len() {
            let without = factors.of(at) * p[at];
            let motion = factors.of(at) * (p[at] + 0.5 * impulse[at]);
            let around = self.h * self.around[first + at];
            let is_in_box = is_in_box(motion + self.shifts[first + at], d[at], largest)
                && is_in_box_of_motion(motion, [around, without], self.largest);
            tests.outside |= u64::from(!is_in_box);
            tests.motions.add(motion - without);
            tests.changes.add(motion - self.h * v[at]);
            v[at] = motion / self.h;
            d[at] = motion + self.shifts[first + at];
            tests.changes.add(d[at] - 2.0 * (m[at] - q[at]));
            tests.displacements.add(d[at]);
            to[at] = p[at] + impulse[at];
            let end = q[at] + d[at];
            tests.bits |= (end - end).to_bits() | (to[at] - to[at]).to_bits();
        }
    }
}

impl Tests {
    /// Returns whether all numbers are finite.
    pub(super) fn are_finite(&self) -> bool {
        self.bits == 0
    }

    /// Returns whether the boxes contain the displacements.
    pub(super) fn are_in_boxes(&self) -> bool {
        self.outside == 0
    }
}

//! Bounds of the spectrum of the equations of a midpoint step.
//!
//! With the displacement d, the equations are `d − f (p₀ + I(q₀ + d/2)/2) = 0` and their Jacobian is
//! `1 + f K/4` with `K = −∂I/∂q`. Input: a box around the start and the solution for each site, and
//! the bounds of the row sums of K over these boxes. Output: an interval that contains the row sums
//! of f K/4, so that it contains the spectrum of each such matrix (Gershgorin).

use core::marker::PhantomData;

use super::Row;
use super::passes::{Factors, PARTS, Pass};
use crate::lanes::dispatch::Kernel;

/// The part of a displacement over which a box extends beyond both its ends.
const BEYOND: f64 = 0.25;

/// The part of the largest displacement by which each box is wider.
const WIDER: f64 = 0.25;

/// Returns the half width of the box of a displacement of the node, the half of a displacement d of
/// the site.
#[inline(always)]
fn half_width(d: f64, largest: f64) -> f64 {
    0.5 * ((0.5 + BEYOND) * d.abs() + WIDER * largest)
}

/// Writes the middle and the half width of the box of each node: from q₀ to q₀ + d/2 and beyond.
pub(super) struct Boxes<'a, R> {
    pub(super) rows: &'a mut [f64],
    pub(super) q: &'a [R],
    pub(super) d: &'a [R],
    pub(super) largest: f64,
}

impl<R: Row> Kernel for Boxes<'_, R> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let size = R::LENGTH;
        let (q, d) = (R::numbers(self.q), R::numbers(self.d));
        let rows = self.rows.chunks_exact_mut(2 * size);
        for ((row, q), d) in rows.zip(q.chunks_exact(size)).zip(d.chunks_exact(size)) {
            for k in 0..size {
                row[k] = q[k] + 0.25 * d[k];
                row[size + k] = half_width(d[k], self.largest);
            }
        }
    }
}

/// The test whether the boxes around displacements contain other displacements.
pub(super) struct BoxesContain<'a> {
    pub(super) d: &'a [f64],
    /// The displacements around which the boxes are, and the largest one.
    pub(super) of: &'a [f64],
    pub(super) largest: f64,
}

impl Kernel for BoxesContain<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let mut is_contained = true;
        for (d, of) in self.d.iter().zip(self.of) {
            // distance of the node at the solution from the middle of its box
            let distance = (0.5 * d - 0.25 * of).abs();
            is_contained &= distance <= half_width(*of, self.largest);
        }
        is_contained
    }
}

/// The smallest and the largest bound of the row sums; NaN if a bound is.
pub(super) struct Extremes<'a, R> {
    pub(super) bounds: &'a [f64],
    pub(super) row: PhantomData<R>,
}

impl<R: Row> Pass for Extremes<'_, R> {
    type Output = [f64; 2];

    #[inline(always)]
    fn components(&self) -> usize {
        self.bounds.len() / 2
    }

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> [f64; 2] {
        let sites = self.components() / R::LENGTH;
        let bounds = &self.bounds[..2 * R::LENGTH * sites];
        let mut parts = Parts {
            lower: [f64::INFINITY; PARTS],
            minus_upper: [f64::INFINITY; PARTS],
            bits: [0; PARTS],
        };
        let whole = sites - sites % PARTS;
        for first in (0..whole).step_by(PARTS) {
            parts.add::<R>(first, PARTS, bounds, &factor);
        }
        parts.add::<R>(whole, sites - whole, bounds, &factor);
        // NaN may have a sign
        if parts.bits.into_iter().any(|bits| bits << 1 != 0) {
            return [f64::NAN; 2];
        }
        let smallest = |parts: [f64; PARTS]| parts.into_iter().fold(f64::INFINITY, f64::min);
        [smallest(parts.lower), -smallest(parts.minus_upper)]
    }
}

/// Partial extremes.
struct Parts {
    lower: [f64; PARTS],
    minus_upper: [f64; PARTS],
    /// 0 if all bounds are finite.
    bits: [u64; PARTS],
}

impl Parts {
    /// Adds the bounds of sites.
    #[inline(always)]
    fn add<R: Row>(
        &mut self,
        first: usize,
        sites: usize,
        bounds: &[f64],
        factor: &impl Fn(usize) -> f64,
    ) {
        let size = R::LENGTH;
        for k in 0..size {
            for part in 0..sites {
                let site = first + part;
                let factor = 0.25 * factor(site * size + k);
                let row = 2 * site * size + k;
                let [a, b] = [factor * bounds[row], factor * bounds[row + size]];
                let width = a - b;
                // the difference of two infinite numbers is NaN
                #[allow(clippy::eq_op)]
                let bits = (width - width).to_bits();
                self.bits[part] |= bits;
                self.lower[part] = smaller(self.lower[part], smaller(a, b));
                self.minus_upper[part] = smaller(self.minus_upper[part], smaller(-a, -b));
            }
        }
    }
}

#[inline(always)]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Returns the component with the worst bounds: those that are no numbers, else the lowest lower
/// bound if it is at most −1, else the highest upper one.
#[cold]
pub(super) fn worst<R: Row>(bounds: &[f64], factors: &Factors) -> usize {
    let size = R::LENGTH;
    let badness = |at: usize| {
        let row = &bounds[at / size * 2 * size..][..2 * size];
        let [a, b] = [row[at % size], row[size + at % size]].map(|x| 0.25 * factors.of(at) * x);
        if !(a - b).is_finite() {
            return f64::INFINITY;
        }
        let (lower, upper) = (a.min(b), a.max(b));
        // larger than any upper bound, and the larger the lower it is
        if lower <= -1.0 {
            f64::MAX * (1.0 + 0.5 / lower)
        } else {
            upper
        }
    };
    let all = 0..bounds.len() / 2;
    let worst = all.max_by(|&a, &b| badness(a).total_cmp(&badness(b)));
    worst.unwrap_or_default()
}

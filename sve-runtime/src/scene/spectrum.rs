//! Bounds of the spectrum of the equations of a midpoint step.
//!
//! With the displacement d, the equations are `d − f (p₀ + I(q₀ + d/2)/2) = 0` and their Jacobian is
//! `1 + f K/4` with `K = −∂I/∂q`. Input: a box around the start and the solution for each site, and
//! the bounds of the row sums of K over these boxes. Output: an interval that contains the row sums
//! of f K/4, so that it contains the spectrum of each such matrix (Gershgorin).

use super::Row;
use super::passes::{Factors, Pass};

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
#[inline(always)]
pub(super) fn write_boxes<R: Row>(boxes: &mut [f64], q: &[f64], d: &[f64], largest: f64) {
    let size = R::LENGTH;
    let rows = boxes.chunks_exact_mut(2 * size);
    for ((row, q), d) in rows.zip(q.chunks_exact(size)).zip(d.chunks_exact(size)) {
        for k in 0..size {
            row[k] = q[k] + 0.25 * d[k];
            row[size + k] = half_width(d[k], largest);
        }
    }
}

/// The test whether the boxes around guessed displacements, those with the momenta of the start,
/// contain the solution.
pub(super) struct BoxesContain<'a> {
    pub(super) d: &'a [f64],
    pub(super) p: &'a [f64],
    /// The largest guess.
    pub(super) largest: f64,
}

impl Pass for BoxesContain<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> bool {
        let mut is_contained = true;
        for (at, (&d, &p)) in self.d.iter().zip(self.p).enumerate() {
            let guess = factor(at) * p;
            // distance of the node at the solution from the middle of its box
            let distance = (0.5 * d - 0.25 * guess).abs();
            is_contained &= distance <= half_width(guess, self.largest);
        }
        is_contained
    }
}

/// The smallest and the largest bound of the row sums; NaN if a bound is.
pub(super) struct Extremes<'a> {
    pub(super) bounds: &'a [f64],
    /// Components of a site.
    pub(super) size: usize,
}

impl Pass for Extremes<'_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run(self, factor: impl Fn(usize) -> f64) -> [f64; 2] {
        let size = self.size;
        let (mut lower, mut upper, mut poison) = (f64::INFINITY, f64::NEG_INFINITY, 0.0);
        for (site, row) in self.bounds.chunks_exact(2 * size).enumerate() {
            for k in 0..size {
                let factor = 0.25 * factor(site * size + k);
                let (a, b) = (factor * row[k], factor * row[size + k]);
                // 0 for finite numbers
                poison += (a - a) + (b - b);
                let (low, high) = if a < b { (a, b) } else { (b, a) };
                lower = if low < lower { low } else { lower };
                upper = if high > upper { high } else { upper };
            }
        }
        [lower + poison, upper + poison]
    }
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

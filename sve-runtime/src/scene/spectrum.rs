//! Bounds of the spectrum of the equations of a midpoint step.
//!
//! With the displacement d, the equations are `d − f (p₀ + I(q₀ + d/2)/2) = 0` and their Jacobian
//! is `1 + f K/4` with `K = −∂I/∂q`. Input: a box around the start and the solution for each site,
//! and the bounds of the row sums of K over these boxes. Output: an interval that contains the row
//! sums of f K/4, so that it contains the spectrum of each such matrix (Gershgorin).

use core::ops::Range;

use super::Row;
use super::gather::Sink;
use super::passes::Factor;
use super::segments::TILE;

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

/// Returns whether the box around the displacement `of` contains the displacement `d`: the distance
/// of its node from the middle of the box is at most the half width.
#[inline(always)]
pub(super) fn is_in_box(d: f64, of: f64, largest: f64) -> bool {
    (0.5 * d - 0.25 * of).abs() <= half_width(of, largest)
}

/// Returns the middle and the half width of the box of a motion h v: from the one without impulses,
/// `first`, to the one `of`, and beyond.
#[inline(always)]
fn box_of_motion(of: f64, first: f64, largest: f64) -> [f64; 2] {
    let half = (0.5 + BEYOND) * (of - first).abs() + WIDER * largest;
    [0.5 * (of + first), half]
}

/// Returns whether such a box contains the motion.
#[inline(always)]
pub(super) fn is_in_box_of_motion(motion: f64, [of, first]: [f64; 2], largest: f64) -> bool {
    let [middle, half] = box_of_motion(of, first, largest);
    (motion - middle).abs() <= half
}

/// The bounds of the row sums of f K/4 at the nodes in boxes: from q₀ to q₀ + d/2 and beyond.
pub(super) struct Spectrum<'a, N, U> {
    /// The middle and the half width of the box of each node.
    pub(super) boxes: &'a mut [N],
    /// The boxes of the velocities, in a scene with forces of velocities or H₁.
    pub(super) velocities: Option<BoxesOfVelocities<'a, N>>,
    /// The number of sites whose boxes are written.
    pub(super) written: usize,
    pub(super) q: &'a [f64],
    pub(super) p: &'a [f64],
    /// The displacements d; those without impulses, f p₀, if it is empty.
    pub(super) d: &'a [f64],
    /// The largest displacement.
    pub(super) largest: f64,
    pub(super) to: U,
}

/// The boxes of velocities.
pub(super) struct BoxesOfVelocities<'a, N> {
    pub(super) boxes: &'a mut [N],
    pub(super) h: f64,
    /// The velocities v around which the boxes are and the largest change of a motion h v, in a
    /// scene with H₁. In another one velocities belong to displacements.
    pub(super) around: Option<(&'a [f64], f64)>,
}

/// The use of the bounds of the row sums. Functions are `#[inline(always)]`.
pub(super) trait Bounds {
    /// Takes a lower and an upper bound of each component of consecutive sites of `size`
    /// components, beginning with the component `first`.
    fn take(&mut self, first: usize, size: usize, bounds: &[f64], factors: impl Factor);
}

impl<N: Row, U: Bounds> Sink<N> for Spectrum<'_, N, U> {
    #[inline(always)]
    fn nodes(&mut self, ready: usize, factors: impl Factor) -> &[N] {
        if self.written < ready {
            let tiles = self.written..ready.next_multiple_of(TILE).min(self.boxes.len());
            self.written = tiles.end;
            let size = N::LENGTH / 2;
            let here = tiles.start * size..tiles.end * size;
            let boxes = N::numbers_mut(&mut self.boxes[tiles.clone()]);
            let [q, p] = [self.q, self.p].map(|x| &x[here.clone()]);
            let (factors, largest) = (factors.within(here.clone()), self.largest);
            let first = |at: usize| factors.of(at) * p[at];
            let d = if self.d.is_empty() {
                write_boxes(boxes, q, size, first, largest);
                &[]
            } else {
                let d = &self.d[here.clone()];
                write_boxes(boxes, q, size, |at| d[at], largest);
                d
            };
            if let Some(BoxesOfVelocities { boxes, h, around }) = &mut self.velocities {
                let (boxes, h, around) = (N::numbers_mut(&mut boxes[tiles]), *h, *around);
                write_boxes_of_velocities(boxes, size, h, |at| match around {
                    Some((v, largest)) => box_of_motion(h * v[here.start + at], first(at), largest),
                    None => {
                        let d = d.get(at).copied().unwrap_or_else(|| first(at));
                        [0.5 * d, 2.0 * half_width(d, largest)]
                    }
                });
            }
        }
        self.boxes
    }

    #[inline(always)]
    fn motion(&mut self) -> [&[N]; 2] {
        let v = self.velocities.as_ref();
        [self.boxes, v.map_or(&[], |v| &*v.boxes)]
    }

    /// The derivatives of the impulses of H₁ are bounded after the sweep.
    #[inline(always)]
    fn with_momenta(&mut self) -> Option<[&[N]; 2]> {
        None
    }

    /// These have to be bounded alone too: in a shorter step, the impulses of potentials are
    /// smaller beside them.
    #[inline(always)]
    fn see_drags(&mut self, drags: &[N], factors: impl Factor) {
        self.take(0..drags.len(), drags, factors);
    }

    #[inline(always)]
    fn take(&mut self, nodes: Range<usize>, sums: &[N], factors: impl Factor) {
        let size = N::LENGTH / 2;
        let first = nodes.start * size;
        let factors = factors.within(first..nodes.end * size);
        self.to.take(first, size, N::numbers(sums), factors);
    }
}

/// Writes the boxes of nodes m.
#[inline(always)]
fn write_boxes(boxes: &mut [f64], q: &[f64], size: usize, d: impl Fn(usize) -> f64, largest: f64) {
    for (site, row) in boxes.chunks_exact_mut(2 * size).enumerate() {
        for k in 0..size {
            let at = site * size + k;
            let d = d(at);
            row[k] = q[at] + 0.25 * d;
            row[size + k] = half_width(d, largest);
        }
    }
}

/// Writes the boxes of velocities v, from the middles and half widths of the motions h v.
#[inline(always)]
fn write_boxes_of_velocities(
    boxes: &mut [f64],
    size: usize,
    h: f64,
    motion: impl Fn(usize) -> [f64; 2],
) {
    for (site, row) in boxes.chunks_exact_mut(2 * size).enumerate() {
        for k in 0..size {
            let [middle, half] = motion(site * size + k);
            row[k] = middle / h;
            row[size + k] = half / h.abs();
        }
    }
}

/// The smallest and the largest bound, as integers in the order of the numbers, so that loops are
/// made in vectors.
#[derive(Clone, Copy)]
pub(super) struct Extremes {
    lower: i64,
    upper: i64,
    /// 0 if all bounds are finite.
    bits: u64,
}

/// Returns the bits of a number as an integer in the order of numbers, or a number of such an
/// integer.
#[inline(always)]
fn ordered(bits: i64) -> i64 {
    bits ^ ((bits >> 63) & i64::MAX)
}

impl Default for Extremes {
    fn default() -> Self {
        Self {
            lower: i64::MAX,
            upper: i64::MIN,
            bits: 0,
        }
    }
}

impl Extremes {
    /// Returns the smallest and the largest bound; NaN if a bound is, zeros if there is none.
    pub(super) fn values(&self) -> [f64; 2] {
        // NaN may have a sign
        if self.bits << 1 != 0 {
            return [f64::NAN; 2];
        }
        if self.lower > self.upper {
            return [0.0; 2];
        }
        [self.lower, self.upper].map(|x| f64::from_bits(ordered(x).cast_unsigned()))
    }
}

impl Bounds for Extremes {
    #[inline(always)]
    fn take(&mut self, _: usize, size: usize, bounds: &[f64], factors: impl Factor) {
        let mut extremes = *self;
        let factors = factors.within(0..bounds.len() / 2);
        for at in 0..bounds.len() {
            let bound = 0.25 * factors.of(at / (2 * size) * size + at % size) * bounds[at];
            // the difference of two infinite numbers is NaN
            #[allow(clippy::eq_op)]
            let bits = (bound - bound).to_bits();
            extremes.bits |= bits;
            let bound = ordered(bound.to_bits().cast_signed());
            extremes.lower = extremes.lower.min(bound);
            extremes.upper = extremes.upper.max(bound);
        }
        *self = extremes;
    }
}

/// The component with the worst bounds: those that are no numbers, else the lowest lower bound if
/// it is at most −1, else the highest upper one. With its badness.
#[derive(Default)]
pub(super) struct Worst {
    pub(super) at: usize,
    badness: f64,
}

impl Bounds for Worst {
    #[inline(always)]
    fn take(&mut self, first: usize, size: usize, bounds: &[f64], factors: impl Factor) {
        for (site, row) in bounds.chunks_exact(2 * size).enumerate() {
            for k in 0..size {
                let factor = 0.25 * factors.of(site * size + k);
                let badness = badness([row[k], row[size + k]].map(|x| factor * x));
                if badness >= self.badness {
                    let at = first + site * size + k;
                    *self = Self { at, badness };
                }
            }
        }
    }
}

fn badness([a, b]: [f64; 2]) -> f64 {
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
}

//! A drift: sites move with their velocities, and friction acts before and after.

use core::ops::Range;

use super::Row;
use super::masses::InverseMasses;
use crate::lanes::dispatch::Kernel;

/// A motion of all sites with their velocities.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drift<'a> {
    pub(super) masses: &'a InverseMasses,
    /// The friction of each component divided by its mass; empty without friction.
    pub(super) rates: &'a [f64],
    /// The time of the motion.
    pub(super) h: f64,
    /// The times over which friction acts before it and after it.
    pub(super) friction: [f64; 2],
}

/// A drift of all nodes.
pub(super) struct DriftAlone<'a, R> {
    pub(super) drift: Drift<'a>,
    pub(super) q: &'a mut [R],
    pub(super) p: &'a mut [R],
    pub(super) is_tested: bool,
}

impl<R: Row> Kernel for DriftAlone<'_, R> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        let nodes = 0..self.q.len();
        drift::<R>(self.q, self.p, nodes, &self.drift, self.is_tested)
    }
}

/// Moves some nodes with their velocities. Returns whether the results are finite, if they are
/// tested.
#[inline(always)]
pub(super) fn drift<R: Row>(
    q: &mut [R],
    p: &mut [R],
    nodes: Range<usize>,
    drift: &Drift<'_>,
    is_tested: bool,
) -> bool {
    let first = nodes.start * R::LENGTH;
    let (q, p) = (&mut q[nodes.clone()], &mut p[nodes]);
    let (q, p) = (R::numbers_mut(q), R::numbers_mut(p));
    let Drift {
        masses, rates, h, ..
    } = *drift;
    if rates.is_empty() {
        match masses {
            InverseMasses::Uniform(inverse) => shift(q, p, h * inverse),
            InverseMasses::Each(inverse) => shift_each(q, p, &inverse[first..], h),
        }
        return !is_tested || are_finite(q);
    }
    damp(p, &rates[first..], |p, rate| {
        p / (1.0 + drift.friction[0] * rate)
    });
    match masses {
        InverseMasses::Uniform(inverse) => shift(q, p, h * inverse),
        InverseMasses::Each(inverse) => shift_each(q, p, &inverse[first..], h),
    }
    damp(p, &rates[first..], |p, rate| {
        p * (1.0 - drift.friction[1] * rate)
    });
    !is_tested || (are_finite(q) && are_finite(p))
}

#[inline(always)]
fn damp(p: &mut [f64], rates: &[f64], by: impl Fn(f64, f64) -> f64) {
    for (p, &rate) in p.iter_mut().zip(rates) {
        *p = by(*p, rate);
    }
}

#[inline(always)]
fn shift(q: &mut [f64], p: &[f64], factor: f64) {
    for (q, p) in q.iter_mut().zip(p) {
        *q += factor * p;
    }
}

#[inline(always)]
fn shift_each(q: &mut [f64], p: &[f64], inverse: &[f64], h: f64) {
    for ((q, p), inverse) in q.iter_mut().zip(p).zip(inverse) {
        *q += h * inverse * p;
    }
}

/// The test whether all numbers are finite.
pub(super) struct AreFinite<'a>(pub(super) &'a [f64]);

impl Kernel for AreFinite<'_> {
    type Output = bool;

    #[inline(always)]
    fn run(self) -> bool {
        are_finite(self.0)
    }
}

#[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
#[inline(always)]
pub(super) fn are_finite(numbers: &[f64]) -> bool {
    (numbers.iter()).fold(0, |bits, x| bits | (x - x).to_bits()) == 0
}

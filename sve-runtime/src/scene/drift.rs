//! A drift: sites move with their velocities, and friction acts before and after.

use core::ops::Range;

use super::Row;
use super::masses::InverseMasses;
use super::segments::TILE;
use super::sweep::Place;
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

impl Drift<'_> {
    /// Moves some nodes. If the drift is tested and a result is not finite, returns its array and
    /// its number; nothing has then changed, unless there is friction.
    #[inline(always)]
    pub(super) fn nodes<R: Row>(
        &self,
        q: &mut [R],
        p: &mut [R],
        nodes: Range<usize>,
        is_tested: bool,
    ) -> Result<(), (&'static str, usize)> {
        let first = nodes.start * R::LENGTH;
        let (q, p) = (&mut q[nodes.clone()], &mut p[nodes]);
        let (q, p) = (R::numbers_mut(q), R::numbers_mut(p));
        let Self {
            masses, rates, h, ..
        } = *self;
        let has_friction = !rates.is_empty();
        if has_friction {
            damp(p, &rates[first..], |p, rate| {
                p / (1.0 + self.friction[0] * rate)
            });
        }
        let is_moved = match masses {
            InverseMasses::Uniform(inverse) => shift(q, p, h * inverse, is_tested),
            InverseMasses::Each(inverse) => shift_each(q, p, &inverse[first..], h, is_tested),
        };
        if has_friction && is_moved {
            damp(p, &rates[first..], |p, rate| {
                p * (1.0 - self.friction[1] * rate)
            });
        }
        if is_moved && !(is_tested && has_friction && !are_finite(p)) {
            return Ok(());
        }
        let velocity = |at: usize| h * masses.of(first + at) * p[at];
        let is_moved = |at: usize| (q[at] + velocity(at)).is_finite();
        Err(match p.iter().position(|p| !p.is_finite()) {
            Some(at) => ("p", first + at),
            None => (
                "q",
                first + (0..q.len()).position(|at| !is_moved(at)).unwrap_or(0),
            ),
        })
    }

    /// Moves all nodes.
    ///
    /// # Errors
    /// A number that is not finite, if numbers are tested.
    #[inline(always)]
    pub(super) fn all<R: Row>(
        &self,
        q: &mut [R],
        p: &mut [R],
        is_tested: bool,
    ) -> Result<(), Place> {
        for moved in (0..q.len()).step_by(TILE) {
            let nodes = moved..(moved + TILE).min(q.len());
            let result = self.nodes(q, p, nodes, is_tested);
            result.map_err(|at| Place::new(at, moved, 0))?;
        }
        Ok(())
    }
}

#[inline(always)]
fn damp(p: &mut [f64], rates: &[f64], by: impl Fn(f64, f64) -> f64) {
    for (p, &rate) in p.iter_mut().zip(rates) {
        *p = by(*p, rate);
    }
}

/// Moves numbers, unless they are tested and a result is not finite.
#[inline(always)]
fn shift(q: &mut [f64], p: &[f64], factor: f64, is_tested: bool) -> bool {
    if is_tested && !all_finite(q.iter().zip(p).map(|(q, p)| q + factor * p)) {
        return false;
    }
    for (q, p) in q.iter_mut().zip(p) {
        *q += factor * p;
    }
    true
}

#[inline(always)]
fn shift_each(q: &mut [f64], p: &[f64], inverse: &[f64], h: f64, is_tested: bool) -> bool {
    let moved = q.iter().zip(p).zip(inverse);
    if is_tested && !all_finite(moved.map(|((q, p), inverse)| q + h * inverse * p)) {
        return false;
    }
    for ((q, p), inverse) in q.iter_mut().zip(p).zip(inverse) {
        *q += h * inverse * p;
    }
    true
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

/// Returns whether all numbers are finite.
#[inline(always)]
pub(super) fn are_finite(numbers: &[f64]) -> bool {
    all_finite(numbers.iter().copied())
}

#[inline(always)]
pub(super) fn all_finite(numbers: impl Iterator<Item = f64>) -> bool {
    numbers.fold(0, |bits, x| bits | not_finite(x)) == 0
}

/// Returns zero if a number is finite.
#[allow(clippy::eq_op)] // the difference of two infinite numbers is NaN
#[inline(always)]
pub(super) fn not_finite(x: f64) -> u64 {
    (x - x).to_bits()
}

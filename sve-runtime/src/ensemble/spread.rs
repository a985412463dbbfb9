//! The spread of the values of an observable over the paths: a variance comes from many paths, or
//! from a few.
//!
//! Input: the moments of a level of the multilevel method. Output: the number of paths that the
//! level needs before its variance is trusted. Invariant: a level is resolved at last, whatever its
//! values, unless they have a tail without a variance.
//!
//! The paths whose values differ, or differ most, carry the variance. If few of n paths do, as for
//! a rare event, its estimate is off by as much as their number may be, and it is 0 if none does.

use super::moments::Column;

/// Least number of paths that have to carry a variance: the relative error of its estimate is then
/// about 1/√8.
pub(super) const CARRIERS: f64 = 8.0;

/// The spread of the values of some paths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spread {
    /// The greatest value less the least one.
    pub(super) range: f64,
    /// The number of paths with the greatest deviation that would have the whole variance; 0
    /// without a variance. Of k equal values far from all others it is k, of n normal values n/(2
    /// ln n).
    pub(super) carriers: f64,
}

impl Spread {
    /// The spread at a recorded time.
    pub(super) fn of(column: &Column, record: usize) -> Self {
        let (_, share) = column.farthest(record);
        Self {
            range: column.max[record] - column.min[record],
            carriers: if share > 0.0 { 1.0 / share } else { 0.0 },
        }
    }

    /// Returns the number of paths at which a mean over them may be trusted to within `error`: 0 if
    /// enough paths carry the variance. If they do not, as many as have at most that error with
    /// [`CARRIERS`] further values that differ by `range`, the largest known difference if the
    /// paths have none themselves.
    pub(super) fn least_paths(self, largest: f64, error: f64) -> f64 {
        if self.carriers >= CARRIERS {
            return 0.0;
        }
        let range = if self.range > 0.0 {
            self.range
        } else {
            largest
        };
        CARRIERS * range / error
    }
}

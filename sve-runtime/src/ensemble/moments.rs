//! Moments of observables: count, mean, sum of squared deviations, least and greatest value at each
//! recorded time, in one pass.
//!
//! Input: the values of tiles with the mask of lanes that count. Output: columns that can be
//! merged. Invariant: stored numbers are finite or, if a deviation overflowed, infinite, never NaN;
//! a mean is within its least and greatest value, and equal values have a sum of squares of exactly
//! 0; without values the mean and the squares are 0 and the extremes ±∞. Sums over the lanes of a
//! tile are formed by halves, so they have the same bits for vectors of any width.
//!
//! Source: T. F. Chan, G. H. Golub, R. J. `LeVeque`, *Updating formulae and a pairwise algorithm
//! for computing sample variances*, COMPSTAT (1982).

use crate::lanes::{LANES, Lane, Mask};

/// An observable over all recorded times.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Column {
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) mean: Vec<f64>,
    /// Sums of squared deviations from the mean, in the unit of `unit`.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) squares: Vec<f64>,
    /// The unit of each deviation, see [`Squares`].
    pub(super) unit: Vec<i8>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) min: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) max: Vec<f64>,
}

/// Bytes of a column for each recorded time.
pub(super) const COLUMN_BYTES: u64 = 4 * 8 + 1;

impl Column {
    pub(super) fn new(records: usize) -> Self {
        Self {
            mean: vec![0.0; records],
            squares: vec![0.0; records],
            unit: vec![0; records],
            min: vec![f64::INFINITY; records],
            max: vec![f64::NEG_INFINITY; records],
        }
    }

    /// Adds the values of a tile to `count` earlier ones.
    #[inline]
    pub(super) fn add(&mut self, record: usize, count: u64, values: &Lane, lanes: Mask) {
        let tile = Moments::of(values, lanes);
        let merged = self.at(record, count).merge(&tile);
        self.set(record, &merged);
    }

    /// Adds the values of another column.
    pub(super) fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
        for record in 0..self.mean.len() {
            let merged = self
                .at(record, counts[record])
                .merge(&other.at(record, others[record]));
            self.set(record, &merged);
        }
    }

    /// Returns whether the column has so many records, each with a valid unit.
    #[cfg(feature = "serde")]
    pub(super) fn fits(&self, records: usize) -> bool {
        [&self.mean, &self.squares, &self.min, &self.max]
            .into_iter()
            .all(|values| values.len() == records)
            && self.unit.len() == records
            && self.unit.iter().all(|unit| (-1..=1).contains(unit))
    }

    /// The sum of squared deviations at a recorded time.
    #[inline]
    pub(super) fn squares_at(&self, record: usize) -> Squares {
        Squares {
            value: self.squares[record],
            unit: self.unit[record],
        }
    }

    /// Returns the value that is farthest from the mean at a recorded time, and its part of the sum
    /// of squared deviations; NaN if that is 0.
    pub(super) fn farthest(&self, record: usize) -> (f64, f64) {
        let (mean, min, max) = (self.mean[record], self.min[record], self.max[record]);
        let value = if max - mean > mean - min { max } else { min };
        let share = ((value - mean) / self.squares_at(record).sqrt()).powi(2);
        (value, share)
    }

    #[inline]
    fn at(&self, record: usize, count: u64) -> Moments {
        Moments {
            count: count as f64,
            mean: self.mean[record],
            squares: self.squares_at(record),
            min: self.min[record],
            max: self.max[record],
        }
    }

    #[inline]
    fn set(&mut self, record: usize, moments: &Moments) {
        self.mean[record] = moments.mean;
        self.squares[record] = moments.squares.value;
        self.unit[record] = moments.squares.unit;
        self.min[record] = moments.min;
        self.max[record] = moments.max;
    }
}

/// A sum of squared deviations: `value` times the square of 2^(600 `unit`), with a unit of −1, 0 or
/// 1.
///
/// Squares of deviations of 1e-200 or 1e200 are outside of the range of `f64`. The unit of all
/// other deviations is 0, so that their sums are plain sums.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Squares {
    pub(super) value: f64,
    pub(super) unit: i8,
}

impl Squares {
    /// 2^600.
    const LARGE: f64 = f64::from_bits((1023 + 600) << 52);
    /// 2^−600.
    const SMALL: f64 = f64::from_bits((1023 - 600) << 52);
    /// Largest deviation of unit 0, 2^450: the sum of 2^64 such squares is below 2^1024.
    const LARGEST: f64 = f64::from_bits((1023 + 450) << 52);
    /// Least deviation of unit 0, 2^−450: its square keeps all its digits, even if another square
    /// of the sum is far smaller.
    const LEAST: f64 = f64::from_bits((1023 - 450) << 52);

    /// Returns the unit in which squares of deviations up to this one neither overflow nor
    /// underflow.
    #[inline]
    fn unit(largest: f64) -> i8 {
        // an infinite deviation has the unit 0: its square is infinite in any unit
        if largest > Self::LARGEST && largest < f64::INFINITY {
            1
        } else if largest < Self::LEAST && largest > 0.0 {
            -1
        } else {
            0
        }
    }

    /// Converts a deviation to a unit.
    #[inline]
    fn in_unit(deviation: f64, unit: i8) -> f64 {
        match unit {
            0 => deviation,
            1 => deviation * Self::SMALL,
            _ => deviation * Self::LARGE,
        }
    }

    /// Returns `weight` times the square of a deviation.
    #[inline]
    fn of(deviation: f64, weight: f64) -> Self {
        let unit = Self::unit(deviation.abs());
        let deviation = Self::in_unit(deviation, unit);
        Self {
            value: deviation * deviation * weight,
            unit,
        }
    }

    #[inline]
    fn add(self, other: Self) -> Self {
        if self.unit == other.unit {
            return Self {
                value: self.value + other.value,
                unit: self.unit,
            };
        }
        self.add_of_other_unit(other)
    }

    #[cold]
    fn add_of_other_unit(self, other: Self) -> Self {
        if self.value == 0.0 {
            return other;
        }
        if other.value == 0.0 {
            return self;
        }
        let (coarse, mut fine) = if self.unit > other.unit {
            (self, other)
        } else {
            (other, self)
        };
        while fine.unit < coarse.unit {
            fine.value = fine.value * Self::SMALL * Self::SMALL;
            fine.unit += 1;
        }
        Self {
            value: coarse.value + fine.value,
            unit: coarse.unit,
        }
    }

    /// Divides the sum by a count.
    pub(super) fn over(self, count: f64) -> Self {
        Self {
            value: self.value / count,
            ..self
        }
    }

    /// Returns the number itself; 0 or ∞ outside of the range of `f64`.
    pub(super) fn get(self) -> f64 {
        let Self { value, unit } = self;
        match unit {
            0 => value,
            1 => value * Self::LARGE * Self::LARGE,
            _ => value * Self::SMALL * Self::SMALL,
        }
    }

    /// Returns the square root, which is within the range of `f64` as the deviations are.
    pub(super) fn sqrt(self) -> f64 {
        let root = self.value.sqrt();
        match self.unit {
            0 => root,
            1 => root * Self::LARGE,
            _ => root * Self::SMALL,
        }
    }
}

/// Moments of a set of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moments {
    count: f64,
    mean: f64,
    squares: Squares,
    min: f64,
    max: f64,
}

impl Moments {
    /// Returns the moments of the values of some lanes, by two passes.
    #[inline]
    fn of(values: &Lane, lanes: Mask) -> Self {
        let counted: [bool; LANES] = core::array::from_fn(|lane| lanes >> lane & 1 == 1);
        let select = |lane: usize, x: f64, other: f64| if counted[lane] { x } else { other };
        let count = f64::from(lanes.count_ones());
        let low = core::array::from_fn(|lane| select(lane, values[lane], f64::INFINITY));
        let high = core::array::from_fn(|lane| select(lane, values[lane], f64::NEG_INFINITY));
        let min = by_halves(low, |a, b| if b < a { b } else { a });
        let max = by_halves(high, |a, b| if b > a { b } else { a });
        let masked: Lane = core::array::from_fn(|lane| select(lane, values[lane], 0.0));
        let mut mean = by_halves(masked, |a, b| a + b) / count.max(1.0);
        if !mean.is_finite() {
            mean = by_halves(masked.map(|x| x / count), |a, b| a + b);
        }
        let mean = within(mean, min, max);
        let deviations: Lane = core::array::from_fn(|lane| select(lane, values[lane] - mean, 0.0));
        // The mean is between the least and the greatest value, so the deviation of one of them is
        // the largest.
        let unit = Squares::unit((max - mean).max(mean - min));
        let squared = if unit == 0 {
            deviations.map(|deviation| deviation * deviation)
        } else {
            deviations.map(|deviation| Squares::in_unit(deviation, unit).powi(2))
        };
        Self {
            count,
            mean,
            squares: Squares {
                value: by_halves(squared, |a, b| a + b),
                unit,
            },
            min,
            max,
        }
    }

    /// Returns the moments of the union of two sets.
    #[inline]
    fn merge(&self, other: &Self) -> Self {
        if other.count == 0.0 {
            return *self;
        }
        if self.count == 0.0 {
            return *other;
        }
        let count = self.count + other.count;
        let share = other.count / count;
        let difference = other.mean - self.mean;
        let mut mean = self.mean + difference * share;
        if !difference.is_finite() {
            mean = self.mean * (self.count / count) + other.mean * share;
        }
        let min = if other.min < self.min {
            other.min
        } else {
            self.min
        };
        let max = if other.max > self.max {
            other.max
        } else {
            self.max
        };
        Self {
            count,
            mean: within(mean, min, max),
            squares: (self.squares)
                .add(other.squares)
                .add(Squares::of(difference, self.count * share)),
            min,
            max,
        }
    }
}

/// Clamps a mean to the range of the values, which rounding errors can make it leave.
#[inline]
fn within(mean: f64, min: f64, max: f64) -> f64 {
    // without values `min` is above `max`
    if mean < min && min <= max {
        min
    } else if mean > max && min <= max {
        max
    } else {
        mean
    }
}

/// Reduces the lanes to one value, by combining the upper half with the lower half repeatedly.
#[inline]
pub(super) fn by_halves(mut values: Lane, join: impl Fn(f64, f64) -> f64) -> f64 {
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            values[lane] = join(values[lane], values[lane + half]);
        }
        half /= 2;
    }
    values[0]
}

#[cfg(test)]
mod tests;

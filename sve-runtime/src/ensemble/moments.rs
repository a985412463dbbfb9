//! Count, mean, sum of squared deviations, least and greatest value at each recorded time, in one pass.
//!
//! Input: tiles of values with the set of lanes that count. Output: columns that can be merged.
//! Invariant: what is stored is finite or, where it overflowed, infinite, never NaN; without values the mean and the
//! squares are 0 and the extremes ±∞. Sums over the lanes of a tile go by halves, so they have the same bits for vectors of any width.
//!
//! Source: T. F. Chan, G. H. Golub, R. J. `LeVeque`, *Updating formulae and a pairwise algorithm for computing sample variances*, COMPSTAT (1982).

use crate::lanes::{LANES, Lane, Mask};

/// An observable over all recorded times.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Column {
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) mean: Vec<f64>,
    /// Sums of squared deviations from the mean.
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) squares: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) min: Vec<f64>,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    pub(super) max: Vec<f64>,
}

impl Column {
    pub(super) fn new(records: usize) -> Self {
        Self {
            mean: vec![0.0; records],
            squares: vec![0.0; records],
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

    /// Adds what another column has.
    pub(super) fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
        for record in 0..self.mean.len() {
            let merged = self
                .at(record, counts[record])
                .merge(&other.at(record, others[record]));
            self.set(record, &merged);
        }
    }

    #[inline]
    fn at(&self, record: usize, count: u64) -> Moments {
        Moments {
            count: count as f64,
            mean: self.mean[record],
            squares: self.squares[record],
            min: self.min[record],
            max: self.max[record],
        }
    }

    #[inline]
    fn set(&mut self, record: usize, moments: &Moments) {
        self.mean[record] = moments.mean;
        self.squares[record] = moments.squares;
        self.min[record] = moments.min;
        self.max[record] = moments.max;
    }
}

/// Moments of a set of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Moments {
    count: f64,
    mean: f64,
    squares: f64,
    min: f64,
    max: f64,
}

impl Moments {
    /// Of the values of some lanes, by two passes over them.
    #[inline]
    fn of(values: &Lane, lanes: Mask) -> Self {
        let counted: [bool; LANES] = core::array::from_fn(|lane| lanes >> lane & 1 == 1);
        let select = |lane: usize, x: f64, other: f64| if counted[lane] { x } else { other };
        let count = f64::from(lanes.count_ones());
        let masked: Lane = core::array::from_fn(|lane| select(lane, values[lane], 0.0));
        let mut mean = by_halves(masked, |a, b| a + b) / count.max(1.0);
        if !mean.is_finite() {
            mean = by_halves(masked.map(|x| x / count), |a, b| a + b);
        }
        let squared = core::array::from_fn(|lane| {
            let deviation = select(lane, values[lane] - mean, 0.0);
            deviation * deviation
        });
        let low = core::array::from_fn(|lane| select(lane, values[lane], f64::INFINITY));
        let high = core::array::from_fn(|lane| select(lane, values[lane], f64::NEG_INFINITY));
        Self {
            count,
            mean,
            squares: by_halves(squared, |a, b| a + b),
            min: by_halves(low, |a, b| if b < a { b } else { a }),
            max: by_halves(high, |a, b| if b > a { b } else { a }),
        }
    }

    /// Of both sets.
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
        let apart = other.mean - self.mean;
        let mut mean = self.mean + apart * share;
        if !apart.is_finite() {
            mean = self.mean * (self.count / count) + other.mean * share;
        }
        Self {
            count,
            mean,
            squares: self.squares + other.squares + apart * apart * (self.count * share),
            min: if other.min < self.min {
                other.min
            } else {
                self.min
            },
            max: if other.max > self.max {
                other.max
            } else {
                self.max
            },
        }
    }
}

/// A sum, or whatever else, over the lanes: the upper half onto the lower one, and again.
#[inline]
fn by_halves(mut values: Lane, join: impl Fn(f64, f64) -> f64) -> f64 {
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
mod tests {
    use super::{Column, LANES, Lane, Mask};

    /// Values and how they are cut into tiles: every lane, some lanes, none.
    fn column(values: &[f64], masks: &[Mask]) -> (Column, u64) {
        let mut column = Column::new(1);
        let (mut count, mut values) = (0, values.iter());
        for &mask in masks.iter().cycle() {
            // what is in the other lanes is of no matter
            let mut tile: Lane = [f64::NAN; LANES];
            let mut counted = 0;
            for lane in (0..LANES).filter(|lane| mask >> lane & 1 == 1) {
                if let Some(&value) = values.next() {
                    tile[lane] = value;
                    counted |= 1 << lane;
                }
            }
            column.add(0, count, &tile, counted);
            count += u64::from(counted.count_ones());
            if values.len() == 0 {
                break;
            }
        }
        (column, count)
    }

    #[test]
    fn agree_with_two_passes_far_from_zero() {
        // a mean 10⁸ times the deviations: sums of squares alone would have no digit left
        let values: Vec<f64> = (0..500)
            .map(|i| 1e8 + f64::from(i * 37 % 101) / 64.0)
            .collect();
        let mean = values.iter().map(|x| x - 1e8).sum::<f64>() / 500.0;
        let squares = values.iter().map(|x| (x - 1e8 - mean).powi(2)).sum::<f64>();
        for masks in [&[0xffff][..], &[0x8001, 0, 0x00f0], &[1, 0xffff]] {
            let (column, count) = column(&values, masks);
            assert_eq!(count, 500);
            assert!((column.mean[0] - 1e8 - mean).abs() < 1e-7, "{masks:?}");
            assert!(
                (column.squares[0] / squares - 1.0).abs() < 1e-9,
                "{masks:?}"
            );
            assert_eq!((column.min[0], column.max[0]), (1e8, 1e8 + 100.0 / 64.0));
        }
    }

    #[test]
    fn of_columns_that_are_merged() {
        let values: Vec<f64> = (0..300)
            .map(|i| f64::from(i * 37 % 101).sqrt() - 4.0)
            .collect();
        let (whole, _) = column(&values, &[0xffff]);
        for cut in [0, 1, 17, 150, 300] {
            let (mut left, a) = column(&values[..cut], &[0xffff]);
            let (right, b) = column(&values[cut..], &[0xffff]);
            left.merge(&[a], &right, &[b]);
            assert!((left.mean[0] - whole.mean[0]).abs() < 1e-14, "{cut}");
            assert!((left.squares[0] / whole.squares[0] - 1.0).abs() < 1e-14);
            assert_eq!((left.min[0], left.max[0]), (whole.min[0], whole.max[0]));
        }
    }

    #[test]
    fn that_overflow_are_infinite_and_not_nan() {
        let values: Vec<f64> = (0..64)
            .map(|i| if i % 32 < 16 { 1.7e308 } else { -1.7e308 })
            .collect();
        let (column, _) = column(&values, &[0xffff]);
        assert!(column.mean[0].abs() < 1e296, "{}", column.mean[0]);
        assert_eq!(column.squares[0], f64::INFINITY);
        assert_eq!((column.min[0], column.max[0]), (-1.7e308, 1.7e308));
    }
}

//! Joint moments of two observables over the paths: covariances at equal times and at two times.
//!
//! Input: the values of two observables in the lanes of tiles. Output: rows of central moments up
//! to the order (2, 2), which give the covariance and its standard error, and which can be merged.
//! Invariant: sums over the lanes of a tile are formed by halves, so they have the same bits for
//! vectors of any width.
//!
//! Source: P. Pébay, *Formulas for robust, one-pass parallel computation of covariances and
//! arbitrary-order statistical moments*, Sandia report SAND2008-6212 (2008); the standard error of
//! a covariance: M. G. Kendall, A. Stuart, *The Advanced Theory of Statistics*, vol. 1, section
//! 13.3.

use super::moments::by_halves;
use super::statistic::Recorded;
use crate::lanes::{Lane, Mask};

/// Returns the number of rows of moments, which may exceed any memory.
pub(super) fn rows(is_two_time: bool, records: u64) -> u128 {
    let records = u128::from(records);
    if is_two_time {
        records.saturating_mul(records)
    } else {
        records
    }
}

/// Bytes of a row.
pub(super) const ROW_BYTES: u128 = 8 * NUMBERS as u128;

/// Numbers of a row.
const NUMBERS: usize = 8;

/// The moments of two observables, a row for each recorded time or for each pair of two: row
/// `s · records + t`.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct JointColumn {
    /// The rows are pairs of times.
    is_two_time: bool,
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    numbers: Vec<f64>,
}

/// Two means, and sums over the paths of products of powers of the deviations from them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct JointMoments {
    pub(super) count: f64,
    mean: [f64; 2],
    pub(super) m20: f64,
    pub(super) m11: f64,
    pub(super) m02: f64,
    m21: f64,
    m12: f64,
    m22: f64,
}

impl JointColumn {
    /// Empty moments, in a number of rows that fits into memory.
    pub(super) fn new(is_two_time: bool, records: u64) -> Self {
        let rows = usize::try_from(rows(is_two_time, records)).unwrap_or(0);
        Self {
            is_two_time,
            numbers: vec![0.0; NUMBERS * rows],
        }
    }

    /// Returns whether the column has the rows of so many records.
    #[cfg(feature = "serde")]
    pub(super) fn fits(&self, is_two_time: bool, records: u64) -> bool {
        self.is_two_time == is_two_time
            && self.numbers.len() as u128 == NUMBERS as u128 * rows(is_two_time, records)
    }

    /// Adds two observables of a tile, by their numbers.
    pub(super) fn add(&mut self, [first, second]: [usize; 2], at: &Recorded<'_>) {
        let [x, y] = [&at.values[first], &at.values[second]];
        let (record, records, lanes) = (at.record, at.counts.len(), at.lanes);
        let count = at.counts[record];
        if !self.is_two_time {
            return self.add_to(record, count, x, y, lanes);
        }
        self.add_to(record * records + record, count, x, y, lanes);
        for (earlier, then) in at.history.iter().enumerate() {
            let [before_x, before_y] = [&then[first], &then[second]];
            self.add_to(earlier * records + record, count, before_x, y, lanes);
            self.add_to(record * records + earlier, count, x, before_y, lanes);
        }
    }

    fn add_to(&mut self, row: usize, count: u64, x: &Lane, y: &Lane, lanes: Mask) {
        let merged = self.at(row, count).merge(&JointMoments::of(x, y, lanes));
        self.set(row, &merged);
    }

    /// Adds the moments of other paths.
    pub(super) fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
        let records = counts.len();
        for row in 0..self.numbers.len() / NUMBERS {
            // A pair of times has the paths of the later time.
            let record = if self.is_two_time {
                (row / records).max(row % records)
            } else {
                row
            };
            let merged = (self.at(row, counts[record])).merge(&other.at(row, others[record]));
            self.set(row, &merged);
        }
    }

    pub(super) fn at(&self, row: usize, count: u64) -> JointMoments {
        let mut numbers = [0.0; NUMBERS];
        numbers.copy_from_slice(&self.numbers[NUMBERS * row..][..NUMBERS]);
        let [x, y, m20, m11, m02, m21, m12, m22] = numbers;
        JointMoments {
            count: count as f64,
            mean: [x, y],
            m20,
            m11,
            m02,
            m21,
            m12,
            m22,
        }
    }

    fn set(&mut self, row: usize, m: &JointMoments) {
        let [x, y] = m.mean;
        let numbers = [x, y, m.m20, m.m11, m.m02, m.m21, m.m12, m.m22];
        self.numbers[NUMBERS * row..][..NUMBERS].copy_from_slice(&numbers);
    }
}

impl JointMoments {
    /// Returns the moments of the values of some lanes, by two passes.
    fn of(x: &Lane, y: &Lane, lanes: Mask) -> Self {
        let sum = |term: &dyn Fn(usize) -> f64| {
            let term = |lane| {
                if lanes >> lane & 1 == 1 {
                    term(lane)
                } else {
                    0.0
                }
            };
            by_halves(core::array::from_fn(term), |a, b| a + b)
        };
        let count = f64::from(lanes.count_ones());
        let mean = [x, y].map(|values| sum(&|lane| values[lane]) / count.max(1.0));
        let u: Lane = core::array::from_fn(|lane| x[lane] - mean[0]);
        let v: Lane = core::array::from_fn(|lane| y[lane] - mean[1]);
        let moment = |i: i32, j: i32| sum(&|lane| u[lane].powi(i) * v[lane].powi(j));
        Self {
            count,
            mean,
            m20: moment(2, 0),
            m11: moment(1, 1),
            m02: moment(0, 2),
            m21: moment(2, 1),
            m12: moment(1, 2),
            m22: moment(2, 2),
        }
    }

    /// Returns the moments of the union of two sets.
    fn merge(&self, other: &Self) -> Self {
        if other.count == 0.0 {
            return *self;
        }
        if self.count == 0.0 {
            return *other;
        }
        let count = self.count + other.count;
        let share = other.count / count;
        let mean: [f64; 2] =
            core::array::from_fn(|i| self.mean[i] + (other.mean[i] - self.mean[i]) * share);
        let (a, b) = (self.about(mean), other.about(mean));
        Self {
            count,
            mean,
            m20: a.m20 + b.m20,
            m11: a.m11 + b.m11,
            m02: a.m02 + b.m02,
            m21: a.m21 + b.m21,
            m12: a.m12 + b.m12,
            m22: a.m22 + b.m22,
        }
    }

    /// Returns the moments about other means.
    fn about(&self, mean: [f64; 2]) -> Self {
        let (n, a, b) = (self.count, self.mean[0] - mean[0], self.mean[1] - mean[1]);
        Self {
            count: n,
            mean,
            m20: self.m20 + n * a * a,
            m11: self.m11 + n * a * b,
            m02: self.m02 + n * b * b,
            m21: self.m21 + b * self.m20 + 2.0 * a * self.m11 + n * a * a * b,
            m12: self.m12 + a * self.m02 + 2.0 * b * self.m11 + n * a * b * b,
            m22: self.m22
                + 2.0 * b * self.m21
                + 2.0 * a * self.m12
                + b * b * self.m20
                + a * a * self.m02
                + 4.0 * a * b * self.m11
                + n * a * a * b * b,
        }
    }

    /// Returns the covariance, with the number of paths less one as the divisor; NaN for fewer than
    /// two paths.
    pub(super) fn covariance(&self) -> f64 {
        self.for_two(self.m11 / (self.count - 1.0))
    }

    /// Returns the covariance over the product of the standard deviations; NaN if a standard
    /// deviation is 0.
    pub(super) fn correlation(&self) -> f64 {
        self.for_two(self.m11 / (self.m20.sqrt() * self.m02.sqrt()))
    }

    /// Returns the standard error of the covariance.
    pub(super) fn standard_error(&self) -> f64 {
        let n = self.count;
        let [m20, m11, m02, m22] = [self.m20, self.m11, self.m02, self.m22].map(|sum| sum / n);
        let variance = (m22 - m11 * m11) / n + (m11 * m11 + m20 * m02) / (n * (n - 1.0));
        // rounding errors of equal values
        self.for_two(if variance < 0.0 { 0.0 } else { variance.sqrt() })
    }

    fn for_two(&self, value: f64) -> f64 {
        if self.count < 2.0 { f64::NAN } else { value }
    }
}

#[cfg(test)]
mod tests {
    use super::{JointColumn, JointMoments, Lane};
    use crate::lanes::{LANES, Mask};

    fn values() -> Vec<(f64, f64)> {
        (0..96)
            .map(|i| {
                let x = f64::from(i * 37 % 101).sqrt();
                (1e3 + x, 0.3 * x * x - f64::from(i * 11 % 17))
            })
            .collect()
    }

    /// Sums of products over all values at once.
    fn naive(values: &[(f64, f64)]) -> [f64; 3] {
        let n = values.len() as f64;
        let mean = |of: fn(&(f64, f64)) -> f64| values.iter().map(of).sum::<f64>() / n;
        let (a, b) = (mean(|v| v.0), mean(|v| v.1));
        let sum = |i: i32, j: i32| {
            let terms = values
                .iter()
                .map(|(x, y)| (x - a).powi(i) * (y - b).powi(j));
            terms.sum::<f64>()
        };
        [sum(1, 1), sum(2, 2), sum(2, 1)]
    }

    #[test]
    fn moments_of_tiles_and_of_merged_columns_are_those_of_all_values() {
        let all = values();
        let column = |values: &[(f64, f64)]| {
            let mut column = JointColumn::new(false, 1);
            let mut count = 0;
            for tile in values.chunks(LANES) {
                let at = |lane: usize| tile.get(lane).copied().unwrap_or((f64::NAN, f64::NAN));
                let x: Lane = core::array::from_fn(|lane| at(lane).0);
                let y: Lane = core::array::from_fn(|lane| at(lane).1);
                let lanes = (1_u64 << tile.len()) - 1;
                column.add_to(0, count, &x, &y, lanes as Mask);
                count += tile.len() as u64;
            }
            (column, [count])
        };
        let expected = naive(&all);
        for cut in [0, 1, 40, 96] {
            let (mut left, a) = column(&all[..cut]);
            let (right, b) = column(&all[cut..]);
            left.merge(&a, &right, &b);
            let m: JointMoments = left.at(0, 96);
            for (found, expected) in [m.m11, m.m22, m.m21].into_iter().zip(expected) {
                assert!(
                    (found / expected - 1.0).abs() < 1e-10,
                    "{cut} {found} {expected}"
                );
            }
        }
    }
}

//! The moments of each observable, at each recorded time.
//!
//! Input: tiles of values; merged columns. Output: the numbers that users read. Invariant: a mean
//! of no paths and a variance of fewer than two are NaN, and nothing else is.

use core::borrow::Borrow;
use core::ops::Index;

use super::difference::Difference;
use super::moments::{COLUMN_BYTES, Column, Squares};
use super::sizes::{AT_ONCE, NUMBER};
use super::spread::Spread;
use super::statistic::{Extent, Recorded, Size, Statistic};
use super::summary::Summary;
use super::warning::{self, Warning};
use crate::lanes::{Lane, Mask};

/// The request of the moments of all observables, which every ensemble has.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct MomentsRequest;

/// The moments of each observable.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Moments(Vec<Column>);

impl Moments {
    /// Returns the memory that moments of all observables need beside their counts.
    pub(super) fn bytes(extent: &Extent<'_>) -> u128 {
        let of_paths = NUMBER + u128::from(COLUMN_BYTES) * extent.names.len() as u128;
        u128::from(extent.records) * AT_ONCE * of_paths
    }

    /// Returns the moments of each observable.
    pub(super) fn into_columns(self) -> Vec<Column> {
        self.0
    }

    /// Adds the values of a tile to `count` earlier values.
    pub(super) fn add_to(
        &mut self,
        record: usize,
        count: u64,
        values: impl IntoIterator<Item = impl Borrow<Lane>>,
        lanes: Mask,
    ) {
        for (column, values) in self.0.iter_mut().zip(values) {
            column.add(record, count, values.borrow(), lanes);
        }
    }
}

impl Statistic for Moments {
    type Request = MomentsRequest;

    const DIFFERENCE: Difference = Difference::Observables;
    const IS_OF_DIFFERENCES: bool = true;

    fn size(_: &MomentsRequest, extent: &Extent<'_>) -> Size {
        let (records, observables) = (extent.records, extent.names.len());
        Size {
            // and the times
            bytes: Self::bytes(extent) + u128::from(records) * NUMBER,
            what: format!("{records} recorded times of {observables} observables"),
            remedy: "record less often with `every`",
        }
    }

    fn empty(_: &MomentsRequest, extent: &Extent<'_>) -> Self {
        Self(vec![Column::new(extent.rows()); extent.names.len()])
    }

    fn add(&mut self, at: &Recorded<'_>) {
        self.add_to(at.record, at.counts[at.record], at.values, at.lanes);
    }

    fn merge(&mut self, counts: &[u64], other: &Self, others: &[u64]) {
        for (column, other) in self.0.iter_mut().zip(&other.0) {
            column.merge(counts, other, others);
        }
    }

    #[cfg(feature = "serde")]
    fn fits(&self, _: &MomentsRequest, extent: &Extent<'_>, _: &[u64]) -> bool {
        self.0.len() == extent.names.len() && self.0.iter().all(|column| column.fits(extent.rows()))
    }

    fn show(self, summary: &mut Summary) {
        for (number, column) in self.0.into_iter().enumerate() {
            let (name, counts) = (
                summary.info.names[number].clone(),
                summary.counts().to_vec(),
            );
            summary.shown.push(Statistics::new(name, counts, column));
        }
    }
}

impl Summary {
    /// The statistics of an observable; `summary["name"]` is the same for a name that exists.
    pub fn get(&self, name: &str) -> Option<&Statistics> {
        self.statistics().iter().find(|s| s.name() == name)
    }

    /// The statistics of all observables, in the order in which they were given.
    pub fn statistics(&self) -> &[Statistics] {
        self.shown.all()
    }
}

impl Index<&str> for Summary {
    type Output = Statistics;

    /// The statistics of an observable.
    ///
    /// # Panics
    /// If there is no observable of this name; [`get`](Summary::get) returns `None` in this case.
    fn index(&self, name: &str) -> &Statistics {
        match self.get(name) {
            Some(statistics) => statistics,
            None => panic!(
                "there is no observable `{name}`; there are {:?}",
                self.info.names
            ),
        }
    }
}

/// An observable at each recorded time, over the paths that have not failed until then.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    name: String,
    counts: Vec<u64>,
    column: Column,
    /// Numbers and statistics of the means of antithetic pairs.
    pub(super) pairs: Option<(Vec<u64>, Column)>,
}

impl Statistics {
    fn new(name: String, counts: Vec<u64>, mut column: Column) -> Self {
        for (mean, &count) in column.mean.iter_mut().zip(&counts) {
            if count == 0 {
                *mean = f64::NAN;
            }
        }
        Self {
            name,
            counts,
            column,
            pairs: None,
        }
    }

    /// Returns the warnings about the statistics.
    pub(super) fn warnings<'a>(&'a self, times: &'a [f64]) -> impl Iterator<Item = Warning> + 'a {
        warning::warnings(&self.name, times, &self.counts, &self.column)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the number of paths at each recorded time.
    pub fn counts(&self) -> &[u64] {
        &self.counts
    }

    /// Means; NaN if all paths have failed.
    pub fn mean(&self) -> &[f64] {
        &self.column.mean
    }

    /// Variances, the sums of squared deviations over the number of paths less one; NaN for fewer
    /// than two paths.
    ///
    /// A variance outside of the range of `f64`, for example of deviations of 1e-200, is 0 or ∞;
    /// [`standard_deviation`](Self::standard_deviation) and
    /// [`standard_error`](Self::standard_error) are right in this case too.
    pub fn variance(&self) -> Vec<f64> {
        self.of_squares(|squares, paths| squares.over(paths - 1.0).get())
    }

    /// Standard deviations, the square roots of the variances.
    pub fn standard_deviation(&self) -> Vec<f64> {
        self.of_squares(|squares, paths| squares.over(paths - 1.0).sqrt())
    }

    /// Standard errors of the means: √(variance / paths). With
    /// [antithetic](super::Ensemble::antithetic) paths, the standard errors of the means over pairs
    /// in which no path has failed.
    pub fn standard_error(&self) -> Vec<f64> {
        let of = |squares: Squares, n: f64| squares.over(n - 1.0).over(n).sqrt();
        match &self.pairs {
            None => self.of_squares(of),
            Some((counts, column)) => of_squares(counts, column, of),
        }
    }

    /// Returns how the values of the paths are spread at a recorded time.
    pub(super) fn spread(&self, record: usize) -> Spread {
        Spread::of(&self.column, record)
    }

    /// Returns a function of the sum of squared deviations and the number of paths, at each
    /// recorded time; NaN for fewer than two paths.
    fn of_squares(&self, of: impl Fn(Squares, f64) -> f64) -> Vec<f64> {
        of_squares(&self.counts, &self.column, of)
    }

    /// Least values; +∞ if all paths have failed.
    pub fn min(&self) -> &[f64] {
        &self.column.min
    }

    /// Greatest values; −∞ if all paths have failed.
    pub fn max(&self) -> &[f64] {
        &self.column.max
    }
}

/// Returns a function of the sum of squared deviations and the number of values, at each recorded
/// time; NaN for fewer than two values.
fn of_squares(counts: &[u64], column: &Column, of: impl Fn(Squares, f64) -> f64) -> Vec<f64> {
    let at = |(record, &count): (usize, &u64)| match count {
        0 | 1 => f64::NAN,
        _ => of(column.squares_at(record), count as f64),
    };
    counts.iter().enumerate().map(at).collect()
}

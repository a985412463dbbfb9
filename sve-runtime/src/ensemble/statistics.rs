//! The statistics and histograms of one observable, at each recorded time.
//!
//! Input: merged columns. Output: the numbers that users read. Invariant: a mean of no paths and a variance of fewer than two are NaN,
//! and nothing else is.

use super::histogram::{Bins, HistogramRequest};
use super::moments::{Column, Squares};
use super::spread::Spread;
use super::warning::{self, Warning};
use crate::table::{Table, Values, table_writers};

/// An observable at each recorded time, over the paths that have not failed until then.
#[derive(Clone, Debug, PartialEq)]
pub struct Statistics {
    name: String,
    counts: Vec<u64>,
    column: Column,
    /// Numbers and statistics of the means of antithetic pairs.
    pairs: Option<(Vec<u64>, Column)>,
}

impl Statistics {
    pub(super) fn new(
        name: String,
        counts: Vec<u64>,
        mut column: Column,
        pairs: Option<(Vec<u64>, Column)>,
    ) -> Self {
        for (mean, &count) in column.mean.iter_mut().zip(&counts) {
            if count == 0 {
                *mean = f64::NAN;
            }
        }
        Self {
            name,
            counts,
            column,
            pairs,
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

    /// Variances, the sums of squared deviations over the number of paths less one; NaN for fewer than two paths.
    ///
    /// A variance outside of the range of `f64`, as of deviations of 1e-200, is 0 or ∞;
    /// [`standard_deviation`](Self::standard_deviation) and [`standard_error`](Self::standard_error) are right there too.
    pub fn variance(&self) -> Vec<f64> {
        self.of_squares(|squares, paths| squares.over(paths - 1.0).get())
    }

    /// Standard deviations, the square roots of the variances.
    pub fn standard_deviation(&self) -> Vec<f64> {
        self.of_squares(|squares, paths| squares.over(paths - 1.0).sqrt())
    }

    /// Standard errors of the means: √(variance / paths). With [antithetic](super::Ensemble::antithetic) paths those of the means over pairs of which no path has failed.
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

    /// Returns a function of the sum of squared deviations and the number of paths, at each recorded time; NaN for fewer than two paths.
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

/// Returns a function of the sum of squared deviations and the number of values, at each recorded time; NaN for fewer than two values.
fn of_squares(counts: &[u64], column: &Column, of: impl Fn(Squares, f64) -> f64) -> Vec<f64> {
    let at = |(record, &count): (usize, &u64)| match count {
        0 | 1 => f64::NAN,
        _ => of(column.squares_at(record), count as f64),
    };
    counts.iter().enumerate().map(at).collect()
}

/// The number of paths with an observable in each of equal bins of a range.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    request: HistogramRequest,
    times: Vec<f64>,
    bins: Bins,
}

impl Histogram {
    /// A histogram of bins at recorded times.
    pub(super) fn new(request: HistogramRequest, bins: Bins, times: &[f64]) -> Self {
        let rows = bins.0.len() / (request.bins + 2);
        let times = times[times.len().saturating_sub(rows)..].to_vec();
        Self {
            request,
            times,
            bins,
        }
    }

    /// The observable.
    pub fn name(&self) -> &str {
        &self.request.name
    }

    /// Returns the edges of the bins, one more than there are bins. A value on an edge is in the bin above it.
    pub fn edges(&self) -> Vec<f64> {
        (0..=self.request.bins)
            .map(|bin| self.request.edge(bin))
            .collect()
    }

    /// Returns the number of recorded times: all of them, or 1 for a final histogram.
    pub fn rows(&self) -> usize {
        self.bins.0.len() / (self.request.bins + 2)
    }

    /// The recorded times of the rows.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Paths in each bin at the end.
    pub fn counts(&self) -> &[u64] {
        self.counts_at(self.rows() - 1)
    }

    /// Paths in each bin at a recorded time.
    ///
    /// # Panics
    /// Unless `row` is below [`rows`](Self::rows).
    pub fn counts_at(&self, row: usize) -> &[u64] {
        &self.row(row)[1..=self.request.bins]
    }

    /// Paths below the range at a recorded time.
    ///
    /// # Panics
    /// As [`counts_at`](Self::counts_at).
    pub fn below_at(&self, row: usize) -> u64 {
        self.row(row)[0]
    }

    /// Paths above the range at a recorded time, or on its upper bound.
    ///
    /// # Panics
    /// As [`counts_at`](Self::counts_at).
    pub fn above_at(&self, row: usize) -> u64 {
        self.row(row)[self.request.bins + 1]
    }

    fn row(&self, row: usize) -> &[u64] {
        let width = self.request.bins + 2;
        &self.bins.0[row * width..][..width]
    }
}

impl Histogram {
    /// The columns: the time, the bounds of a bin, and the paths in it, with the paths below and above the range in bins without a bound.
    fn table(&self) -> Table {
        let [mut t, mut low, mut high] = [const { Vec::new() }; 3];
        let mut paths = Vec::new();
        let edges = self.edges();
        for (row, time) in self.times.iter().enumerate() {
            t.extend(vec![*time; self.request.bins + 2]);
            low.push(f64::NEG_INFINITY);
            low.extend(&edges);
            high.extend(&edges);
            high.push(f64::INFINITY);
            paths.extend_from_slice(self.row(row));
        }
        let numbers = [("t", t), ("low", low), ("high", high)];
        let numbers = numbers.map(|(name, values)| (name.to_owned(), Values::Numbers(values)));
        let mut columns: Vec<_> = numbers.into();
        columns.push(("paths".to_owned(), Values::Counts(paths)));
        let name = "histogram";
        Table { name, columns }
    }
}

table_writers!(
    Histogram,
    "the histogram, a row for each recorded time and bin with `t`, `low`, `high` and `paths`, and two for the paths below and above the range, from −∞ and to ∞,"
);

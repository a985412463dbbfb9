//! Histograms of observables: how many paths are in each bin.
//!
//! Input: tiles of values. Output: counts, which merge by addition in any order. Invariant: a value
//! is in the bin between whose published edges it is; the counts with those below and above sum up
//! to the paths.

use core::ops::Range;

use super::difference::Difference;
use super::sizes::{AT_ONCE, NUMBER};
use super::statistic::{AnyRequest, Extent, Recorded, Size, Statistic, check_known};
use super::{Ensemble, EnsembleError, Summary, edges};
use crate::ensemble::PathMethod;
use crate::lanes::{LANES, Lane};
use crate::table::{Table, Values, table_writers};

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Takes a histogram of an observable with equal bins over a range, at each recorded time, or
    /// with [`Bins::at_end`] at the end only.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().every(5).histogram("q", -5.0..5.0, 20).run()?;
    /// let histogram = summary.histogram("q").unwrap();
    /// assert_eq!((histogram.rows(), histogram.edges().len()), (3, 21));
    /// // all paths start at q = 1, the lower edge of bin 12
    /// assert_eq!(histogram.counts_at(0)[12], 100);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn histogram(
        self,
        name: impl Into<String>,
        range: Range<f64>,
        bins: impl Into<Bins>,
    ) -> Self {
        let Bins { number, always } = bins.into();
        self.take(AnyRequest::Histogram(HistogramRequest {
            name: name.into(),
            range: [range.start, range.end],
            bins: number,
            always,
        }))
    }
}

/// The bins of a histogram: their number, and when they count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bins {
    number: usize,
    /// The bins count at each recorded time, and not at the last one only.
    always: bool,
}

impl Bins {
    /// Counts at the end of the run only, which takes less memory. A number of bins as it is counts
    /// at each recorded time.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().every(5).histogram("q", -5.0..5.0, Bins::at_end(20)).run()?;
    /// let histogram = summary.histogram("q").unwrap();
    /// assert_eq!((histogram.rows(), histogram.times()), (1, &[1.0][..]));
    /// assert_eq!(histogram.counts().iter().sum::<u64>(), 100);
    #[doc = include_str!("../example_end.md")]
    pub const fn at_end(number: usize) -> Self {
        let always = false;
        Self { number, always }
    }
}

impl From<usize> for Bins {
    /// Counts at each recorded time.
    fn from(number: usize) -> Self {
        let always = true;
        Self { number, always }
    }
}

/// The request of a histogram: observable, range and bins.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct HistogramRequest {
    /// Name of the observable.
    pub(super) name: String,
    /// The range; its upper end does not belong to it.
    pub(super) range: [f64; 2],
    /// Number of bins.
    pub(super) bins: usize,
    /// The histogram counts at each recorded time, and not at the last one only.
    pub(super) always: bool,
}

impl HistogramRequest {
    /// Returns whether the bounds are finite, the lower one is below the upper one, and there is a
    /// bin.
    fn is_valid(&self) -> bool {
        let [low, high] = self.range;
        (high - low).is_finite() && low < high && self.bins > 0
    }

    /// Returns the lower edge of a bin.
    fn edge(&self, bin: usize) -> f64 {
        edges::edge(self.range, bin, self.bins)
    }

    /// Returns the number of recorded times at which it counts.
    fn rows(&self, records: u64) -> u64 {
        if self.always { records } else { 1 }
    }

    /// Returns the row of counts of a record; `None` if it does not count then.
    fn row(&self, record: usize, records: usize) -> Option<usize> {
        if self.always {
            Some(record)
        } else {
            (record + 1 == records).then_some(0)
        }
    }

    /// Returns the number of counts, which may exceed any memory.
    fn counts(&self, records: u64) -> u128 {
        u128::from(self.rows(records)) * (self.bins as u128 + 2)
    }

    /// Returns the distance from an edge, in bins, within which rounding errors can place a value
    /// into the wrong bin, so that the value has to be compared with the edges.
    ///
    /// The place of a value has four rounding errors, an edge one: 4ε bins and ε max(|low|,
    /// |high|)/(high − low) bins. Subnormal numbers have the absolute rounding error of the
    /// smallest normal number.
    fn rounding_margin(&self) -> f64 {
        let [low, high] = self.range;
        let size = low.abs().max(high.abs()).max(f64::MIN_POSITIVE) / (high - low);
        8.0 * f64::EPSILON * self.bins as f64 * (1.0 + size)
    }

    /// Returns the number of a value's count: 0 below the range, 1 … in the bins, `bins + 1` above.
    fn place(&self, value: f64, margin: f64) -> usize {
        let [low, high] = self.range;
        if value < low {
            return 0;
        }
        if value >= high {
            return self.bins + 1;
        }
        let guess = (value - low) / (high - low) * self.bins as f64;
        #[allow(clippy::cast_sign_loss)] // the value is not below the range
        let mut bin = (guess as usize).min(self.bins - 1);
        let within = guess - bin as f64;
        if within <= margin || within >= 1.0 - margin {
            while bin > 0 && value < self.edge(bin) {
                bin -= 1;
            }
            while bin + 1 < self.bins && value >= self.edge(bin + 1) {
                bin += 1;
            }
        }
        bin + 1
    }
}

/// The counts of a histogram.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct BinCounts {
    request: HistogramRequest,
    /// Number of the observable.
    column: usize,
    /// A row for each recorded time: below the range, in its bins, above.
    counts: Vec<u64>,
}

impl Statistic for BinCounts {
    type Request = HistogramRequest;

    const DIFFERENCE: Difference = Difference::Statistic("histograms");

    fn check(request: &HistogramRequest, names: &[String]) -> Result<(), EnsembleError> {
        check_known(&request.name, names, "make a histogram of")?;
        if request.is_valid() {
            return Ok(());
        }
        let ([low, high], bins) = (request.range, request.bins);
        Err(EnsembleError::Histogram {
            name: request.name.clone(),
            low,
            high,
            bins,
        })
    }

    fn size(request: &HistogramRequest, extent: &Extent<'_>) -> Size {
        let HistogramRequest { name, bins, .. } = request;
        let rows = request.rows(extent.records);
        Size {
            bytes: request
                .counts(extent.records)
                .saturating_mul(AT_ONCE * NUMBER),
            what: format!("the histogram of `{name}` with {bins} bins at {rows} recorded times"),
            remedy: "take fewer bins, or `Bins::at_end`",
        }
    }

    fn empty(request: &HistogramRequest, extent: &Extent<'_>) -> Self {
        let counts = usize::try_from(request.counts(extent.records));
        Self {
            request: request.clone(),
            column: extent.column(&request.name),
            // counts that fit into memory
            counts: vec![0; counts.unwrap_or(0)],
        }
    }

    fn add(&mut self, at: &Recorded<'_>) {
        let Self {
            request, counts, ..
        } = self;
        let Some(row) = request.row(at.record, at.counts.len()) else {
            return;
        };
        let row = &mut counts[row * (request.bins + 2)..][..request.bins + 2];
        let margin = request.rounding_margin();
        let values: &Lane = &at.values[self.column];
        for lane in (0..LANES).filter(|lane| at.lanes >> lane & 1 == 1) {
            row[request.place(values[lane], margin)] += 1;
        }
    }

    fn merge(&mut self, _: &[u64], other: &Self, _: &[u64]) {
        for (count, other) in self.counts.iter_mut().zip(&other.counts) {
            *count += other;
        }
    }

    #[cfg(feature = "serde")]
    fn fits(&self, request: &HistogramRequest, extent: &Extent<'_>, _: &[u64]) -> bool {
        self.request == *request
            && self.column == extent.column(&request.name)
            && self.counts.len() as u128 == request.counts(extent.records)
    }

    fn show(self, summary: &mut Summary) {
        let Self {
            request, counts, ..
        } = self;
        let times = summary.times();
        let rows = counts.len() / (request.bins + 2);
        let histogram = Histogram {
            times: times[times.len().saturating_sub(rows)..].to_vec(),
            request,
            counts,
        };
        summary.shown.push(histogram);
    }
}

impl Summary {
    /// The histograms, in the order in which they were asked for.
    pub fn histograms(&self) -> &[Histogram] {
        self.shown.all()
    }

    /// The first histogram of an observable.
    pub fn histogram(&self, name: &str) -> Option<&Histogram> {
        self.histograms().iter().find(|h| h.name() == name)
    }
}

/// The number of paths with an observable in each of equal bins of a range.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    request: HistogramRequest,
    times: Vec<f64>,
    counts: Vec<u64>,
}

impl Histogram {
    /// The observable.
    pub fn name(&self) -> &str {
        &self.request.name
    }

    /// Returns the edges of the bins, one more than there are bins. A value on an edge is in the
    /// bin above it.
    pub fn edges(&self) -> Vec<f64> {
        (0..=self.request.bins)
            .map(|bin| self.request.edge(bin))
            .collect()
    }

    /// Returns the number of recorded times: all of them, or 1 for a final histogram.
    pub fn rows(&self) -> usize {
        self.counts.len() / (self.request.bins + 2)
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
        &self.counts[row * width..][..width]
    }

    /// The columns: the time, the bounds of a bin, and the paths in it, with the paths below and
    /// above the range in bins without a bound.
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

#[cfg(test)]
mod tests {
    use super::HistogramRequest;

    /// Checks values on the edges, next to them and between them.
    #[test]
    fn a_value_is_between_the_edges_of_its_bin() {
        for (range, bins) in [
            ([-3.0, 3.0], 12),
            ([0.1, 0.7], 7),
            ([-1e8, -1e8 + 1e-4], 100),
            ([1e-310, 3e-310], 9),
            ([-1e300, 1e307], 1000),
        ] {
            let request = HistogramRequest {
                name: String::new(),
                range,
                bins,
                always: true,
            };
            let edges: Vec<f64> = (0..=bins).map(|bin| request.edge(bin)).collect();
            for pair in edges.windows(2) {
                let middle = 0.5 * pair[0] + 0.5 * pair[1];
                for value in [pair[0], pair[0].next_up(), middle, pair[1].next_down()] {
                    let expected = edges.iter().filter(|&&edge| value >= edge).count();
                    assert_eq!(
                        request.place(value, request.rounding_margin()),
                        expected,
                        "{value}"
                    );
                }
            }
        }
    }
}

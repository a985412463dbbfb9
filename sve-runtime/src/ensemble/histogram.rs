//! Histograms of observables: how many paths are in each bin.
//!
//! Input: tiles of values. Output: counts, which merge by addition in any order.
//! Invariant: a value is in the bin between whose published edges it is; the counts with those below and above sum up to the paths.

use core::ops::Range;

use super::{Ensemble, edges};
use crate::configuration::Coordinates;
use crate::lanes::{LANES, Lane, Mask};
use crate::method::Method;
use crate::system::{Dims, System};

impl<I, S, Q, const N: usize, const M: usize> Ensemble<'_, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Takes a histogram of an observable with `bins` equal bins over a range, at each recorded time.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().record_every(5).histogram("q", -5.0..5.0, 20).run()?;
    /// let histogram = summary.histogram("q").unwrap();
    /// assert_eq!((histogram.rows(), histogram.edges().len()), (3, 21));
    /// // all paths start at q = 1, the lower edge of bin 12
    /// assert_eq!(histogram.counts_at(0)[12], 100);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn histogram(self, name: impl Into<String>, range: Range<f64>, bins: usize) -> Self {
        self.request(name.into(), &range, bins, true)
    }

    /// Takes a histogram as [`histogram`](Self::histogram) does, at the end only.
    ///
    #[doc = include_str!("example.md")]
    /// let summary = ensemble().record_every(5).final_histogram("q", -5.0..5.0, 20).run()?;
    /// let histogram = summary.histogram("q").unwrap();
    /// assert_eq!((histogram.rows(), histogram.times()), (1, &[1.0][..]));
    /// assert_eq!(histogram.counts().iter().sum::<u64>(), 100);
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn final_histogram(self, name: impl Into<String>, range: Range<f64>, bins: usize) -> Self {
        self.request(name.into(), &range, bins, false)
    }

    fn request(mut self, name: String, range: &Range<f64>, bins: usize, always: bool) -> Self {
        let range = [range.start, range.end];
        self.histograms.push(HistogramRequest {
            name,
            range,
            bins,
            always,
        });
        self
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
    /// Whether it counts at each recorded time, or at the last one only.
    pub(super) always: bool,
}

impl HistogramRequest {
    /// Returns whether the bounds are finite, the lower one is below the upper one, and there is a bin.
    pub(super) fn is_valid(&self) -> bool {
        let [low, high] = self.range;
        (high - low).is_finite() && low < high && self.bins > 0
    }

    /// Returns the lower edge of a bin.
    pub(super) fn edge(&self, bin: usize) -> f64 {
        edges::edge(self.range, bin, self.bins)
    }

    /// Returns the number of recorded times at which it counts.
    fn rows(&self, records: usize) -> usize {
        if self.always { records } else { 1 }
    }

    /// Returns the row of counts of a record; `None` if it does not count then.
    pub(super) fn row(&self, record: usize, records: usize) -> Option<usize> {
        if self.always {
            Some(record)
        } else {
            (record + 1 == records).then_some(0)
        }
    }

    /// Returns the number of counts, which may exceed any memory.
    pub(super) fn counts(&self, records: usize) -> u128 {
        self.rows(records) as u128 * (self.bins as u128 + 2)
    }

    /// Returns the distance from an edge, in bins, within which rounding errors can place a value into the wrong bin, so that the value has to be compared with the edges.
    ///
    /// The place of a value has four rounding errors, an edge one: 4ε bins and ε max(|low|, |high|)/(high − low) bins. Subnormal
    /// numbers have the absolute rounding error of the smallest normal number.
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

/// The counts of a histogram, a row for each recorded time: below the range, in its bins, above.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Bins(pub(super) Vec<u64>);

impl Bins {
    pub(super) fn new(request: &HistogramRequest, records: usize) -> Self {
        Self(vec![0; request.rows(records) * (request.bins + 2)])
    }

    pub(super) fn add(
        &mut self,
        request: &HistogramRequest,
        row: usize,
        values: &Lane,
        lanes: Mask,
    ) {
        let row = &mut self.0[row * (request.bins + 2)..][..request.bins + 2];
        let margin = request.rounding_margin();
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            row[request.place(values[lane], margin)] += 1;
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (count, other) in self.0.iter_mut().zip(&other.0) {
            *count += other;
        }
    }
}

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

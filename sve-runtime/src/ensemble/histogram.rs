//! Histograms of observables: how many paths are in each bin.
//!
//! Input: tiles of values. Output: counts, which merge by addition in any order.
//! Invariant: a value is in the bin between whose published edges it is; the counts with those below and above sum up to the paths.

use super::edges;
use crate::lanes::{LANES, Lane, Mask};

/// What a histogram counts.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Request {
    /// Which observable.
    pub(super) name: String,
    /// The range, of which the upper bound is outside.
    pub(super) range: [f64; 2],
    /// Number of bins.
    pub(super) bins: usize,
    /// At each recorded time, or at the last alone.
    pub(super) always: bool,
}

impl Request {
    /// Whether the bounds are finite, the lower one below the upper one, and there is a bin.
    pub(super) fn is_sound(&self) -> bool {
        let [low, high] = self.range;
        (high - low).is_finite() && low < high && self.bins > 0
    }

    /// The lower edge of a bin, and the upper one of the bin before.
    pub(super) fn edge(&self, bin: usize) -> f64 {
        edges::edge(self.range, bin, self.bins)
    }

    /// Recorded times that it counts at.
    fn rows(&self, records: usize) -> usize {
        if self.always { records } else { 1 }
    }

    /// The row of a record.
    pub(super) fn row(&self, record: usize, records: usize) -> Option<usize> {
        if self.always {
            Some(record)
        } else {
            (record + 1 == records).then_some(0)
        }
    }

    /// How many counts it has, which may be more than any memory.
    pub(super) fn counts(&self, records: usize) -> u128 {
        self.rows(records) as u128 * (self.bins as u128 + 2)
    }

    /// Distance from a whole number, in bins, within which the edges have to decide where a value belongs.
    ///
    /// The place of a value is rounded four times, each edge once: 4ε bins and ε max(|low|, |high|)/(high − low) bins. Below the least normal
    /// number rounding is as there.
    fn doubt(&self) -> f64 {
        let [low, high] = self.range;
        let size = low.abs().max(high.abs()).max(f64::MIN_POSITIVE) / (high - low);
        8.0 * f64::EPSILON * self.bins as f64 * (1.0 + size)
    }

    /// Where a value belongs: 0 below, 1 … in the bins, `bins + 1` above.
    fn place(&self, value: f64, doubt: f64) -> usize {
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
        if within <= doubt || within >= 1.0 - doubt {
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

/// Counts, in rows of one a recorded time: below the range, in its bins, above.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Bins(pub(super) Vec<u64>);

impl Bins {
    pub(super) fn new(request: &Request, records: usize) -> Self {
        Self(vec![0; request.rows(records) * (request.bins + 2)])
    }

    pub(super) fn add(&mut self, request: &Request, row: usize, values: &Lane, lanes: Mask) {
        let row = &mut self.0[row * (request.bins + 2)..][..request.bins + 2];
        let doubt = request.doubt();
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            row[request.place(values[lane], doubt)] += 1;
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
    use super::Request;

    /// Values on the edges, next to them and between them.
    #[test]
    fn a_value_is_between_the_edges_of_its_bin() {
        for (range, bins) in [
            ([-3.0, 3.0], 12),
            ([0.1, 0.7], 7),
            ([-1e8, -1e8 + 1e-4], 100),
            ([1e-310, 3e-310], 9),
            ([-1e300, 1e307], 1000),
        ] {
            let request = Request {
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
                    assert_eq!(request.place(value, request.doubt()), expected, "{value}");
                }
            }
        }
    }
}

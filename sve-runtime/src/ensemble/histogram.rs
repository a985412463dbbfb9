//! Histograms of observables: how many paths are in each bin.
//!
//! Input: tiles of values. Output: counts, which merge by addition in any order.
//! Invariant: a value is in the bin between whose published edges it is; the counts with those below and above sum up to the paths.

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
    /// The lower edge of a bin, and the upper one of the bin before.
    pub(super) fn edge(&self, bin: usize) -> f64 {
        let [low, high] = self.range;
        let place = bin as f64 / self.bins as f64;
        low * (1.0 - place) + high * place
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

    /// Where a value belongs: 0 below, 1 … in the bins, `bins + 1` above.
    fn place(&self, value: f64) -> usize {
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
        // the guess is rounded, the edges decide
        while bin > 0 && value < self.edge(bin) {
            bin -= 1;
        }
        while bin + 1 < self.bins && value >= self.edge(bin + 1) {
            bin += 1;
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
        for lane in (0..LANES).filter(|lane| lanes >> lane & 1 == 1) {
            row[request.place(values[lane])] += 1;
        }
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (count, other) in self.0.iter_mut().zip(&other.0) {
            *count += other;
        }
    }
}

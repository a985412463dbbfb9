//! Quantile sketches: the values of an observable, of which every other one is dropped whenever they are too many.
//!
//! Input: values. Output: values with weights, and a bound on the error of their ranks. Invariant: the sketch of a node of the merge tree depends on the values of its
//! blocks only; it has all values as long as they are at most `size`.
//!
//! Values of weight 2ˡ are in level l. A level with more than `size` values is sorted, and every other one moves up with twice the weight: the first, third, … and the
//! second, fourth, … one in turn. That changes any rank by at most 2ˡ, so the sum of these weights bounds the error of all ranks. For n values it is at most n/`size` times the number of
//! levels, ⌈log₂(n/`size`)⌉, and the error itself is much smaller, since those of successive turns have opposite signs.
//!
//! Source: G. S. Manku, S. Rajagopalan, B. G. Lindsay, *Approximate medians and other order statistics in one pass and with limited memory*, SIGMOD (1998); P. K. Agarwal, G. Cormode, Z. Huang,
//! J. M. Phillips, Z. Wei, K. Yi, *Mergeable summaries*, ACM Trans. Database Syst. 38, 26 (2013).

use crate::lanes::{LANES, Lane, Mask};

/// The request of quantiles.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct QuantileRequest {
    /// Name of the observable.
    pub(super) name: String,
    /// Largest number of values of a level.
    pub(super) size: usize,
}

/// A sketch of the values at one recorded time.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sketch {
    levels: Vec<Level>,
    /// Bound on the error of a rank.
    pub(super) rank_error: u64,
}

/// Values of one weight.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Level {
    #[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))]
    values: Vec<f64>,
    /// Whether the next reduction keeps the second value of each pair.
    keeps_second: bool,
}

/// The sketches of an observable, one for each recorded time.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct SketchColumn {
    size: usize,
    pub(super) sketches: Vec<Sketch>,
}

impl SketchColumn {
    pub(super) fn new(request: &QuantileRequest, records: usize) -> Self {
        Self {
            size: request.size,
            sketches: vec![Sketch::default(); records],
        }
    }

    /// Returns whether the column is one of a request, with so many paths at each recorded time.
    #[cfg(feature = "serde")]
    pub(super) fn fits(&self, request: &QuantileRequest, counts: &[u64]) -> bool {
        let mut sketches = self.sketches.iter().zip(counts);
        self.size == request.size
            && self.sketches.len() == counts.len()
            && sketches.all(|(sketch, &count)| sketch.has_weight(count))
    }

    pub(super) fn add(&mut self, record: usize, values: &Lane, lanes: Mask) {
        let counted = (0..LANES).filter(|lane| lanes >> lane & 1 == 1);
        let values = counted.map(|lane| values[lane]);
        self.sketches[record].level(0).values.extend(values);
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (sketch, other) in self.sketches.iter_mut().zip(&other.sketches) {
            sketch.merge(other, self.size);
        }
    }
}

impl Sketch {
    fn level(&mut self, number: usize) -> &mut Level {
        if self.levels.len() <= number {
            self.levels.resize(number + 1, Level::default());
        }
        &mut self.levels[number]
    }

    /// Adds the values of another sketch.
    fn merge(&mut self, other: &Self, size: usize) {
        for (number, level) in other.levels.iter().enumerate() {
            self.level(number).values.extend_from_slice(&level.values);
        }
        self.rank_error = self.rank_error.saturating_add(other.rank_error);
        let mut number = 0;
        while number < self.levels.len() {
            if self.levels[number].values.len() > size {
                let kept = self.levels[number].reduce();
                self.rank_error = self.rank_error.saturating_add(1 << number);
                self.level(number + 1).values.extend(kept);
            }
            number += 1;
        }
    }

    /// Returns whether the weights add up to a number of paths.
    #[cfg(any(test, feature = "serde"))]
    fn has_weight(&self, count: u64) -> bool {
        let levels = self.levels.iter().enumerate();
        let weights = levels.map(|(number, level)| (level.values.len() as u128) << number.min(64));
        self.levels.len() <= 64 && weights.sum::<u128>() == u128::from(count)
    }

    /// Returns the values with their weights, in ascending order.
    pub(super) fn weighted(&self) -> Vec<(f64, u64)> {
        let levels = self.levels.iter().enumerate();
        let all = levels.flat_map(|(number, level)| {
            level.values.iter().map(move |&value| (value, 1 << number))
        });
        let mut all: Vec<_> = all.collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }
}

impl Level {
    /// Returns every other one of an even number of values, and keeps the greatest of an odd number.
    fn reduce(&mut self) -> Vec<f64> {
        self.values.sort_by(f64::total_cmp);
        let rest = self.values.split_off(self.values.len() / 2 * 2);
        let all = core::mem::replace(&mut self.values, rest);
        let first = usize::from(self.keeps_second);
        self.keeps_second = !self.keeps_second;
        all.into_iter().skip(first).step_by(2).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Sketch;

    /// Merges blocks of 64 values pairwise, as the tree does.
    fn tree(values: &[f64], size: usize) -> Sketch {
        if values.len() <= 64 {
            let mut sketch = Sketch::default();
            sketch.level(0).values.extend_from_slice(values);
            return sketch;
        }
        let blocks = values.len().div_ceil(64).next_power_of_two();
        let (left, right) = values.split_at((32 * blocks).min(values.len()));
        let mut sketch = tree(left, size);
        sketch.merge(&tree(right, size), size);
        sketch
    }

    /// Every rank of every kept value, in orders that are sorted, reversed, periodic and scattered.
    #[test]
    fn ranks_are_within_the_bound() {
        let n = 64 * 300 + 17;
        let orders: [fn(u64) -> u64; 4] = [
            |i| i,
            |i| 1_000_000 - i,
            |i| i % 64 * 1000 + i / 64,
            |i| i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20,
        ];
        for (number, order) in orders.into_iter().enumerate() {
            let values: Vec<f64> = (0..n).map(|i| order(i) as f64).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            for size in [2, 63, 64, 1000, 100_000] {
                let sketch = tree(&values, size);
                assert!(sketch.has_weight(n), "{size}");
                let mut rank = 0;
                let mut worst = 0;
                for (value, weight) in sketch.weighted() {
                    rank += weight;
                    let exact = sorted.partition_point(|&x| x <= value) as u64;
                    worst = worst.max(exact.abs_diff(rank).saturating_sub(weight - 1));
                }
                assert!(
                    worst <= sketch.rank_error,
                    "{size}: {worst} {}",
                    sketch.rank_error
                );
                assert_eq!(sketch.rank_error == 0, size as u64 >= n);
                // scattered values: the errors of successive turns have opposite signs
                let are_small = worst <= sketch.rank_error / 2;
                assert!(
                    number < 3 || !(63..=64).contains(&size) || are_small,
                    "{worst}"
                );
            }
            let (size, n) = (1000.0, n as f64);
            let bound = n / size * (n / size).log2().ceil();
            assert!(tree(&values, 1000).rank_error as f64 <= bound);
        }
    }
}

//! Quantile sketches: the values of an observable. Whenever they are too many, every other value is
//! dropped.
//!
//! Input: values. Output: values with weights, and a bound on the error of their ranks. Invariant:
//! the sketch of a node of the merge tree depends on the values of its blocks only; it has all
//! values as long as they are at most `size`.
//!
//! Values of weight 2ˡ are in level l. A level with more than `size` values is sorted, and every
//! other value moves up with twice the weight: the values with odd numbers, or the values with even
//! numbers. This changes any rank by at most 2ˡ, so the sum of these weights bounds the error of
//! all ranks. Odd numbers make a rank too large, even numbers too small, by the same amount and at
//! the same places. A bit of a hash of all values below the node chooses between the two, so that
//! the error of every rank has the mean 0 over the samples, for any shape of the tree.
//!
//! For n values, a reduction of level l uses up at least `size` values of weight 2ˡ, so level l has
//! at most n/(2ˡ `size`) reductions, and the last level has 2ˡ < n/`size`. So the bound is at most
//! n/`size` times ⌈log₂(n/`size`)⌉, and the standard deviation of the error at most √(Σ 4ˡ n/(2ˡ
//! `size`)) < √2 n/`size`.
//!
//! Source: G. S. Manku, S. Rajagopalan, B. G. Lindsay, *Approximate medians and other order
//! statistics in one pass and with limited memory*, SIGMOD (1998); P. K. Agarwal, G. Cormode, Z.
//! Huang, J. M. Phillips, Z. Wei, K. Yi, *Mergeable summaries*, ACM Trans. Database Syst. 38, 26
//! (2013), which also has the random choice.

use crate::fingerprint::hash;

/// A sketch of the values at one recorded time.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sketch {
    levels: Vec<Level>,
    /// Bound on the error of a rank.
    pub(super) rank_error: u64,
    /// Hash of all values, including the dropped values. Bit l chooses the values of level l that a
    /// merge keeps.
    choices: u64,
}

/// Values of one weight.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Level(#[cfg_attr(feature = "serde", serde(with = "crate::floats::many"))] Vec<f64>);

impl Sketch {
    /// Adds values of a block.
    pub(super) fn add(&mut self, values: impl Iterator<Item = f64> + Clone) {
        self.choices = hash(|hash| {
            hash.add(self.choices);
            values.clone().for_each(|value| hash.add_number(value));
        });
        self.level(0).0.extend(values);
    }

    fn level(&mut self, number: usize) -> &mut Level {
        if self.levels.len() <= number {
            self.levels.resize(number + 1, Level::default());
        }
        &mut self.levels[number]
    }

    /// Adds the values of another sketch.
    pub(super) fn merge(&mut self, other: &Self, size: usize) {
        for (number, level) in other.levels.iter().enumerate() {
            self.level(number).0.extend_from_slice(&level.0);
        }
        self.rank_error = self.rank_error.saturating_add(other.rank_error);
        self.choices = hash(|hash| {
            hash.add(self.choices);
            hash.add(other.choices);
        });
        let mut number = 0;
        while number < self.levels.len() {
            if self.levels[number].0.len() > size {
                let keeps_second = self.choices >> number & 1 == 1;
                let kept = self.levels[number].reduce(keeps_second);
                self.rank_error = self.rank_error.saturating_add(1 << number);
                self.level(number + 1).0.extend(kept);
            }
            number += 1;
        }
    }

    /// Returns whether the weights add up to a number of paths.
    #[cfg(any(test, feature = "serde"))]
    pub(super) fn has_weight(&self, count: u64) -> bool {
        let levels = self.levels.iter().enumerate();
        let weights = levels.map(|(number, level)| (level.0.len() as u128) << number.min(64));
        self.levels.len() <= 64 && weights.sum::<u128>() == u128::from(count)
    }

    /// Returns the values with their weights, in ascending order.
    pub(super) fn weighted(&self) -> Vec<(f64, u64)> {
        let levels = self.levels.iter().enumerate();
        let all = levels
            .flat_map(|(number, level)| level.0.iter().map(move |&value| (value, 1 << number)));
        let mut all: Vec<_> = all.collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    }
}

impl Level {
    /// Removes and returns the first or the second value of each pair of neighbours. Keeps the
    /// greatest of an odd number of values.
    fn reduce(&mut self, keeps_second: bool) -> Vec<f64> {
        self.0.sort_by(f64::total_cmp);
        let rest = self.0.split_off(self.0.len() / 2 * 2);
        let pairs = core::mem::replace(&mut self.0, rest);
        let first = usize::from(keeps_second);
        pairs.into_iter().skip(first).step_by(2).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Sketch;

    /// Merges blocks of 64 values pairwise, as the tree does.
    fn tree(values: &[f64], size: usize) -> Sketch {
        if values.len() <= 64 {
            let mut sketch = Sketch::default();
            sketch.add(values.iter().copied());
            return sketch;
        }
        let blocks = values.len().div_ceil(64).next_power_of_two();
        let (left, right) = values.split_at((32 * blocks).min(values.len()));
        let mut sketch = tree(left, size);
        sketch.merge(&tree(right, size), size);
        sketch
    }

    /// Returns the errors of the numbers of values up to some places.
    fn rank_errors<const K: usize>(sketch: &Sketch, sorted: &[f64], at: [f64; K]) -> [f64; K] {
        let kept = sketch.weighted();
        at.map(|at| {
            let up_to = &kept[..kept.partition_point(|(x, _)| *x <= at)];
            let estimate: u64 = up_to.iter().map(|(_, weight)| weight).sum();
            estimate as f64 - sorted.partition_point(|&x| x <= at) as f64
        })
    }

    fn scattered(i: u64) -> u64 {
        let i = (i ^ i >> 31).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (i ^ i >> 29).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 20
    }

    /// Checks every rank of every kept value, in orders that are sorted, reversed, periodic and
    /// scattered, for all sizes up to three blocks and some larger sizes.
    #[test]
    fn ranks_are_within_the_bound() {
        let n = 64 * 60 + 17;
        let orders: [fn(u64) -> u64; 4] = [
            |i| i,
            |i| 1_000_000 - i,
            |i| i % 64 * 1000 + i / 64,
            scattered,
        ];
        for order in orders {
            let values: Vec<f64> = (0..n).map(|i| order(i) as f64).collect();
            let mut sorted = values.clone();
            sorted.sort_by(f64::total_cmp);
            for size in (2..=192).chain([1000, 3857, 100_000]) {
                let sketch = tree(&values, size);
                assert!(sketch.has_weight(n), "{size}");
                let mut rank = 0;
                let mut worst = 0;
                for (value, weight) in sketch.weighted() {
                    rank += weight;
                    let exact = sorted.partition_point(|&x| x <= value) as u64;
                    worst = worst.max(exact.abs_diff(rank).saturating_sub(weight - 1));
                }
                let error = sketch.rank_error;
                assert!(worst <= error, "{size}: {worst} {error}");
                assert_eq!(error == 0, size as u64 >= n, "{size}");
                let part = n as f64 / size as f64;
                let bound = part * part.log2().ceil().max(0.0);
                assert!(error as f64 <= bound, "{size}: {error} {bound}");
            }
        }
    }

    /// Checks that over samples the errors of ranks have the mean 0 and at most the standard
    /// deviation √2 n/size, also at the ends of the distribution and for values many of which are
    /// equal.
    #[test]
    fn errors_of_ranks_have_the_mean_zero() {
        const PLACES: [f64; 7] = [0.01, 0.1, 0.25, 0.5, 0.75, 0.9, 0.99];
        let (n, count) = (64 * 25 + 40_u32, 50_u32);
        for levels in [1 << 20, 16] {
            let sample = |seed: u32| {
                let value = |i: u32| scattered(u64::from(seed) << 32 | u64::from(i)) % levels;
                let values = (0..n).map(|i| value(i) as f64 / levels as f64);
                values.collect::<Vec<_>>()
            };
            let samples: Vec<_> = (0..count).map(sample).collect();
            let sorted = samples.iter().map(|values| {
                let mut sorted = values.clone();
                sorted.sort_by(f64::total_cmp);
                sorted
            });
            let sorted: Vec<_> = sorted.collect();
            let count = f64::from(count);
            for size in (2..64).chain((64..=900).step_by(76)) {
                let (mut sums, mut squares) = ([0.0; 7], [0.0; 7]);
                for (values, sorted) in samples.iter().zip(&sorted) {
                    let errors = rank_errors(&tree(values, size), sorted, PLACES);
                    for (k, error) in errors.into_iter().enumerate() {
                        sums[k] += error;
                        squares[k] += error * error;
                    }
                }
                let bound = 2.0_f64.sqrt() * f64::from(n) / size as f64;
                for ((at, sum), squares) in PLACES.into_iter().zip(sums).zip(squares) {
                    let deviation = (squares / count).sqrt();
                    assert!(
                        deviation < bound,
                        "{levels} {size} {at}: {deviation} {bound}"
                    );
                    // Among 1000 values of Student's distribution, one exceeds 4.8 in a hundred
                    // runs.
                    let limit = 4.8 * deviation / count.sqrt();
                    assert!(
                        sum.abs() / count <= limit,
                        "{levels} {size} {at}: {sum} {limit}"
                    );
                }
            }
        }
    }
}

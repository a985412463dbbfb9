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
pub(super) struct Column {
    pub(super) mean: Vec<f64>,
    /// Sums of squared deviations from the mean.
    pub(super) squares: Vec<f64>,
    pub(super) min: Vec<f64>,
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

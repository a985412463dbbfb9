//! Quantiles of observables over the paths, as users read them.
//!
//! Input: tiles of values; merged sketches, and the extremes of the values. Output: quantiles with
//! intervals and the error of their ranks. Invariant: they are NaN if all paths have failed; the
//! first and the last rank are exact.

use super::difference::Difference;
use super::sizes::{AT_ONCE, NUMBER};
use super::sketch::Sketch;
use super::statistic::{AnyRequest, Extent, Recorded, Size, Statistic, check_known};
use super::{Ensemble, EnsembleError, Summary};
use crate::ensemble::PathMethod;
use crate::lanes::LANES;

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Takes quantiles of an observable over the paths, at each recorded time:
    /// [`Summary::quantiles`](super::Summary::quantiles).
    ///
    /// Up to `size` paths have exact quantiles; the least and the greatest value are exact for any
    /// number of paths. For more paths the memory is about `size` numbers times log₂(paths/`size`)
    /// for each recorded time, and the rank of a quantile is right to within
    /// [`rank_error`](Quantiles::rank_error) of all paths: a proven bound, at most
    /// ⌈log₂(paths/`size`)⌉/`size`. Over the seeds the error itself has the mean 0, except within a
    /// few `1/size` of the ends, and a standard deviation below √2/`size`: where values are
    /// dropped, a hash of the values decides which of two neighbours is kept.
    ///
    /// **How large a `size`.** The statistical error of the rank of a `p`-quantile is √(p(1 −
    /// p)/paths). A `size` of 4 √(paths/(p(1 − p))), for a median 8 √paths, makes the error of the
    /// ranks a third of that at most, so it adds at most 6 % to the whole error. An
    /// [`interval`](Quantiles::interval) is wider by the proven bound on each side.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Free { sigma: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Free {
    ///     fn lagrangian(&self, _q: f64, v: f64) -> f64 { 0.5 * v * v }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let free = Integrator::new(Free { sigma: 1.0 }, Endpoint);
    /// let summary = Ensemble::new(&free)
    ///     .paths(10_000).seed(1)
    ///     .steps(0.1, 10)
    ///     .start(State::new([0.0], [0.0]))
    ///     .observe("p", |_, state| state.p[0])
    ///     .quantiles("p", 1000)
    ///     .run()?;
    /// let momentum = summary.quantiles("p").expect("they were asked for");
    /// // at t = 1 the momentum is a standard normal number
    /// let [low, high] = momentum.interval(0.975, 4.0)[1];
    /// assert!(low < 1.95996 && 1.95996 < high && high - low < 0.4);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn quantiles(self, name: impl Into<String>, size: usize) -> Self {
        let name = name.into();
        self.take(AnyRequest::Quantiles(QuantileRequest { name, size }))
    }
}

/// The request of quantiles.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct QuantileRequest {
    /// Name of the observable.
    pub(super) name: String,
    /// Largest number of values of a level.
    pub(super) size: usize,
}

/// The sketches of an observable.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Sketches {
    /// Number of the observable.
    column: usize,
    size: usize,
    /// A sketch for each recorded time.
    rows: Vec<Sketch>,
}

impl Statistic for Sketches {
    type Request = QuantileRequest;

    const DIFFERENCE: Difference = Difference::Statistic("quantiles");
    const NEEDS_INDEPENDENT_PATHS: bool = true;

    fn check(request: &QuantileRequest, names: &[String]) -> Result<(), EnsembleError> {
        check_known(&request.name, names, "take quantiles of")?;
        if request.size >= 2 {
            return Ok(());
        }
        let (name, size) = (request.name.clone(), request.size);
        Err(EnsembleError::Quantiles { name, size })
    }

    fn size(request: &QuantileRequest, extent: &Extent<'_>) -> Size {
        let (QuantileRequest { name, size }, records) = (request, extent.records);
        // all values of a level, for each time
        let values = u128::from(extent.paths).min(*size as u128);
        let bytes = u128::from(records).saturating_mul(values);
        Size {
            bytes: bytes.saturating_mul(AT_ONCE * NUMBER),
            what: format!("quantiles of `{name}` with {size} values at {records} recorded times"),
            remedy: "keep fewer values, or record less often with `every`",
        }
    }

    fn empty(request: &QuantileRequest, extent: &Extent<'_>) -> Self {
        Self {
            column: extent.column(&request.name),
            size: request.size,
            rows: vec![Sketch::default(); extent.rows()],
        }
    }

    fn add(&mut self, at: &Recorded<'_>) {
        let values = &at.values[self.column];
        let counted = (0..LANES).filter(|lane| at.lanes >> lane & 1 == 1);
        self.rows[at.record].add(counted.map(|lane| values[lane]));
    }

    fn merge(&mut self, _: &[u64], other: &Self, _: &[u64]) {
        for (sketch, other) in self.rows.iter_mut().zip(&other.rows) {
            sketch.merge(other, self.size);
        }
    }

    #[cfg(feature = "serde")]
    fn fits(&self, request: &QuantileRequest, extent: &Extent<'_>, counts: &[u64]) -> bool {
        let mut sketches = self.rows.iter().zip(counts);
        self.size == request.size
            && self.column == extent.column(&request.name)
            && self.rows.len() == counts.len()
            && sketches.all(|(sketch, &count)| sketch.has_weight(count))
    }

    fn show(self, summary: &mut Summary) {
        let of = &summary.statistics()[self.column];
        let sketches = self.rows.iter();
        let quantiles = Quantiles {
            name: of.name().to_owned(),
            counts: of.counts().to_vec(),
            extremes: [of.min().to_vec(), of.max().to_vec()],
            rank_errors: sketches.clone().map(|sketch| sketch.rank_error).collect(),
            values: sketches.map(Sketch::weighted).collect(),
        };
        summary.shown.push(quantiles);
    }
}

impl Summary {
    /// The quantiles of an observable, from [`Ensemble::quantiles`](super::Ensemble::quantiles).
    pub fn quantiles(&self, name: &str) -> Option<&Quantiles> {
        let mut all = self.shown.all::<Quantiles>().iter();
        all.find(|quantiles| quantiles.name() == name)
    }
}

/// Quantiles of an observable over the paths that have not failed, at each recorded time. From
/// [`Summary::quantiles`](super::Summary::quantiles).
#[derive(Clone, Debug, PartialEq)]
pub struct Quantiles {
    name: String,
    counts: Vec<u64>,
    /// Values with their weights in ascending order, for each recorded time.
    values: Vec<Vec<(f64, u64)>>,
    /// The least and the greatest values.
    extremes: [Vec<f64>; 2],
    rank_errors: Vec<u64>,
}

impl Quantiles {
    /// The observable.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns the `p`-quantile at each recorded time: the least value that a part `p` of all
    /// values does not exceed, with the error of [`rank_error`](Self::rank_error); NaN if all paths
    /// have failed.
    ///
    /// For `p` = 0 and `p` = 1 it is the least and the greatest value of all paths, without an
    /// error.
    ///
    /// # Panics
    /// Unless `p` is from 0 to 1.
    pub fn quantile(&self, p: f64) -> Vec<f64> {
        assert!((0.0..=1.0).contains(&p), "a quantile of {p}: from 0 to 1");
        let at = |(row, &paths): (usize, &u64)| match paths {
            0 => f64::NAN,
            _ => self.value_of_rank(row, (p * paths as f64).ceil().max(1.0)),
        };
        self.counts.iter().enumerate().map(at).collect()
    }

    /// Returns an interval that contains the `p`-quantile of the distribution, at each recorded
    /// time. It extends by `deviations` standard deviations of the rank to each side, plus the
    /// bound on the error of the rank: 2 for 95 %, 3 for 99.7 %. It holds for every distribution.
    /// An end is infinite if there are too few paths to bound it; both are NaN if all paths have
    /// failed.
    ///
    /// # Panics
    /// Unless `p` is from 0 to 1 and `deviations` is not negative.
    pub fn interval(&self, p: f64, deviations: f64) -> Vec<[f64; 2]> {
        assert!((0.0..=1.0).contains(&p), "a quantile of {p}: from 0 to 1");
        assert!(
            deviations >= 0.0,
            "{deviations} standard deviations: 0 or more"
        );
        let at = |(row, &paths): (usize, &u64)| {
            if paths == 0 {
                return [f64::NAN; 2];
            }
            let n = paths as f64;
            let margin = deviations * (n * p * (1.0 - p)).sqrt() + self.rank_errors[row] as f64;
            let low = (n * p - margin).floor();
            let high = (n * p + margin).ceil() + 1.0;
            let low = if low < 1.0 {
                f64::NEG_INFINITY
            } else {
                self.value_of_rank(row, low)
            };
            let high = if high > n {
                f64::INFINITY
            } else {
                self.value_of_rank(row, high)
            };
            [low, high]
        };
        self.counts.iter().enumerate().map(at).collect()
    }

    /// Returns a bound on the error of the ranks at each recorded time, as a part of the paths: 0
    /// if the quantiles are exact.
    pub fn rank_error(&self) -> Vec<f64> {
        let all = self.rank_errors.iter().zip(&self.counts);
        all.map(|(&error, &paths)| error as f64 / (paths.max(1)) as f64)
            .collect()
    }

    /// Returns the value of a rank, from 1 to the number of paths.
    fn value_of_rank(&self, row: usize, rank: f64) -> f64 {
        let [least, greatest] = &self.extremes;
        if rank <= 1.0 {
            return least[row];
        }
        if rank >= self.counts[row] as f64 {
            return greatest[row];
        }
        let values = &self.values[row];
        let mut below = 0;
        let found = values.iter().find(|(_, weight)| {
            below += weight;
            below as f64 >= rank
        });
        found
            .or(values.last())
            .map_or(f64::NAN, |(value, _)| *value)
    }
}

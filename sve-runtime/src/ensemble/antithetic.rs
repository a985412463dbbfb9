//! Antithetic pairs of paths: the second path of a pair has the increments of the first one with
//! the other sign.
//!
//! Input: the observables of tiles. Output: statistics of the means of pairs. The means are
//! independent of one another, while the two paths of a pair are not. Invariant: if one path of a
//! pair has failed, the pair does not count.

use super::difference::Difference;
use super::statistic::{AnyRequest, Extent, Recorded, Size, Statistic};
use super::statistics::{Moments, MomentsRequest, Statistics};
use super::{Ensemble, Summary};
use crate::ensemble::PathMethod;
use crate::lanes::{LANES, Lane, Mask};

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Makes the paths 2k and 2k + 1 a pair: both have the increments of path k of the noise, the
    /// second one with the other sign.
    ///
    /// An observable whose values on the two paths of a pair lie on opposite sides of the mean has
    /// a mean with a smaller error: where it depends linearly on the noise, none. An observable
    /// that is even in the noise has the same value on both, and its mean an error that is √2 times
    /// larger. [`Statistics::standard_error`](super::Statistics::standard_error) is the standard
    /// error of the means of pairs, so it is right in all cases. Random
    /// [starts](super::Starts::each) have the same generator for both paths of a pair; the function
    /// can mirror a start by the number of its path.
    ///
    /// The number of paths has to be even. Covariances and quantiles are refused, since their
    /// errors suppose independent paths.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let oscillator = Integrator::new(Oscillator { sigma: 1.0 }, Midpoint);
    /// let ensemble = Ensemble::new(&oscillator)
    ///     .paths(1000).seed(1)
    ///     .steps(0.05, 20)
    ///     .start(State::new([1.0], [0.0]))
    ///     .observe("q", |_, state| state.q[0]);
    /// let plain = ensemble.run()?["q"].standard_error()[1];
    /// let paired = ensemble.antithetic(true).run()?["q"].standard_error()[1];
    /// assert!(plain > 0.01 && paired < 1e-15); // the position is linear in the noise
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn antithetic(mut self, are_paired: bool) -> Self {
        (self.observed.statistics).retain(|request| !matches!(request, AnyRequest::Pairs(_)));
        if are_paired {
            self.take(AnyRequest::Pairs(PairsRequest))
        } else {
            self
        }
    }
}

impl<I: PathMethod> Ensemble<'_, I> {
    /// Returns whether the paths are antithetic pairs.
    pub(super) fn is_antithetic(&self) -> bool {
        are_pairs(&self.observed.statistics)
    }
}

/// Returns whether a run with these requests has antithetic pairs.
pub(super) fn are_pairs(requests: &[AnyRequest]) -> bool {
    (requests.iter()).any(|request| matches!(request, AnyRequest::Pairs(_)))
}

/// The request of the means of antithetic pairs, which makes the paths such pairs.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct PairsRequest;

/// The moments of the means over antithetic pairs of paths in which neither path has failed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pairs {
    /// Number of pairs at each recorded time.
    counts: Vec<u64>,
    /// The moments of the means.
    moments: Moments,
}

impl Statistic for Pairs {
    type Request = PairsRequest;

    const DIFFERENCE: Difference = Difference::Noise;
    const IS_OF_DIFFERENCES: bool = true;

    fn size(_: &PairsRequest, extent: &Extent<'_>) -> Size {
        Size {
            bytes: Moments::bytes(extent),
            ..Moments::size(&MomentsRequest, extent)
        }
    }

    fn empty(_: &PairsRequest, extent: &Extent<'_>) -> Self {
        Self {
            counts: vec![0; extent.rows()],
            moments: Moments::empty(&MomentsRequest, extent),
        }
    }

    fn add(&mut self, at: &Recorded<'_>) {
        let mut pairs = 0;
        for pair in 0..LANES / 2 {
            pairs |= Mask::from(at.lanes >> (2 * pair) & 3 == 3) << pair;
        }
        let means = at.values.iter().map(|values| {
            let mut means: Lane = [0.0; LANES];
            for pair in 0..LANES / 2 {
                means[pair] = 0.5 * values[2 * pair] + 0.5 * values[2 * pair + 1];
            }
            means
        });
        let count = &mut self.counts[at.record];
        self.moments.add_to(at.record, *count, means, pairs);
        *count += u64::from(pairs.count_ones());
    }

    fn merge(&mut self, _: &[u64], other: &Self, _: &[u64]) {
        self.moments
            .merge(&self.counts, &other.moments, &other.counts);
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    #[cfg(feature = "serde")]
    fn fits(&self, _: &PairsRequest, extent: &Extent<'_>, counts: &[u64]) -> bool {
        let mut pairs = self.counts.iter().zip(counts);
        self.counts.len() == counts.len()
            && pairs.all(|(pairs, paths)| *pairs <= paths / 2)
            && (self.moments).fits(&MomentsRequest, extent, counts)
    }

    /// Gives the statistics of all observables the moments of the pairs, from which their standard
    /// errors are.
    fn show(self, summary: &mut Summary) {
        let statistics = summary.shown.list_mut::<Statistics>().into_iter().flatten();
        for (statistics, column) in statistics.zip(self.moments.into_columns()) {
            statistics.pairs = Some((self.counts.clone(), column));
        }
    }
}

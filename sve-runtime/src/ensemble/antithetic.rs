//! Antithetic pairs of paths: the second path of a pair has the increments of the first one with the other sign.
//!
//! Input: the observables of tiles. Output: statistics of the means of pairs, which are independent of one another where the paths of a pair are not.
//! Invariant: a pair of which one path has failed does not count.

use super::Ensemble;
use super::moments::Column;
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
    /// Makes the paths 2k and 2k + 1 a pair: both have the increments of path k of the noise, the second one with the other sign.
    ///
    /// An observable whose values on the two paths of a pair lie on opposite sides of the mean has a mean with a smaller error: where it depends linearly on the noise, none. An observable
    /// that is even in the noise has the same value on both, and its mean an error that is √2 times larger. [`Statistics::standard_error`](super::Statistics::standard_error) is that of the means of
    /// pairs, so it is right in all cases. Random [starts](Self::start_with) have the same generator for both paths of a pair; the function can mirror a start by the number of its path.
    ///
    /// The number of paths has to be even. Covariances and quantiles are refused, since their errors suppose independent paths.
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
        self.antithetic = are_paired;
        self
    }
}

/// The means over antithetic pairs of paths, of which neither has failed.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Pairs {
    /// Number of pairs at each recorded time; none without antithetic pairs.
    pub(super) counts: Vec<u64>,
    /// Statistics of the means of each observable.
    pub(super) columns: Vec<Column>,
}

impl Pairs {
    pub(super) fn new(records: usize, observables: usize) -> Self {
        Self {
            counts: vec![0; records],
            columns: vec![Column::new(records); observables],
        }
    }

    /// Adds the means of the pairs of a tile.
    pub(super) fn add(&mut self, record: usize, values: &[Lane], lanes: Mask) {
        let Some(count) = self.counts.get(record).copied() else {
            return;
        };
        let mut pairs = 0;
        for pair in 0..LANES / 2 {
            pairs |= Mask::from(lanes >> (2 * pair) & 3 == 3) << pair;
        }
        for (column, values) in self.columns.iter_mut().zip(values) {
            let mut means = [0.0; LANES];
            for pair in 0..LANES / 2 {
                means[pair] = 0.5 * values[2 * pair] + 0.5 * values[2 * pair + 1];
            }
            column.add(record, count, &means, pairs);
        }
        self.counts[record] += u64::from(pairs.count_ones());
    }

    pub(super) fn merge(&mut self, other: &Self) {
        for (column, more) in self.columns.iter_mut().zip(&other.columns) {
            column.merge(&self.counts, more, &other.counts);
        }
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }
}

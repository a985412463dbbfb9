//! The same ensemble from several starts.
//!
//! Input: an ensemble and starts. Output: a summary for each start. Invariant: the summary of a start is that of the ensemble with this start and with its part of the paths of
//! the noise, so that shards of it merge as any others.

use super::starts::Starts;
use super::{Ensemble, EnsembleError, Summary};
use crate::noise::{ManyPaths as _, Wiener};
use crate::system::StateOf;
use crate::trajectory::Method;

impl<I: Method + Sync> Ensemble<'_, I> {
    /// Gives all starts of [`run_from`](Self::run_from) the same paths of the noise. Without it each start has paths of its own.
    ///
    /// Means at starts that lie close together then have nearly the same sampling error, so that their differences have a small one: what is needed for a
    /// gradient. A mean over the starts has a larger error than with paths of their own.
    ///
    #[doc = include_str!("example.md")]
    /// let points = [1.0, 1.001].map(|q| State::new([q], [0.0]));
    /// let summaries = ensemble().share_paths(true).run_from(&points)?;
    /// let [a, b] = [0, 1].map(|k| summaries[k]["q"].mean()[1]);
    /// assert!((b - a).abs() < 0.001); // the sampling errors are the same
    #[doc = include_str!("../example_end.md")]
    #[must_use]
    pub fn share_paths(mut self, share: bool) -> Self {
        self.share_paths = share;
        self
    }

    /// Runs all paths from each of several starts, in place of a [`start`](Self::start). Returns a summary for each, in their order.
    ///
    /// With a [`weight`](Self::weight) and a [`terminal`](Self::terminal) function this is the solution of a parabolic equation at several points:
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
    /// // ∂u/∂t = p ∂u/∂q − q ∂u/∂p + ½σ² ∂²u/∂p² − ½κq²u,  u(0) = 1
    /// let oscillator = Integrator::new(Oscillator { sigma: 0.8 }, Midpoint);
    /// let kappa = 1.3;
    /// let points = [State::new([0.7], [-0.4]), State::new([0.0], [0.0])];
    /// let summaries = Ensemble::new(&oscillator)
    ///     .paths(20_000).seed(1)
    ///     .steps(1.0 / 16.0, 32)
    ///     .weight(|_, state| 0.5 * kappa * state.q[0].powi(2))
    ///     .terminal("u", |_, _| 1.0)
    ///     .run_from(&points)?;
    /// let (u, error) = (summaries[0]["u"].mean()[1], summaries[0]["u"].standard_error()[1]);
    /// assert!(error < 0.002 && (u - 0.627173387859).abs() < 4.0 * error + 1e-4);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Start number `k` has the paths of the noise from `k` times the number of paths on, or the first ones if paths are [shared](Self::share_paths). Shards are made and
    /// merged start by start.
    ///
    /// # Errors
    /// As [`run`](Self::run); [`EnsembleError::PointsInOneFile`] with a checkpoint, which is a file for one start.
    pub fn run_from(
        mut self,
        starts: &[StateOf<I::System>],
    ) -> Result<Vec<Summary>, EnsembleError> {
        #[cfg(feature = "checkpoint")]
        if self.execution.checkpoint.is_some() {
            return Err(EnsembleError::PointsInOneFile);
        }
        let seed = self.seed.unwrap_or(0);
        let noise = (self.noise).unwrap_or_else(|| Wiener::new(seed).many_paths());
        let each = if self.share_paths {
            0
        } else {
            self.paths.unwrap_or(0)
        };
        let mut summaries = Vec::with_capacity(starts.len());
        for (start, number) in starts.iter().zip(0_u64..) {
            let mut noise = noise;
            noise.first_path = noise.first_path.wrapping_add(number.wrapping_mul(each));
            self.noise = Some(noise);
            self.start = Some(Starts::Same(*start));
            summaries.push(self.run()?);
        }
        Ok(summaries)
    }
}

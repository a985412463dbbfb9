//! Steps that fail, in smaller steps on the same path of the noise.
//!
//! Input: a step of a path that failed. Output: the state after it, or the error of its smallest
//! part.

use super::Ensemble;
use super::path_block::PathBlock;
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::method::Within;
use crate::noise::DyadicInterval;
use crate::system::StateOf;
use crate::trajectory::Halving;

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Refines steps that fail, as [`Trajectory::refine`](crate::Trajectory::refine) does: divides
    /// such a step into two halves on the same path of the noise, and divides each half that fails
    /// in the same way, up to `depth` times.
    /// [`Summary::refined_steps`](super::Summary::refined_steps) counts the refined steps. If the
    /// smallest parts fail too, the path fails.
    ///
    /// All steps are smaller, on the same paths, with the [`noise`](Self::noise)
    /// `Wiener::new(seed).refine(depth)?` and `steps(h / 2^depth, …)`.
    ///
    /// The noise has to be known within steps: [`Wiener`](crate::noise::Wiener), also refined, or
    /// [`NoNoise`](crate::noise::NoNoise).
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// A pendulum with noise of fourth degree in the momentum: for a large ΔW the step has no
    /// /// solution.
    /// struct Rotor;
    ///
    /// #[variational(midpoint)]
    /// impl Rotor {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + q.cos() }
    ///     #[h1]
    ///     fn jitter(&self, _q: f64, p: f64) -> f64 { 0.1 * p.powi(4) }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let rotor = Integrator::new(Rotor, Midpoint);
    /// let start = State::new([0.0], [2.0]);
    /// let ensemble = || Ensemble::new(&rotor).paths(100).steps(0.5, 50).start(start);
    /// assert!(ensemble().run()?.failed() > 0);
    /// let summary = ensemble().refine(16).run()?;
    /// assert!(summary.failed() == 0 && summary.refined_steps() > 0);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn refine(mut self, depth: u32) -> Self {
        self.refine = depth;
        self
    }
}

impl<I: PathMethod> PathBlock<'_, I> {
    /// Makes the last step of a path, which failed, in smaller steps, if these were asked for.
    #[cold]
    pub(super) fn step_in_parts(
        &mut self,
        error: StepError,
        tile: usize,
        lane: usize,
        state: &mut StateOf<I::System>,
        dw: &I::Increments,
    ) -> Result<(), StepError> {
        let (settings, path) = (&self.settings, self.tiles[tile].paths[lane]);
        let depth = settings.ensemble.refine;
        let Some(noise) = settings.noise.within_steps(path).filter(|_| depth > 0) else {
            return Err(error);
        };
        let halving = Halving {
            method: Within {
                method: settings.method,
                step: Some(&self.prepared),
            },
            noise: &*noise,
            depth,
        };
        let whole = DyadicInterval::whole(self.step - 1);
        halving.step(error, whole, settings.h, dw, state)?;
        self.ends.refined.push(path);
        Ok(())
    }
}

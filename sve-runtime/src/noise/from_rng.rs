//! Increments from a random generator of the `rand` crates.
//!
//! Input: a generator of random words. Output: √h z with z the next standard normal of its stream.
//! Invariant: every two words become two normals, and both normals are used.

use super::{Noise, NoiseError, box_muller};
use crate::error::check_step;
use crate::gauss::stage_noise;

/// Increments drawn one after another from a generator of the `rand` crates (`rand_core` 0.10).
///
/// The step number is ignored: each call takes the next numbers of the generator. A path cannot be
/// replayed or read in another order, and two trajectories that share a generator by reference
/// share its stream; use [`Wiener`](crate::noise::Wiener) for these purposes. Two words give two
/// normals, by the transform of `Wiener`.
///
/// The only error is [`NoiseError::InvalidStep`], for an `h` that is zero or not finite.
///
/// ```
/// use rand::{SeedableRng, rngs::StdRng};
/// use sve_runtime::noise::{FromRng, Noise};
///
/// let mut noise = FromRng::new(StdRng::seed_from_u64(42));
/// let (mut first, mut second) = ([0.0], [0.0]);
/// noise.increments(0, 0.1, &mut first)?;
/// noise.increments(0, 0.1, &mut second)?;
/// assert_ne!(first, second); // the same step number, the next draw
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
#[derive(Clone, Debug)]
pub struct FromRng<R> {
    rng: R,
    /// The second normal of the last pair, with variance 1.
    spare: Option<f64>,
}

impl<R: rand_core::Rng> FromRng<R> {
    /// Takes a generator, or a mutable reference to one.
    pub fn new(rng: R) -> Self {
        Self { rng, spare: None }
    }

    #[inline]
    fn normal(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        let [first, second] = box_muller::pair(self.rng.next_u64(), self.rng.next_u64(), 1.0);
        self.spare = Some(second);
        first
    }
}

impl<R: rand_core::Rng> Noise for FromRng<R> {
    #[inline]
    fn increments(&mut self, _step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        check_step(h)?;
        let scale = h.abs().sqrt();
        for dw in dw {
            *dw = scale * self.normal();
        }
        Ok(())
    }

    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let weights = stage_noise::weights(stages).ok_or(NoiseError::NoStages { stages })?;
        self.increments(step, h, dw)?;
        for (dw, weight) in dw.iter_mut().zip(weights.iter().cycle()) {
            *dw *= weight.sqrt();
        }
        Ok(())
    }
}

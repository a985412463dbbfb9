//! Wiener paths from a counter-based generator.
//!
//! Input: seed, path, step, process and step size. Output: √h z with z a standard normal.
//! Invariant: z is a pure function of (seed, path, step, process), the same bits on every machine.

#[cfg(feature = "ensemble")]
use super::Halves;
use super::counter_path::CounterPath;
use super::distribution::{Distribution, Workspace};
#[cfg(feature = "ensemble")]
use super::many_paths::{DistributionKind, ManyPaths, PathData, PathDistribution};
use super::stages::StagePath;
use super::{Noise, NoiseError, Replayable, WithinSteps, box_muller};

/// Wiener paths from a seed: any step of any path, in any order, always the same.
///
/// An increment is a pure function of the seed, the path, the step and the process: nothing is
/// consumed. Seed and path are enough to replay a path, to enter it in the middle, and to share it
/// between threads or machines. Two systems with equal `Wiener`s have the same noise. Increments of
/// different seeds, paths, steps or processes are independent, also of neighbouring ones. The bits
/// are the same on every platform: normals are computed by arithmetic with fused multiply-adds and
/// square roots, without a library's `ln`, `sin` and `cos`. Machines without a fused multiply-add
/// compute it by a slow function of the library.
///
/// An increment has variance `h` and never exceeds 9.4926 √h in size.
///
/// A source is a value to copy. As a [`Noise`] it draws and keeps the increments of 32 steps for up
/// to four processes, and of four steps for up to 16, so steps in sequence cost least. Increments
/// of further processes are drawn step by step. Its only error as a [`Noise`] is
/// [`NoiseError::InvalidStep`], for an `h` that is zero or not finite.
///
/// ```
/// use sve_runtime::noise::{Noise, Wiener};
///
/// let paths = Wiener::new(42);
/// let mut path = paths.path(3);
/// let mut dw = [0.0; 2];
/// for step in [0, 1, 1_000_000, 5] {
///     path.increments(step, 0.01, &mut dw)?;
///     assert_eq!(dw[0], path.increment(step, 0, 0.01));
///     assert_ne!(dw[0], paths.increment(step, 0, 0.01)); // that is path 0
/// }
/// # Ok::<(), sve_runtime::noise::NoiseError>(())
/// ```
///
/// A trajectory begins at step 0 of its source. To continue from a state reached after `k` steps,
/// give [`from_step(k)`](super::Replayable::from_step); otherwise the increments of these steps are
/// repeated.
///
/// [`refine`](Self::refine) gives the same path in smaller steps.
///
/// For rules with [stage noise](crate::StageNoise) it draws the same path in more detail: the
/// increments at the stages add up to the increments of the steps.
///
/// Generator: Threefry4x64-13 of Salmon, Moraes, Dror and Shaw (2011); normals by Box and Muller
/// (1958).
#[derive(Clone, Copy, Debug)]
pub struct Wiener(
    pub(super) CounterPath<Normal>,
    /// The higher coefficients, for the stages of Gauss rules.
    StagePath,
);

impl Wiener {
    /// Returns path 0 of a seed. All seeds are equally good.
    pub fn new(seed: u64) -> Self {
        Self(CounterPath::new(seed), StagePath::new(seed))
    }

    /// Returns path number `path` of the same seed.
    ///
    /// ```
    /// use sve_runtime::noise::Wiener;
    ///
    /// let paths = Wiener::new(42);
    /// let [first, second] = [0, 1].map(|k| paths.path(k).increment(0, 0, 0.01));
    /// assert_ne!(first, second);
    /// ```
    #[must_use]
    pub fn path(&self, path: u64) -> Self {
        Self(self.0.path(path), self.1.path(path))
    }

    /// Returns the increment of a process (from 0) over step number `step` (from 0) of length `h`.
    ///
    /// It equals the increment from [`Noise::increments`], and costs several times as much in a
    /// sequence of steps. Its variance is |h|. If `h` is NaN, returns NaN.
    #[inline]
    pub fn increment(&self, step: u64, process: usize, h: f64) -> f64 {
        self.0.increment(step, process, h)
    }
}

impl Noise for Wiener {
    #[inline]
    fn increments(&mut self, step: u64, h: f64, dw: &mut [f64]) -> Result<(), NoiseError> {
        self.0.increments(step, h, dw)
    }

    fn stage_increments(
        &mut self,
        step: u64,
        h: f64,
        stages: usize,
        dw: &mut [f64],
    ) -> Result<(), NoiseError> {
        let Self(whole, higher) = self;
        higher.increments(whole, step, h, stages, dw)
    }

    fn within_steps(&self) -> Option<WithinSteps<'_>> {
        Some(WithinSteps::of(self))
    }

    fn is_replayable(&self) -> bool {
        true
    }
}

impl Replayable for Wiener {}

#[cfg(feature = "ensemble")]
impl ManyPaths for Wiener {
    fn many_paths(self) -> PathData {
        PathData::of(&self.0, &Normal)
    }
}

/// Normal increments.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Normal;

impl Distribution for Normal {
    const DOMAIN: u64 = u64::from_le_bytes(*b"wiener  ");

    #[inline(always)]
    fn four(words: [u64; 4], scale: f64) -> [f64; 4] {
        box_muller::inlined_four(words, scale)
    }

    #[inline(always)]
    fn fill_lanes<const L: usize, const AVX512: bool>(
        words: impl Fn(usize) -> [u64; 4],
        scale: f64,
        work: &mut Workspace<L>,
        out: &mut [[f64; L]; 4],
    ) {
        box_muller::fill_lanes::<L, AVX512>(words, scale, work, out);
    }
}

#[cfg(feature = "ensemble")]
impl PathDistribution for Normal {
    const KIND: DistributionKind = DistributionKind::Normal;
    const NAME: &'static str = "normal increments";
    const HAS_SUMS: bool = true;
    const HAS_STAGES: bool = true;

    fn within_steps(seed: u64, path: u64, depth: u32) -> Option<Box<dyn Halves>> {
        let path = Wiener::new(seed).path(path);
        if depth == 0 {
            return Some(Box::new(path));
        }
        let refined = path.refine(depth).ok()?;
        Some(Box::new(refined))
    }
}

//! Sources with a path for each number: the noise of an ensemble.
//!
//! Input: a source. Output: the data from which increments of many paths are drawn in lanes.
//! Invariant: a source is one file, which implements [`ManyPaths`] and, if its increments have a
//! distribution of their own, [`PathDistribution`].

use core::fmt::Debug;

use super::counter_path::CounterPath;
use super::distribution::Distribution;
use super::lanes::{Draw, Rows, fill};
use super::{Halves, Noise, Truncated};

/// A source with a path for each number, for [`Ensemble::noise`](crate::ensemble::Ensemble::noise).
///
/// [`Wiener`](super::Wiener), also [refined](super::Wiener::refine),
/// [`ThreePoint`](super::ThreePoint), [`NoNoise`](super::NoNoise) and `Truncated<Wiener>` are such
/// sources. Path `k` of the ensemble has the increments of path `first + k` of the source, where
/// `first` is the path of the given source, 0 unless [`path`](super::Wiener::path) sets it.
#[diagnostic::on_unimplemented(
    message = "`{Self}` cannot be the noise of an ensemble",
    label = "this source does not have a path for each number",
    note = "an ensemble takes `Wiener::new(seed)`, also refined, `Truncated::new(Wiener::new(seed))`, `ThreePoint::new(seed)` or `NoNoise`; \
            the increments of `ThreePoint` are bounded by √(3h) and are not truncated"
)]
pub trait ManyPaths {
    /// The data of the source.
    #[doc(hidden)]
    fn many_paths(self) -> PathData;
}

/// The kinds of distributions. Their numbers are part of the fingerprints of shards and
/// checkpoints, so they must not change.
#[derive(Clone, Copy)]
pub(crate) enum DistributionKind {
    Normal = 0,
    ThreePoint = 1,
    NoNoise = 2,
}

/// A distribution from which the increments of many paths are drawn.
pub(crate) trait PathDistribution: Distribution + Debug + Sync + 'static {
    /// The kind of the distribution.
    const KIND: DistributionKind;
    /// The name of the increments on pages.
    const NAME: &'static str;
    /// True if the sum of the increments over two halves of a step has the distribution of the
    /// increment over the step.
    const HAS_SUMS: bool = false;
    /// True if [`fill_stages`](super::stages::fill_stages) draws the increments at the stages of a
    /// rule.
    const HAS_STAGES: bool = false;

    /// Returns a path in steps that are halved `depth` times, if the path is known within steps.
    fn within_steps(seed: u64, path: u64, depth: u32) -> Option<Box<dyn Halves>> {
        let _ = (seed, path, depth);
        None
    }
}

/// A [`PathDistribution`] as a value.
pub(crate) trait AnyDistribution: Debug + Sync {
    /// Returns [`PathDistribution::KIND`].
    fn kind(&self) -> DistributionKind;
    /// Returns [`PathDistribution::NAME`].
    fn name(&self) -> &'static str;
    /// Returns [`PathDistribution::HAS_SUMS`].
    fn has_sums(&self) -> bool;
    /// Returns [`PathDistribution::HAS_STAGES`].
    fn has_stages(&self) -> bool;
    /// Calls [`PathDistribution::within_steps`].
    fn within_steps(&self, seed: u64, path: u64, depth: u32) -> Option<Box<dyn Halves>>;
    /// Returns a path in steps that are halved `depth` times.
    fn path(&self, seed: u64, path: u64, depth: u32) -> Box<dyn Noise>;
    /// Fills rows with increments, see [`fill`].
    fn fill(&self, draw: &Draw<'_>, out: &mut [Rows]);
}

impl<D: PathDistribution> AnyDistribution for D {
    fn kind(&self) -> DistributionKind {
        D::KIND
    }

    fn name(&self) -> &'static str {
        D::NAME
    }

    fn has_sums(&self) -> bool {
        D::HAS_SUMS
    }

    fn has_stages(&self) -> bool {
        D::HAS_STAGES
    }

    fn within_steps(&self, seed: u64, path: u64, depth: u32) -> Option<Box<dyn Halves>> {
        D::within_steps(seed, path, depth)
    }

    fn path(&self, seed: u64, path: u64, depth: u32) -> Box<dyn Noise> {
        match D::within_steps(seed, path, depth) {
            Some(path) => path,
            None => Box::new(CounterPath::<D>::new(seed).path(path)),
        }
    }

    fn fill(&self, draw: &Draw<'_>, out: &mut [Rows]) {
        fill::<D>(draw, out);
    }
}

/// The data of a source with many paths.
#[derive(Clone, Copy, Debug)]
pub struct PathData {
    /// Seed and first path; `None` without noise.
    pub(crate) seed: Option<u64>,
    pub(crate) first_path: u64,
    /// The distribution of the increments; `None` without noise.
    pub(crate) distribution: Option<&'static dyn AnyDistribution>,
    pub(crate) truncation: Option<Truncated<()>>,
    /// Number of halvings of a step of the source: the ensemble makes 2^`depth` steps in each step
    /// of the source.
    pub(crate) depth: u32,
}

impl PathData {
    /// The data of the source without noise.
    pub(super) const NONE: Self = Self {
        seed: None,
        first_path: 0,
        distribution: None,
        truncation: None,
        depth: 0,
    };

    /// Returns the data of a counter-based source.
    pub(super) fn of<D: PathDistribution>(path: &CounterPath<D>, distribution: &'static D) -> Self {
        Self {
            seed: Some(path.seed),
            first_path: path.path,
            distribution: Some(distribution),
            ..Self::NONE
        }
    }
}

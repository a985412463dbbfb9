//! Sources with a path for each number: the noise of an ensemble.
//!
//! Input: a source. Output: the plain data from which increments of many paths are drawn in lanes.

use super::lanes::DistributionKind;
use super::{NoNoise, Refined, ThreePoint, Truncated, Wiener};

/// A source with a path for each number, for [`Ensemble::noise`](crate::ensemble::Ensemble::noise).
///
/// [`Wiener`], also [refined](Wiener::refine), [`ThreePoint`], [`NoNoise`] and `Truncated<Wiener>` are such sources. Path `k` of the ensemble has the increments of path `first + k`
/// of the source, where `first` is the path of the given source, 0 unless [`path`](Wiener::path) sets it.
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

/// The data of a source with many paths.
#[derive(Clone, Copy, Debug)]
pub struct PathData {
    /// Seed and first path; `None` without noise.
    pub(crate) seed: Option<u64>,
    pub(crate) first_path: u64,
    /// The distribution of the increments; `None` without noise.
    pub(crate) distribution: Option<DistributionKind>,
    pub(crate) truncation: Option<Truncated<()>>,
    /// Number of halvings of a step of the source: the ensemble makes 2^`depth` steps in each.
    pub(crate) depth: u32,
}

impl ManyPaths for Wiener {
    fn many_paths(self) -> PathData {
        PathData {
            seed: Some(self.0.seed),
            first_path: self.0.path,
            distribution: Some(DistributionKind::Normal),
            truncation: None,
            depth: 0,
        }
    }
}

/// The steps of the ensemble are parts of those of the path, as in a trajectory: `steps(h / 2^depth, …)`.
impl ManyPaths for Refined {
    fn many_paths(self) -> PathData {
        let (path, depth) = self.into_parts();
        PathData {
            depth,
            ..path.many_paths()
        }
    }
}

impl ManyPaths for ThreePoint {
    fn many_paths(self) -> PathData {
        PathData {
            seed: Some(self.0.seed),
            first_path: self.0.path,
            distribution: Some(DistributionKind::ThreePoint),
            truncation: None,
            depth: 0,
        }
    }
}

impl ManyPaths for NoNoise {
    fn many_paths(self) -> PathData {
        PathData {
            seed: None,
            first_path: 0,
            distribution: None,
            truncation: None,
            depth: 0,
        }
    }
}

impl ManyPaths for Truncated<Wiener> {
    fn many_paths(self) -> PathData {
        PathData {
            truncation: Some(self.bound_alone()),
            ..self.into_source().many_paths()
        }
    }
}

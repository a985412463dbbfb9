//! The data that summaries of the same run have in common.
//!
//! Input: the settings of a run. Output: the first difference between two runs, by which shards and
//! checkpoints of another run are refused.

use super::difference::Difference;
use super::fingerprint::Fingerprint;
use super::settings::Settings;
#[cfg(feature = "serde")]
use super::statistic::Extent;
use super::statistic::{self, AnyRequest};
use crate::description::{RunDescription, SystemDescription};
use crate::ensemble::PathMethod;
use crate::system::{Increments, IncrementsOf};

/// The data that summaries of the same run have in common.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Info {
    pub(super) names: Vec<String>,
    /// Number of bins between two recorded times in which passages are counted.
    pub(super) passage_bins: u64,
    pub(super) statistics: Vec<AnyRequest>,
    pub(super) times: Vec<f64>,
    pub(super) paths: u64,
    pub(super) coordinates: usize,
    /// Number of momenta of a final state.
    pub(super) momenta: usize,
    pub(super) fingerprint: Fingerprint,
    /// The description of the run on pages. Runs are not compared by it.
    pub(super) description: RunDescription,
}

impl Info {
    /// Returns the first difference to another run; `None` for the same run.
    pub(super) fn difference(&self, other: &Self) -> Option<Difference> {
        if self.names != other.names {
            return Some(Difference::Observables);
        }
        let same = [
            (self.times == other.times, Difference::Times),
            (
                self.passage_bins == other.passage_bins,
                Difference::Settings,
            ),
            (self.paths == other.paths, Difference::Paths),
            (self.coordinates == other.coordinates, Difference::Formulas),
            (self.momenta == other.momenta, Difference::Formulas),
        ];
        let differs = same
            .into_iter()
            .find_map(|(same, what)| (!same).then_some(what));
        statistic::difference(&self.statistics, &other.statistics)
            .or(differs)
            .or_else(|| self.fingerprint.difference(&other.fingerprint))
    }

    /// Returns the extent of results of so many paths.
    #[cfg(feature = "serde")]
    pub(super) fn extent(&self, paths: u64) -> Extent<'_> {
        Extent {
            names: &self.names,
            records: self.times.len() as u64,
            paths,
            passage_bins: self.passage_bins,
        }
    }
}

impl<I: PathMethod> Settings<'_, I> {
    /// Returns the description of the run for pages.
    pub(super) fn description(&self) -> RunDescription {
        let has_noise = <IncrementsOf<I::System>>::COUNT > 0;
        RunDescription {
            system: SystemDescription::of(self.method.system()),
            method: self.method.describe(),
            h: self.h,
            steps: self.steps,
            noise: if has_noise {
                self.noise.describe()
            } else {
                String::new()
            },
            seed: self.noise.seed,
            start_seed: self.start_seed,
        }
    }
}

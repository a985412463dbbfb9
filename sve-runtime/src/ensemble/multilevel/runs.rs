//! The paths of a level of the multilevel method: a coarse and a fine run along the same paths of
//! the noise.
//!
//! Input: the number of a level and of its blocks. Output: the mean and the variance of the
//! difference, and how it is spread. Invariant: blocks that were run are not run again.

use super::Multilevel;
use crate::ensemble::PathMethod;
use crate::ensemble::coupled::Coupled;
use crate::ensemble::estimate::Level;
use crate::ensemble::fingerprint::Fingerprint;
use crate::ensemble::info::Info;
use crate::ensemble::merge_tree::{MergeTree, PartialResult};
use crate::ensemble::settings::{Leg, Settings};
use crate::ensemble::spread::Spread;
use crate::ensemble::{BLOCK_PATHS, EnsembleError, Summary};

/// Number of paths of the noise that are reserved for a level.
pub(super) const PATHS_OF_LEVEL: u64 = 1 << 48;

/// A level that has been run so far.
pub(super) struct Run<'a, I: PathMethod> {
    pub(super) number: u32,
    /// The coarse and the fine run; on level 0 one run.
    pub(super) legs: Coupled<'a, I>,
    info: Info,
    tree: Option<MergeTree>,
    pub(super) blocks: u64,
    pub(super) level: Level,
    pub(super) spread: Spread,
    /// Number of times that the paths were doubled since they differ, for more of them to carry the
    /// variance.
    pub(super) doublings: u32,
}

impl<'a, I: PathMethod + Sync> Multilevel<'a, I> {
    /// Runs the first blocks of a level.
    pub(super) fn begin(&self, number: u32, blocks: u64) -> Result<Run<'a, I>, EnsembleError> {
        let leg = |halvings, is_coarsened| {
            let leg = Leg {
                halvings,
                is_coarsened,
                first_path: u64::from(number).wrapping_mul(PATHS_OF_LEVEL),
                paths: Some(PATHS_OF_LEVEL),
                of: Some(super::MULTILEVEL),
                ..Leg::of(self.ensemble)
            };
            Settings::of_leg(self.ensemble, &leg)
        };
        let fine = leg(number, false)?;
        let mut legs = Vec::new();
        if number > 0 {
            legs.push(leg(number - 1, true)?);
        }
        legs.push(fine);
        let steps = legs.iter().map(|leg| leg.steps).sum();
        let legs = Coupled { legs };
        // never merged with another run, so it needs no fingerprint
        let info = legs.info_of_differences(legs.legs.len() - 1, Fingerprint::default());
        let mut run = Run {
            number,
            legs,
            info,
            tree: None,
            blocks: 0,
            level: Level {
                h: fine.h,
                steps,
                paths: 0,
                failed: 0,
                mean: f64::NAN,
                variance: f64::NAN,
                standard_error: f64::NAN,
            },
            spread: Spread {
                range: 0.0,
                carriers: 0.0,
            },
            doublings: 0,
        };
        self.extend(&mut run, blocks)?;
        Ok(run)
    }

    /// Runs the blocks of a level up to this number, and updates its numbers.
    pub(super) fn extend(&self, run: &mut Run<'a, I>, blocks: u64) -> Result<(), EnsembleError> {
        let legs = &run.legs;
        let mut settings = legs.legs[0];
        settings.shard = [run.blocks, blocks];
        let trees = settings.execute_with(1, |block| {
            // the last result is the difference, or the only run
            let last = legs.run_block(block)?.pop();
            Ok(last.map(PartialResult::of_differences)).map(|result| result.into_iter().collect())
        })?;
        for mut tree in trees {
            let old = run
                .tree
                .take()
                .into_iter()
                .flat_map(|old| old.nodes.into_values());
            old.for_each(|node| tree.insert(node));
            run.tree = Some(tree);
        }
        run.blocks = blocks;
        let Some(tree) = &run.tree else {
            return Err(EnsembleError::NothingRun);
        };
        let summary = Summary::new(run.info.clone(), tree.clone());
        let Some(statistics) = summary.get(&self.name) else {
            return Err(EnsembleError::NothingRun);
        };
        let last = summary.times().len() - 1;
        let paths = blocks * BLOCK_PATHS;
        let (counted, mean) = (summary.counts()[last], statistics.mean()[last]);
        let standard_error = statistics.standard_error()[last];
        run.level = Level {
            paths,
            failed: paths - counted,
            mean,
            // for each path also where paths are pairs
            variance: standard_error.powi(2) * counted as f64,
            standard_error,
            ..run.level
        };
        run.spread = statistics.spread(last);
        if !(mean.is_finite() && run.level.variance.is_finite()) {
            return Err(EnsembleError::NoLevel {
                name: self.name.clone(),
                level: run.number,
                h: run.level.h,
                failed: run.level.failed,
                paths,
            });
        }
        Ok(())
    }
}

/// Returns the numbers of all levels.
pub(super) fn levels<I: PathMethod>(runs: &[Run<'_, I>]) -> Vec<Level> {
    runs.iter().map(|run| run.level).collect()
}

/// Returns the largest difference of two values of a level.
pub(super) fn largest_range<I: PathMethod>(runs: &[Run<'_, I>]) -> f64 {
    runs.iter().map(|run| run.spread.range).fold(0.0, f64::max)
}

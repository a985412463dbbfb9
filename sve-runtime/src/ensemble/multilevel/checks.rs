//! Refusals of the multilevel method: settings that do not go with it, and levels that have no
//! mean.
//!
//! Input: the settings; the levels that have been run. Output: an error with a remedy, if they give
//! no estimate.

use super::runs::{Run, largest_range};
use super::{FIRST_LEVELS, MULTILEVEL, Multilevel, SURE};
use crate::ensemble::PathMethod;
use crate::ensemble::estimate::Level;
use crate::ensemble::settings::{Leg, Settings};
use crate::ensemble::starts::Start;
use crate::ensemble::{BLOCK_PATHS, EnsembleError};
use crate::system::{Increments, IncrementsOf};

impl<I: PathMethod + Sync> Multilevel<'_, I> {
    /// Checks the settings. Returns the first number of blocks of each level.
    pub(super) fn checked(&self, error: f64) -> Result<u64, EnsembleError> {
        let ensemble = self.ensemble;
        let settings = Settings::of_leg(
            ensemble,
            &Leg {
                of: Some(MULTILEVEL),
                ..Leg::of(ensemble)
            },
        )?;
        #[cfg(feature = "checkpoint")]
        let has_file = ensemble.execution.checkpoint.is_some();
        #[cfg(not(feature = "checkpoint"))]
        let has_file = false;
        let is_part = ensemble
            .execution
            .shard
            .is_some_and(|shard| shard != (0, 1));
        if is_part || ensemble.execution.stop_when.is_some() || has_file {
            return Err(EnsembleError::MultilevelInParts);
        }
        if self.deepest < FIRST_LEVELS - 1 {
            return Err(EnsembleError::TooFewLevels {
                deepest: self.deepest,
            });
        }
        let settings_without = [
            (settings.noise.depth > 0, "refined noise"),
            (ensemble.keep_final_states, "keep_final_states"),
        ];
        if let Some((_, setting)) = settings_without.into_iter().find(|(is_set, _)| *is_set) {
            return Err(EnsembleError::NotTogether {
                settings: [MULTILEVEL, setting],
                why: "each level has paths and steps of its own",
            });
        }
        for (what, value) in [("error", error), ("weak order", self.weak_order)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(EnsembleError::MultilevelTarget { what, value });
            }
        }
        if !ensemble.observed.names.contains(&self.name) {
            return Err(EnsembleError::UnknownObservable {
                name: self.name.clone(),
                purpose: "take the mean of",
                known: ensemble.observed.names.clone(),
            });
        }
        Ok(settings.paths.div_ceil(BLOCK_PATHS))
    }
}

/// Returns an error if all paths of each level have the same value, although they have noise or
/// random starts: an event that is too rare for them would look the same.
pub(super) fn check_values<I: PathMethod>(
    multilevel: &Multilevel<'_, I>,
    runs: &[Run<'_, I>],
) -> Result<(), EnsembleError> {
    let [first, finer @ ..] = runs else {
        return Ok(());
    };
    let noise = &first.legs.legs[0].noise;
    let has_noise = noise.distribution.is_some() && <IncrementsOf<I::System>>::COUNT > 0;
    let has_starts = matches!(multilevel.ensemble.start, Some(Start::Drawn(_)));
    let may_differ = has_noise || has_starts;
    let have_changes = finer.iter().any(|run| run.level.mean != 0.0);
    if !may_differ || have_changes || largest_range(runs) > 0.0 {
        return Ok(());
    }
    Err(EnsembleError::OneValue {
        name: multilevel.name.clone(),
        value: first.level.mean,
        paths: first.level.paths,
    })
}

/// Returns the size that the mean of a level has for certain.
pub(super) fn least_size(level: &Level) -> f64 {
    (level.mean.abs() - SURE * level.standard_error).max(0.0)
}

/// Returns an error if the last three differences do not fall, for certain.
pub(super) fn check_fall(name: &str, levels: &[Level]) -> Result<(), EnsembleError> {
    let [_, .., first, second, third] = levels else {
        return Ok(());
    };
    let largest_size = |level: &Level| level.mean.abs() + SURE * level.standard_error;
    let do_not_fall = |a, b| least_size(b) >= largest_size(a);
    if !(do_not_fall(first, second) && do_not_fall(second, third)) {
        return Ok(());
    }
    Err(EnsembleError::NoLimit {
        name: name.to_owned(),
        level: levels.len() as u32 - 1,
        changes: [first, second, third].map(|level| level.mean.abs()),
    })
}

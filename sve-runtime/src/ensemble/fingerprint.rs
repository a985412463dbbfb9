//! Fingerprints: hashes that identify shards and checkpoints of the same run.
//!
//! Input: the settings, the system's formulas and parameters, the method, starts, and values along
//! some paths. Output: a 64-bit hash of each of them, so that a message can name the one that
//! differs. Invariant: equal runs have equal hashes; every value enters with all its bits.
//!
//! Closures cannot be read, so they are sampled: starts of up to 33 paths; observables along path 0
//! at its recorded times, and along three other paths for a few steps; memories of
//! [`fold`](super::Ensemble::fold) along the first steps of these paths. The behaviour of a closure
//! elsewhere does not enter.

use std::collections::BTreeSet;

use super::difference::Difference;
use super::observer::{Kind, LastStep, Seen};
use super::settings::Settings;
use super::systems::Systems;
use crate::ensemble::PathMethod;
use crate::fingerprint::{Hash, StepsDifference, StepsFingerprint, hash};
use crate::lanes::LANES;
use crate::method::DimsOf;
use crate::noise::{self, DistributionKind};
use crate::phase::configuration::Configuration;
use crate::phase::state::State;
use crate::system::{Dimensions, Increments as _};

/// Smallest number of steps of path 0 that are compared.
const STEPS: u64 = 4096;

/// For the fingerprint, one step is made for each `SHARE` steps of the run, if that gives more than
/// [`STEPS`]. A scalar step costs up to nine steps in lanes, so the fingerprint takes at most a
/// hundredth of the time.
const SHARE: u128 = 1024;

/// Number of steps of three other paths that are compared.
const OTHER_STEPS: u64 = 64;

/// Number of first paths whose starts are compared. The starts of as many evenly distributed paths
/// are compared too, and the start of the last path.
const STARTS: u64 = 16;

/// The fingerprint of a run.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub(super) struct Fingerprint {
    seed: u64,
    noise: u64,
    settings: u64,
    steps: StepsFingerprint,
    starts: u64,
    values: u64,
}

impl Fingerprint {
    /// Returns the first difference to another run.
    pub(super) fn difference(&self, other: &Self) -> Option<Difference> {
        if let Some(steps) = self.steps.difference(&other.steps) {
            return Some(match steps {
                StepsDifference::Formulas => Difference::Formulas,
                StepsDifference::Parameters => Difference::Parameters,
                StepsDifference::Method => Difference::Method,
            });
        }
        [
            (self.seed == other.seed, Difference::Seed),
            (self.noise == other.noise, Difference::Noise),
            (self.settings == other.settings, Difference::Settings),
            (self.starts == other.starts, Difference::Starts),
            (self.values == other.values, Difference::Values),
        ]
        .into_iter()
        .find_map(|(same, what)| (!same).then_some(what))
    }
}

/// Adds time, configuration and momentum.
fn add_state<Q: Configuration>(hash: &mut Hash, state: &State<Q>) {
    hash.add_number(state.t);
    for x in state.stored().into_iter().flatten() {
        hash.add_number(x);
    }
}

impl<I: PathMethod> Settings<'_, I> {
    pub(super) fn fingerprint(self) -> Fingerprint {
        let (ensemble, observed) = (self.ensemble, &self.ensemble.observed);
        Fingerprint {
            seed: hash(|hash| {
                hash.add(self.noise.seed);
                if self.start_seed != self.noise.seed {
                    hash.add(self.start_seed);
                }
            }),
            noise: hash(|hash| match self.noise.distribution {
                None => hash.add(DistributionKind::NoNoise as u64),
                Some(distribution) => {
                    hash.add(noise::VERSION);
                    hash.add(distribution.kind() as u64);
                    hash.add_number(self.noise.largest);
                    if self.noise.depth != 0 {
                        hash.add(u64::from(self.noise.depth));
                    }
                    if self.noise.first_path != 0 {
                        hash.add(self.noise.first_path);
                    }
                    if self.noise.is_antithetic || self.noise.is_coarsened {
                        hash.add(u64::from(self.noise.is_antithetic));
                        hash.add(u64::from(self.noise.is_coarsened));
                    }
                }
            }),
            settings: hash(|hash| {
                hash.add_number(self.h);
                hash.add(self.steps);
                hash.add(u64::from(ensemble.keep_final_states));
                // Runs without integrals keep the hashes of earlier versions.
                let kinds = observed.observables.iter().map(|of| of.kind());
                if kinds.clone().any(|kind| kind != Kind::Plain) || observed.weight.is_some() {
                    for kind in kinds {
                        hash.add(kind as u64);
                    }
                    hash.add(observed.settle);
                    hash.add(u64::from(observed.weight.is_some()));
                }
                if ensemble.refine > 0 {
                    hash.add(u64::from(ensemble.refine));
                }
                for passage in &observed.passages {
                    hash.add(u64::from(passage.stops));
                }
                for (name, range) in &observed.bounds {
                    let column = observed.column(name);
                    hash.add(column.unwrap_or(usize::MAX) as u64);
                    for &x in range {
                        hash.add_number(x);
                    }
                }
            }),
            steps: StepsFingerprint::of(self.method),
            starts: hash(|hash| self.add_starts(hash)),
            values: hash(|hash| self.add_values(hash)),
        }
    }

    fn add_starts(self, hash: &mut Hash) {
        let even = |k: u64| (u128::from(self.paths) * u128::from(k) / u128::from(STARTS)) as u64;
        let mut paths: BTreeSet<u64> = (0..STARTS.min(self.paths)).collect();
        paths.extend((0..STARTS).map(even));
        paths.insert(self.paths - 1);
        for path in paths {
            add_state(hash, &self.start_of(path));
        }
    }

    /// Adds states and observables along some paths.
    fn add_values(self, hash: &mut Hash) {
        let all = u128::from(self.paths) * u128::from(self.steps) / SHARE;
        let followed = u64::try_from(all).unwrap_or(u64::MAX).max(STEPS);
        self.add_path(0, followed, hash);
        let others = [1, self.paths / 2, self.paths - 1];
        for path in BTreeSet::from(others.map(|path| path.min(self.paths - 1))) {
            self.add_path(path, OTHER_STEPS, hash);
        }
    }

    /// Adds the states and observables along so many steps of a path.
    fn add_path(self, path: u64, steps: u64, hash: &mut Hash) {
        let method = self.method;
        let Ok(mut prepared) = method.prepare(self.h) else {
            return;
        };
        let mut state = self.start_of(path);
        let mut increments = self.noise.increments_of(path, self.h);
        let observables = &self.ensemble.observed.observables;
        let hidden = observables.iter().filter(|of| of.has_hidden_memory());
        let mut memories: Vec<_> = hidden.map(|of| of.observer(1, 0)).collect();
        for step in 0..=steps.min(self.steps) {
            if step > 0 {
                let mut dw = I::Increments::NONE;
                let made = increments(step - 1, dw.as_mut()).is_ok()
                    && (method.hold(&mut prepared, path, step - 1, &state)).is_ok()
                    && method
                        .step_prepared(&prepared, &mut state, self.h, &dw)
                        .is_ok();
                if !made {
                    hash.add(step);
                    return;
                }
                state.t = self.time(step);
            }
            if step > OTHER_STEPS {
                memories.clear();
            }
            if step == 0 {
                // inputs that fail are found by the first step
                let _ = method.hold(&mut prepared, path, 0, &state);
            }
            let system = method.system_in(&prepared);
            for memory in &mut memories {
                let (last, states) = (LastStep::whole(step, self.h), DimsOf::<I>::splat(&state));
                let systems = Systems::Same(system);
                let seen = Seen::new(&systems, 0, [&states; 2], 1, &last);
                memory.update(&seen);
                if step.is_power_of_two() {
                    let mut values = [0.0; LANES];
                    memory.values(&seen, &mut values);
                    hash.add_number(values[0]);
                }
            }
            let recorded = self.records_after(step);
            if recorded || step.is_power_of_two() {
                add_state(hash, &state);
            }
            if recorded {
                for observable in observables {
                    let value = observable.function().value(system, &state);
                    hash.add_number(value.unwrap_or(f64::NAN));
                }
                for passage in &self.ensemble.observed.passages {
                    let value = passage.function.value(system, &state);
                    hash.add_number(value.unwrap_or(f64::NAN));
                }
                if let Some(weight) = &self.ensemble.observed.weight {
                    let value = weight.function().value(system, &state);
                    hash.add_number(value.unwrap_or(f64::NAN));
                }
            }
        }
    }
}

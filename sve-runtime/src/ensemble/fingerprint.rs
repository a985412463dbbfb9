//! Fingerprints: hashes by which shards and checkpoints of the same run are recognised.
//!
//! Input: the settings, the system's formulas and parameters, the method, starts, and values along some paths. Output: a 64-bit hash of
//! each, so that a message can say which one differs. Invariant: equal runs have equal numbers; every value enters with all its bits.
//!
//! Closures cannot be read, so they are sampled: starts of up to 33 paths; observables along path 0 at its recorded times, and along
//! three others for a few steps; memories of [`fold`](super::Ensemble::fold) along the first steps of these paths. What a closure does elsewhere is not seen.

use std::collections::BTreeSet;

use super::difference::Difference;
use super::memory::{Kind, LastStep};
use super::path_noise::PathNoise;
use super::settings::Settings;
use crate::fingerprint::{Hash, StepsDifference, StepsFingerprint, hash};
use crate::noise::lanes::DistributionKind;
use crate::noise::{self, Noise, ThreePoint, Wiener};
use crate::phase::configuration::{Configuration, Coordinates, FixedSize};
use crate::phase::state::State;
use crate::system::{Dimensions, Dims, System};
use crate::trajectory::Method;

/// Smallest number of steps of path 0 that are compared.
const STEPS: u64 = 4096;

/// One step in so many of the run is made for the fingerprint, if that is more than [`STEPS`]. A scalar step costs up to nine steps
/// in lanes, so the fingerprint takes at most a hundredth of the time.
const SHARE: u128 = 1024;

/// Number of steps of three other paths that are compared.
const OTHER_STEPS: u64 = 64;

/// Number of first paths whose starts are compared. As many evenly distributed paths are compared, and the last one.
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
fn add_state<Q: FixedSize>(hash: &mut Hash, state: &State<Q>) {
    hash.add_number(state.t);
    let mut values = vec![0.0; Q::STORED_VALUES + Q::DEGREES_OF_FREEDOM];
    let (q, p) = values.split_at_mut(Q::STORED_VALUES);
    state.q.store(q);
    state.p.store(p);
    for x in values {
        hash.add_number(x);
    }
}

impl<I, S, Q, const N: usize, const M: usize> Settings<'_, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    pub(super) fn fingerprint(self) -> Fingerprint {
        let ensemble = self.ensemble;
        Fingerprint {
            seed: hash(|hash| {
                hash.add(self.noise.seed);
                if self.start_seed != self.noise.seed {
                    hash.add(self.start_seed);
                }
            }),
            noise: hash(|hash| match self.noise.distribution {
                None => hash.add(2),
                Some(distribution) => {
                    hash.add(noise::VERSION);
                    hash.add(u64::from(distribution == DistributionKind::ThreePoint));
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
                // runs without integrals have the hashes that they always had
                let are_plain = ensemble.kinds.iter().all(|&kind| kind == Kind::Value);
                if !are_plain || ensemble.weight.is_some() {
                    ensemble
                        .kinds
                        .iter()
                        .for_each(|&kind| hash.add(kind.number()));
                    hash.add(ensemble.settle);
                    hash.add(u64::from(ensemble.weight.is_some()));
                }
                if ensemble.refine > 0 {
                    hash.add(u64::from(ensemble.refine));
                }
                for passage in &ensemble.passages {
                    hash.add(u64::from(passage.stops));
                }
                for (name, range) in &ensemble.bounds {
                    let column = ensemble.names.iter().position(|known| known == name);
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
        let (method, system) = (self.method, self.method.system());
        let Ok(prepared) = method.prepare(self.h) else {
            return;
        };
        let mut state = self.start_of(path);
        let mut increments = self.increments_of(path);
        let observables = &self.ensemble.observables;
        let mut memories: Vec<_> = observables.iter().filter_map(|o| o.memory(1)).collect();
        for step in 0..=steps.min(self.steps) {
            if step > 0 {
                let mut dw = [0.0; M];
                let made = increments(step - 1, &mut dw)
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
            for memory in &mut memories {
                let last = LastStep::whole(step, self.h);
                memory.update(0, system, &S::Dims::splat(&state), &last);
                if step.is_power_of_two() {
                    hash.add_number(memory.values(0, &last)[0]);
                }
            }
            let recorded = self.records_after(step);
            if recorded || step.is_power_of_two() {
                add_state(hash, &state);
            }
            if recorded {
                for observable in observables {
                    hash.add_number(observable.value(system, &state).unwrap_or(f64::NAN));
                }
                for passage in &self.ensemble.passages {
                    let value = passage.function.value(system, &state);
                    hash.add_number(value.unwrap_or(f64::NAN));
                }
                if let Some(weight) = &self.ensemble.weight {
                    hash.add_number(weight.value(system, &state).unwrap_or(f64::NAN));
                }
            }
        }
    }

    /// Returns the increments of a path, for each step in order; the function returns false if there are none.
    fn increments_of(self, path: u64) -> impl FnMut(u64, &mut [f64; M]) -> bool {
        let noise = self.noise;
        let PathNoise {
            seed,
            first_path,
            distribution,
            largest,
            depth,
            ..
        } = noise;
        let h = self.h;
        let is_mirrored = noise.is_antithetic && path % 2 == 1;
        let path = first_path.wrapping_add(noise.path_within(path));
        let mut wiener = Wiener::new(seed).path(path);
        let mut refined = wiener.refine(depth).ok().filter(|_| depth > 0);
        let mut three_point = ThreePoint::new(seed).path(path);
        move |step, dw| {
            let Some(distribution) = distribution else {
                return true;
            };
            let drawn = match distribution {
                DistributionKind::Normal if noise.is_coarsened => {
                    let mut second = [0.0; M];
                    let drawn = (wiener.increments(2 * step, 0.5 * h, dw))
                        .and_then(|()| wiener.increments(2 * step + 1, 0.5 * h, &mut second));
                    for (dw, second) in dw.iter_mut().zip(second) {
                        *dw += second;
                    }
                    drawn
                }
                DistributionKind::Normal => match &mut refined {
                    Some(refined) => refined.increments(step, h, dw),
                    None => wiener.increments(step, h, dw),
                },
                DistributionKind::ThreePoint => three_point.increments(step, h, dw),
            };
            for dw in dw {
                *dw = dw.clamp(-largest, largest);
                if is_mirrored {
                    *dw = -*dw;
                }
            }
            drawn.is_ok()
        }
    }
}

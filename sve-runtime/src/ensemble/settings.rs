//! The settings of an ensemble, complete and checked.
//!
//! Input: an [`Ensemble`]. Output: [`Settings`], or an error that contains the remedy.

use core::ops::Range;

use super::fingerprint::Fingerprint;
use super::increment_buffer::IncrementBuffer;
use super::info::Info;
use super::inputs::check_inputs;
use super::merge_tree::PartialResult;
use super::observer::Kind;
use super::passage::counts::Grid;
use super::path_noise::PathNoise;
use super::starts::{Start, StartRng};
use super::statistic::{AnyRequest, Extent, check_known};
use super::{BLOCK_PATHS, Ensemble, EnsembleError, path_at, sizes};
use crate::ensemble::PathMethod;
use crate::phase::configuration::FixedSize;
use crate::system::{ConfigurationOf, StateOf};
use crate::time::time_after;

/// The settings that differ between runs of an ensemble that share their noise.
pub(super) struct Leg<'a, I: PathMethod> {
    pub(super) method: &'a I,
    pub(super) start: Option<&'a Start<'a, StateOf<I::System>>>,
    /// Number of halvings of the step.
    pub(super) halvings: u32,
    /// An increment is the sum of the two increments over the halves of the step.
    pub(super) is_coarsened: bool,
    /// The path of the noise that belongs to path 0.
    pub(super) first_path: u64,
    /// The number of paths, if it differs from the number of the ensemble.
    pub(super) paths: Option<u64>,
    /// The method that decides on the settings in the place of the ensemble's own run.
    pub(super) of: Option<&'static str>,
}

impl<'a, I: PathMethod> Leg<'a, I> {
    /// The run of the ensemble itself.
    pub(super) fn of(ensemble: &'a Ensemble<'a, I>) -> Self {
        Self {
            method: &ensemble.method,
            start: ensemble.start.as_ref(),
            halvings: 0,
            is_coarsened: false,
            first_path: 0,
            paths: None,
            of: None,
        }
    }
}

/// The settings of an ensemble, complete and checked.
pub(super) struct Settings<'a, I: PathMethod> {
    pub(super) ensemble: &'a Ensemble<'a, I>,
    pub(super) method: &'a I,
    start: &'a Start<'a, StateOf<I::System>>,
    pub(super) h: f64,
    pub(super) steps: u64,
    every: u64,
    /// Number of steps in a step of the ensemble.
    pub(super) parts: u64,
    pub(super) paths: u64,
    pub(super) start_time: f64,
    pub(super) noise: PathNoise,
    /// The seed of random starts.
    pub(super) start_seed: u64,
    /// The generator of the start of path 0.
    first_start: u64,
    pub(super) records: usize,
    /// Blocks to run.
    pub(super) shard: [u64; 2],
}

impl<I: PathMethod> Clone for Settings<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I: PathMethod> Copy for Settings<'_, I> {}

impl<'a, I: PathMethod> Settings<'a, I> {
    /// Checks the settings of the ensemble's own run.
    pub(super) fn new(ensemble: &'a Ensemble<'a, I>) -> Result<Self, EnsembleError> {
        Self::of_leg(ensemble, &Leg::of(ensemble))
    }

    /// Checks the settings of a run that shares its noise with others.
    pub(super) fn of_leg(
        ensemble: &'a Ensemble<'a, I>,
        leg: &Leg<'a, I>,
    ) -> Result<Self, EnsembleError> {
        let paths = (leg.paths.or(ensemble.paths))
            .ok_or_else(|| missing("number of paths", ".paths(1000)"))?;
        let (h, ensemble_steps) = (ensemble.steps)
            .ok_or_else(|| missing("step size and number of steps", ".steps(0.01, 1000)"))?;
        let start =
            (leg.start).ok_or_else(|| missing("start", ".start(State::new([1.0], [0.0]))"))?;
        check_numbers(ensemble, paths, ensemble_steps)?;
        check_inputs(leg)?;
        let parts = 1_u64.checked_shl(leg.halvings).unwrap_or(u64::MAX);
        let h = h / parts as f64;
        let every = ensemble.every.unwrap_or(ensemble_steps);
        let [every, steps] = [every, ensemble_steps].map(|count| count.saturating_mul(parts));
        leg.method.prepare(h).map_err(EnsembleError::Prepare)?;
        let noise = noise_of(ensemble, leg, h)?;
        check_steps(ensemble, leg.of, &noise)?;
        let start_seed = ensemble.seed.unwrap_or(noise.seed);
        let drawn;
        let first = match start {
            Start::Same(state) => state,
            Start::Drawn(draw) => {
                drawn = draw(0, &mut StartRng::new(start_seed, 0));
                &drawn
            }
        };
        let start_time = first.t;
        check_times(start_time, h, steps)?;
        check_observed(ensemble, ensemble_steps)?;
        let system = leg.method.system();
        (ensemble.observed.gradients).check(system, first, ensemble.has_stops())?;
        let shard = blocks_of_shard(ensemble.execution.shard.unwrap_or((0, 1)), paths)?;
        let own = path_at(shard[1], paths) - path_at(shard[0], paths);
        let extent = Extent {
            names: &ensemble.observed.names,
            // times that differ are fewer than the numbers of 64 bits
            records: steps.div_ceil(every).saturating_add(1),
            paths: own,
            passage_bins: Grid::new(steps, every).between_records(),
        };
        sizes::check_all(ensemble, &extent)?;
        Ok(Self {
            ensemble,
            method: leg.method,
            start,
            h,
            steps,
            every,
            parts,
            paths,
            start_time,
            noise,
            start_seed,
            first_start: leg.first_path,
            records: extent.rows(),
            shard,
        })
    }

    /// Returns the start of a path. The two paths of an antithetic pair have the same generator.
    pub(super) fn start_of(&self, path: u64) -> StateOf<I::System>
    where
        StateOf<I::System>: Copy,
    {
        match self.start {
            Start::Same(state) => *state,
            Start::Drawn(draw) => {
                let number = self.noise.path_within(path);
                let number = self.first_start.wrapping_add(number);
                draw(path, &mut StartRng::new(self.start_seed, number))
            }
        }
    }

    /// Returns the step at which averages begin.
    pub(super) fn settled(&self) -> u64 {
        self.ensemble.observed.settle.saturating_mul(self.parts)
    }

    /// Returns the time after so many steps.
    pub(super) fn time(&self, step: u64) -> f64 {
        time_after(self.start_time, step, self.h)
    }

    /// Returns the step after which a record is taken.
    pub(super) fn step_of(&self, record: usize) -> u64 {
        (record as u64).saturating_mul(self.every).min(self.steps)
    }

    /// Returns whether a record is taken after so many steps.
    pub(super) fn records_after(&self, step: u64) -> bool {
        step.is_multiple_of(self.every) || step == self.steps
    }

    /// Returns the first record that is not before step number `step`.
    pub(super) fn record_after(&self, step: u64) -> usize {
        // records that fit into memory can be counted by a `usize`
        (step.div_ceil(self.every) as usize).min(self.records - 1)
    }

    /// Returns the bins in which passages are counted.
    pub(super) fn passage_grid(&self) -> Grid {
        Grid::new(self.steps, self.every)
    }

    /// Returns the empty result of a block.
    pub(super) fn empty(&self, block: u64) -> PartialResult {
        let extent = Extent {
            names: &self.ensemble.observed.names,
            records: self.records as u64,
            paths: self.paths_of(block..block + 1),
            passage_bins: self.passage_grid().between_records(),
        };
        PartialResult::new(block, &self.ensemble.observed.statistics, &extent)
    }

    /// Returns an empty buffer of increments.
    pub(super) fn increments(&self) -> IncrementBuffer<I::Increments> {
        IncrementBuffer::new(self.noise, self.h)
    }

    /// Returns the number of paths of some blocks.
    pub(super) fn paths_of(&self, blocks: Range<u64>) -> u64 {
        path_at(blocks.end, self.paths) - path_at(blocks.start, self.paths)
    }

    /// Returns the data that summaries of the same run have in common.
    pub(super) fn info(&self, fingerprint: Fingerprint) -> Info {
        let times = (0..self.records).map(|record| self.time(self.step_of(record)));
        Info {
            names: self.ensemble.observed.names.clone(),
            passage_bins: self.passage_grid().between_records(),
            statistics: self.ensemble.observed.statistics.clone(),
            times: times.collect(),
            paths: self.paths,
            coordinates: ConfigurationOf::<I::System>::STORED_VALUES,
            momenta: ConfigurationOf::<I::System>::DEGREES_OF_FREEDOM,
            fingerprint,
            description: self.description(),
        }
    }
}

/// The error of a setting that a run needs; `write` is an example of it.
pub(super) fn missing(what: &'static str, write: &'static str) -> EnsembleError {
    EnsembleError::Missing { what, write }
}

/// Checks the numbers of paths, steps and threads, and the file to resume from.
fn check_numbers<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    paths: u64,
    steps: u64,
) -> Result<(), EnsembleError> {
    let zero = |setting, remedy| Err(EnsembleError::Zero { setting, remedy });
    if paths == 0 {
        return zero("paths", "how many paths are to be averaged over?");
    }
    if steps == 0 {
        return zero("steps", "how many steps is a path to make?");
    }
    if ensemble.every == Some(0) {
        return zero("every", "write 1 to record each step");
    }
    if ensemble.execution.threads == Some(0) {
        return zero("threads", "leave it out to use every core");
    }
    #[cfg(feature = "checkpoint")]
    if ensemble.execution.resume && ensemble.execution.checkpoint.is_none() {
        let write = ".checkpoint(\"run.sve\", Duration::from_secs(60))";
        return Err(missing("file to resume from", write));
    }
    if ensemble.is_antithetic() && !paths.is_multiple_of(2) {
        return Err(EnsembleError::OddPaths { paths });
    }
    Ok(())
}

/// Returns the noise of a leg, whose paths are numbered from the first path of the leg.
fn noise_of<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    leg: &Leg<'_, I>,
    h: f64,
) -> Result<PathNoise, EnsembleError> {
    let mut noise = PathNoise::new(ensemble.noise, ensemble.seed.unwrap_or(0), h)?;
    noise.first_path = noise.first_path.wrapping_add(leg.first_path);
    noise.is_antithetic = ensemble.is_antithetic();
    noise.is_coarsened = leg.is_coarsened;
    noise.stages = leg.method.stages();
    noise.check_stages()?;
    if leg.is_coarsened && noise.distribution.is_some_and(|of| !of.has_sums()) {
        return Err(EnsembleError::NoSums);
    }
    Ok(noise)
}

/// Checks the settings that divide steps against the noise, and against settings that take other
/// increments.
fn check_steps<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    of: Option<&'static str>,
    noise: &PathNoise,
) -> Result<(), EnsembleError> {
    let divides = [
        (ensemble.has_stops(), "stop_at"),
        (!ensemble.observed.passages.is_empty(), "first_passage"),
        (ensemble.refine > 0, "refine"),
    ];
    let of = of.or(ensemble.is_antithetic().then_some("antithetic"));
    match divides.into_iter().find(|(is_set, _)| *is_set) {
        None => Ok(()),
        Some((_, setting)) => match of {
            Some(first) => Err(EnsembleError::NotTogether {
                settings: [first, setting],
                why: "a path is not known within its steps there",
            }),
            None if noise.stages > 1 => Err(EnsembleError::NotTogether {
                settings: [setting, "stage_noise"],
                why: "increments at stages belong to whole steps",
            }),
            None if noise.within_steps(0).is_none() => {
                Err(EnsembleError::NoiseWithinSteps { setting })
            }
            None => Ok(()),
        },
    }
}

/// Returns the first block of a shard and the first block after it.
fn blocks_of_shard((index, of): (u64, u64), paths: u64) -> Result<[u64; 2], EnsembleError> {
    if index >= of {
        return Err(EnsembleError::Shard { index, of });
    }
    let blocks = paths.div_ceil(BLOCK_PATHS);
    let border = |i: u64| (u128::from(blocks) * u128::from(i) / u128::from(of)) as u64;
    let shard = [border(index), border(index + 1)];
    if shard[0] == shard[1] {
        return Err(EnsembleError::EmptyShard {
            index,
            of,
            paths,
            blocks,
        });
    }
    Ok(shard)
}

/// Checks that the times of all steps are finite and differ. The spacing of numbers is largest at
/// the first or the last step.
fn check_times(start: f64, h: f64, steps: u64) -> Result<(), EnsembleError> {
    let end = time_after(start, steps, h);
    if !(start.is_finite() && end.is_finite()) {
        return Err(EnsembleError::Time { start, h, steps });
    }
    let last = time_after(start, steps - 1, h);
    match [start, last].into_iter().find(|t| t + h == *t) {
        None => Ok(()),
        Some(t) => Err(EnsembleError::TimeStands {
            start,
            h,
            steps,
            t,
            next: t.abs().next_up() - t.abs(),
        }),
    }
}

/// Checks the observed functions in so many steps of the ensemble.
fn check_observed<I: PathMethod>(
    ensemble: &Ensemble<'_, I>,
    steps: u64,
) -> Result<(), EnsembleError> {
    let observed = &ensemble.observed;
    let names = &observed.names;
    let passages = observed.passages.iter().map(|passage| &passage.name);
    let all: Vec<&String> = names.iter().chain(passages).collect();
    if let Some((_, name)) = (all.iter().enumerate()).find(|(i, name)| all[..*i].contains(name)) {
        let name = (*name).clone();
        return Err(EnsembleError::TwiceNamed { name });
    }
    for request in &observed.statistics {
        request.check(names)?;
    }
    let mut requests = observed.statistics.iter();
    if ensemble.is_antithetic() && requests.any(AnyRequest::needs_independent_paths) {
        return Err(EnsembleError::AntitheticPairs);
    }
    for (name, [low, high]) in &observed.bounds {
        check_known(name, names, "bound")?;
        if low.is_nan() || high.is_nan() || low > high {
            return Err(EnsembleError::Bound {
                name: name.clone(),
                low: *low,
                high: *high,
            });
        }
    }
    let mut observables = observed.observables.iter();
    if observed.settle >= steps && observables.any(|of| of.kind() == Kind::Average) {
        return Err(EnsembleError::Settle {
            settle: observed.settle,
            steps,
        });
    }
    Ok(())
}

//! The settings of an ensemble once they are checked, and what follows from them.
//!
//! Input: an [`Ensemble`]. Output: a [`Run`], or what has to be written instead.

use core::ops::Range;

use super::increments::Increments;
use super::start::{Start, StartRng};
use super::summary::Info;
use super::{BLOCK_PATHS, Ensemble, EnsembleError};
use crate::method::Method;
use crate::system::{Dimensions, System};

/// Settings that were checked, and what follows from them.
pub(super) struct Run<'a, I: Method> {
    pub(super) ensemble: &'a Ensemble<'a, I>,
    pub(super) h: f64,
    pub(super) steps: u64,
    every: u64,
    pub(super) paths: u64,
    pub(super) start_time: f64,
    largest: f64,
    pub(super) records: usize,
    /// Blocks to run.
    pub(super) shard: [u64; 2],
}

impl<I: Method> Clone for Run<'_, I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I: Method> Copy for Run<'_, I> {}

impl<'a, I: Method> Run<'a, I> {
    /// Checks the settings.
    pub(super) fn new(ensemble: &'a Ensemble<'a, I>) -> Result<Self, EnsembleError> {
        let missing = |what, write| EnsembleError::Missing { what, write };
        let zero = |setting, remedy| Err(EnsembleError::Zero { setting, remedy });
        let paths = ensemble
            .paths
            .ok_or_else(|| missing("number of paths", ".paths(1000)"))?;
        let (h, steps) = ensemble
            .steps
            .ok_or_else(|| missing("step size and number of steps", ".steps(0.01, 1000)"))?;
        let start = ensemble
            .start
            .as_ref()
            .ok_or_else(|| missing("start", ".start(State::new([1.0], [0.0]))"))?;
        if paths == 0 {
            return zero("paths", "how many paths are to be averaged over?");
        }
        if steps == 0 {
            return zero("steps", "how many steps is a path to make?");
        }
        if ensemble.every == Some(0) {
            return zero("record_every", "write 1 to record each step");
        }
        if ensemble.threads == Some(0) {
            return zero("threads", "leave it out to use every core");
        }
        ensemble.method.prepare(h).map_err(EnsembleError::Prepare)?;
        let largest = ensemble.law.largest(h).map_err(EnsembleError::Truncation)?;
        let time = <<I::System as System>::Dims as Dimensions>::time;
        let start_time = match start {
            Start::Same(state) => time(state),
            Start::Drawn(draw) => time(&draw(0, &mut StartRng::new(ensemble.seed, 0))),
        };
        if !(start_time + steps as f64 * h).is_finite() {
            let start = start_time;
            return Err(EnsembleError::Time { start, h, steps });
        }
        check_names(ensemble)?;
        let (index, of) = ensemble.shard;
        if index >= of {
            return Err(EnsembleError::Shard { index, of });
        }
        let blocks = u128::from(paths.div_ceil(BLOCK_PATHS));
        let border = |i: u64| (blocks * u128::from(i) / u128::from(of)) as u64;
        let every = ensemble.every.unwrap_or(steps);
        Ok(Self {
            ensemble,
            h,
            steps,
            every,
            paths,
            start_time,
            largest,
            records: steps.div_ceil(every) as usize + 1,
            shard: [border(index), border(index + 1)],
        })
    }

    /// The time after so many steps.
    pub(super) fn time(&self, step: u64) -> f64 {
        self.start_time + step as f64 * self.h
    }

    /// The step after which a record is taken.
    pub(super) fn step_of(&self, record: usize) -> u64 {
        (record as u64).saturating_mul(self.every).min(self.steps)
    }

    pub(super) fn increments<const M: usize>(&self, first_path: u64) -> Increments<M> {
        let Ensemble { law, seed, .. } = *self.ensemble;
        Increments::new(law, seed, first_path, self.h, self.largest)
    }

    /// How many paths some blocks have.
    pub(super) fn paths_of(&self, blocks: Range<u64>) -> u64 {
        let border = |block: u64| (block * BLOCK_PATHS).min(self.paths);
        border(blocks.end) - border(blocks.start)
    }

    /// What summaries of the same run have in common.
    pub(super) fn info(&self, fingerprint: u64) -> Info {
        let times = (0..self.records).map(|record| self.time(self.step_of(record)));
        Info {
            names: self.ensemble.names.clone(),
            histograms: self.ensemble.histograms.clone(),
            times: times.collect(),
            paths: self.paths,
            fingerprint,
        }
    }
}

fn check_names<I: Method>(ensemble: &Ensemble<'_, I>) -> Result<(), EnsembleError> {
    let names = &ensemble.names;
    if let Some((_, name)) = (names.iter().enumerate()).find(|(i, name)| names[..*i].contains(name))
    {
        let name = name.clone();
        return Err(EnsembleError::TwiceNamed { name });
    }
    for request in &ensemble.histograms {
        let name = request.name.clone();
        if !names.contains(&name) {
            let known = names.clone();
            return Err(EnsembleError::UnknownObservable { name, known });
        }
        let ([low, high], bins) = (request.range, request.bins);
        if !((high - low).is_finite() && low < high && bins > 0) {
            return Err(EnsembleError::Histogram {
                name,
                low,
                high,
                bins,
            });
        }
    }
    Ok(())
}

//! The run of a study: solves the paths in parallel, then computes statistics in the order of the
//! paths, then measures times with nothing else running.

use rayon::prelude::*;

use super::any_method::AnyMethod;
use super::estimate::Estimate;
use super::order::{self, Convergence, ErrorOf, Level, NotAsymptotic, Order};
use super::reference::PathRequest;
use super::report::{Invariant, Report, Row};
use super::settings::Settings;
use super::stopwatch::Stopwatch;
use super::{Study, StudyError};
use crate::description::SystemDescription;
use crate::error::StepError;
use crate::noise::{NoNoise, Recorded};
use crate::phase::configuration::FixedSize;
use crate::phase::state::State;
use crate::system::{ConfigurationOf, StateOf, System};

/// The errors of one path, by one method with one step size.
struct Sample {
    square: f64,
    observed: Vec<f64>,
    largest: f64,
    slope: f64,
}

/// The results of one path.
struct Outcome {
    /// Size of the reference, squared.
    size: f64,
    observed: Vec<f64>,
    /// Methods, each with every number of steps; `None` where it failed.
    samples: Vec<Option<Sample>>,
}

pub(super) fn run<S: System>(study: &Study<'_, S>) -> Result<Report, StudyError> {
    let settings = Settings::new(study)?;
    let outcomes: Vec<Outcome> = (0..settings.paths)
        .into_par_iter()
        .map(|path| settings.outcome(path))
        // the first error in the order of the paths, not of the threads
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    let mut rows: Vec<Row> = settings
        .cases()
        .enumerate()
        .map(|(case, (method, steps))| settings.row(&outcomes, case, method, steps))
        .collect();
    let strong = |_: &Outcome, sample: &Sample| sample.square;
    let size = |outcome: &Outcome| outcome.size;
    let (orders, not_asymptotic) = settings.orders(&outcomes, None, size, strong);
    let (mut weak_orders, mut weak_not_asymptotic) = (Vec::new(), Vec::new());
    for at in 0..study.observables.len() {
        let size = |outcome: &Outcome| outcome.observed[at].powi(2);
        let weak = |outcome: &Outcome, sample: &Sample| settings.difference(at, outcome, sample);
        let (orders, others) = settings.orders(&outcomes, Some(at), size, weak);
        weak_orders.extend(orders);
        weak_not_asymptotic.extend(others);
    }
    settings.measure_costs(&outcomes, &mut rows)?;
    Ok(Report {
        problem: study.problem.to_string(),
        horizon: settings.horizon,
        paths: settings.paths,
        observables: study
            .observables
            .iter()
            .map(|o| o.name.to_string())
            .collect(),
        rows,
        orders,
        not_asymptotic,
        weak_orders,
        weak_not_asymptotic,
        system: SystemDescription::of(settings.system()),
        methods: (study.methods.iter())
            .map(|candidate| (candidate.name.to_string(), candidate.method.describe()))
            .collect(),
        reference: settings.reference.describe(),
        seed: settings
            .reference
            .has_seed(settings.processes)
            .then_some(study.seed),
    })
}

impl<'a, S: System> Settings<'a, S> {
    /// Returns every method with every number of steps.
    fn cases(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        (0..self.study.methods.len()).flat_map(|method| {
            let steps = self.study.steps_of(method);
            steps.iter().map(move |&steps| (method, steps))
        })
    }

    fn subject(&self, method: usize) -> &'a dyn AnyMethod<S> {
        self.study.methods[method].method
    }

    /// The system of the first method; the systems of the other methods are equal to it.
    fn system(&self) -> &'a S {
        self.subject(0).system()
    }

    fn reference(&self, path: u64) -> Result<(Recorded, StateOf<S>), StudyError> {
        self.reference.get(&PathRequest {
            path,
            seed: self.study.seed,
            start: self.start,
            horizon: self.horizon,
            finest: self.finest,
            processes: self.processes,
            stages: self.stages,
        })
    }

    fn observed(&self, state: &StateOf<S>) -> Result<Vec<f64>, StepError> {
        let values = self.study.observables.iter();
        values.map(|o| (o.value)(self.system(), state)).collect()
    }

    fn outcome(&self, path: u64) -> Result<Outcome, StudyError> {
        let (fine, exact) = self.reference(path)?;
        let observed = self
            .observed(&exact)
            .map_err(|source| StudyError::Reference { path, source })?;
        let origin = State::at(
            exact.t,
            FixedSize::origin(),
            ConfigurationOf::<S>::no_momentum(),
        );
        let size = (self.study.distance)(&exact, &origin).powi(2);
        if !(size + observed.iter().sum::<f64>()).is_finite() {
            return Err(StudyError::NotFinite { path });
        }
        let mut samples = Vec::new();
        for (method, steps) in self.cases() {
            let coarse = self.coarsened(&fine, steps, path)?;
            samples.push(self.sample(method, &coarse, &exact));
        }
        Ok(Outcome {
            size,
            observed,
            samples,
        })
    }

    /// Returns the path in `steps` steps.
    fn coarsened(&self, fine: &Recorded, steps: usize, path: u64) -> Result<Recorded, StudyError> {
        if self.processes == 0 {
            Recorded::record_stages(NoNoise, self.horizon / steps as f64, 0, self.stages, steps)
        } else {
            fine.coarsen(fine.len() / steps)
        }
        .map_err(|source| StudyError::Noise { path, source })
    }

    /// Solves a path by a method; `None` if it fails or overflows.
    fn sample(&self, method: usize, path: &Recorded, exact: &StateOf<S>) -> Option<Sample> {
        let n = path.len() as f64;
        let (mut largest, mut moment, mut step) = (0.0_f64, 0.0, 0.0);
        let end = match &self.study.invariant {
            None => self
                .subject(method)
                .solve(self.start, path, &mut |_| Ok(())),
            Some(invariant) => {
                let first = invariant(self.system(), self.start).ok()?;
                self.subject(method).solve(self.start, path, &mut |state| {
                    step += 1.0;
                    let change = invariant(self.system(), state)? - first;
                    largest = largest.max(change.abs());
                    moment += (step - 0.5 * n) * change;
                    Ok(())
                })
            }
        }
        .ok()?;
        let sample = Sample {
            square: (self.study.distance)(&end, exact).powi(2),
            observed: self.observed(&end).ok()?,
            largest,
            // Σ (k − n/2)² over k = 0 … n is n (n + 1) (n + 2)/12; at k = 0 there is no change
            slope: 12.0 * moment / (n * (n + 1.0) * (n + 2.0)) / path.h(),
        };
        let sum = sample.square + sample.slope + sample.observed.iter().sum::<f64>();
        sum.is_finite().then_some(sample)
    }

    /// Estimates over paths. Without noise the estimate has no error.
    fn estimate(&self, values: &[f64], of: fn(&[f64]) -> Estimate) -> Estimate {
        let estimate = of(values);
        if self.processes == 0 {
            Estimate::certain(estimate.value)
        } else {
            estimate
        }
    }

    fn row(&self, outcomes: &[Outcome], case: usize, method: usize, steps: usize) -> Row {
        let alive: Vec<(&Outcome, &Sample)> = outcomes
            .iter()
            .filter_map(|outcome| Some((outcome, outcome.samples[case].as_ref()?)))
            .collect();
        let each = |f: &dyn Fn(&Outcome, &Sample) -> f64| -> Vec<f64> {
            alive
                .iter()
                .map(|(outcome, sample)| f(outcome, sample))
                .collect()
        };
        let mut row = Row {
            method: self.study.methods[method].name.to_string(),
            h: self.horizon / steps as f64,
            steps,
            error: None,
            weak_errors: Vec::new(),
            invariant: None,
            timing: None,
            newton_iterations: None,
            failures: (outcomes.len() - alive.len()) as u64,
        };
        if alive.is_empty() {
            return row;
        }
        row.error = Some(self.estimate(&each(&|_, s| s.square), Estimate::root_mean));
        for at in 0..self.study.observables.len() {
            let differences = each(&|outcome, sample| self.difference(at, outcome, sample));
            let weak = self.estimate(&differences, Estimate::mean);
            row.weak_errors.push(weak);
        }
        row.invariant = self.study.invariant.as_ref().map(|_| Invariant {
            largest: each(&|_, s| s.largest).into_iter().fold(0.0, f64::max),
            drift: self.estimate(&each(&|_, s| s.slope), Estimate::mean),
        });
        row
    }

    /// Returns the value of an observable less that of the reference, or less its exact mean.
    fn difference(&self, observable: usize, outcome: &Outcome, sample: &Sample) -> f64 {
        let exact = self.study.observables[observable].mean;
        sample.observed[observable] - exact.unwrap_or(outcome.observed[observable])
    }

    /// Fits the order of each method: the strong order, or that of an observable. `size` is the
    /// square of what errors are compared with.
    fn orders(
        &self,
        outcomes: &[Outcome],
        observable: Option<usize>,
        size: impl Fn(&Outcome) -> f64,
        of_path: impl Fn(&Outcome, &Sample) -> f64,
    ) -> (Vec<Order>, Vec<NotAsymptotic>) {
        let size = outcomes.iter().map(size).sum::<f64>() / outcomes.len() as f64;
        let name = observable.map(|at| self.study.observables[at].name.to_string());
        let of = match name {
            None => ErrorOf::Squares,
            Some(_) => ErrorOf::Differences,
        };
        let (mut orders, mut others) = (Vec::new(), Vec::new());
        for (method, candidate) in self.study.methods.iter().enumerate() {
            let levels = self.levels(outcomes, method, &of_path);
            let (method, observable) = (candidate.name.to_string(), name.clone());
            let strong = candidate.method.order();
            let of_method = strong.filter(|_| name.is_none());
            match order::fit(levels, of, size.sqrt(), self.processes > 0) {
                Convergence::Asymptotic(order, points) => orders.push(Order {
                    method,
                    observable,
                    order,
                    points,
                    of_method,
                }),
                Convergence::Unsettled(slopes) => others.push(NotAsymptotic {
                    method,
                    observable,
                    slopes,
                    of_method,
                }),
            }
        }
        (orders, others)
    }

    /// Returns a number of each path for the numbers of steps with which no path failed.
    fn levels(
        &self,
        outcomes: &[Outcome],
        method: usize,
        of_path: &impl Fn(&Outcome, &Sample) -> f64,
    ) -> Vec<Level> {
        let level = |(case, (of, steps)): (usize, (usize, usize))| {
            if of != method {
                return None;
            }
            let of_path =
                |outcome: &Outcome| Some(of_path(outcome, outcome.samples[case].as_ref()?));
            Some(Level {
                ln_h: (self.horizon / steps as f64).ln(),
                steps,
                of_paths: outcomes.iter().map(of_path).collect::<Option<_>>()?,
            })
        };
        self.cases().enumerate().filter_map(level).collect()
    }

    /// Measures iterations and times of each case, on the first path that did not fail.
    fn measure_costs(&self, outcomes: &[Outcome], rows: &mut [Row]) -> Result<(), StudyError> {
        let mut stopwatches = Vec::new();
        for (case, (method, steps)) in self.cases().enumerate() {
            let alive = |outcome: &Outcome| outcome.samples[case].is_some();
            let Some(path) = outcomes.iter().position(alive) else {
                continue;
            };
            let (fine, _) = self.reference(path as u64)?;
            let coarse = self.coarsened(&fine, steps, path as u64)?;
            let subject = self.subject(method);
            rows[case].newton_iterations = subject.iterations(self.start, &coarse);
            if self.study.repeats > 0 {
                stopwatches.push(Stopwatch::<S>::new(case, subject, self.start, coarse));
            }
        }
        for _ in 0..self.study.repeats {
            for stopwatch in &mut stopwatches {
                stopwatch.measure(self.start);
            }
        }
        for stopwatch in stopwatches {
            let case = stopwatch.case;
            rows[case].timing = stopwatch.timing();
        }
        Ok(())
    }
}

//! The run of a study: paths in parallel, then statistics in the order of the paths, then the clock with nothing else running.

use rayon::prelude::*;

use super::clock::Watch;
use super::estimate::Estimate;
use super::order::{self, Convergence, Level, NotAsymptotic, Order};
use super::reference::{Reference, Wanted};
use super::report::{Invariant, Report, Row};
use super::subject::{Subject, increments};
use super::{Study, StudyError};
use crate::configuration::Coordinates;
use crate::error::StepError;
use crate::noise::Recorded;
use crate::state::State;
use crate::system::{Dims, StateOf, System};

/// One path by one method with one step size.
struct Sample {
    square: f64,
    observed: Vec<f64>,
    largest: f64,
    slope: f64,
}

/// One path.
struct Outcome {
    /// Size of the reference, squared.
    size: f64,
    observed: Vec<f64>,
    /// Methods, each with every number of steps; `None` where it failed.
    samples: Vec<Option<Sample>>,
}

/// Settings that are complete.
struct Plan<'a, S: System> {
    study: &'a Study<'a, S>,
    start: &'a StateOf<S>,
    horizon: f64,
    reference: &'a Reference<'a, S>,
    finest: usize,
    paths: u64,
    processes: usize,
}

pub(super) fn run<S, Q, const N: usize, const M: usize>(
    study: &Study<'_, S>,
) -> Result<Report, StudyError>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    let plan = Plan::new::<Q, N, M>(study)?;
    let outcomes: Vec<Outcome> = (0..plan.paths)
        .into_par_iter()
        .map(|path| plan.outcome(path))
        // the first error in the order of the paths, whichever thread was first
        .collect::<Vec<_>>()
        .into_iter()
        .collect::<Result<_, _>>()?;
    let mut rows: Vec<Row> = plan
        .cases()
        .enumerate()
        .map(|(case, (method, steps))| plan.row(&outcomes, case, method, steps))
        .collect();
    let (orders, not_asymptotic) = plan.orders(&outcomes);
    plan.ask(&outcomes, &mut rows)?;
    Ok(Report {
        problem: study.problem.to_string(),
        horizon: plan.horizon,
        paths: plan.paths,
        observables: study
            .observables
            .iter()
            .map(|o| o.name.to_string())
            .collect(),
        rows,
        orders,
        not_asymptotic,
    })
}

impl<'a, S: System> Plan<'a, S> {
    /// Checks the settings.
    fn new<Q, const N: usize, const M: usize>(study: &'a Study<'a, S>) -> Result<Self, StudyError>
    where
        S: System<Dims = Dims<N, M, Q>>,
        Q: Coordinates<N>,
    {
        let missing = |what, write| StudyError::Missing { what, write };
        let names = study.methods.iter().map(|(name, _)| name.to_string());
        twice("methods", names)?;
        let names = study.observables.iter().map(|o| o.name.to_string());
        twice("observables", names)?;
        twice("steps", study.steps.iter().map(usize::to_string))?;
        let horizon = study.horizon.ok_or(missing("horizon", ".horizon(10.0)"))?;
        if !(horizon > 0.0 && horizon.is_finite()) {
            return Err(StudyError::Horizon { horizon });
        }
        if study.methods.is_empty() {
            return Err(missing("methods", ".method(\"midpoint\", &integrator)"));
        }
        let finest = *study
            .steps
            .iter()
            .max()
            .ok_or(missing("numbers of steps", ".steps([64, 128, 256])"))?;
        for &steps in &study.steps {
            if steps == 0 {
                return Err(StudyError::Zero { setting: "steps" });
            }
            if !finest.is_multiple_of(steps) {
                return Err(StudyError::Steps { steps, finest });
            }
        }
        if study.paths == 0 {
            return Err(StudyError::Zero { setting: "paths" });
        }
        let reference = study.reference.as_ref().ok_or(missing(
            "reference",
            ".fine(&integrator, 16)` or `.exact(|path| …)",
        ))?;
        if let Reference::Fine(method, factor) = *reference {
            check_fine(study, method, factor, finest)?;
        }
        Ok(Self {
            study,
            start: study
                .start
                .as_ref()
                .ok_or(missing("start", ".start(State::new([1.0], [0.0]))"))?,
            horizon,
            reference,
            finest,
            paths: if M == 0 { 1 } else { study.paths },
            processes: M,
        })
    }
}

/// Checks that a fine reference has steps that can be counted, and is none of the methods with the same steps: the error of that one would be 0,
/// and those of the others too small.
fn check_fine<S: System>(
    study: &Study<'_, S>,
    reference: &dyn Subject<S>,
    factor: usize,
    finest: usize,
) -> Result<(), StudyError> {
    if factor == 0 {
        return Err(StudyError::Zero { setting: "fine" });
    }
    if finest.checked_mul(factor).is_none() {
        return Err(StudyError::TooFine { finest, factor });
    }
    let is_reference = |&&(_, method): &&(_, &dyn Subject<S>)| {
        factor == 1 && method.identity() == reference.identity()
    };
    match study.methods.iter().find(is_reference) {
        None => Ok(()),
        Some((name, _)) => Err(StudyError::OwnReference {
            method: name.to_string(),
            steps: finest,
        }),
    }
}

/// Refuses a name that stands twice.
fn twice(what: &'static str, names: impl Iterator<Item = String>) -> Result<(), StudyError> {
    let mut seen = Vec::new();
    for name in names {
        if seen.contains(&name) {
            return Err(StudyError::Twice { what, name });
        }
        seen.push(name);
    }
    Ok(())
}

impl<'a, S, Q, const N: usize, const M: usize> Plan<'a, S>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Every method with every number of steps.
    fn cases(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        let steps = &self.study.steps;
        (0..self.study.methods.len())
            .flat_map(move |method| steps.iter().map(move |&steps| (method, steps)))
    }

    fn subject(&self, method: usize) -> &'a dyn Subject<S> {
        self.study.methods[method].1
    }

    /// The system, of which the methods have equal ones.
    fn system(&self) -> &'a S {
        self.subject(0).system()
    }

    fn reference(&self, path: u64) -> Result<(Recorded, State<Q>), StudyError> {
        self.reference.get(&Wanted {
            path,
            seed: self.study.seed,
            start: self.start,
            horizon: self.horizon,
            finest: self.finest,
            processes: self.processes,
        })
    }

    fn observed(&self, state: &State<Q>) -> Result<Vec<f64>, StepError> {
        let values = self.study.observables.iter();
        values.map(|o| (o.value)(self.system(), state)).collect()
    }

    fn outcome(&self, path: u64) -> Result<Outcome, StudyError> {
        let (fine, exact) = self.reference(path)?;
        let observed = self
            .observed(&exact)
            .map_err(|source| StudyError::Reference { path, source })?;
        let origin = State::at(exact.t, Q::origin(), Q::no_momentum());
        let size = (self.study.distance)(&exact, &origin).powi(2);
        if !(size + observed.iter().sum::<f64>()).is_finite() {
            return Err(StudyError::NotFinite { path });
        }
        let mut samples = Vec::new();
        for (method, steps) in self.cases() {
            let coarse = coarsened(&fine, steps, path)?;
            samples.push(self.sample(method, &coarse, &exact));
        }
        Ok(Outcome {
            size,
            observed,
            samples,
        })
    }

    /// A path by a method, unless it fails or overflows.
    fn sample(&self, method: usize, path: &Recorded, exact: &State<Q>) -> Option<Sample> {
        let n = path.len() as f64;
        let (mut largest, mut moment, mut step) = (0.0_f64, 0.0, 0.0);
        let end = match &self.study.invariant {
            None => self.subject(method).walk(self.start, path, &mut |_| Ok(())),
            Some(invariant) => {
                let first = invariant(self.system(), self.start).ok()?;
                self.subject(method).walk(self.start, path, &mut |state| {
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

    /// An estimate over paths; of the only one where nothing is random.
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
            method: self.study.methods[method].0.to_string(),
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
        for (i, observable) in self.study.observables.iter().enumerate() {
            let differences = match observable.mean {
                Some(mean) => each(&|_, s| s.observed[i] - mean),
                None => each(&|o, s| s.observed[i] - o.observed[i]),
            };
            let weak = self.estimate(&differences, Estimate::mean);
            row.weak_errors.push(weak);
        }
        row.invariant = self.study.invariant.as_ref().map(|_| Invariant {
            largest: each(&|_, s| s.largest).into_iter().fold(0.0, f64::max),
            drift: self.estimate(&each(&|_, s| s.slope), Estimate::mean),
        });
        row
    }

    /// What the errors tell of the order of each method.
    fn orders(&self, outcomes: &[Outcome]) -> (Vec<Order>, Vec<NotAsymptotic>) {
        let size = outcomes.iter().map(|o| o.size).sum::<f64>() / outcomes.len() as f64;
        let (mut orders, mut others) = (Vec::new(), Vec::new());
        for (method, (name, subject)) in self.study.methods.iter().enumerate() {
            let levels = self.levels(outcomes, method);
            let method = name.to_string();
            match order::fit(levels, size.sqrt(), self.processes > 0) {
                Convergence::Asymptotic(order, points) => orders.push(Order {
                    method,
                    order,
                    points,
                    of_method: subject.order(),
                }),
                Convergence::Unsettled(slopes) => others.push(NotAsymptotic {
                    method,
                    slopes,
                    of_method: subject.order(),
                }),
            }
        }
        (orders, others)
    }

    /// The errors of a method with every number of steps with which no path failed.
    fn levels(&self, outcomes: &[Outcome], method: usize) -> Vec<Level> {
        let level = |(case, (of, steps)): (usize, (usize, usize))| {
            if of != method {
                return None;
            }
            let square = |outcome: &Outcome| Some(outcome.samples[case].as_ref()?.square);
            Some(Level {
                ln_h: (self.horizon / steps as f64).ln(),
                steps,
                squares: outcomes.iter().map(square).collect::<Option<_>>()?,
            })
        };
        self.cases().enumerate().filter_map(level).collect()
    }

    /// Iterations and times, each on the first path that did not fail.
    fn ask(&self, outcomes: &[Outcome], rows: &mut [Row]) -> Result<(), StudyError> {
        let mut watches = Vec::new();
        for (case, (method, steps)) in self.cases().enumerate() {
            let alive = |outcome: &Outcome| outcome.samples[case].is_some();
            let Some(path) = outcomes.iter().position(alive) else {
                continue;
            };
            let (fine, _) = self.reference(path as u64)?;
            let coarse = coarsened(&fine, steps, path as u64)?;
            let subject = self.subject(method);
            rows[case].newton_iterations = subject.iterations(self.start, &coarse);
            if self.study.repeats > 0 {
                let increments = (0..steps).map(|step| increments::<S>(&coarse, step));
                watches.push(Watch::<S>::new(
                    case,
                    subject,
                    self.start,
                    coarse.h(),
                    increments.collect(),
                ));
            }
        }
        for _ in 0..self.study.repeats {
            for watch in &mut watches {
                watch.measure(self.start);
            }
        }
        for watch in watches {
            let case = watch.case;
            rows[case].timing = watch.timing();
        }
        Ok(())
    }
}

fn coarsened(fine: &Recorded, steps: usize, path: u64) -> Result<Recorded, StudyError> {
    fine.coarsen(fine.len() / steps)
        .map_err(|source| StudyError::Noise { path, source })
}

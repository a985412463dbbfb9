//! Ensembles: many paths on all cores, with progress and Ctrl-C.
//!
//! The paths run on threads of their own, without Python. The thread that called waits for them,
//! looks for Ctrl-C and calls the function for the progress. After Ctrl-C it does not wait: the
//! threads end after the block of paths that each of them is in.

use std::num::NonZero;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::thread;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use sve_runtime::Configuration;
use sve_runtime::ensemble::{BLOCK_PATHS, Ensemble, EnsembleError};
use sve_runtime::system::{AnySystem, StateOf};

use crate::arguments::{check_step_size, whole, wrong};
use crate::errors;
use crate::expose::{Exposable, Stepper};
use crate::state::State;
use crate::summary::Summary;
use crate::trajectory::{LOOK, MOST_HALVINGS, Rows};

/// The observable that is no coordinate and no momentum.
const ENERGY: &str = "energy";

/// Largest number of threads: a larger one is a mistake.
const MOST_THREADS: usize = 65_536;

/// The settings of an ensemble, checked.
pub(crate) struct Request {
    h: f64,
    steps: u64,
    paths: u64,
    seed: u64,
    every: u64,
    refine: u32,
    observe: Option<Vec<String>>,
    threads: usize,
    keep_ends: bool,
}

impl Request {
    pub(crate) fn new(
        h: f64,
        [steps, paths, seed, refine]: [i128; 4],
        every: Option<i128>,
        observe: Option<Vec<String>>,
        threads: Option<i128>,
        keep_ends: bool,
    ) -> PyResult<Self> {
        check_step_size(h)?;
        let cores = thread::available_parallelism().map_or(1, NonZero::get);
        let threads = threads.unwrap_or(cores as i128);
        Ok(Self {
            h,
            steps: whole("steps", steps, 1..=u64::MAX)?,
            paths: whole("paths", paths, 1..=u64::MAX)?,
            seed: whole("seed", seed, 0..=u64::MAX)?,
            every: whole("every", every.unwrap_or(steps), 1..=u64::MAX)?,
            refine: whole("refine", refine, 0..=MOST_HALVINGS)?,
            observe,
            threads: whole("threads", threads, 1..=MOST_THREADS)?,
            keep_ends,
        })
    }

    /// Checks the names of what is observed. Returns all that the system has if none are given.
    fn names<S: AnySystem>(&self) -> PyResult<Vec<String>> {
        let [q, p] = [S::NAMES.coordinates, S::NAMES.momenta];
        let all: Vec<String> = q
            .iter()
            .chain(p)
            .chain([&ENERGY])
            .map(|&name| name.to_owned())
            .collect();
        let Some(names) = &self.observe else {
            return Ok(all);
        };
        match names.iter().find(|name| !all.contains(name)) {
            None => Ok(names.clone()),
            Some(name) => Err(wrong(format!(
                "observe has {name:?}, and the system has {all:?}"
            ))),
        }
    }
}

/// The data that the waiting thread and the running threads share.
#[derive(Default)]
struct Shared {
    is_stopped: AtomicBool,
    /// Number of blocks of paths that were begun.
    blocks: AtomicU64,
}

/// Runs an ensemble.
pub(crate) fn run<I: Stepper>(
    py: Python<'_>,
    method: I,
    start: &State,
    request: Request,
    progress: Option<&Py<PyAny>>,
) -> PyResult<Summary> {
    let start = start.read::<I::System>(py)?;
    let names = request.names::<I::System>()?;
    let (paths, threads) = (request.paths, request.threads as u64);
    let ends = request
        .keep_ends
        .then(|| Rows::new::<I::System>(paths))
        .transpose()?;
    let shared = Arc::new(Shared::default());
    let (sender, receiver) = channel();
    let of_run = Arc::clone(&shared);
    thread::spawn(move || {
        // nobody waits for the result after Ctrl-C
        let _ = sender.send(run_paths(&method, start, &request, names, &of_run));
    });
    let result = py.detach(|| {
        wait(receiver, |py| {
            py.check_signals()?;
            let begun = shared.blocks.load(Ordering::Relaxed);
            let done = begun.saturating_sub(threads).saturating_mul(BLOCK_PATHS);
            report(py, progress, done.min(paths), paths)
        })
        .inspect_err(|_| shared.is_stopped.store(true, Ordering::Relaxed))
    })?;
    let summary = result.map_err(|error| errors::of_ensemble(&error))?;
    report(py, progress, paths, paths)?;
    Summary::new(py, summary, ends)
}

#[allow(clippy::needless_pass_by_value)] // a thread can give its receiver away, not lend it
/// Waits for a result. Calls `look` now and then, with Python, and gives up if it fails.
fn wait<T>(results: Receiver<T>, mut look: impl FnMut(Python<'_>) -> PyResult<()>) -> PyResult<T> {
    loop {
        match results.recv_timeout(LOOK) {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => Python::attach(&mut look)?,
            Err(RecvTimeoutError::Disconnected) => {
                let message = "the threads of the ensemble panicked; see standard error";
                return Err(PyRuntimeError::new_err(message));
            }
        }
    }
}

/// Calls the function for the progress, if there is one.
fn report(py: Python<'_>, progress: Option<&Py<PyAny>>, done: u64, paths: u64) -> PyResult<()> {
    progress.map_or(Ok(()), |progress| {
        progress.call1(py, (done, paths)).map(|_| ())
    })
}

/// Runs the paths, without Python.
fn run_paths<I: Stepper>(
    method: &I,
    start: StateOf<I::System>,
    request: &Request,
    names: Vec<String>,
    shared: &Shared,
) -> Result<sve_runtime::ensemble::Summary, EnsembleError> {
    let mut ensemble = Ensemble::new(method)
        .paths(request.paths)
        .seed(request.seed)
        .steps(request.h, request.steps)
        .every(request.every)
        .refine(request.refine)
        .start(start)
        .threads(request.threads)
        .keep_final_states(request.keep_ends)
        .stop_when(|| {
            shared.blocks.fetch_add(1, Ordering::Relaxed);
            shared.is_stopped.load(Ordering::Relaxed)
        });
    for name in names {
        ensemble = match index::<I::System>(&name) {
            None => ensemble.observe_energy(name),
            Some(index) => {
                ensemble.observe(name, move |_, state| number::<I::System>(state, index))
            }
        };
    }
    ensemble.run()
}

/// Returns the place of a name among the coordinates, then the momenta; `None` for the energy.
fn index<S: AnySystem>(name: &str) -> Option<usize> {
    let mut names = S::NAMES.coordinates.iter().chain(S::NAMES.momenta);
    names.position(|known| *known == name)
}

/// Returns the number of a state at a place among the coordinates, then the momenta.
fn number<S: Exposable>(state: &StateOf<S>, index: usize) -> f64 {
    let q = state.q.stored_values();
    if index < q {
        value(&state.q, index)
    } else {
        value(&state.p, index - q)
    }
}

/// Returns one of the numbers by which a configuration or a momentum is stored.
fn value(of: &impl Configuration, index: usize) -> f64 {
    // a few numbers need no memory of the heap
    let mut few = [0.0; 16];
    if let Some(values) = few.get_mut(..of.stored_values()) {
        of.store(values);
        return values[index];
    }
    let mut values = vec![0.0; of.stored_values()];
    of.store(&mut values);
    values[index]
}

//! Single steps, and paths as arrays.
//!
//! A path is a structured array of `NumPy` with the fields `t`, `q` and `p`. In memory it is rows
//! of numbers, `t`, the coordinates and the momenta, which Rust fills and Python views.

use std::time::{Duration, Instant};

use numpy::PyArray1;
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use sve_runtime::Configuration;
use sve_runtime::noise::Wiener;
use sve_runtime::system::StateOf;

use crate::StepError;
use crate::arguments::{check_length, check_step_size, numbers, whole, wrong};
use crate::errors;
use crate::expose::{Exposable, Stepper};
use crate::state::{State, empty};

/// Time between two looks for Ctrl-C, in which a user does not notice the delay.
pub(crate) const LOOK: Duration = Duration::from_millis(50);

/// Number of steps between two looks at the clock.
const STEPS_AT_ONCE: u64 = 256;

/// Largest number of halvings of a step: the noise has no increments of smaller parts.
pub(crate) const MOST_HALVINGS: u32 = 63;

/// Makes one step of a state, in place.
pub(crate) fn step<I: Stepper>(
    method: &I,
    noises: usize,
    state: &Bound<'_, State>,
    h: f64,
    dw: Option<&Bound<'_, PyAny>>,
) -> PyResult<()> {
    let py = state.py();
    check_step_size(h)?;
    let dw = dw.map_or(Ok(Vec::new()), |dw| numbers("dw", dw))?;
    check_length("dw", dw.len(), noises, "noise")?;
    let dw = I::Increments::try_from(&dw).map_err(|_| wrong("dw has a wrong length".to_owned()))?;
    let mut next = state.borrow().read::<I::System>(py)?;
    py.detach(|| method.step(&mut next, h, &dw))
        .map_err(|error| errors::of_step(&error))?;
    state.borrow_mut().write::<I::System>(py, &next)
}

/// The numbers of a path, checked.
pub(crate) struct Request {
    h: f64,
    steps: u64,
    seed: u64,
    path: u64,
    every: u64,
    refine: u32,
}

impl Request {
    pub(crate) fn new(h: f64, [steps, seed, path, every, refine]: [i128; 5]) -> PyResult<Self> {
        check_step_size(h)?;
        Ok(Self {
            h,
            steps: whole("steps", steps, 0..=u64::MAX)?,
            seed: whole("seed", seed, 0..=u64::MAX)?,
            path: whole("path", path, 0..=u64::MAX)?,
            every: whole("every", every, 1..=u64::MAX)?,
            refine: whole("refine", refine, 0..=MOST_HALVINGS)?,
        })
    }
}

/// Returns the states of a path as an array.
pub(crate) fn trajectory<'py, I: Stepper>(
    py: Python<'py>,
    method: &I,
    start: &State,
    request: &Request,
) -> PyResult<Bound<'py, PyAny>> {
    let start = start.read::<I::System>(py)?;
    let mut rows = Rows::new::<I::System>(request.steps.div_ceil(request.every))?;
    let made = py.detach(|| make_steps(&mut rows, method, start, request));
    let states = rows.into_array(py)?;
    match made {
        Ok(()) => Ok(states),
        Err(error) => {
            if error.is_instance_of::<StepError>(py) {
                error.value(py).setattr("states", states)?;
            }
            Err(error)
        }
    }
}

/// Makes the steps of a path, and divides those that fail if this was asked for.
fn make_steps<I: Stepper>(
    rows: &mut Rows,
    method: &I,
    start: StateOf<I::System>,
    request: &Request,
) -> PyResult<()> {
    let noise = Wiener::new(request.seed).path(request.path);
    rows.push::<I::System>(&start);
    let mut path = method.trajectory(start, request.h, noise);
    if request.refine == 0 {
        return save::<I::System>(rows, request, |steps| path.advance(steps).copied());
    }
    let mut path = path.refine(request.refine);
    save::<I::System>(rows, request, |steps| {
        for _ in 0..steps {
            path.next().transpose()?;
        }
        Ok(*path.state())
    })
}

#[allow(clippy::redundant_closure_for_method_calls)] // the method is not general in its lifetime
/// Saves states of a path, which `advance` steps. Looks for Ctrl-C between steps.
fn save<S: Exposable>(
    rows: &mut Rows,
    request: &Request,
    mut advance: impl FnMut(u64) -> Result<StateOf<S>, sve_runtime::StepError>,
) -> PyResult<()> {
    let mut looked = Instant::now();
    let mut made = 0;
    while made < request.steps {
        let saved = request.steps.min(made.saturating_add(request.every));
        while made < saved {
            let some = STEPS_AT_ONCE.min(saved - made);
            let state = advance(some).map_err(|error| errors::of_step(&error))?;
            made += some;
            if made == saved {
                rows.push::<S>(&state);
            }
            if looked.elapsed() > LOOK {
                Python::attach(|py| py.check_signals())?;
                looked = Instant::now();
            }
        }
    }
    Ok(())
}

/// States as rows of numbers.
pub(crate) struct Rows {
    /// Numbers of coordinates and momenta.
    sizes: [usize; 2],
    values: Vec<f64>,
}

impl Rows {
    /// Returns no rows, with the memory for so many and one more.
    pub(crate) fn new<S: Exposable>(more: u64) -> PyResult<Self> {
        let state = empty::<S>();
        let sizes = [state.q.stored_values(), state.p.stored_values()];
        let numbers = (u128::from(more) + 1) * (1 + sizes[0] + sizes[1]) as u128;
        let mut values = Vec::new();
        let reserved = usize::try_from(numbers).map(|numbers| values.try_reserve_exact(numbers));
        match reserved {
            Ok(Ok(())) => Ok(Self { sizes, values }),
            _ => Err(PyMemoryError::new_err(format!(
                "the states take {} bytes, more than this machine gives; save fewer with a larger `every`",
                8 * numbers
            ))),
        }
    }

    /// Appends a state.
    pub(crate) fn push<S: Exposable>(&mut self, state: &StateOf<S>) {
        let at = self.values.len();
        let [q, p] = self.sizes;
        self.values.resize(at + 1 + q + p, state.t);
        state.q.store(&mut self.values[at + 1..at + 1 + q]);
        state.p.store(&mut self.values[at + 1 + q..]);
    }

    /// Appends a state, given as its numbers.
    pub(crate) fn push_numbers(&mut self, t: f64, q: &[f64], p: &[f64]) {
        self.values.push(t);
        self.values.extend_from_slice(q);
        self.values.extend_from_slice(p);
    }

    /// Returns the rows as a structured array.
    pub(crate) fn into_array(self, py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
        let float = "f8";
        let [q, p] = self.sizes;
        let fields = (("t", float), ("q", float, (q,)), ("p", float, (p,)));
        let fields = py.import("builtins")?.call_method1("list", (fields,))?;
        PyArray1::from_vec(py, self.values).call_method1("view", (fields,))
    }
}

/// Returns the energy of a state, or of each state of an array that `trajectory` returned.
pub(crate) fn energy<'py, S: Exposable>(
    system: &S,
    states: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = states.py();
    let energy = |state: &StateOf<S>| {
        system
            .hamiltonian(state)
            .map_err(|error| errors::of_step(&error))
    };
    if let Ok(state) = states.cast::<State>() {
        let energy = energy(&state.borrow().read::<S>(py)?)?;
        return Ok(energy.into_pyobject(py)?.into_any());
    }
    let mut energies = Vec::new();
    let mut state = empty::<S>();
    let [q, p] = [state.q.stored_values(), state.p.stored_values()];
    let field = |name| numbers("states", &states.get_item(name)?);
    let (times, qs, ps) = (field("t")?, field("q")?, field("p")?);
    check_length(
        "the q of states",
        qs.len(),
        q * times.len(),
        "coordinate of each state",
    )?;
    check_length(
        "the p of states",
        ps.len(),
        p * times.len(),
        "momentum of each state",
    )?;
    for (i, &t) in times.iter().enumerate() {
        state.t = t;
        state.q.restore(&qs[i * q..(i + 1) * q]);
        state.p.restore(&ps[i * p..(i + 1) * p]);
        energies.push(energy(&state)?);
    }
    Ok(PyArray1::from_vec(py, energies).into_any())
}

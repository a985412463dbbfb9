//! The class `State`: time, coordinates and momenta, as arrays of `NumPy`.

use numpy::{PyArray1, PyArrayMethods as _, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use sve_runtime::system::{AnySystem, StateOf};
use sve_runtime::{Configuration, StepError};

use crate::arguments::{check_length, numbers};
use crate::errors;
use crate::expose::Exposable;

/// The configuration of a system.
type ConfigurationOf<S> = <S as AnySystem>::Configuration;
/// The momentum of a system, which is also the type of its velocity.
type MomentumOf<S> = <ConfigurationOf<S> as Configuration>::Momentum;

/// A state of a system: the coordinates q, the momenta p and the time t.
///
/// q and p are given as numbers or arrays, and kept as arrays of one dimension.
#[pyclass]
pub(crate) struct State {
    #[pyo3(get, set)]
    t: f64,
    /// The coordinates, an array.
    #[pyo3(get)]
    q: Py<PyArray1<f64>>,
    /// The momenta, an array.
    #[pyo3(get)]
    p: Py<PyArray1<f64>>,
}

#[pymethods]
impl State {
    #[new]
    #[pyo3(signature = (q, p, t = 0.0))]
    fn new(q: &Bound<'_, PyAny>, p: &Bound<'_, PyAny>, t: f64) -> PyResult<Self> {
        Ok(Self {
            t,
            q: array("q", q)?,
            p: array("p", p)?,
        })
    }

    #[setter]
    fn set_q(&mut self, q: &Bound<'_, PyAny>) -> PyResult<()> {
        self.q = array("q", q)?;
        Ok(())
    }

    #[setter]
    fn set_p(&mut self, p: &Bound<'_, PyAny>) -> PyResult<()> {
        self.p = array("p", p)?;
        Ok(())
    }

    /// Returns a state with arrays of its own.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let copied = |array: &Py<PyArray1<f64>>| {
            let values = array.bind(py).to_vec()?;
            Ok::<_, PyErr>(PyArray1::from_vec(py, values).unbind())
        };
        Ok(Self {
            t: self.t,
            q: copied(&self.q)?,
            p: copied(&self.p)?,
        })
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let [q, p] = [&self.q, &self.p].map(|array| array.bind(py).to_vec());
        Ok(format!("State(q={:?}, p={:?}, t={:?})", q?, p?, self.t))
    }
}

impl State {
    /// Returns the state as one of a system.
    pub(crate) fn read<S: Exposable>(&self, py: Python<'_>) -> PyResult<StateOf<S>> {
        let mut state = empty::<S>();
        state.t = self.t;
        let (q, p) = (self.q.bind(py).readonly(), self.p.bind(py).readonly());
        check_length("q", q.len(), state.q.stored_values(), "coordinate")?;
        check_length("p", p.len(), state.p.stored_values(), "momentum")?;
        state.q.restore(q.as_slice()?);
        state.p.restore(p.as_slice()?);
        Ok(state)
    }

    /// Writes a state of a system into the arrays.
    pub(crate) fn write<S: Exposable>(
        &mut self,
        py: Python<'_>,
        state: &StateOf<S>,
    ) -> PyResult<()> {
        let mut q = self.q.bind(py).readwrite();
        let mut p = self.p.bind(py).readwrite();
        state.q.store(q.as_slice_mut()?);
        state.p.store(p.as_slice_mut()?);
        self.t = state.t;
        Ok(())
    }

    fn of<S: Exposable>(py: Python<'_>, state: &StateOf<S>) -> Self {
        let mut q = vec![0.0; state.q.stored_values()];
        let mut p = vec![0.0; state.p.stored_values()];
        state.q.store(&mut q);
        state.p.store(&mut p);
        Self {
            t: state.t,
            q: PyArray1::from_vec(py, q).unbind(),
            p: PyArray1::from_vec(py, p).unbind(),
        }
    }
}

/// Returns the numbers of an argument as an array.
fn array(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Py<PyArray1<f64>>> {
    Ok(PyArray1::from_vec(value.py(), numbers(name, value)?).unbind())
}

/// Returns a state to which numbers are written.
pub(crate) fn empty<S: Exposable>() -> StateOf<S> {
    StateOf::<S>::new(Default::default(), Default::default())
}

/// Returns the state of coordinates and a velocity, which `with_velocity` makes.
pub(crate) fn from_velocity<S: Exposable>(
    q: &Bound<'_, PyAny>,
    v: &Bound<'_, PyAny>,
    with_velocity: impl FnOnce(ConfigurationOf<S>, MomentumOf<S>) -> Result<StateOf<S>, StepError>,
) -> PyResult<State> {
    let py = q.py();
    let (q, v) = (numbers("q", q)?, numbers("v", v)?);
    let mut state = empty::<S>();
    check_length("q", q.len(), state.q.stored_values(), "coordinate")?;
    check_length("v", v.len(), state.p.stored_values(), "velocity")?;
    state.q.restore(&q);
    state.p.restore(&v);
    let state = with_velocity(state.q, state.p).map_err(|error| errors::of_step(&error))?;
    Ok(State::of::<S>(py, &state))
}

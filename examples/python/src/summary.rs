//! The classes `Summary` and `Statistics`: the results of an ensemble.

use numpy::PyArray1;
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use sve_runtime::ensemble;

use crate::trajectory::Rows;

/// Statistics of the paths of an ensemble; summary["q"] are those of the coordinate q.
#[pyclass(frozen)]
pub(crate) struct Summary {
    summary: ensemble::Summary,
    /// The states at the ends of the paths, if they were asked for.
    #[pyo3(get)]
    ends: Option<Py<PyAny>>,
}

impl Summary {
    /// Returns the results; `ends` has room for the states of the ends, if they are kept.
    pub(crate) fn new(
        py: Python<'_>,
        summary: ensemble::Summary,
        ends: Option<Rows>,
    ) -> PyResult<Self> {
        let ends = ends.map(|mut rows| {
            for (_, end) in summary.final_states() {
                rows.push_numbers(end.t, end.q, end.p);
            }
            rows.into_array(py).map(Bound::unbind)
        });
        let ends = ends.transpose()?;
        Ok(Self { summary, ends })
    }
}

#[pymethods]
impl Summary {
    /// The recorded times.
    #[getter]
    fn times<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.summary.times())
    }

    /// The number of paths that were run, with those that failed.
    #[getter]
    fn paths(&self) -> u64 {
        self.summary.paths()
    }

    /// The number of paths that failed, which are in the statistics before their failure alone.
    #[getter]
    fn failed(&self) -> u64 {
        self.summary.failed()
    }

    /// The messages of the failures: of the 256 lowest paths at most.
    #[getter]
    fn failures(&self) -> Vec<String> {
        self.summary
            .failures()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// Warnings about statistics that are not to be relied on.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.summary
            .warnings()
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    /// The names of what was observed.
    #[getter]
    fn names(&self) -> Vec<&str> {
        self.summary
            .statistics()
            .iter()
            .map(ensemble::Statistics::name)
            .collect()
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Statistics> {
        let statistics = self.summary.get(name).ok_or_else(|| {
            PyKeyError::new_err(format!(
                "{name:?} was not observed, only {:?}",
                self.names()
            ))
        })?;
        Ok(Statistics::new(py, statistics))
    }

    fn __str__(&self) -> String {
        self.summary.to_string()
    }
}

/// Statistics of one quantity: arrays with a number for each recorded time.
#[pyclass(frozen, get_all)]
pub(crate) struct Statistics {
    /// The mean over the paths.
    mean: Py<PyArray1<f64>>,
    /// The standard error of the mean.
    standard_error: Py<PyArray1<f64>>,
    /// The variance over the paths.
    variance: Py<PyArray1<f64>>,
    /// The smallest value.
    min: Py<PyArray1<f64>>,
    /// The largest value.
    max: Py<PyArray1<f64>>,
}

impl Statistics {
    fn new(py: Python<'_>, of: &ensemble::Statistics) -> Self {
        let array = |values: &[f64]| PyArray1::from_slice(py, values).unbind();
        Self {
            mean: array(of.mean()),
            standard_error: array(&of.standard_error()),
            variance: array(&of.variance()),
            min: array(of.min()),
            max: array(of.max()),
        }
    }
}

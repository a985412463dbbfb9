//! The macro that makes a Python module of systems.
//!
//! The macro writes what pyo3 has to see for each class: its constructor and its methods, with the
//! texts that `help()` shows. Each method calls a function that works for any system.

use pyo3::prelude::*;
use pyo3::types::PyType;
use sve_runtime::system::AnySystem;
use sve_runtime::{Configuration, Mechanics, Method, OneStepMethod};

/// A system that `expose!` takes: one of fixed size that can be cloned, since a run has a copy of
/// its own. `Default` gives the states that numbers from Python are written to.
pub(crate) trait Exposable:
    Mechanics
    + AnySystem<Configuration: Configuration<Momentum: Default> + Default>
    + Clone
    + Send
    + Sync
    + 'static
{
}

impl<S> Exposable for S where
    S: Mechanics
        + AnySystem<Configuration: Configuration<Momentum: Default> + Default>
        + Clone
        + Send
        + Sync
        + 'static
{
}

/// The integrator of a system that `expose!` takes.
pub(crate) trait Stepper:
    Method
    + OneStepMethod<System: Exposable, Increments: for<'a> TryFrom<&'a [f64]> + Sync>
    + Send
    + Sync
    + 'static
{
}

impl<I> Stepper for I where
    I: Method
        + OneStepMethod<System: Exposable, Increments: for<'a> TryFrom<&'a [f64]> + Sync>
        + Send
        + Sync
        + 'static
{
}

/// Tells the classes of a module its name, which `repr` and tracebacks show.
pub(crate) fn name_classes(module: &Bound<'_, PyModule>, name: &str) -> PyResult<()> {
    for class in module.dict().values() {
        if class.is_instance_of::<PyType>() {
            class.setattr("__module__", name)?;
        }
    }
    Ok(())
}

/// Makes a Python module of systems, each with the rule that steps it:
/// `module: System { parameter: type = default, … } by Rule; …`.
///
/// A system is a struct with `#[pyclass(frozen, get_all)]`, which `#[derive(Clone)]` copies. Its
/// doc comment is the text of the class in Python, and its fields are keyword arguments. A default
/// is a number or an array; a negative number stands in parentheses.
macro_rules! expose {
    ($module:ident: $(
        $system:ident { $($field:ident: $type:ty = $default:tt),* $(,)? } by $rule:expr;
    )+) => {
        $(
            #[pymethods]
            impl $system {
                #[new]
                #[pyo3(signature = (*, $($field = $default),*))]
                fn new($($field: $type),*) -> PyResult<Self> {
                    let system = Self { $($field),* };
                    $crate::arguments::check_parameters(&system)?;
                    Ok(system)
                }

                fn __repr__(&self) -> String {
                    let fields: &[String] = &[
                        $(format!("{}={:?}", stringify!($field), self.$field)),*
                    ];
                    format!("{}({})", stringify!($system), fields.join(", "))
                }

                /// The plan of the step: its equations, its orders and its cost, as text.
                #[getter]
                fn plan(&self) -> String {
                    Integrator::new(self, $rule).plan().to_string()
                }

                /// Returns the state of a velocity: p is the derivative of L by v.
                #[pyo3(signature = (q, v, t = 0.0))]
                fn state_from_velocity(
                    &self,
                    q: &Bound<'_, PyAny>,
                    v: &Bound<'_, PyAny>,
                    t: f64,
                ) -> PyResult<$crate::state::State> {
                    $crate::state::from_velocity::<Self>(q, v, |q, v| {
                        sve_runtime::State::from_velocity_at(self, t, q, v)
                    })
                }

                /// Returns the energy ⟨p, v⟩ − L of a State, or of each state that trajectory()
                /// returned.
                fn energy<'py>(&self, states: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
                    $crate::trajectory::energy(self, states)
                }

                /// Makes one step of length h, in place.
                ///
                /// dw is the Wiener increment over the step, a normal number with variance h; an
                /// array of them if the system has several noises. A system without noise needs
                /// none. A step that fails raises StepError, and the state is then unchanged.
                #[pyo3(signature = (state, h, dw = None))]
                fn step(
                    &self,
                    state: &Bound<'_, $crate::state::State>,
                    h: f64,
                    dw: Option<&Bound<'_, PyAny>>,
                ) -> PyResult<()> {
                    let method = Integrator::new(self.clone(), $rule);
                    $crate::trajectory::step(&method, method.plan().noises, state, h, dw)
                }

                /// Returns the states of one path as an array with the fields "t", "q" and "p".
                ///
                /// The array has the start, the state after each `every` steps, and the end; "q"
                /// and "p" have a column for each coordinate. The noise is a function of seed and
                /// path, and that of path k in ensemble() with the same seed. A step that fails
                /// raises StepError, whose attribute `states` has the states before it. With
                /// `refine` such a step is divided into halves, and these again, so many times at
                /// most.
                #[pyo3(signature = (start, h, steps, *, seed = 0, path = 0, every = 1,
                    refine = 0))]
                #[allow(clippy::too_many_arguments)]
                fn trajectory<'py>(
                    &self,
                    py: Python<'py>,
                    start: &$crate::state::State,
                    h: f64,
                    steps: i128,
                    seed: i128,
                    path: i128,
                    every: i128,
                    refine: i128,
                ) -> PyResult<Bound<'py, PyAny>> {
                    let method = Integrator::new(self.clone(), $rule);
                    let request = $crate::trajectory::Request::new(
                        h,
                        [steps, seed, path, every, refine],
                    )?;
                    $crate::trajectory::trajectory(py, &method, start, &request)
                }

                /// Runs many paths on all cores and returns a Summary of what `observe` names.
                ///
                /// The names are those of the coordinates and momenta in the Lagrangian, and
                /// "energy"; without `observe` all of them. Statistics are taken at the start,
                /// after each `every` steps and at the end; without `every`, at the start and the
                /// end. A path that fails is counted, and the others go on; `refine` is that of
                /// trajectory(). The function
                /// `progress(done, paths)` is called some times a second. With `keep_ends` the
                /// summary has the states of all paths at the end.
                #[pyo3(signature = (start, h, steps, paths, *, seed = 0, every = None,
                    refine = 0, observe = None, threads = None, progress = None, keep_ends = false))]
                #[allow(clippy::too_many_arguments)]
                fn ensemble(
                    &self,
                    py: Python<'_>,
                    start: &$crate::state::State,
                    h: f64,
                    steps: i128,
                    paths: i128,
                    seed: i128,
                    every: Option<i128>,
                    refine: i128,
                    observe: Option<Vec<String>>,
                    threads: Option<i128>,
                    progress: Option<Py<PyAny>>,
                    keep_ends: bool,
                ) -> PyResult<$crate::summary::Summary> {
                    let method = Integrator::new(self.clone(), $rule);
                    let request = $crate::ensemble::Request::new(
                        h, [steps, paths, seed, refine], every, observe, threads, keep_ends,
                    )?;
                    $crate::ensemble::run(py, method, start, request, progress.as_ref())
                }
            }
        )+

        create_exception!(
            $module,
            StepError,
            PyException,
            "A step could not be made; the state that it was given is unchanged.\n\n\
             The message says why, and what to change."
        );
        create_exception!(
            $module,
            EnsembleError,
            PyException,
            "An ensemble could not be run. The message says why, and what to change."
        );

        /// Systems of sve: stochastic variational integrators, compiled from a Lagrangian.
        #[pymodule]
        mod $module {
            use pyo3::prelude::*;

            #[pymodule_export]
            use super::{EnsembleError, StepError, $($system),+};
            #[pymodule_export]
            use $crate::state::State;
            #[pymodule_export]
            use $crate::summary::{Statistics, Summary};

            #[pymodule_init]
            fn name_classes(module: &Bound<'_, PyModule>) -> PyResult<()> {
                $crate::expose::name_classes(module, stringify!($module))
            }
        }
    };
}
pub(crate) use expose;

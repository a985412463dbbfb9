//! Work–precision studies: the cost of an error, for several methods and step sizes of one problem.
//!
//! Input: methods, a start, a horizon, numbers of steps, and a reference: an exact solution, or a
//! fine step on the same Brownian path. Output: a [`Report`] with errors, their standard errors,
//! orders, times and failures. Invariant: all but the times are functions of the settings, with the
//! same bits for any number of threads.
//!
//! Every method and step size has the same Brownian paths: the paths of the finest step, whose
//! increments are summed. So errors are strong errors, path by path, and the choice of paths does
//! not blur differences between methods.

mod any_method;
mod csv;
mod error;
mod estimate;
mod options;
mod order;
mod reference;
mod report;
mod run;
mod settings;
mod stopwatch;
mod table;

pub use csv::{Record, read_csv, to_csv, write_csv};
pub use error::StudyError;
pub use estimate::Estimate;
pub use order::{NotAsymptotic, Order};
pub use report::{Invariant, Report, Row, Timing};

use core::fmt;
use std::borrow::Cow;

use self::any_method::AnyMethod;
use self::reference::Reference;
use crate::error::StepError;
use crate::phase::configuration::FixedSize;
use crate::phase::state::State;
use crate::system::{StateOf, System};

/// Default number of repeats of each timing.
const REPEATS: u32 = 9;

/// A function of the system and a state.
type Closure<'a, S> = Box<dyn Fn(&S, &StateOf<S>) -> Result<f64, StepError> + Sync + 'a>;
/// The distance between two states.
type Distance<'a, S> = Box<dyn Fn(&StateOf<S>, &StateOf<S>) -> f64 + Sync + 'a>;

/// A function of the state whose weak error is measured.
struct Observable<'a, S: System> {
    name: Cow<'a, str>,
    value: Closure<'a, S>,
    /// Its exact mean at the horizon, if it is known.
    mean: Option<f64>,
}

/// A method of a study.
struct Candidate<'a, S: System> {
    name: Cow<'a, str>,
    method: &'a dyn AnyMethod<S>,
    /// Numbers of steps; `None` for the numbers of the study.
    steps: Option<Vec<usize>>,
}

/// One problem, solved by several methods with several step sizes.
///
/// A start, a horizon, numbers of steps, a method and a reference have to be given. The seed is 0
/// and the number of paths 1 unless they are given; a system without noise always has one path.
///
/// ```
/// use sve_runtime::baseline::Heun;
/// use sve_runtime::prelude::*;
/// use sve_runtime::study::{Study, StudyError};
///
/// #[derive(Clone, Copy)]
/// struct Kubo { a: f64, sigma: f64 }
///
/// #[variational(midpoint)]
/// impl Kubo {
///     fn lagrangian(&self, q: f64, v: f64) -> f64 {
///         v * v / (2.0 * self.a) - self.a / 2.0 * q * q
///     }
///     #[h1]
///     fn jitter(&self, q: f64, p: f64) -> f64 { self.sigma / 2.0 * (q * q + p * p) }
/// }
///
/// # fn main() -> Result<(), StudyError> {
/// let kubo = Kubo { a: 1.0, sigma: 0.5 };
/// let midpoint = Integrator::new(kubo, Midpoint);
/// let heun = Heun::new(kubo);
/// let report = Study::new("Kubo")
///     .start(State::new([1.0], [0.0]))
///     .horizon(1.0)
///     .step_counts([16, 32, 64, 128])
///     .paths(200).seed(7)
///     .method("midpoint", &midpoint)
///     .method("Heun", &heun)
///     .exact(|path| {
///         let w: f64 = (0..path.len()).filter_map(|step| path.get(step)).map(|dw| dw[0]).sum();
///         let (sin, cos) = (1.0 + 0.5 * w).sin_cos();
///         State::new([cos], [-sin])
///     })
///     .invariant(|_, z| z.q[0].powi(2) + z.p[0].powi(2))
///     .repeats(0) // no times
///     .run()?;
/// println!("{report}");
/// let order = &report.orders()[0];
/// assert_eq!(order.method, "midpoint");
/// assert!((order.order.value - 1.0).abs() < 2.0 * order.order.standard_error);
/// // the midpoint rule keeps q² + p², Heun's method does not
/// let largest = |method| report.row(method, 16).unwrap().invariant.unwrap().largest;
/// assert!(largest("midpoint") < 1e-14 && largest("Heun") > 1e-4);
/// # Ok(())
/// # }
/// ```
pub struct Study<'a, S: System> {
    problem: Cow<'a, str>,
    methods: Vec<Candidate<'a, S>>,
    start: Option<StateOf<S>>,
    horizon: Option<f64>,
    steps: Vec<usize>,
    paths: u64,
    seed: u64,
    reference: Option<Reference<'a, S>>,
    distance: Distance<'a, S>,
    observables: Vec<Observable<'a, S>>,
    invariant: Option<Closure<'a, S>>,
    repeats: u32,
}

impl<'a, S: System> Study<'a, S> {
    /// A study of the problem of this name.
    pub fn new(problem: impl Into<Cow<'a, str>>) -> Self {
        Self {
            problem: problem.into(),
            methods: Vec::new(),
            start: None,
            horizon: None,
            steps: Vec::new(),
            paths: 1,
            seed: 0,
            reference: None,
            distance: Box::new(euclidean),
            observables: Vec::new(),
            invariant: None,
            repeats: REPEATS,
        }
    }

    /// Returns the numbers of steps of a method.
    fn steps_of(&self, method: usize) -> &[usize] {
        self.methods[method].steps.as_ref().unwrap_or(&self.steps)
    }

    /// Solves the problem with every method and number of steps.
    ///
    #[doc = include_str!("example.md")]
    /// let report = study().run()?;
    /// println!("{report}");
    #[doc = include_str!("../example_end.md")]
    ///
    /// # Errors
    /// A [`StudyError`] for settings that make no sense, and where the reference fails. A method
    /// that fails is counted in its [`Row`].
    pub fn run(&self) -> Result<Report, StudyError> {
        run::run(self)
    }
}

/// Returns the square root of the sum of squared differences of all entries, which include the
/// entries of rotation matrices, and momenta.
fn euclidean<Q: FixedSize>(a: &State<Q>, b: &State<Q>) -> f64 {
    let entries = |state: &State<Q>| {
        let mut entries = vec![0.0; Q::ENTRIES];
        state.q.entries(&mut entries);
        entries
    };
    let ([a_q, b_q], [a_p, b_p]) = (
        [a, b].map(entries),
        [a, b].map(|state| state.stored()[1].clone()),
    );
    let mut sum = 0.0;
    // each coordinate with its momentum, so that the order of a vector space stays
    for i in 0..Q::ENTRIES.max(Q::DEGREES_OF_FREEDOM) {
        let q = if i < Q::ENTRIES {
            (a_q[i] - b_q[i]).powi(2)
        } else {
            0.0
        };
        let p = if i < Q::DEGREES_OF_FREEDOM {
            (a_p[i] - b_p[i]).powi(2)
        } else {
            0.0
        };
        sum += q + p;
    }
    sum.sqrt()
}

impl<S: System> fmt::Debug for Study<'_, S> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<_> = self
            .methods
            .iter()
            .map(|candidate| &candidate.name)
            .collect();
        f.debug_struct("Study")
            .field("problem", &self.problem)
            .field("methods", &names)
            .field("horizon", &self.horizon)
            .field("steps", &self.steps)
            .field("paths", &self.paths)
            .field("seed", &self.seed)
            .finish_non_exhaustive()
    }
}

//! Gradients of means: derivatives of an observable along each path, by the chain rule through its
//! steps.
//!
//! Input: a smooth function of a state, and the quantities by which its mean is differentiated.
//! Output: the function and each of its derivatives as observables of the summary. Invariant: the
//! derivatives change no other number of a run; the derivatives of a path depend on its number
//! only.
//!
//! `tangents.rs` carries the tangent vectors of the paths along their steps.

use std::sync::Arc;

use super::by::By;
use super::observe::Function;
use super::observer::{Kind, Observable, Observer, Seen};
use super::statistics::Statistics;
use super::summary::Summary;
use super::systems::Systems;
use super::tangents::{CarryTiles, carry_tiles};
use super::tile::lanes;
use super::{Ensemble, EnsembleError};
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::Lane;
use crate::mechanics::with_dual_state;
use crate::method::{Differentiable, OneStepMethod};
use crate::phase::Field;
use crate::phase::configuration::FixedSize;
use crate::phase::dual::Dual;
use crate::system::linearisation::Directions;
use crate::system::{
    ConfigurationOf, Dimensions, DualStateOf, StateLanesOf, StateOf, System, VectorOf,
};

/// A smooth function of a state, with its derivatives.
pub(super) trait Smooth<S: System>: Send + Sync {
    /// Returns the derivative along a direction.
    fn slope(
        &self,
        system: &S,
        state: &StateOf<S>,
        direction: &Field<VectorOf<S>>,
        varied: Option<usize>,
    ) -> f64;
    /// Returns the error of a function that cannot be evaluated.
    fn check(&self, system: &S, state: &StateOf<S>) -> Result<(), StepError>;
}

/// A closure over dual numbers.
struct SmoothClosure<F>(F);

impl<S, F> Smooth<S> for SmoothClosure<F>
where
    S: System,
    F: Fn(&DualStateOf<'_, S>) -> Dual + Send + Sync,
{
    fn slope(
        &self,
        system: &S,
        state: &StateOf<S>,
        direction: &Field<VectorOf<S>>,
        varied: Option<usize>,
    ) -> f64 {
        let dual = with_dual_state(system, state, direction, varied, &|_| {}, &self.0);
        dual.map_or(f64::NAN, Dual::slope)
    }

    fn check(&self, system: &S, state: &StateOf<S>) -> Result<(), StepError> {
        let dual = with_dual_state(
            system,
            state,
            &Field::zero::<S::Dims>(),
            None,
            &|_| {},
            &self.0,
        );
        dual.map(|_| ())
    }
}

impl<S, F> Function<S> for SmoothClosure<F>
where
    S: System,
    F: Fn(&DualStateOf<'_, S>) -> Dual + Send + Sync,
{
    fn tile(&self, systems: &Systems<'_, S>, states: &StateLanesOf<S>, values: &mut Lane) {
        systems.each(|lane, system| {
            let state = S::Dims::get(states, lane);
            values[lane] = self.value(system, &state).unwrap_or(f64::NAN);
        });
    }

    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        let dual = with_dual_state(
            system,
            state,
            &Field::zero::<S::Dims>(),
            None,
            &|_| {},
            &self.0,
        )?;
        Ok(dual.value())
    }
}

/// A smooth function, or its derivative in a direction.
struct Smoothed<F> {
    function: Arc<SmoothClosure<F>>,
    direction: Option<usize>,
}

impl<S, F> Observable<S> for Smoothed<F>
where
    S: System,
    F: Fn(&DualStateOf<'_, S>) -> Dual + Send + Sync,
{
    fn kind(&self) -> Kind {
        if self.direction.is_some() {
            Kind::Gradient
        } else {
            Kind::Plain
        }
    }

    fn function(&self) -> &dyn Function<S> {
        &*self.function
    }

    fn observer(&self, _: usize, _: u64) -> Box<dyn Observer<S> + '_> {
        Box::new(self)
    }
}

impl<S, F> Observer<S> for &Smoothed<F>
where
    S: System,
    F: Fn(&DualStateOf<'_, S>) -> Dual + Send + Sync,
{
    fn sees_steps(&self) -> bool {
        false
    }

    fn values(&self, seen: &Seen<'_, S>, values: &mut Lane) {
        let (Some(direction), Some(tangents)) = (self.direction, seen.tangents) else {
            return self.function.tile(seen.systems, seen.states, values);
        };
        let varied = tangents.varied_in(direction, seen.step);
        for lane in lanes(seen.active) {
            let state = S::Dims::get(seen.states, lane);
            let along = tangents.of(seen.tile, direction, lane);
            values[lane] = (self.function).slope(seen.systems.of(lane), &state, &along, varied);
        }
    }
}

/// Makes a step and carries tangent vectors along it, see [`Differentiable::push_forward`].
pub(super) type PushForward<I> = fn(
    &I,
    &<I as OneStepMethod>::Prepared,
    &mut StateOf<<I as OneStepMethod>::System>,
    f64,
    &<I as OneStepMethod>::Increments,
    Directions<'_, VectorOf<<I as OneStepMethod>::System>>,
) -> Result<(), StepError>;

/// The steps of a method that carry tangent vectors.
pub(super) struct TangentSteps<I: PathMethod> {
    /// The steps of a single state.
    pub(super) alone: PushForward<I>,
    /// The steps in lanes.
    pub(super) in_lanes: fn(CarryTiles<'_, I>) -> u64,
}

impl<I: PathMethod> Clone for TangentSteps<I> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<I: PathMethod> Copy for TangentSteps<I> {}

/// The function that is differentiated, and the variables.
pub(super) struct Gradients<'a, I: PathMethod> {
    /// The names of the functions.
    names: Vec<String>,
    pub(super) functions: Vec<Arc<dyn Smooth<I::System> + 'a>>,
    pub(super) by: Vec<By>,
    pub(super) steps: Option<TangentSteps<I>>,
}

impl<I: PathMethod> Default for Gradients<'_, I> {
    fn default() -> Self {
        Self {
            names: Vec::new(),
            functions: Vec::new(),
            by: Vec::new(),
            steps: None,
        }
    }
}

/// The reason why paths that stop have no gradients.
const STOPS: &str = "the mean over paths that end at an event depends on the times of the events, which the derivatives along the paths leave out; run without `stop_at`, or take differences with common noise by `sweep`";

impl<I: PathMethod> Gradients<'_, I> {
    /// Checks that each quantity of a gradient exists in the system, that the functions ask for
    /// existing parameters, and that no path stops. `first` is the start of the first path.
    pub(super) fn check(
        &self,
        system: &I::System,
        first: &StateOf<I::System>,
        has_stops: bool,
    ) -> Result<(), EnsembleError> {
        let coordinates = ConfigurationOf::<I::System>::DEGREES_OF_FREEDOM;
        let stops = || has_stops.then(|| STOPS.to_owned());
        for by in &self.by {
            if let Some(why) = by.problem::<I::System>(coordinates).or_else(stops) {
                let by = by.to_string();
                return Err(EnsembleError::Gradient { by, why });
            }
        }
        for (name, function) in self.names.iter().zip(&self.functions) {
            function
                .check(system, first)
                .map_err(|error| EnsembleError::GradientFunction {
                    name: name.clone(),
                    error: Box::new(error),
                })?;
        }
        Ok(())
    }
}

impl<'a, I: PathMethod, K> Ensemble<'a, I, K> {
    /// Takes statistics of a smooth function of a state, and of its derivatives: the derivatives of
    /// the mean by parameters, by parameters during some steps and by the start, with their
    /// standard errors.
    ///
    /// The function is written with [dual numbers](Dual), which have the operators and smooth
    /// functions of `f64`. [`Summary::derivative`] returns the statistics of a derivative; its name
    /// among the observables is `∂name/∂quantity`.
    ///
    /// ```
    /// use sve_runtime::ensemble::By;
    /// use sve_runtime::prelude::*;
    ///
    /// struct Oscillator { k: f64, sigma: f64 }
    ///
    /// #[variational(endpoint)]
    /// impl Oscillator {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v - 0.5 * self.k * q * q }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let integrator = Integrator::new(Oscillator { k: 1.0, sigma: 0.5 }, Endpoint);
    /// let summary = Ensemble::new(&integrator)
    ///     .paths(10_000).seed(7)
    ///     .steps(0.05, 40)
    ///     .start(State::new([1.0], [0.0]))
    ///     .gradient("energy", ["sigma".into(), By::p(0)], |s| {
    ///         0.5 * s.p[0].powi(2) + 0.5 * s.parameter("k") * s.q[0].powi(2)
    ///     })
    ///     .run()?;
    /// // the mean energy is ½ + ½σ²t + O(h)
    /// let by_sigma = summary.derivative("energy", "sigma").unwrap();
    /// let (slope, error) = (by_sigma.mean()[1], by_sigma.standard_error()[1]);
    /// assert!(error < 0.05 && (slope - 0.5 * 2.0).abs() < 0.1 + 4.0 * error);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// Each path is differentiated with its increments held fixed. The mean of these derivatives is
    /// the derivative of the mean only for smooth functions of the state at a fixed time. Other
    /// functions cannot be written: dual numbers do not compare, and have no `abs`. For the
    /// probability of an event replace the jump by a smooth step,
    /// `0.5 + 0.5 * ((q - a) / w).tanh()`, with a width w that is small compared with the spread of
    /// q, and check that the result does not depend on w; or use likelihood ratios, as the
    /// [guide](crate::guide::derivatives) does. The gradient of a quantile is minus the gradient of
    /// the probability to be below it, over the density at the quantile. [Averages](Self::average),
    /// [weighted](Self::weight) means and paths that [stop](Self::stop_at) have no gradients: take
    /// differences with common noise by [`sweep`](Self::sweep). A path on which a step had to be
    /// [refined](Self::refine) fails.
    ///
    /// The derivatives do not include the dependence of a start on a parameter. Its contribution is
    /// the sum of the derivatives by [`By::q`] and [`By::p`] times the derivatives of the start.
    ///
    /// The tangent vectors are carried in lanes, as the states are: a run with gradients by one to
    /// four quantities takes 1.3 to 3 times as long as without gradients. If the step is not in
    /// lanes ([`Plan::in_lanes`](crate::Plan::in_lanes)), has constraints or large derivatives, a
    /// step with tangent vectors is made for one path after the other, which takes 10 to 30 times
    /// as long as a step in lanes. The other statistics of a run keep their bits.
    ///
    /// # Errors
    /// [`run`](Self::run) returns [`EnsembleError::Gradient`] for a quantity that the system does
    /// not have, and [`EnsembleError::GradientFunction`] for a function that asks for such a
    /// parameter.
    #[must_use]
    pub fn gradient<B: Into<By>>(
        mut self,
        name: impl Into<String>,
        by: impl IntoIterator<Item = B>,
        function: impl Fn(&DualStateOf<'_, I::System>) -> Dual + Send + Sync + 'a,
    ) -> Self
    where
        I: Differentiable,
    {
        let name = name.into();
        let function = Arc::new(SmoothClosure(function));
        let smoothed = |direction| {
            let function = function.clone();
            Smoothed {
                function,
                direction,
            }
        };
        self = self.add(&name, smoothed(None));
        for by in by {
            let (by, gradients) = (by.into(), &mut self.observed.gradients);
            let known = gradients.by.iter().position(|known| *known == by);
            let direction = known.unwrap_or(gradients.by.len());
            let of = derivative(&name, &by);
            if known.is_none() {
                gradients.by.push(by);
            }
            self = self.add(of, smoothed(Some(direction)));
        }
        let gradients = &mut self.observed.gradients;
        gradients.names.push(name);
        gradients.functions.push(function);
        gradients.steps = Some(TangentSteps {
            alone: I::push_forward,
            in_lanes: carry_tiles::<I>,
        });
        self
    }
}

/// Returns the name of a derivative.
fn derivative(name: &str, by: &By) -> String {
    format!("∂{name}/∂{by}")
}

impl Summary {
    /// The statistics of the derivative of an observable of [`Ensemble::gradient`] by a quantity,
    /// at each recorded time. `None` if the ensemble did not take this derivative.
    pub fn derivative(&self, name: &str, by: impl Into<By>) -> Option<&Statistics> {
        self.get(&derivative(name, &by.into()))
    }
}

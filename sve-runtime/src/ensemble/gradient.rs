//! Gradients of means: derivatives of an observable along each path, by the chain rule through its steps.
//!
//! Input: a smooth function of a state, and the quantities by which its mean is differentiated. Output: the function and each of its derivatives as observables of the
//! summary. Invariant: the derivatives change no other number of a run; those of a path depend on its number only.
//!
//! The tangent vectors of a path are carried through the tangent maps of its steps, at the states that the step in lanes has reached.

use std::sync::Arc;

use super::by::By;
use super::failure::Cause;
use super::memory::Kind;
use super::observe::Observable;
use super::path_block::PathBlock;
use super::statistics::Statistics;
use super::summary::Summary;
use super::tile::lanes;
use super::{Ensemble, EnsembleError};
use crate::configuration::{Coordinates, VectorCoordinates};
use crate::dual::{Dual, DualState, with_dual_state};
use crate::error::StepError;
use crate::lanes::{LANES, Lane};
use crate::linearisation::Directions;
use crate::mechanics::Field;
use crate::method::{Differentiable, Method};
use crate::state::State;
use crate::system::{Dimensions, Dims, IncrementsOf, StateOf, System, VectorOf};

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
}

/// A closure over dual numbers for a system with `N` coordinates.
struct SmoothClosure<F, const N: usize>(F);

impl<S, F, Q, const N: usize, const M: usize> Smooth<S> for SmoothClosure<F, N>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
    F: Fn(&DualState<'_, N>) -> Dual + Send + Sync,
{
    fn slope(
        &self,
        system: &S,
        state: &State<Q>,
        direction: &Field<[f64; N]>,
        varied: Option<usize>,
    ) -> f64 {
        let state = state.to_coordinates();
        with_dual_state(system, &state, direction, varied, &|_| {}, &self.0).slope()
    }
}

impl<S, F, Q, const N: usize, const M: usize> Observable<S> for Arc<SmoothClosure<F, N>>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: VectorCoordinates<N>,
    F: Fn(&DualState<'_, N>) -> Dual + Send + Sync,
{
    fn tile(&self, system: &S, states: &<S::Dims as Dimensions>::StateLanes, values: &mut Lane) {
        for (lane, value) in values.iter_mut().enumerate() {
            let state = S::Dims::get(states, lane);
            *value = self.value(system, &state).unwrap_or(f64::NAN);
        }
    }

    fn value(&self, system: &S, state: &State<Q>) -> Result<f64, StepError> {
        let state = state.to_coordinates();
        let dual = with_dual_state(system, &state, &Field::ZERO, None, &|_| {}, &self.0);
        Ok(dual.value())
    }
}

/// Makes a step and carries tangent vectors along it, see [`Differentiable::push_forward`].
type PushForward<I> = fn(
    &I,
    &<I as crate::OneStepMethod>::Prepared,
    &mut StateOf<<I as crate::OneStepMethod>::System>,
    f64,
    &IncrementsOf<<I as crate::OneStepMethod>::System>,
    Directions<'_, VectorOf<<I as crate::OneStepMethod>::System>>,
) -> Result<(), StepError>;

/// What is differentiated, and by what.
pub(super) struct Gradients<'a, I: Method> {
    functions: Vec<Arc<dyn Smooth<I::System> + 'a>>,
    by: Vec<By>,
    push_forward: Option<PushForward<I>>,
}

impl<I: Method> Default for Gradients<'_, I> {
    fn default() -> Self {
        Self {
            functions: Vec::new(),
            by: Vec::new(),
            push_forward: None,
        }
    }
}

/// Why paths that stop have no gradients.
const STOPS: &str = "the mean over paths that end at an event depends on the times of the events, which the derivatives along the paths leave out; run without `stop_at`";

impl<I: Method> Gradients<'_, I> {
    /// Checks that the system has what its means are differentiated by, and that no path stops.
    pub(super) fn check(&self, coordinates: usize, has_stops: bool) -> Result<(), EnsembleError> {
        let stops = || has_stops.then(|| STOPS.to_owned());
        for by in &self.by {
            if let Some(why) = by.problem::<I::System>(coordinates).or_else(stops) {
                let by = by.to_string();
                return Err(EnsembleError::Gradient { by, why });
            }
        }
        Ok(())
    }
}

/// The tangent vectors of the paths of a block, by path and quantity.
#[derive(Default)]
pub(super) struct Tangents<const N: usize> {
    fields: Vec<Field<[f64; N]>>,
    /// Work space: the parameter that varies in a step, by quantity.
    varied: Vec<Option<usize>>,
}

impl<const N: usize> Tangents<N> {
    /// The tangent vectors at the start, for so many tiles.
    pub(super) fn new<I: Method>(gradients: &Gradients<'_, I>, tiles: usize) -> Self {
        let starts: Vec<_> = gradients.by.iter().map(By::start).collect();
        Self {
            fields: starts.repeat(tiles * LANES),
            varied: vec![None; starts.len()],
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.fields.is_empty()
    }
}

impl<'a, I, S, Q, const N: usize, const M: usize> Ensemble<'a, I>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Takes statistics of a smooth function of a state, and of its derivatives: the derivatives of the mean by parameters, by parameters during some steps and by the start, with
    /// their standard errors.
    ///
    /// The function is written with [dual numbers](Dual), which have the operators and smooth functions of `f64`. [`Summary::derivative`] returns the statistics of a derivative; its
    /// name among the observables is `∂name/∂quantity`.
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
    /// The derivatives are those of each path with its increments held fixed. Their mean is the derivative of the mean only for smooth functions of the state at a fixed time, and
    /// nothing else can be written: dual numbers do not compare, and have no `abs`. For the probability of an event replace the jump by a smooth step, `0.5 + 0.5 * ((q - a) / w).tanh()`,
    /// with a width w that is small beside the law of q, and see that the result does not depend on w. The gradient of a quantile is that of the probability over the density there. [Averages](Self::average),
    /// [weighted](Self::weight) means and paths that [stop](Self::stop_at) have no gradients, and a path on which a step had to be [refined](Self::refine) fails.
    ///
    /// A start that depends on a parameter does not follow it; its part is the sum of the derivatives by [`By::q`] and [`By::p`] times those of the start.
    ///
    /// Each step costs one step that is not in lanes and one linear system, and little more for each further quantity: with two quantities a run takes 5 to 12 times as long. The other statistics of a run keep their bits. Systems with rotations are excluded.
    #[must_use]
    pub fn gradient<B: Into<By>>(
        mut self,
        name: impl Into<String>,
        by: impl IntoIterator<Item = B>,
        function: impl Fn(&DualState<'_, N>) -> Dual + Send + Sync + 'a,
    ) -> Self
    where
        I: Differentiable,
        Q: VectorCoordinates<N>,
    {
        let name = name.into();
        let smooth = Arc::new(SmoothClosure(function));
        let number = self.gradients.functions.len();
        self = self.add(name.clone(), smooth.clone(), Kind::Value);
        for by in by {
            let by = by.into();
            let known = self.gradients.by.iter().position(|known| *known == by);
            let direction = known.unwrap_or(self.gradients.by.len());
            let of = derivative(&name, &by);
            if known.is_none() {
                self.gradients.by.push(by);
            }
            let kind = Kind::Slope(number, direction);
            self = self.add(of, smooth.clone(), kind);
        }
        self.gradients.functions.push(smooth);
        self.gradients.push_forward = Some(I::push_forward);
        self
    }
}

/// Returns the name of a derivative.
fn derivative(name: &str, by: &By) -> String {
    format!("∂{name}/∂{by}")
}

impl Summary {
    /// The statistics of the derivative of an observable of [`Ensemble::gradient`] by a quantity, at each recorded time. `None` if it was not asked for.
    pub fn derivative(&self, name: &str, by: impl Into<By>) -> Option<&Statistics> {
        self.get(&derivative(name, &by.into()))
    }
}

impl<I, S, Q, const N: usize, const M: usize> PathBlock<'_, I, N, M>
where
    I: Method<System = S>,
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    /// Carries the tangent vectors of the active paths of a tile along the last step.
    pub(super) fn advance_tangents(&mut self, tile: usize) {
        let settings = self.settings;
        let gradients = &settings.ensemble.gradients;
        let (Some(push_forward), Some(step)) = (gradients.push_forward, self.step.checked_sub(1))
        else {
            return;
        };
        let quantities = gradients.by.len();
        for (varied, by) in self.tangents.varied.iter_mut().zip(&gradients.by) {
            *varied = by.parameter_in::<S>(step / settings.parts);
        }
        let increments = self.increments_of(tile, step);
        for lane in lanes(self.tiles[tile].active) {
            let mut state = S::Dims::get(self.tiles[tile].states_before(), lane);
            state.t = settings.time(step);
            let first = (tile * LANES + lane) * quantities;
            let directions = Directions {
                fields: &mut self.tangents.fields[first..][..quantities],
                parameters: &self.tangents.varied,
            };
            let dw = increments.0.map(|process| process[lane]);
            let (method, h) = (settings.method, settings.h);
            let made = push_forward(method, &self.prepared, &mut state, h, &dw, directions);
            if let Err(error) = made {
                self.fail(tile, lane, step, Cause::Step(error));
            }
        }
    }

    /// Evaluates a derivative in the active lanes of a tile.
    pub(super) fn slopes(
        &self,
        (function, direction): (usize, usize),
        tile: usize,
        values: &mut Lane,
    ) {
        let ensemble = self.settings.ensemble;
        let gradients = &ensemble.gradients;
        let by = &gradients.by[direction];
        let varied = by.parameter_in::<S>(self.step.saturating_sub(1) / self.settings.parts);
        for lane in lanes(self.tiles[tile].active) {
            let state = S::Dims::get(self.tiles[tile].states(), lane);
            let at = (tile * LANES + lane) * gradients.by.len() + direction;
            let field = &self.tangents.fields[at];
            let function = &gradients.functions[function];
            values[lane] = function.slope(self.settings.method.system(), &state, field, varied);
        }
    }
}

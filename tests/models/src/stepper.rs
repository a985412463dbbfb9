//! Integrators behind a pointer: one loop goes over the rules of a system.

use sve_runtime::__private::VectorCoordinates;
use sve_runtime::prelude::*;
use sve_runtime::system::{Dims, System};
use sve_runtime::{Configuration, Rule, Variational};

use crate::checks::failure;
use crate::oracle::name;

/// An integrator by any rule.
pub trait Stepper<Q: Configuration, I: ?Sized> {
    /// `Pendulum by midpoint`, for messages.
    fn name(&self) -> String;
    /// The name of the rule.
    fn rule(&self) -> &'static str;
    /// Makes a step.
    ///
    /// # Errors
    /// That of the step.
    fn step(&self, state: &mut State<Q>, h: f64, dw: &I) -> Result<(), StepError>;
    /// Returns the state on the constraints that is nearest to a state.
    ///
    /// # Errors
    /// That of the projection.
    fn consistent(&self, state: State<Q>) -> Result<State<Q>, StepError>;
    /// Returns the error of a step that must fail and leave the state unchanged.
    ///
    /// # Panics
    /// If it does not.
    fn failure(&self, start: &State<Q>, h: f64, dw: &I) -> StepError;
    /// Returns the state after steps with the same increments.
    ///
    /// # Panics
    /// If a step fails.
    fn after(&self, start: State<Q>, h: f64, dw: &I, steps: u32) -> State<Q>;
}

impl<S, R, Q, const N: usize, const M: usize> Stepper<Q, R::Increments> for Integrator<S, R>
where
    S: System<Dims = Dims<N, M, Q>>,
    R: Rule<S::Itself>,
    Q: VectorCoordinates<N>,
{
    fn name(&self) -> String {
        name(self)
    }

    fn rule(&self) -> &'static str {
        self.plan().rule
    }

    fn step(&self, state: &mut State<Q>, h: f64, dw: &R::Increments) -> Result<(), StepError> {
        Integrator::step(self, state, h, dw)
    }

    fn consistent(&self, state: State<Q>) -> Result<State<Q>, StepError> {
        Integrator::consistent(self, state)
    }

    fn failure(&self, start: &State<Q>, h: f64, dw: &R::Increments) -> StepError {
        failure(self, start, h, dw)
    }

    fn after(&self, start: State<Q>, h: f64, dw: &R::Increments, steps: u32) -> State<Q> {
        let mut state = start;
        for step in 0..steps {
            let result = Integrator::step(self, &mut state, h, dw);
            result.unwrap_or_else(|error| panic!("{}, step {step}: {error}", name(self)));
        }
        state
    }
}

/// Integrators of one system by several rules, with an increment for each of M processes.
pub type Steppers<'a, Q, const M: usize> = Vec<Box<dyn Stepper<Q, [f64; M]> + 'a>>;

/// The one-node rules: initial point, midpoint, endpoint.
pub fn one_node<S, Q, const N: usize, const M: usize>(system: &S) -> Steppers<'_, Q, M>
where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>,
    Q: VectorCoordinates<N>,
{
    vec![
        Box::new(Integrator::new(system, InitialPoint)),
        Box::new(Integrator::new(system, Midpoint)),
        Box::new(Integrator::new(system, Endpoint)),
    ]
}

/// The one-node rules, and that of Störmer and Verlet.
pub fn with_verlet<S, Q, const N: usize, const M: usize>(system: &S) -> Steppers<'_, Q, M>
where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + Variational<StormerVerlet>,
    Q: VectorCoordinates<N>,
{
    let mut rules = one_node(system);
    rules.push(Box::new(Integrator::new(system, StormerVerlet)));
    rules
}

/// The one-node rules, and that of Taylor series of degree two.
pub fn with_taylor2<S, Q, const N: usize, const M: usize>(system: &S) -> Steppers<'_, Q, M>
where
    S: System<Dims = Dims<N, M, Q>>
        + Variational<InitialPoint>
        + Variational<Midpoint>
        + Variational<Endpoint>
        + Variational<Taylor2>,
    Q: VectorCoordinates<N>,
{
    let mut rules = one_node(system);
    rules.push(Box::new(Integrator::new(system, Taylor2)));
    rules
}

//! A system with another type of configurations. Its equations and coordinates are the same.

use std::marker::PhantomData;

use sve_runtime::__private::lane::KeepUnknowns;
use sve_runtime::__private::{
    BlockSolver, Dimensions, EulerIncrement, IncrementLanesOf, Lane, Mask, StateLanesOf,
    StepEquations, VectorCoordinates, VectorOf,
};
use sve_runtime::__private::{Linearisation, Returns, SolveError, StartOfStep};
use sve_runtime::system::{Dims, IncrementsOf, System};
use sve_runtime::{Newton, Plan, State};

/// The system `S` with configurations of the type `Q`.
#[derive(Clone, Copy)]
pub struct Configured<S, Q>(pub S, PhantomData<Q>);

/// Prints the inner system.
impl<S: std::fmt::Debug, Q> std::fmt::Debug for Configured<S, Q> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

impl<S, Q> Configured<S, Q> {
    /// Returns a system with another type of configurations.
    pub fn new(system: S) -> Self {
        Self(system, PhantomData)
    }
}

impl<S, P, Q, const N: usize, const M: usize> System for Configured<S, Q>
where
    S: System<Dims = Dims<N, M, P>>,
    P: VectorCoordinates<N>,
    Q: VectorCoordinates<N>,
{
    type Dims = Dims<N, M, Q>;
    type Itself = Self;
    const AFFINE_MOMENTUM: bool = S::AFFINE_MOMENTUM;
    const FORCED: bool = S::FORCED;
    const PARAMETERS: &'static [&'static str] = S::PARAMETERS;
    const FORMULAS: u64 = S::FORMULAS;
    type EulerNumbers = S::EulerNumbers;
    const HAS_EULER_INCREMENT: bool = S::HAS_EULER_INCREMENT;
    const EULER_STAGES_IN_LANES: usize = S::EULER_STAGES_IN_LANES;

    fn itself(&self) -> &Self {
        self
    }

    fn euler_numbers(&self, h: f64) -> Option<S::EulerNumbers> {
        self.0.euler_numbers(h)
    }

    fn euler_increment(
        &self,
        prepared: &S::EulerNumbers,
        t: f64,
        q: &VectorOf<Self>,
        p: &VectorOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
    ) -> Option<EulerIncrement<VectorOf<Self>>> {
        self.0.euler_increment(prepared, t, q, p, h, dw)
    }

    fn euler_increment_in_lane(
        &self,
        prepared: &S::EulerNumbers,
        t: f64,
        q: &VectorOf<Self>,
        p: &VectorOf<Self>,
        h: f64,
        dw: &IncrementsOf<Self>,
    ) -> Option<EulerIncrement<VectorOf<Self>>> {
        self.0.euler_increment_in_lane(prepared, t, q, p, h, dw)
    }

    fn parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.0.parameters(visit);
    }

    fn lagrangian_jet(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::LagrangianJet {
        self.0.lagrangian_jet(t, q, v)
    }

    fn noise_jets(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        p: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::NoiseJets {
        self.0.noise_jets(t, q, p)
    }

    fn force_jet(
        &self,
        t: f64,
        q: &VectorOf<Self>,
        v: &VectorOf<Self>,
    ) -> <Self::Dims as Dimensions>::ForceJet {
        self.0.force_jet(t, q, v)
    }

    fn energy_lanes(&self, states: &StateLanesOf<Self>, energies: &mut Lane) {
        self.0.energy_lanes(states, energies);
    }
}

impl<S, P, Q, const N: usize, const M: usize> StartOfStep for Configured<S, Q>
where
    S: StartOfStep + System<Dims = Dims<N, M, P>>,
    P: VectorCoordinates<N>,
    Q: VectorCoordinates<N>,
{
    const TESTS_PARAMETERS: bool = S::TESTS_PARAMETERS;
    const TESTS_STATE: bool = S::TESTS_STATE;
    const TESTS_VELOCITY: bool = S::TESTS_VELOCITY;

    fn parameters_give_regular_mass(&self) -> bool {
        self.0.parameters_give_regular_mass()
    }

    fn state_gives_regular_mass(&self, t: f64, q: &[f64; N]) -> bool {
        self.0.state_gives_regular_mass(t, q)
    }

    fn lanes_of_singular_mass(&self, states: &StateLanesOf<Self>) -> Option<Mask> {
        self.0.lanes_of_singular_mass(states)
    }
}

impl<S, R, P, Q, const N: usize, const M: usize> StepEquations<R> for Configured<S, Q>
where
    S: StepEquations<R> + System<Dims = Dims<N, M, P>>,
    P: VectorCoordinates<N>,
    Q: VectorCoordinates<N>,
{
    type Increments = S::Increments;
    type Prepared = S::Prepared;
    type Memory = S::Memory;
    type Unknowns = S::Unknowns;
    const DOMAIN: &'static [&'static str] = S::DOMAIN;
    const STAGES: usize = S::STAGES;
    const PLAN: &'static Plan = S::PLAN;
    const PROVES_START: bool = S::PROVES_START;
    const RETURNS: Returns = S::RETURNS;

    fn prepare(&self, h: f64) -> S::Prepared {
        self.0.prepare(h)
    }

    fn start(
        &self,
        state: &State<[f64; N]>,
        velocity: &[f64; N],
        acceleration: &[f64; N],
    ) -> S::Unknowns {
        self.0.start(state, velocity, acceleration)
    }

    fn increment(
        &self,
        prepared: &S::Prepared,
        memory: &mut S::Memory,
        state: &State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
        newton: &BlockSolver<'_>,
    ) -> Result<([f64; N], [f64; N], S::Unknowns), SolveError> {
        self.0.increment(prepared, memory, state, h, dw, newton)
    }

    fn increment_lanes(
        &self,
        prepared: &S::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<S::Increments>,
        newton: &Newton,
        unknowns: &mut impl KeepUnknowns,
    ) -> Mask {
        (self.0).increment_lanes(prepared, states, next, h, dw, newton, unknowns)
    }

    fn multipliers(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
        unknowns: &S::Unknowns,
        visit: &mut dyn FnMut(f64),
    ) {
        self.0.multipliers(state, h, dw, unknowns, visit);
    }

    fn linearise<T>(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
        unknowns: &S::Unknowns,
        then: impl FnOnce(Linearisation<'_>) -> T,
    ) -> T {
        self.0.linearise(state, h, dw, unknowns, then)
    }
}

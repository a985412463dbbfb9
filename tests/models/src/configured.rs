//! A system with another type of configurations. Its equations and coordinates are the same.

use std::marker::PhantomData;

use sve_runtime::__private::{Covector, Directions, Mask};
use sve_runtime::nalgebra::DMatrix;
use sve_runtime::{
    Dimensions, Dims, Discretised, EulerIncrement, IncrementLanesOf, IncrementsOf, Lane, Newton,
    Plan, State, StateLanesOf, StepError, System, VectorCoordinates, VectorOf,
};

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
    /// A system with another type of configurations.
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
    const AFFINE_MOMENTUM: bool = S::AFFINE_MOMENTUM;
    const FORCED: bool = S::FORCED;
    const PARAMETERS: &'static [&'static str] = S::PARAMETERS;
    const FORMULAS: u64 = S::FORMULAS;
    type EulerNumbers = S::EulerNumbers;
    const HAS_EULER_INCREMENT: bool = S::HAS_EULER_INCREMENT;
    const EULER_STAGES_IN_LANES: usize = S::EULER_STAGES_IN_LANES;

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

impl<S, R, P, Q, const N: usize, const M: usize> Discretised<R> for Configured<S, Q>
where
    S: Discretised<R> + System<Dims = Dims<N, M, P>>,
    P: VectorCoordinates<N>,
    Q: VectorCoordinates<N>,
{
    type Increments = S::Increments;
    type Prepared = S::Prepared;
    type Memory = S::Memory;
    const STAGES: usize = S::STAGES;
    const PLAN: &'static Plan = S::PLAN;
    const HAS_INCREMENTS: bool = S::HAS_INCREMENTS;

    fn prepare(&self, h: f64) -> S::Prepared {
        self.0.prepare(h)
    }

    fn advance(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        memory: &mut S::Memory,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        self.0.advance(newton, prepared, memory, state, h, dw)
    }

    fn advance_compensated(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        memory: &mut S::Memory,
        state: [&mut State<[f64; N]>; 2],
        h: f64,
        dw: &S::Increments,
    ) -> Result<(), StepError> {
        self.0
            .advance_compensated(newton, prepared, memory, state, h, dw)
    }

    fn advance_lanes(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self>,
    ) -> Mask {
        self.0.advance_lanes(newton, prepared, states, next, h, dw)
    }

    fn advance_with_derivatives(
        &self,
        newton: &Newton,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
    ) -> Result<DMatrix<f64>, StepError> {
        self.0.advance_with_derivatives(newton, state, h, dw)
    }

    fn push_forward(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &mut State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
        directions: Directions<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        self.0
            .push_forward(newton, prepared, state, h, dw, directions)
    }

    fn pull_back(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
        covector: Covector<'_, [f64; N]>,
    ) -> Result<(), StepError> {
        self.0.pull_back(newton, prepared, state, h, dw, covector)
    }

    fn newton_iterations(
        &self,
        newton: &Newton,
        prepared: &S::Prepared,
        state: &State<[f64; N]>,
        h: f64,
        dw: &S::Increments,
    ) -> Option<u32> {
        self.0.newton_iterations(newton, prepared, state, h, dw)
    }
}

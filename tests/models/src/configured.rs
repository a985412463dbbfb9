//! A system with another type of configurations. Its equations and coordinates are the same.

use std::marker::PhantomData;

use sve_runtime::__private::{Linearisation, Returns, SolveError};
use sve_runtime::{
    BlockSolver, Coordinates, Dimensions, Dims, IncrementLanesOf, IncrementsOf, Mask, Newton, Plan,
    State, StateLanesOf, StepOf, System, Variational, VectorOf,
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
    P: Coordinates<N>,
    Q: Coordinates<N>,
{
    type Dims = Dims<N, M, Q>;
    const AFFINE_MOMENTUM: bool = S::AFFINE_MOMENTUM;
    const FORCED: bool = S::FORCED;
    const PARAMETERS: &'static [&'static str] = S::PARAMETERS;
    const FORMULAS: u64 = S::FORMULAS;

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
}

impl<S, R, P, Q, const N: usize, const M: usize> Variational<R> for Configured<S, Q>
where
    S: Variational<R> + System<Dims = Dims<N, M, P>>,
    P: Coordinates<N>,
    Q: Coordinates<N>,
{
    type Prepared = S::Prepared;
    type Unknowns = S::Unknowns;
    const PLAN: &'static Plan = S::PLAN;
    const RETURNS: Returns = S::RETURNS;
    const DOMAIN: &'static [&'static str] = S::DOMAIN;

    fn prepare(&self, h: f64) -> S::Prepared {
        self.0.prepare(h)
    }

    fn start(
        &self,
        state: &State<[f64; N]>,
        velocity: &VectorOf<Self>,
        acceleration: &VectorOf<Self>,
    ) -> S::Unknowns {
        self.0.start(state, velocity, acceleration)
    }

    fn increment(
        &self,
        prepared: &S::Prepared,
        state: &State<[f64; N]>,
        h: f64,
        dw: &IncrementsOf<Self>,
        newton: &BlockSolver<'_>,
    ) -> Result<StepOf<Self, R>, SolveError> {
        self.0.increment(prepared, state, h, dw, newton)
    }

    fn increment_lanes(
        &self,
        prepared: &S::Prepared,
        states: &StateLanesOf<Self>,
        next: &mut StateLanesOf<Self>,
        h: f64,
        dw: &IncrementLanesOf<Self>,
        newton: &Newton,
    ) -> Mask {
        self.0
            .increment_lanes(prepared, states, next, h, dw, newton)
    }

    fn linearise(
        &self,
        state: &State<[f64; N]>,
        h: f64,
        dw: &IncrementsOf<Self>,
        unknowns: &S::Unknowns,
    ) -> Linearisation {
        self.0.linearise(state, h, dw, unknowns)
    }
}

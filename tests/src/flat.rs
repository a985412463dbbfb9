//! A system whose configuration is a row of numbers, whatever the configuration of the system that it stands for.

use sve_runtime::__private::{Linearisation, Returns, SolveError};
use sve_runtime::{
    Coordinates, Dimensions, Dims, IncrementLanesOf, IncrementsOf, Mask, Newton, Plan, Solver,
    StateLanesOf, StepOf, System, Variational, VectorOf,
};

/// The same equations with `[f64; N]` for configurations.
#[derive(Clone, Copy, Debug)]
pub struct Flat<S>(pub S);

impl<S, Q, const N: usize, const M: usize> System for Flat<S>
where
    S: System<Dims = Dims<N, M, Q>>,
    Q: Coordinates<N>,
{
    type Dims = Dims<N, M>;
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

impl<S, R, Q, const N: usize, const M: usize> Variational<R> for Flat<S>
where
    S: Variational<R> + System<Dims = Dims<N, M, Q>>,
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
        state: &sve_runtime::State<[f64; N]>,
        velocity: &VectorOf<Self>,
        acceleration: &VectorOf<Self>,
    ) -> S::Unknowns {
        self.0.start(state, velocity, acceleration)
    }

    fn increment(
        &self,
        prepared: &S::Prepared,
        state: &sve_runtime::State<[f64; N]>,
        h: f64,
        dw: &IncrementsOf<Self>,
        newton: &Solver<'_>,
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
        state: &sve_runtime::State<[f64; N]>,
        h: f64,
        dw: &IncrementsOf<Self>,
        unknowns: &S::Unknowns,
    ) -> Linearisation {
        self.0.linearise(state, h, dw, unknowns)
    }
}

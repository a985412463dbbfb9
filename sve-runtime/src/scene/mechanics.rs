//! Energies and velocities of scenes, for users.

use super::Scene;
use super::errors::{check_length, index_error};
use super::masses::InverseMasses;
use crate::error::StepError;
use crate::phase::configuration::Site;
use crate::phase::state::State;
use crate::system::AnySystem;

/// Mechanical quantities of a scene, a system whose length is that of the state: the functions of
/// [`Mechanics`](crate::Mechanics) that scenes have.
pub trait SceneMechanics: AnySystem {
    /// Returns the velocities of a state.
    ///
    /// # Errors
    /// [`StepError::Mass`], [`StepError::Index`] and [`StepError::Length`] as in a step.
    fn velocity(
        &self,
        state: &State<Self::Configuration>,
    ) -> Result<Self::Configuration, StepError>;

    /// Returns the energy `H = ⟨p, v⟩ − L`, in the units of L. It is not finite where L is not.
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity).
    fn hamiltonian(&self, state: &State<Self::Configuration>) -> Result<f64, StepError>;

    /// Returns the instantaneous temperature `⟨p, v⟩/n` of `n` degrees of freedom, in the units of
    /// L (kT, with Boltzmann's constant).
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity).
    fn temperature(&self, state: &State<Self::Configuration>) -> Result<f64, StepError>;
}

impl<S, Q> SceneMechanics for S
where
    S: AnySystem<Configuration = Vec<Q>> + Scene<Row = Q::Row>,
    Q: Site,
{
    fn velocity(&self, state: &State<Vec<Q>>) -> Result<Vec<Q>, StepError> {
        let State { t, q, p } = state;
        check_length("p", p.len(), q.len(), *t)?;
        let mut v = p.clone();
        let masses = InverseMasses::new(self, q.len(), *t)?;
        let components = Q::rows_mut(&mut v).iter_mut().flat_map(AsMut::as_mut);
        for (at, v) in components.enumerate() {
            *v *= masses.of(at);
        }
        Ok(v)
    }

    fn hamiltonian(&self, state: &State<Vec<Q>>) -> Result<f64, StepError> {
        let v = self.velocity(state)?;
        let l = self.lagrangian(state.t, Q::rows(&state.q), Q::rows(&v));
        let l = l.map_err(|error| index_error(error, state.t))?;
        Ok(twice_kinetic(&state.p, &v) - l)
    }

    fn temperature(&self, state: &State<Vec<Q>>) -> Result<f64, StepError> {
        let v = self.velocity(state)?;
        let degrees_of_freedom = state.q.len() * Q::NUMBERS;
        Ok(twice_kinetic(&state.p, &v) / degrees_of_freedom as f64)
    }
}

/// Returns ⟨p, v⟩, as a sum of sums of many sites.
fn twice_kinetic<Q: Site>(p: &[Q], v: &[Q]) -> f64 {
    let product = |(p, v): (&Q::Row, &Q::Row)| -> f64 {
        p.as_ref().iter().zip(v.as_ref()).map(|(p, v)| p * v).sum()
    };
    let parts = Q::rows(p).chunks(512).zip(Q::rows(v).chunks(512));
    parts
        .map(|(p, v)| p.iter().zip(v).map(product).sum::<f64>())
        .sum()
}

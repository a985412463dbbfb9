//! Energies and velocities of scenes, for users.

use super::Scene;
use super::errors::{check_length, index_error};
use super::kinetic::{Sites, to_momenta};
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
    /// [`StepError::Mass`], [`StepError::Site`], [`StepError::Index`] and [`StepError::Length`] as
    /// in a step.
    fn velocity(
        &self,
        state: &State<Self::Configuration>,
    ) -> Result<Self::Configuration, StepError>;

    /// Returns the state with these velocities at the time `t`.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// /// Relativistic sites.
    /// struct Fast {
    ///     c: f64,
    /// }
    ///
    /// #[variational(stormer_verlet)]
    /// impl Fast {
    ///     fn lagrangian(&self, _q: &[f64], v: &[f64]) -> f64 {
    ///         let c2 = self.c * self.c;
    ///         v.iter().map(|v| -c2 * (1.0 - v * v / c2).sqrt()).sum::<f64>()
    ///     }
    /// }
    ///
    /// # fn main() -> Result<(), StepError> {
    /// let fast = Fast { c: 2.0 };
    /// let state = fast.state_with_velocity(0.0, vec![0.0; 2], vec![0.0, 1.2])?;
    /// assert!((state.p[1] - 1.5).abs() < 1e-15); // v/√(1 − v²/c²) at 0.6 c
    /// assert!((fast.velocity(&state)?[1] - 1.2).abs() < 1e-15);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`velocity`](Self::velocity); [`StepError::Site`] where L is not defined.
    fn state_with_velocity(
        &self,
        t: f64,
        q: Self::Configuration,
        v: Self::Configuration,
    ) -> Result<State<Self::Configuration>, StepError>;

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
        let sites = Sites::new(self, q.len()).map_err(|error| index_error(error, *t))?;
        if let Some(sites) = sites {
            sites.to_velocities(self, *t, Q::rows(q), Q::rows_mut(&mut v))?;
            return Ok(v);
        }
        let masses = InverseMasses::new(self, q.len(), *t)?;
        let components = Q::rows_mut(&mut v).iter_mut().flat_map(AsMut::as_mut);
        for (at, v) in components.enumerate() {
            *v *= masses.of(at);
        }
        Ok(v)
    }

    fn state_with_velocity(
        &self,
        t: f64,
        q: Vec<Q>,
        v: Vec<Q>,
    ) -> Result<State<Vec<Q>>, StepError> {
        check_length("v", v.len(), q.len(), t)?;
        let mut p = v;
        to_momenta(self, t, Q::rows(&q), Q::rows_mut(&mut p))?;
        Ok(State::at(t, q, p))
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

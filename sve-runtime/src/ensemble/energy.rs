//! The energy as an observable, in lanes.
//!
//! Input: the states of a tile. Output: the energy of each lane by the loop that the macro derived,
//! and by the function of a single state where this has no finite value.

use super::Ensemble;
use super::observe::Function;
use super::observer::Plain;
use super::systems::Systems;
use crate::ensemble::PathMethod;
use crate::error::StepError;
use crate::lanes::Lane;
use crate::lanes::dispatch::{Kernel, dispatch};
use crate::mechanics::Mechanics;
use crate::system::{Dimensions, StateLanesOf, StateOf, System};

impl<I: PathMethod, K> Ensemble<'_, I, K> {
    /// Takes statistics of the energy, as `observe(name, |system, state|
    /// system.hamiltonian(state))` does, in the lanes of vector registers. This is many times as
    /// fast if the macro has H(q, p) as a formula, that is for Lagrangians that are quadratic in
    /// the velocities, with up to six coordinates that the mass matrix couples. The energies agree
    /// with [`hamiltonian`](crate::Mechanics::hamiltonian) to rounding. For other systems the
    /// energy is computed for one state after the other, as it is for paths with inputs.
    ///
    /// ```
    /// use sve_runtime::prelude::*;
    ///
    /// struct Pendulum { g: f64, sigma: f64 }
    ///
    /// #[variational(midpoint)]
    /// impl Pendulum {
    ///     fn lagrangian(&self, q: f64, v: f64) -> f64 { 0.5 * v * v + self.g * q.cos() }
    ///     #[gamma]
    ///     fn push(&self, q: f64) -> f64 { self.sigma * q }
    /// }
    ///
    /// # fn main() -> Result<(), EnsembleError> {
    /// let pendulum = Integrator::new(Pendulum { g: 9.8, sigma: 0.5 }, Midpoint);
    /// let summary = Ensemble::new(&pendulum)
    ///     .paths(1000).steps(0.01, 100)
    ///     .start(State::new([0.1], [0.0]))
    ///     .observe_energy("H")
    ///     .run()?;
    /// // noise in p adds σ²/2 per unit of time
    /// let (mean, error) = (summary["H"].mean(), summary["H"].standard_error());
    /// assert!((mean[1] - mean[0] - 0.125).abs() < 4.0 * error[1]);
    /// # Ok(())
    /// # }
    /// ```
    #[must_use]
    pub fn observe_energy(self, name: impl Into<String>) -> Self
    where
        I::System: Mechanics,
    {
        let (function, is_weighted) = (Energy, false);
        self.add(
            name,
            Plain {
                function,
                is_weighted,
            },
        )
    }
}

/// The energy.
struct Energy;

impl<S: Mechanics> Function<S> for Energy {
    fn tile(&self, systems: &Systems<'_, S>, states: &StateLanesOf<S>, values: &mut Lane) {
        values.fill(f64::NAN);
        if let Systems::Same(system) = *systems {
            let energies = &mut *values;
            dispatch(EnergyLanes {
                system,
                states,
                energies,
            });
        }
        for (lane, value) in values.iter_mut().enumerate() {
            if !value.is_finite() {
                let state = S::Dims::get(states, lane);
                let energy = systems.of(lane).hamiltonian(&state);
                *value = energy.unwrap_or(f64::NAN);
            }
        }
    }

    fn value(&self, system: &S, state: &StateOf<S>) -> Result<f64, StepError> {
        system.hamiltonian(state)
    }
}

/// The energies of a tile.
struct EnergyLanes<'a, S: System> {
    system: &'a S,
    states: &'a StateLanesOf<S>,
    energies: &'a mut Lane,
}

impl<S: System> Kernel for EnergyLanes<'_, S> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        self.system.energy_lanes(self.states, self.energies);
    }
}

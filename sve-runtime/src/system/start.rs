//! Tests of the start of a step: a velocity has the momentum of the start, and no other velocity
//! near it has this momentum.
//!
//! The step is the solution that is connected with no noise and h → 0, where v₀ solves ∂L/∂v(q₀,
//! v₀) = p₀ (`docs/mathematics.md`, section 6). If no isolated velocity solves this equation, there
//! is no step, in any rule. If ∂L/∂v is affine in v, the velocity exists and is isolated exactly if
//! the mass matrix ∂²L/∂v² is regular at the start. Otherwise it has to be found.
//!
//! The macro determines which tests can fail: none if the mass matrix consists of numbers, or if
//! constraints or a degenerate Lagrangian have a definition of their own. `integrator/start.rs`
//! makes the tests.

use crate::lanes::Mask;
use crate::system::{FlatOf, StateLanesOf, System};

/// The tests that the start of a step of a system needs. Implemented by `#[variational]`.
pub trait StartOfStep: System {
    /// True if parameters can make the mass matrix singular in every state of the system.
    const TESTS_PARAMETERS: bool = false;
    /// True if the mass matrix can be singular at some configurations or times.
    const TESTS_STATE: bool = false;
    /// True if ∂L/∂v is not affine in v, so that no velocity or several velocities may have a
    /// momentum.
    const TESTS_VELOCITY: bool = false;
    /// Returns whether the part of the mass matrix that depends on parameters alone is regular.
    #[inline(always)]
    fn parameters_give_regular_mass(&self) -> bool {
        true
    }
    /// Returns whether the part of the mass matrix that depends on configuration or time is
    /// regular.
    #[inline(always)]
    fn state_gives_regular_mass(&self, t: f64, q: &FlatOf<Self>) -> bool {
        let _ = (t, q);
        true
    }
    /// Returns the lanes in which the part of the mass matrix that depends on configuration or time
    /// is singular, or not surely regular; `None` if this part has no loop over lanes.
    #[inline(always)]
    fn lanes_of_singular_mass(&self, states: &StateLanesOf<Self>) -> Option<Mask> {
        let _ = states;
        None
    }
}

/// Values that depend on parameters and step size alone, and the result of the test of the
/// parameters.
#[derive(Clone, Copy, Debug)]
pub struct Tested<C> {
    /// The values that the rule prepares.
    pub(crate) coefficients: C,
    /// True if the part of the mass matrix that depends on parameters alone is regular.
    pub(crate) has_regular_mass: bool,
}

impl<C> Tested<C> {
    /// Adds the test of a system's parameters to the values that a rule prepares.
    #[inline(always)]
    pub(crate) fn of(system: &impl StartOfStep, coefficients: C) -> Self {
        Self {
            coefficients,
            has_regular_mass: system.parameters_give_regular_mass(),
        }
    }
}

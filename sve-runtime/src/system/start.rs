//! What a step tests of its start: that one velocity has the momentum there, and no other one near it.
//!
//! The step is the solution that is connected with no noise and h → 0, where v₀ solves ∂L/∂v(q₀, v₀) = p₀ (`docs/mathematics.md`, section 6). Where no such velocity
//! exists, or none that is isolated, there is no step, in any rule. If ∂L/∂v is affine in v, the velocity exists and is isolated exactly if the mass matrix
//! ∂²L/∂v² is regular at the start. Otherwise it has to be found.
//!
//! The macro says what may fail: nothing where the mass matrix has numbers alone, or where constraints or a degenerate Lagrangian have a definition of their own.
//! `integrator/start.rs` makes the tests.

use crate::lanes::Mask;
use crate::system::{FlatOf, StateLanesOf, System};

/// What the start of a step of a system needs. Implemented by `#[variational]`.
pub trait StartOfStep: System {
    /// Whether parameters can make the mass matrix singular wherever the system is.
    const TESTS_PARAMETERS: bool = false;
    /// Whether the mass matrix can be singular at some configurations or times.
    const TESTS_STATE: bool = false;
    /// Whether ∂L/∂v is not affine in v, so that a momentum may have no velocity, or several.
    const TESTS_VELOCITY: bool = false;
    /// Returns whether the parameters make the part of the mass matrix regular that depends on nothing else.
    #[inline(always)]
    fn parameters_give_regular_mass(&self) -> bool {
        true
    }
    /// Returns whether the part of the mass matrix that depends on configuration or time is regular.
    #[inline(always)]
    fn state_gives_regular_mass(&self, t: f64, q: &FlatOf<Self>) -> bool {
        let _ = (t, q);
        true
    }
    /// Returns the lanes where that part is singular, or not surely regular; `None` if a loop over lanes is not written for it.
    #[inline(always)]
    fn lanes_of_singular_mass(&self, states: &StateLanesOf<Self>) -> Option<Mask> {
        let _ = states;
        None
    }
}

/// What depends on parameters and step size alone, and whether parameters allow a start.
#[derive(Clone, Copy, Debug)]
pub struct Tested<C> {
    /// What the rule computes.
    pub(crate) coefficients: C,
    /// Whether the part of the mass matrix that depends on parameters alone is regular.
    pub(crate) has_regular_mass: bool,
}

impl<C> Tested<C> {
    /// What a rule computes for a system.
    #[inline(always)]
    pub(crate) fn of(system: &impl StartOfStep, coefficients: C) -> Self {
        Self {
            coefficients,
            has_regular_mass: system.parameters_give_regular_mass(),
        }
    }
}

//! The functions of a system that no step needs, in the forms in which they are computed.
//!
//! Input: the model with its derivatives. Output: the expressions that `impl System` prints. They
//! are created in the arena of the derivatives.

use super::classify::Classified;
use super::energy::{self, Energy};
use super::euler::{self, Euler};
use super::mechanics::Mechanics;
use crate::algebra::{Arena, Expr, Purpose};

/// The expressions that `impl System` computes.
pub(crate) struct Functions {
    /// The derivatives, in stable forms.
    pub(crate) mechanics: Mechanics,
    /// The second time derivative of each constraint in motion without acceleration,
    /// `∂²φ/∂t² + 2 ⟨∂²φ/∂t∂q, v⟩ + ⟨v, ∂²φ/∂q² v⟩`.
    pub(crate) constraint_curvatures: Vec<Expr>,
    /// The energies of many states at once.
    pub(crate) energy: Option<Energy>,
    /// The increments of the first-order form.
    pub(crate) euler: Option<Euler>,
}

/// Derives the functions. `has_lanes` says whether functions of many states at once are wanted.
pub(crate) fn functions(system: &Classified, has_lanes: bool, arena: &mut Arena) -> Functions {
    let model = &system.model;
    let twice = model.constraints.iter().map(|constraint| {
        let once = model.rate(constraint.value, arena);
        model.rate(once, arena)
    });
    let mut constraint_curvatures: Vec<Expr> = twice.collect();
    let mechanics = system.mechanics.stabilised(arena);
    let is_regular = system.degeneracy.is_none();
    arena.stabilise(Purpose::Values, constraint_curvatures.iter_mut().collect());
    let energy = (has_lanes && is_regular)
        .then(|| energy::energy(model, &mechanics, arena))
        .flatten();
    let euler = is_regular
        .then(|| euler::euler(model, &mechanics, arena))
        .flatten();
    Functions {
        mechanics,
        constraint_curvatures,
        energy,
        euler,
    }
}

//! The energy as a function of q and p, which needs the mass matrix and the momentum at rest in
//! addition to L.
//!
//! Input: the derivatives of L. Output: expressions for the velocity of a momentum, v = M⁻¹ (p −
//! ∂L/∂v(q, 0)).

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Model;
use crate::system::mechanics::Mechanics;

/// Largest number of coordinates that a mass matrix may couple.
const MAX_COUPLED: usize = 6;

/// Largest number of coordinates.
const MAX_COORDINATES: usize = 32;

/// The energy H(q, p) = ⟨p, v⟩ − L(q, v) of a Lagrangian that is quadratic in v.
pub(crate) struct Energy {
    pub(crate) lagrangian: Expr,
    /// ∂²L/∂v².
    pub(crate) mass: Vec<Vec<Expr>>,
    pub(crate) has_diagonal_mass: bool,
    /// ∂L/∂v at v = 0.
    pub(crate) at_rest: Vec<Expr>,
}

/// Returns the energy of a system whose L determines every velocity. `None` if the velocity must be
/// found by iteration or the system is too large.
pub(crate) fn energy(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Option<Energy> {
    let is_plain = mechanics.affine_momentum && !model.configuration().has_rotations();
    let jet = &mechanics.lagrangian;
    let n = model.dof();
    let is_zero = |e: Expr| arena.constant_value(e) == Some(0.0);
    let has_diagonal_mass = (0..n).all(|i| (0..n).all(|j| i == j || is_zero(jet.dvv[i][j])));
    let is_small = n <= MAX_COORDINATES && (has_diagonal_mass || n <= MAX_COUPLED);
    if !is_plain || !is_small {
        return None;
    }
    let zero = arena.constant(0.0);
    let rest: HashMap<Symbol, Expr> = model.v.iter().map(|&v| (v, zero)).collect();
    let rows = jet.dvv.iter();
    Some(Energy {
        lagrangian: jet.value,
        mass: rows.map(|row| arena.substitute_all(row, &rest)).collect(),
        has_diagonal_mass,
        at_rest: arena.substitute_all(&jet.dv, &rest),
    })
}

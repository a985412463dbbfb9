//! How the forces of velocities depend on the state.
//!
//! Input: the derivatives of L and of the force. Output: [`Drag`]. The strong order of rules with
//! stage noise follows from it.

use super::mechanics::{ForceJet, LagrangianJet};
use crate::algebra::{Arena, Symbol};
use crate::model::Model;

/// How the forces of velocities depend on the state, where masses are constant: of G v with
/// `G = ∂F/∂v + L_qv − L_vq`, such as a friction or a magnetic force.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Drag {
    /// G depends on time alone, or there is one coordinate, and G does not depend on v.
    Linear,
    /// G depends on several coordinates.
    OfPlace,
    /// G depends on v.
    Nonlinear,
}

impl Drag {
    /// Computes it in an arena of its own: the formulas of the steps stay as they are.
    pub(super) fn of(
        model: &Model,
        lagrangian: &LagrangianJet,
        force: Option<&ForceJet>,
        arena: &Arena,
    ) -> Self {
        let (dof, mut arena) = (model.q.len(), arena.clone());
        let mut entries = Vec::new();
        for (i, j) in (0..dof).flat_map(|i| (0..dof).map(move |j| (i, j))) {
            let [there, back] = [[i, j], [j, i]].map(|[i, j]| lagrangian.dqv[i][j]);
            let gyroscopic = arena.sub(there, back);
            let damping = force.map(|force| force.dv[i][j]);
            entries.push(damping.map_or(gyroscopic, |entry| arena.add(entry, gyroscopic)));
        }
        let mut varies = |along: &[Symbol]| {
            let pairs = entries
                .iter()
                .flat_map(|&e| along.iter().map(move |&s| (e, s)));
            pairs.clone().any(|(entry, symbol)| {
                let change = arena.diff(entry, symbol);
                !arena.is_zero(change)
            })
        };
        if varies(&model.v) {
            Self::Nonlinear
        } else if dof > 1 && varies(&model.q) {
            Self::OfPlace
        } else {
            Self::Linear
        }
    }
}

//! Model → the model with its derivatives and all properties that are determined before a rule is
//! derived; or errors of the user's functions and rules.

use super::applicable;
use super::commutation::{Commutation, commutation};
use super::constraints;
use super::degeneracy::{self, Degeneracy};
use super::mechanics::{Mechanics, mechanics};
use super::size::Budget;
use super::symmetry::{self, MomentumMap};
use crate::algebra::Arena;
use crate::model::Model;
use crate::syntax::parse::Annotated;

/// A model with its derivatives and properties.
pub(crate) struct Classified {
    pub(crate) model: Model,
    pub(crate) mechanics: Mechanics,
    /// The result of the test whether the noises commute.
    pub(crate) commutation: Commutation,
    /// The parts of L, if it does not determine every velocity.
    pub(crate) degeneracy: Option<Degeneracy>,
    pub(crate) momenta: Vec<MomentumMap>,
}

impl Classified {
    /// Returns whether a noise is a force.
    pub(crate) fn has_noise_forces(&self) -> bool {
        self.model.noises.iter().any(|noise| noise.force.is_some())
    }
}

/// Classifies a model. The noises of the result are tangent to the constraints.
pub(crate) fn classify(
    block: &Annotated,
    model: Model,
    budget: &Budget,
    arena: &mut Arena,
) -> syn::Result<Classified> {
    arena.grant(budget.work);
    let plain = budget.stage(arena, |arena| mechanics(&model, arena))?;
    let degeneracy = budget.stage(arena, |arena| {
        degeneracy::classify(block, &model, &plain, arena)
    })??;
    if let Some(degeneracy) = &degeneracy {
        applicable::check_degenerate(block, degeneracy)?;
    }
    constraints::check_momentum(block, &model, &plain)?;
    let (model, mechanics) = match constraints::tangent_noises(block, &model, &plain, arena)? {
        None => (model, plain),
        Some(noises) => {
            let model = Model { noises, ..model };
            let mechanics = budget.stage(arena, |arena| mechanics(&model, arena))?;
            (model, mechanics)
        }
    };
    let commutation = budget.stage(arena, |arena| {
        commutation(&model, &mechanics, degeneracy.as_ref(), arena)
    })?;
    let commutes_on_constraints = budget.stage(arena, |arena| {
        constraints::check(block, &model, &mechanics, arena)
    })??;
    let momenta = budget.stage(arena, |arena| {
        symmetry::check(block, &model, degeneracy.as_ref(), arena)
    })??;
    Ok(Classified {
        commutation: if commutes_on_constraints {
            commutation.on_constraints()
        } else {
            commutation
        },
        model,
        mechanics,
        degeneracy,
        momenta,
    })
}

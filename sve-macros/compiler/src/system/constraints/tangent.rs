//! Noises of the option `#[h1(tangent)]`, in which the momentum along the constraints replaces p:
//!
//! ```text
//! Πp = p − Dφᵀ (Dφ M⁻¹ Dφᵀ)⁻¹ (Dφ M⁻¹ (p − a) + ∂φ/∂t)        ∂L/∂v = M v + a
//! ```
//!
//! The motion is the motion of the noise restricted to the constraints, where Πp = p.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::errors::Errors;
use crate::model::{Model, NoiseKind, NoiseTerm};
use crate::syntax::parse::Annotated;
use crate::syntax::roles::Role;
use crate::system::inverse_mass::{self, NoFormula};
use crate::system::mechanics::Mechanics;

/// Returns the noises. In noises with the option, the momentum along the constraints replaces p.
/// Returns `None` if no noise has the option.
pub(crate) fn tangent_noises(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> syn::Result<Option<Vec<NoiseTerm>>> {
    let is_tangent = |noise: &NoiseTerm| noise.kind == NoiseKind::TangentH1;
    if !model.noises.iter().any(is_tangent) {
        return Ok(None);
    }
    let mut errors = Errors::new();
    let mut functions = block.noises.iter().filter(|f| f.role == Role::TangentH1);
    let place = functions
        .next()
        .map_or_else(proc_macro2::Span::call_site, |f| f.name.span());
    if model.constraints.is_empty() {
        errors.push(
            place,
            "`tangent` is for systems with constraints, and this block has none: write `#[h1]`",
        );
        return errors.finish(None);
    }
    let mut noises = model.noises.clone();
    match projected(model, mechanics, arena) {
        Ok(by) => {
            for noise in noises.iter_mut().filter(|noise| is_tangent(noise)) {
                noise.hamiltonian = arena.substitute(noise.hamiltonian, &by);
            }
        }
        Err(NoFormula::TooManyCoupled(count) | NoFormula::NoPivot(count)) => {
            let message = format!(
                "the momentum along {count} coupled constraints has no short formula: write the noise such that ∂H₁/∂p is tangent to the constraints, as a rotation or a multiple of H is"
            );
            errors.push(place, message);
        }
    }
    errors.finish(Some(noises))
}

/// Returns the expression that replaces each momentum.
fn projected(
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Result<HashMap<Symbol, Expr>, NoFormula> {
    let lagrangian = &mechanics.lagrangian;
    let zero = arena.constant(0.0);
    let rest: HashMap<Symbol, Expr> = model.v.iter().map(|&v| (v, zero)).collect();
    let relative: Vec<Expr> = (0..model.dof())
        .map(|i| {
            let p = arena.symbol(model.p[i]);
            let offset = arena.substitute(lagrangian.dv[i], &rest);
            arena.sub(p, offset)
        })
        .collect();
    let solve =
        |b: &[Expr], arena: &mut Arena| inverse_mass::solve(&lagrangian.dvv, b, &model.q, arena);
    let velocity = solve(&relative, arena)?;
    let mut directions = Vec::new();
    for constraint in &mechanics.constraints {
        directions.push(solve(&constraint.dq, arena)?);
    }
    let product = |a: &[Expr], b: &[Expr], first: Expr, arena: &mut Arena| {
        let mut terms = vec![(1.0, first)];
        for (&a, &b) in a.iter().zip(b) {
            terms.push((1.0, arena.mul(a, b)));
        }
        arena.sum(0.0, &terms)
    };
    let (mut matrix, mut rates) = (Vec::new(), Vec::new());
    for constraint in &mechanics.constraints {
        let row = directions
            .iter()
            .map(|d| product(&constraint.dq, d, zero, arena));
        matrix.push(row.collect::<Vec<Expr>>());
        rates.push(product(&constraint.dq, &velocity, constraint.dt, arena));
    }
    let multipliers = inverse_mass::solve(&matrix, &rates, &model.q, arena)?;
    let mut by = HashMap::new();
    for (i, &p) in model.p.iter().enumerate() {
        let mut terms = vec![(1.0, arena.symbol(p))];
        for (constraint, &multiplier) in mechanics.constraints.iter().zip(&multipliers) {
            terms.push((-1.0, arena.mul(constraint.dq[i], multiplier)));
        }
        let along = arena.sum(0.0, &terms);
        by.insert(p, arena.opaque(along));
    }
    Ok(by)
}

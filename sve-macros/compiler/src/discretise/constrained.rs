//! The equations of constraints.
//!
//! Input: the equations of the variations, and the contributions of the constraints to the action
//! ([`Enforced`]). Output: the equations with φ(t₁,q₁) = 0 and the projection of p₁, and each
//! equation to leading order in the step size. The first guess solves these:
//!
//! ```text
//! p − (kicks of the noise at q₀, p₀) − p₀ − Dφ(q₀)ᵀ λ = 0
//! d − h v − Σ ∂G/∂p(q₀,p₀) ΔW = 0      ∂φ/∂t + Dφ(q₀) v = 0
//! ```
//!
//! The guess contains the noise: without it a large increment leads Newton's method to another
//! root.

use std::collections::HashMap;

use super::equations::{Equations, Leading};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::{Family, Meaning, Symbols};
use crate::rules::action::Action;
use crate::rules::constraints::{Enforced, leading};

/// Adds the equations of constraints. `ends` is `∂S/∂d`, which is p₁.
pub(super) fn extend(
    mut equations: Equations,
    ends: &[Expr],
    enforced: &Enforced,
    action: &Action,
    symbols: &Symbols,
    arena: &mut Arena,
) -> Equations {
    let rows = equations.residuals.iter().zip(&equations.variations);
    let order = rows.map(|(&residual, &variation)| {
        of_variation(residual, variation, enforced, action, symbols, arena)
    });
    let mut order: Vec<Expr> = order.collect();
    let mut scales = vec![None; order.len()];
    let mut mean_values = vec![None; order.len()];
    scales.extend(enforced.scales.iter().copied().map(Some));
    mean_values.extend(enforced.mean_values.iter().copied().map(Some));
    let projected = enforced.end_momentum.iter().zip(ends);
    let projected = projected.map(|(&momentum, &end)| arena.sub(momentum, end));
    let projected: Vec<Expr> = projected.collect();
    order.extend(&enforced.start_rates);
    for rows in [&projected, &enforced.end_rates] {
        order.extend(rows);
    }
    for rows in [&enforced.end_values, &projected, &enforced.end_rates] {
        equations.residuals.extend(rows);
    }
    let Enforced {
        start_multipliers,
        end_multipliers,
        end_velocity,
        ..
    } = enforced;
    for family in [end_multipliers, end_velocity, start_multipliers] {
        equations.variations.extend(family);
    }
    for family in [end_velocity, start_multipliers, end_multipliers] {
        equations.unknowns.extend(family);
    }
    equations.torn = [start_multipliers.as_slice(), end_multipliers].concat();
    let multipliers = equations.torn.iter();
    equations.reported = multipliers.map(|&s| arena.symbol(s)).collect();
    equations.conditions.clone_from(&enforced.at_start);
    equations.guards.extend(enforced.guard);
    scales.resize(order.len(), None);
    mean_values.resize(order.len(), None);
    equations.leading = Some(Leading {
        residuals: order,
        mean_values,
        variations: equations.variations.clone(),
        scales,
        has_sign: enforced.has_sign,
    });
    equations
}

/// Returns the equation of a variation to leading order.
fn of_variation(
    residual: Expr,
    variation: Symbol,
    enforced: &Enforced,
    action: &Action,
    symbols: &Symbols,
    arena: &mut Arena,
) -> Expr {
    let Meaning::Unknown(unknown) = *symbols.meaning(variation) else {
        return residual;
    };
    let i = unknown.index;
    let own = |family: Family| {
        let all = action.internal.iter().copied();
        let mut named = all.filter(|&s| {
            matches!(symbols.meaning(s), Meaning::Unknown(u) if u.family == family && u.index == i)
        });
        named.next().unwrap_or(variation)
    };
    match unknown.family {
        Family::Displacement => {
            let p = arena.symbol(own(Family::Momentum));
            let p0 = arena.symbol(action.start_p[i]);
            let linear = [(1.0, p), (-1.0, p0), (-1.0, enforced.start_impulse[i])];
            let linear = arena.sum(0.0, &linear);
            leading(residual, linear, action, symbols, arena)
        }
        Family::Momentum => {
            let [d, h, v] =
                [action.displacement[i], action.h, own(Family::Velocity)].map(|s| arena.symbol(s));
            let hv = arena.mul(h, v);
            let linear = arena.sub(d, hv);
            leading(residual, linear, action, symbols, arena)
        }
        _ => {
            // the momentum that belongs to the velocity
            let zero = arena.constant(0.0);
            let mut by = HashMap::from([(action.h, zero)]);
            by.extend(action.displacement.iter().map(|&d| (d, zero)));
            arena.substitute(residual, &by)
        }
    }
}

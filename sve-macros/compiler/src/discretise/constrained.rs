//! The equations that constraints add to those of an action.
//!
//! Input: the equations of the variations, and what the constraints added to the action ([`Enforced`]). Output: the equations with φ(t₁,q₁) = 0 and the
//! projection of p₁, and each equation to leading order in the step size, from which the first guess is solved:
//!
//! ```text
//! p − (kicks of the noise at q₀, p₀) − p₀ − Dφ(q₀)ᵀ λ = 0      d − h v − Σ ∂G/∂p(q₀,p₀) ΔW = 0      ∂φ/∂t + Dφ(q₀) v = 0
//! ```
//!
//! The guess contains the noise: without it a large increment leads Newton's method to another root.

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
    let rows: Vec<(Expr, Symbol)> = {
        let residuals = equations.residuals.iter().copied();
        residuals
            .zip(equations.variations.iter().copied())
            .collect()
    };
    let (mut order, mut beside) = (Vec::new(), vec![None; rows.len()]);
    let mut means = vec![None; rows.len()];
    for (residual, variation) in rows {
        order.push(of_variation(
            residual, variation, enforced, action, symbols, arena,
        ));
    }
    let Enforced {
        start_multipliers,
        end_multipliers,
        end_velocity,
        end_values,
        mean_values,
        end_rates,
        start_rates,
        end_momentum,
        start_impulse: _,
        scales,
        has_sign,
        at_start,
        guard,
    } = enforced;
    equations.residuals.extend(end_values);
    equations.variations.extend(end_multipliers);
    order.extend(start_rates);
    beside.extend(scales.iter().copied().map(Some));
    means.extend(mean_values.iter().copied().map(Some));
    for (i, &momentum) in end_momentum.iter().enumerate() {
        let row = arena.sub(momentum, ends[i]);
        equations.residuals.push(row);
        order.push(row);
    }
    equations.variations.extend(end_velocity);
    equations.residuals.extend(end_rates);
    equations.variations.extend(start_multipliers);
    order.extend(end_rates);
    for family in [end_velocity, start_multipliers, end_multipliers] {
        equations.unknowns.extend(family);
    }
    equations.torn = [start_multipliers.as_slice(), end_multipliers].concat();
    equations.reported = {
        let pairs = start_multipliers.iter().chain(end_multipliers);
        pairs.map(|&s| arena.symbol(s)).collect()
    };
    equations.conditions.clone_from(at_start);
    equations.guards.extend(guard);
    beside.resize(order.len(), None);
    means.resize(order.len(), None);
    equations.leading = Some(Leading {
        residuals: order,
        mean_values: means,
        variations: equations.variations.clone(),
        scales: beside,
        has_sign: *has_sign,
    });
    equations
}

/// The equation of a variation to leading order.
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
            // the momentum of the velocity
            let zero = arena.constant(0.0);
            let mut by = HashMap::from([(action.h, zero)]);
            by.extend(action.displacement.iter().map(|&d| (d, zero)));
            arena.substitute(residual, &by)
        }
    }
}

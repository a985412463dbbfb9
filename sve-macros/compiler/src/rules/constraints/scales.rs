//! Scales for the residuals of a step with constraints, and the comparison of the motion with its
//! noise.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Function, Symbol};
use crate::model::{Constraint, Meaning, Model, Symbols};
use crate::rules::action::Action;

/// Returns the mass of a coordinate and its momentum at rest, at q₀.
fn at_rest(i: usize, at: &HashMap<Symbol, Expr>, model: &Model, arena: &mut Arena) -> [Expr; 2] {
    let momentum = arena.diff(model.lagrangian, model.v[i]);
    let mass = arena.diff(momentum, model.v[i]);
    [mass, momentum].map(|e| arena.substitute(e, at))
}

/// Returns the values of the model's variables at the start, without motion.
fn resting(
    start: &HashMap<Symbol, Expr>,
    model: &Model,
    arena: &mut Arena,
) -> HashMap<Symbol, Expr> {
    let zero = arena.constant(0.0);
    let mut at = start.clone();
    at.extend(model.v.iter().map(|&v| (v, zero)));
    at
}

/// Returns, for each constraint, the rate at which φ changes if a velocity as large as in the step
/// points across the constraint: `√E Σ |∂φ/∂q_i| M_ii^(−½)` with
///
/// ```text
/// E = Σ_i [ (|p₀ − a| + |h ∂L/∂q| + Σ |(∂G/∂q − f) ΔW|)_i² / M_ii + M_ii (Σ |∂G/∂p_i ΔW|)² / h² ]
/// ```
///
/// at q₀. The residual φ(t₁,q₁)/h has no terms of this size if the motion is along the constraints.
pub(super) fn velocity_scales(
    action: &Action,
    model: &Model,
    symbols: &Symbols,
    start: &HashMap<Symbol, Expr>,
    arena: &mut Arena,
) -> Vec<Expr> {
    let at = resting(start, model, arena);
    let all = (0..symbols.meanings().len() as u32).map(Symbol);
    let dw: Vec<Symbol> = all
        .filter(|&s| matches!(symbols.meaning(s), Meaning::Wiener(_)))
        .collect();
    let h = arena.symbol(action.h);
    let (mut energy, mut inverse_roots) = (Vec::new(), Vec::new());
    for i in 0..model.dof() {
        let [mass, rest] = at_rest(i, &at, model, arena);
        let mass = arena.abs(mass);
        let root = arena.call(Function::Sqrt, mass);
        inverse_roots.push(arena.pow(root, -1));
        let p = arena.symbol(action.start_p[i]);
        let relative = arena.sub(p, rest);
        let force = arena.diff(model.lagrangian, model.q[i]);
        let force = arena.substitute(force, &at);
        let kick = arena.mul(h, force);
        let mut sizes = vec![(1.0, arena.abs(relative)), (1.0, arena.abs(kick))];
        let mut shifts = Vec::new();
        for (noise, &dw) in model.noises.iter().zip(&dw) {
            let dw = arena.symbol(dw);
            let [mut dq, dp] = [model.q[i], model.p[i]].map(|s| arena.diff(noise.hamiltonian, s));
            if let Some(force) = &noise.force {
                dq = arena.sub(dq, force[i]);
            }
            let [dq, dp] = [dq, dp].map(|e| arena.substitute(e, &at));
            let [dq, dp] = [dq, dp].map(|e| arena.mul(e, dw));
            sizes.push((1.0, arena.abs(dq)));
            shifts.push((1.0, arena.abs(dp)));
        }
        let (size, shift) = (arena.sum(0.0, &sizes), arena.sum(0.0, &shifts));
        energy.push((1.0, arena.product(&[(size, 2), (mass, -1)])));
        energy.push((1.0, arena.product(&[(shift, 2), (mass, 1), (h, -2)])));
    }
    let energy = arena.sum(0.0, &energy);
    let speed = arena.call(Function::Sqrt, energy);
    let scale = |constraint: &Constraint| {
        let mut terms = Vec::new();
        for (&q, &inverse_root) in model.q.iter().zip(&inverse_roots) {
            let slope = arena.diff(constraint.value, q);
            let slope = arena.substitute(slope, &at);
            let slope = arena.abs(slope);
            terms.push((1.0, arena.mul(slope, inverse_root)));
        }
        let sum = arena.sum(0.0, &terms);
        arena.mul(speed, sum)
    };
    model.constraints.iter().map(scale).collect()
}

/// Returns `Σ M_ii (d_i/h)² − ¼ Σ (p₀ − a)²_i / M_ii` for a system with noise. If this is negative,
/// the noise cancels much of the motion. Then the equations of the step are no guide to the
/// equations of the step without noise, from which the solution is followed.
pub(super) fn guard(
    action: &Action,
    model: &Model,
    start: &HashMap<Symbol, Expr>,
    arena: &mut Arena,
) -> Option<Expr> {
    if model.noises.is_empty() {
        return None;
    }
    let at = resting(start, model, arena);
    let h = arena.symbol(action.h);
    let mut terms = Vec::new();
    for i in 0..model.dof() {
        let [mass, rest] = at_rest(i, &at, model, arena);
        let [d, p] = [action.displacement[i], action.start_p[i]].map(|s| arena.symbol(s));
        let relative = arena.sub(p, rest);
        terms.push((1.0, arena.product(&[(d, 2), (h, -2), (mass, 1)])));
        terms.push((-0.25, arena.product(&[(relative, 2), (mass, -1)])));
    }
    Some(arena.sum(0.0, &terms))
}

/// Returns whether some noise has nonzero second derivatives in the momentum.
pub(super) fn is_curved(model: &Model, arena: &mut Arena) -> bool {
    model.noises.iter().any(|noise| {
        model.p.iter().any(|&a| {
            let slope = arena.diff(noise.hamiltonian, a);
            model.p.iter().any(|&b| {
                let curvature = arena.diff(slope, b);
                !arena.is_zero(curvature)
            })
        })
    })
}

//! Holonomic constraints φ(t, q) = 0: what they add to the action of any rule.
//!
//! ```text
//! S_d + ⟨λ, φ(t₀,q₀)⟩ + ⟨μ, φ(t₁,q₁)⟩
//! ```
//!
//! The forces of the constraints act at the two ends of the step, never at a node: with Dφᵀλ at a node the step is not symplectic on the manifold of the
//! constraints. λ enters the momentum balance at the start, μ the momentum at the end. The further equations are
//!
//! ```text
//! 0 = φ(t₁,q₁)      p₁ = ∂L/∂v(t₁,q₁,v₁)      0 = ∂φ/∂t + Dφ(t₁,q₁) v₁
//! ```
//!
//! The first one determines λ, the others project p₁. With the rule of Störmer and Verlet this is RATTLE.
//!
//! Sources: Marsden, West, *Discrete mechanics and variational integrators*, Acta Numerica 10 (2001), section 3; Leimkuhler, Reich, *Simulating Hamiltonian
//! Dynamics* (2004), chapter 7; Bou-Rabee, Owhadi, *Stochastic variational integrators*, IMA J. Numer. Anal. 29 (2009).

use std::collections::HashMap;

use super::action::Action;
use crate::algebra::{Arena, Expr, Function, Symbol};
use crate::model::domain::Condition;
use crate::model::{AtNode, END, Family, Meaning, Model, NodeQuantity, Symbols, Unknown};

/// What constraints add to an action.
pub(crate) struct Enforced {
    /// λ and μ, one for each constraint.
    pub(crate) start_multipliers: Vec<Symbol>,
    pub(crate) end_multipliers: Vec<Symbol>,
    /// v₁.
    pub(crate) end_velocity: Vec<Symbol>,
    /// φ(t₁,q₁)/h, in a form that does not cancel where φ is of second degree.
    pub(crate) end_values: Vec<Expr>,
    /// `∂φ/∂t + Dφ d/h` and φ(t₀,q₀)/h.
    pub(crate) mean_values: Vec<MeanValue>,
    /// ∂φ/∂t + Dφ(t₁,q₁) v₁.
    pub(crate) end_rates: Vec<Expr>,
    /// ∂φ/∂t + Dφ(t₀,q₀) v with the velocity of the rule: φ(t₁,q₁)/h to leading order.
    pub(crate) start_rates: Vec<Expr>,
    /// ∂L/∂v(t₁,q₁,v₁).
    pub(crate) end_momentum: Vec<Expr>,
    /// What φ(t₁,q₁)/h is small beside: see [`velocity_scales`].
    pub(crate) scales: Vec<Expr>,
    /// `Dφ(t₀,q₀)ᵀ λ`.
    pub(crate) start_impulse: Vec<Expr>,
    /// Whether the sign of the Jacobian's determinant is that of a small step, whatever the increments are: no noise is curved in p.
    pub(crate) has_sign: bool,
    /// That φ(t₀,q₀) vanishes to rounding.
    pub(crate) at_start: Vec<Condition<Expr>>,
    /// With noise: what is negative if the noise undoes most of the motion of the step, see [`guard`].
    pub(crate) guard: Option<Expr>,
}

/// φ(t₁,q₁)/h by the mean-value theorem.
#[derive(Clone, Copy)]
pub(crate) struct MeanValue {
    /// `∂φ/∂t + Σ ∂φ/∂q_i d_i/h` at some point between the ends, which is written as the end.
    pub(crate) rate: Expr,
    /// φ(t₀,q₀)/h, which is rounding error.
    pub(crate) start: Expr,
}

/// Largest φ at the start of a step, relative to the sum of the magnitudes of its terms. Steps leave some rounding errors.
pub(crate) const INCONSISTENT: f64 = 1e-8;

/// Adds the constraints of the model to an action.
pub(crate) fn enforce(
    mut action: Action,
    model: &Model,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Action {
    if model.constraints.is_empty() {
        return action;
    }
    let (n, count) = (model.dof(), model.constraints.len());
    let mut family = |family, size| symbols.declare_all(size, Unknown::of(family));
    let start_multipliers = family(Family::StartMultiplier, count);
    let end_multipliers = family(Family::EndMultiplier, count);
    let end_velocity = family(Family::EndVelocity, n);
    let velocity: Vec<Symbol> = action
        .internal
        .iter()
        .copied()
        .filter(
            |&s| matches!(symbols.meaning(s), Meaning::Unknown(u) if u.family == Family::Velocity),
        )
        .collect();
    let start = at_start(&action, model, &velocity, arena);
    let end = at_end(&action, model, &end_velocity, arena);
    let mut terms = vec![(1.0, action.value)];
    let mut enforced = Enforced {
        end_values: Vec::new(),
        mean_values: Vec::new(),
        end_rates: Vec::new(),
        start_rates: Vec::new(),
        scales: velocity_scales(&action, model, symbols, &start, arena),
        end_momentum: Vec::new(),
        start_impulse: vec![arena.constant(0.0); n],
        has_sign: !is_curved(model, arena),
        at_start: Vec::new(),
        guard: guard(&action, model, &start, arena),
        start_multipliers,
        end_multipliers,
        end_velocity,
    };
    for (k, constraint) in model.constraints.iter().enumerate() {
        let [lambda, mu] = [enforced.start_multipliers[k], enforced.end_multipliers[k]];
        let [lambda, mu] = [lambda, mu].map(|s| arena.symbol(s));
        let [first, last] = [&start, &end].map(|at| arena.substitute(constraint.value, at));
        terms.push((1.0, arena.mul(lambda, first)));
        terms.push((1.0, arena.mul(mu, last)));
        for i in 0..n {
            let slope = arena.diff(constraint.value, model.q[i]);
            let slope = arena.substitute(slope, &start);
            let impulse = arena.mul(slope, lambda);
            enforced.start_impulse[i] = arena.add(enforced.start_impulse[i], impulse);
        }
        let rate = model.rate(constraint.value, arena);
        let [start_rate, end_rate] = [&start, &end].map(|at| arena.substitute(rate, at));
        enforced.start_rates.push(start_rate);
        enforced.end_rates.push(end_rate);
        let by: HashMap<Symbol, Expr> = {
            let h = arena.symbol(action.h);
            let ends = enforced.end_velocity.iter().zip(&action.displacement);
            ends.map(|(&v, &d)| {
                let d = arena.symbol(d);
                (v, arena.product(&[(d, 1), (h, -1)]))
            })
            .collect()
        };
        let h = arena.symbol(action.h);
        let value = arena.opaque(first);
        enforced.mean_values.push(MeanValue {
            rate: arena.substitute(end_rate, &by),
            start: arena.product(&[(value, 1), (h, -1)]),
        });
        let value = end_value(constraint.value, &start, last, &action, model, arena);
        enforced.end_values.push(value);
        let size = model.magnitude(constraint.value, arena);
        let size = arena.substitute(size, &start);
        enforced.at_start.push(consistency(first, size, arena));
    }
    for &v in &model.v {
        let momentum = arena.diff(model.lagrangian, v);
        enforced.end_momentum.push(arena.substitute(momentum, &end));
    }
    action.value = arena.sum(0.0, &terms);
    action.varied = action.value;
    action.enforced = Some(enforced);
    action
}

/// What the model's variables are at the start, with the velocity of the rule.
fn at_start(
    action: &Action,
    model: &Model,
    velocity: &[Symbol],
    arena: &mut Arena,
) -> HashMap<Symbol, Expr> {
    let mut start = HashMap::new();
    for i in 0..model.dof() {
        start.insert(model.q[i], arena.symbol(action.start_q[i]));
        start.insert(model.v[i], arena.symbol(velocity[i]));
        start.insert(model.p[i], arena.symbol(action.start_p[i]));
    }
    start
}

/// What the model's variables are at the end.
fn at_end(
    action: &Action,
    model: &Model,
    velocity: &[Symbol],
    arena: &mut Arena,
) -> HashMap<Symbol, Expr> {
    let mut end = HashMap::new();
    let (t, h) = (arena.symbol(model.time), arena.symbol(action.h));
    let at = |quantity| {
        Some(
            AtNode {
                node: END,
                quantity,
            }
            .identity(),
        )
    };
    let time = arena.add(t, h);
    end.insert(model.time, arena.intermediate(time, at(NodeQuantity::Time)));
    for i in 0..model.dof() {
        let [q, d] = [action.start_q[i], action.displacement[i]].map(|s| arena.symbol(s));
        let position = arena.add(q, d);
        let position = arena.intermediate(position, at(NodeQuantity::Position(i)));
        end.insert(model.q[i], position);
        end.insert(model.v[i], arena.symbol(velocity[i]));
    }
    end
}

/// φ(t₁,q₁)/h. A φ(q) of second degree is written as `φ(q₀)/h + ⟨Dφ(q₀) + ½ D²φ d, d/h⟩`: the difference of φ at the ends has no rounding errors of the
/// size of φ's terms, so that the velocity of a small step keeps its digits.
fn end_value(
    value: Expr,
    start: &HashMap<Symbol, Expr>,
    last: Expr,
    action: &Action,
    model: &Model,
    arena: &mut Arena,
) -> Expr {
    let h = arena.symbol(action.h);
    if !is_quadratic(value, model, arena) {
        return arena.product(&[(last, 1), (h, -1)]);
    }
    let first = arena.substitute(value, start);
    let first = arena.opaque(first);
    let mut terms = vec![(1.0, arena.product(&[(first, 1), (h, -1)]))];
    for (i, &d) in action.displacement.iter().enumerate() {
        let slope = arena.diff(value, model.q[i]);
        let mut along = vec![(1.0, arena.substitute(slope, start))];
        for (j, &e) in action.displacement.iter().enumerate() {
            let curvature = arena.diff(slope, model.q[j]);
            let curvature = arena.substitute(curvature, start);
            let e = arena.symbol(e);
            along.push((0.5, arena.mul(curvature, e)));
        }
        let along = arena.sum(0.0, &along);
        let d = arena.symbol(d);
        terms.push((1.0, arena.product(&[(along, 1), (d, 1), (h, -1)])));
    }
    arena.sum(0.0, &terms)
}

/// Whether φ depends on q alone, with constant second derivatives.
fn is_quadratic(value: Expr, model: &Model, arena: &mut Arena) -> bool {
    let depends = |arena: &Arena, e: Expr| {
        let mut moving = model.q.iter().chain([&model.time]);
        moving.any(|&s| arena.contains(e, s))
    };
    if arena.contains(value, model.time) {
        return false;
    }
    for &a in &model.q {
        let slope = arena.diff(value, a);
        for &b in &model.q {
            let curvature = arena.diff(slope, b);
            if depends(arena, curvature) {
                return false;
            }
        }
    }
    true
}

/// The condition that φ is small beside its terms.
fn consistency(value: Expr, size: Expr, arena: &mut Arena) -> Condition<Expr> {
    let size = arena.scale(INCONSISTENT, size);
    let rest = arena.abs(value);
    let value = arena.sub(size, rest);
    Condition {
        value,
        is_closed: true,
        text: value,
    }
}

/// For each constraint the rate of φ at which a velocity of the size of that in the step crosses it, `√E Σ |∂φ/∂q_i| M_ii^(−½)` with
///
/// ```text
/// E = Σ_i [ (|p₀ − a| + |h ∂L/∂q| + Σ |∂G/∂q ΔW|)_i² / M_ii + M_ii (Σ |∂G/∂p_i ΔW|)² / h² ]
/// ```
///
/// at q₀. The residual φ(t₁,q₁)/h has no terms of that size where the motion is along the constraints.
fn velocity_scales(
    action: &Action,
    model: &Model,
    symbols: &Symbols,
    start: &HashMap<Symbol, Expr>,
    arena: &mut Arena,
) -> Vec<Expr> {
    let zero = arena.constant(0.0);
    let mut at = start.clone();
    at.extend(model.v.iter().map(|&v| (v, zero)));
    let increments = |m: &Meaning| matches!(m, Meaning::Wiener(_));
    let dw: Vec<Symbol> = (0..symbols.meanings().len() as u32)
        .map(Symbol)
        .filter(|&s| increments(symbols.meaning(s)))
        .collect();
    let h = arena.symbol(action.h);
    let (mut energy, mut inverse_roots) = (Vec::new(), Vec::new());
    for i in 0..model.dof() {
        let momentum = arena.diff(model.lagrangian, model.v[i]);
        let mass = arena.diff(momentum, model.v[i]);
        let mass = arena.substitute(mass, &at);
        let mass = arena.abs(mass);
        let root = arena.call(Function::Sqrt, mass);
        inverse_roots.push(arena.pow(root, -1));
        let rest = arena.substitute(momentum, &at);
        let p = arena.symbol(action.start_p[i]);
        let relative = arena.sub(p, rest);
        let force = arena.diff(model.lagrangian, model.q[i]);
        let force = arena.substitute(force, &at);
        let kick = arena.mul(h, force);
        let mut sizes = vec![(1.0, arena.abs(relative)), (1.0, arena.abs(kick))];
        let mut shifts = Vec::new();
        for (noise, &dw) in model.noises.iter().zip(&dw) {
            let dw = arena.symbol(dw);
            let [dq, dp] = [model.q[i], model.p[i]].map(|s| arena.diff(noise.hamiltonian, s));
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
    let mut scales = Vec::new();
    for constraint in &model.constraints {
        let mut terms = Vec::new();
        for (i, &inverse_root) in inverse_roots.iter().enumerate() {
            let slope = arena.diff(constraint.value, model.q[i]);
            let slope = arena.substitute(slope, &at);
            let slope = arena.abs(slope);
            terms.push((1.0, arena.mul(slope, inverse_root)));
        }
        let sum = arena.sum(0.0, &terms);
        scales.push(arena.mul(speed, sum));
    }
    scales
}

/// `Σ M_ii (d_i/h)² − ¼ Σ (p₀ − a)²_i / M_ii` for a system with noise. If this is negative, the noise undoes much of the motion: then the equations of the step say little of
/// those of the step without noise, from which its solution is followed.
fn guard(
    action: &Action,
    model: &Model,
    start: &HashMap<Symbol, Expr>,
    arena: &mut Arena,
) -> Option<Expr> {
    if model.noises.is_empty() {
        return None;
    }
    let zero = arena.constant(0.0);
    let mut at = start.clone();
    at.extend(model.v.iter().map(|&v| (v, zero)));
    let h = arena.symbol(action.h);
    let mut terms = Vec::new();
    for i in 0..model.dof() {
        let momentum = arena.diff(model.lagrangian, model.v[i]);
        let mass = arena.diff(momentum, model.v[i]);
        let mass = arena.substitute(mass, &at);
        let rest = arena.substitute(momentum, &at);
        let [d, p] = [action.displacement[i], action.start_p[i]].map(|s| arena.symbol(s));
        let relative = arena.sub(p, rest);
        terms.push((1.0, arena.product(&[(d, 2), (h, -2), (mass, 1)])));
        terms.push((-0.25, arena.product(&[(relative, 2), (mass, -1)])));
    }
    Some(arena.sum(0.0, &terms))
}

/// Whether some noise has second derivatives by the momentum.
fn is_curved(model: &Model, arena: &mut Arena) -> bool {
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

/// The equation of a variation to leading order in the step size: with no step, displacement and velocity but in its `linear` part, and with p₀ in the
/// place of the momentum. The noise keeps its place.
pub(crate) fn leading(
    residual: Expr,
    linear: Expr,
    action: &Action,
    symbols: &Symbols,
    arena: &mut Arena,
) -> Expr {
    let rest = arena.sub(residual, linear);
    let zero = arena.constant(0.0);
    let mut by = HashMap::from([(action.h, zero)]);
    by.extend(action.displacement.iter().map(|&d| (d, zero)));
    for &x in &action.internal {
        let Meaning::Unknown(unknown) = *symbols.meaning(x) else {
            continue;
        };
        let value = match unknown.family {
            Family::Momentum => arena.symbol(action.start_p[unknown.index]),
            _ => zero,
        };
        by.insert(x, value);
    }
    let rest = arena.substitute(rest, &by);
    arena.add(linear, rest)
}

//! Holonomic constraints φ(t, q) = 0, and the terms that they add to the action of any rule.
//!
//! ```text
//! S_d + ⟨λ, φ(t₀,q₀)⟩ + ⟨μ, φ(t₁,q₁)⟩
//! ```
//!
//! The forces of the constraints act at the two ends of the step, never at a node: with Dφᵀλ at a
//! node the step is not symplectic on the manifold of the constraints. λ enters the momentum
//! balance at the start, μ the momentum at the end. The additional equations are
//!
//! ```text
//! 0 = φ(t₁,q₁)      p₁ = ∂L/∂v(t₁,q₁,v₁)      0 = ∂φ/∂t + Dφ(t₁,q₁) v₁
//! ```
//!
//! The first equation determines λ, the others project p₁. With the rule of Störmer and Verlet this
//! is RATTLE.
//!
//! Sources: Marsden, West, *Discrete mechanics and variational integrators*, Acta Numerica 10
//! (2001), section 3; Leimkuhler, Reich, *Simulating Hamiltonian Dynamics* (2004), chapter 7;
//! Bou-Rabee, Owhadi, *Stochastic variational integrators*, IMA J. Numer. Anal. 29 (2009).

mod scales;

use std::collections::HashMap;

use super::action::Action;
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::domain::Condition;
use crate::model::{AtNode, END, Family, Meaning, Model, NodeQuantity, Symbols, Unknown};
use scales::{guard, is_curved, velocity_scales};

/// The contributions of constraints to an action.
pub(crate) struct Enforced {
    /// λ and μ, one for each constraint.
    pub(crate) start_multipliers: Vec<Symbol>,
    pub(crate) end_multipliers: Vec<Symbol>,
    /// v₁.
    pub(crate) end_velocity: Vec<Symbol>,
    /// φ(t₁,q₁)/h, in a form that does not cancel if φ is of second degree.
    pub(crate) end_values: Vec<Expr>,
    /// `∂φ/∂t + Dφ d/h` and φ(t₀,q₀)/h.
    pub(crate) mean_values: Vec<MeanValue>,
    /// ∂φ/∂t + Dφ(t₁,q₁) v₁.
    pub(crate) end_rates: Vec<Expr>,
    /// ∂φ/∂t + Dφ(t₀,q₀) v with the velocity of the rule: φ(t₁,q₁)/h to leading order.
    pub(crate) start_rates: Vec<Expr>,
    /// ∂L/∂v(t₁,q₁,v₁).
    pub(crate) end_momentum: Vec<Expr>,
    /// The scales that φ(t₁,q₁)/h is compared with; see
    /// [`velocity_scales`](scales::velocity_scales).
    pub(crate) scales: Vec<Expr>,
    /// `Dφ(t₀,q₀)ᵀ λ`.
    pub(crate) start_impulse: Vec<Expr>,
    /// True if the Jacobian's determinant has the same sign as in a small step, whatever the
    /// increments: no noise is curved in p.
    pub(crate) has_sign: bool,
    /// The condition that φ(t₀,q₀) vanishes to rounding.
    pub(crate) at_start: Vec<Condition<Expr>>,
    /// An expression that is negative if the noise cancels most of the motion of the step; see
    /// [`guard`](scales::guard). `None` without noise.
    pub(crate) guard: Option<Expr>,
}

/// φ(t₁,q₁)/h by the mean-value theorem.
#[derive(Clone, Copy)]
pub(crate) struct MeanValue {
    /// `∂φ/∂t + Σ ∂φ/∂q_i d_i/h` at some point between the ends. The expression is written at the
    /// end.
    pub(crate) rate: Expr,
    /// φ(t₀,q₀)/h, which is a rounding error.
    pub(crate) start: Expr,
}

/// Largest φ at the start of a step, relative to the sum of the magnitudes of its terms. Steps
/// leave rounding errors in φ, which must pass.
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
    let is_velocity = |s: &Symbol| matches!(symbols.meaning(*s), Meaning::Unknown(u) if u.family == Family::Velocity);
    let velocity: Vec<Symbol> = action
        .internal
        .iter()
        .copied()
        .filter(is_velocity)
        .collect();
    let start = at_start(&action, model, &velocity, arena);
    let end = at_end(&action, model, &end_velocity, arena);
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
    let mut terms = vec![(1.0, action.value)];
    for k in 0..count {
        terms.extend(enforced.add(k, [&start, &end], &action, model, arena));
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

impl Enforced {
    /// Adds the contributions of constraint `k`, and returns its terms of the action.
    fn add(
        &mut self,
        k: usize,
        [start, end]: [&HashMap<Symbol, Expr>; 2],
        action: &Action,
        model: &Model,
        arena: &mut Arena,
    ) -> [(f64, Expr); 2] {
        let value = model.constraints[k].value;
        let [lambda, mu] = [self.start_multipliers[k], self.end_multipliers[k]];
        let [lambda, mu] = [lambda, mu].map(|s| arena.symbol(s));
        let [first, last] = [start, end].map(|at| arena.substitute(value, at));
        let terms = [arena.mul(lambda, first), arena.mul(mu, last)];
        for (i, impulse) in self.start_impulse.iter_mut().enumerate() {
            let slope = arena.diff(value, model.q[i]);
            let slope = arena.substitute(slope, start);
            let more = arena.mul(slope, lambda);
            *impulse = arena.add(*impulse, more);
        }
        let rate = model.rate(value, arena);
        let [start_rate, end_rate] = [start, end].map(|at| arena.substitute(rate, at));
        self.start_rates.push(start_rate);
        self.end_rates.push(end_rate);
        let h = arena.symbol(action.h);
        let ends = self.end_velocity.iter().zip(&action.displacement);
        let by: HashMap<Symbol, Expr> = ends
            .map(|(&v, &d)| {
                let d = arena.symbol(d);
                (v, arena.product(&[(d, 1), (h, -1)]))
            })
            .collect();
        let at_start = arena.opaque(first);
        self.mean_values.push(MeanValue {
            rate: arena.substitute(end_rate, &by),
            start: arena.product(&[(at_start, 1), (h, -1)]),
        });
        let end_value = end_value(value, start, last, action, model, arena);
        self.end_values.push(end_value);
        let size = model.magnitude(value, arena);
        let size = arena.substitute(size, start);
        self.at_start.push(consistency(first, size, arena));
        terms.map(|term| (1.0, term))
    }
}

/// Returns the values of the model's variables at the start, with the velocity of the rule.
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

/// Returns the values of the model's variables at the end.
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

/// Returns φ(t₁,q₁)/h. A φ(q) of second degree is written as `φ(q₀)/h + ⟨Dφ(q₀) + ½ D²φ d, d/h⟩`.
/// This form has no rounding errors of the size of φ's terms, so the velocity of a small step keeps
/// its digits.
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

/// Returns whether φ depends on q alone, with constant second derivatives.
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

/// Returns the condition that φ is small compared with its terms.
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

/// Returns the equation of a variation to leading order in the step size. Step size, displacement
/// and velocity are zero except in the `linear` part, and p₀ replaces the momentum. The noise
/// stays.
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

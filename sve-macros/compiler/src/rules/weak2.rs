//! The option `weak2`: a potential that removes the leading error of expectations, so that the weak
//! order is 2 with one Gaussian increment for each process.
//!
//! The noise Hamiltonians are `G_a = −γ` or `H₁`. The term of the option in the action of a rule
//! with weights `bᵢ` of its nodes is
//!
//! ```text
//! S_d −= ½ κ h |h| Σᵢ bᵢ Σ_a K_a(node i)
//! K_a = {G_a, {G_a, H} + ∂G_a/∂t}        {f, g} = ⟨f_q, g_p⟩ − ⟨f_p, g_q⟩
//! ```
//!
//! so L becomes `L − ½ κ |h| Σ_a K_a` at each node. The variance of an increment is `|h|`, so a
//! symmetric rule stays symmetric. A step of order 3 or above with frozen increments has κ = ⅙. The
//! midpoint rule and the rule of Störmer and Verlet are flows of Hamiltonians that lack another
//! `h ΔW² K_a/24` if `G_a` is a γ; this makes κ = ¼. For a γ, `K_a = ⟨γ_q, M⁻¹ γ_q⟩` with
//! `M = ∂²L/∂v²`. For an H₁, K also depends on the momentum and acts as a noise Hamiltonian with
//! the increment `½ κ h |h| bᵢ` at node i. A force F is then refused, since the leading error also
//! contains the double bracket with F. A Gauss rule with stage noise has `κ = 1/(4(2S − 1))`.
//!
//! A noise force f(q), with constant masses, gives the impulse `− κ h |h| bᵢ ∂f/∂q M⁻¹ f`, which is
//! that of `K` if f is the gradient of a γ.
//!
//! The derivation is in `docs/mathematics.md`, section 9.
//!
//! Input: the model with its derivatives. Output: `Σ_a K_a`, or the reason why the option is
//! refused.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::catalogue::{Rule, RuleOption};
use crate::model::{Model, NoiseKind, NoiseTerm};
use crate::system::classify::Classified;
use crate::system::commutation::Commutation;
use crate::system::inverse_mass::{self, NoFormula};
use crate::system::mechanics::{self, Mechanics, NoiseJet};

/// The reason why the option is refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Obstacle {
    /// Two noises do not commute.
    NonCommuting(String, String),
    /// A noise moves the position, and the rule does not take such noises with this option.
    MovesPosition {
        noise: String,
        is_forced: bool,
    },
    /// A noise moves the position, and there is a force.
    MovesPositionWithForce(String),
    /// The force of a noise depends on velocities, or the masses depend on the configuration.
    NoiseForce {
        name: String,
        reads_velocity: bool,
    },
    /// ∂²L/∂v² depends on v.
    MomentumNotAffine,
    /// A force is not affine in v.
    ForceNotAffine,
    NoInverseMass(NoFormula),
}

/// Returns the reason why the option is refused, except for a missing formula for the inverse of
/// the mass matrix.
fn obstacle(system: &Classified, takes_h1: bool, arena: &mut Arena) -> Option<Obstacle> {
    let (model, mechanics) = (&system.model, &system.mechanics);
    if let Commutation::NonCommuting(a, b) = &system.commutation {
        return Some(Obstacle::NonCommuting(a.clone(), b.clone()));
    }
    if let Some(obstacle) = of_noise_force(model, mechanics, arena) {
        return Some(obstacle);
    }
    let is_forced = model.forces().next().is_some();
    if !takes_h1 || is_forced {
        let moves_position = |at: &usize| {
            let dp = &mechanics.noises[*at].dp;
            dp.iter()
                .any(|&e| arena.constant_value(e) != Some(0.0) && !arena.is_zero(e))
        };
        if let Some(at) = (0..model.noises.len()).find(moves_position) {
            let noise = model.noises[at].name.clone();
            return Some(if takes_h1 {
                Obstacle::MovesPositionWithForce(noise)
            } else {
                Obstacle::MovesPosition { noise, is_forced }
            });
        }
    }
    if !mechanics.affine_momentum {
        return Some(Obstacle::MomentumNotAffine);
    }
    let force = mechanics.force.iter().flat_map(|force| &force.dv).flatten();
    for &entry in force {
        for &v in &model.v {
            if arena.contains(entry, v) {
                let change = arena.diff(entry, v);
                if !arena.is_zero(change) {
                    return Some(Obstacle::ForceNotAffine);
                }
            }
        }
    }
    None
}

/// Returns the reason why the option is refused for the force of a noise.
fn of_noise_force(model: &Model, mechanics: &Mechanics, arena: &Arena) -> Option<Obstacle> {
    let masses = mechanics.lagrangian.dvv.iter().flatten();
    let moving = [model.q_and_v(), vec![model.time]].concat();
    let moves = |&e: &Expr| moving.iter().any(|&s| arena.contains(e, s));
    let has_constant_masses = !masses.copied().any(|e| moves(&e));
    for (noise, jet) in model.noises.iter().zip(&mechanics.noises) {
        let reads_velocity = jet.reads_velocity;
        if jet.force.is_some() && (reads_velocity || !has_constant_masses) {
            let name = noise.name.clone();
            return Some(Obstacle::NoiseForce {
                name,
                reads_velocity,
            });
        }
    }
    None
}

/// `Σ_a K_a` as a function of time, position and momentum.
#[derive(Clone)]
pub(crate) struct Potential {
    pub(crate) value: Expr,
    /// The derivatives in q, if all other derivatives are zero.
    pub(crate) gradient: Option<Vec<Expr>>,
    /// `− Σ_a ∂f_a/∂q M⁻¹ f_a`, if it does not vanish. For a force that is the gradient of a γ it
    /// is the force of `½ K`.
    pub(crate) push: Option<Vec<Expr>>,
}

/// Returns `Σ_a K_a`; `None` if it does not depend on the state and so would not change a step.
pub(crate) fn potential(
    system: &Classified,
    takes_h1: bool,
    arena: &mut Arena,
) -> Result<Option<Potential>, Obstacle> {
    let (model, mechanics) = (&system.model, &system.mechanics);
    if let Some(obstacle) = obstacle(system, takes_h1, arena) {
        return Err(obstacle);
    }
    let n = model.dof();
    let mut values = Vec::new();
    let mut gradients = vec![Vec::new(); n];
    for at in 0..model.noises.len() {
        let bracket = double_bracket(at, model, mechanics, arena);
        let (value, w) = bracket.map_err(Obstacle::NoInverseMass)?;
        values.push((1.0, value));
        for (k, gradient) in gradients.iter_mut().enumerate() {
            gradient.extend(slope(at, k, &w, mechanics, model, arena));
        }
    }
    let value = arena.sum(0.0, &values);
    let gradient: Vec<Expr> = gradients
        .iter()
        .map(|terms| arena.sum(0.0, terms))
        .collect();
    let is_of_q = |noise: &NoiseJet| {
        noise
            .dp
            .iter()
            .all(|&e| arena.constant_value(e) == Some(0.0))
    };
    let are_of_q = mechanics.noises.iter().all(is_of_q);
    let push = push(mechanics, model, arena).map_err(Obstacle::NoInverseMass)?;
    if are_of_q {
        let is_constant = arena.zeros(&gradient).into_iter().all(|zero| zero);
        let gradient = Some(gradient);
        return Ok((!is_constant || push.is_some()).then_some(Potential {
            value,
            gradient,
            push,
        }));
    }
    let velocities = velocities(model, mechanics, arena).map_err(Obstacle::NoInverseMass)?;
    Ok(Some(Potential {
        value: arena.substitute(value, &velocities),
        gradient: None,
        push,
    }))
}

/// Returns `− Σ_a ∂f_a/∂q M⁻¹ f_a`, unless it vanishes.
fn push(
    mechanics: &Mechanics,
    model: &Model,
    arena: &mut Arena,
) -> Result<Option<Vec<Expr>>, NoFormula> {
    let mut rows = vec![Vec::new(); model.dof()];
    for force in mechanics
        .noises
        .iter()
        .filter_map(|noise| noise.force.as_ref())
    {
        let mass = &mechanics.lagrangian.dvv;
        let w = inverse_mass::solve(mass, &force.value, &model.q, arena)?;
        for (row, slopes) in rows.iter_mut().zip(&force.dq) {
            for (&slope, &w) in slopes.iter().zip(&w) {
                row.push((-1.0, arena.mul(slope, w)));
            }
        }
    }
    let push: Vec<Expr> = rows.iter().map(|terms| arena.sum(0.0, terms)).collect();
    let vanishes = arena.zeros(&push).into_iter().all(|zero| zero);
    Ok((!vanishes).then_some(push))
}

/// Returns the velocity of a momentum, `M⁻¹ (p − a)` for `∂L/∂v = M v + a`.
fn velocities(
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Result<HashMap<Symbol, Expr>, NoFormula> {
    let zero = arena.constant(0.0);
    let rest = model.v.iter().map(|&v| (v, zero)).collect();
    let rows = mechanics.lagrangian.dvv.iter();
    let mass: Vec<Vec<Expr>> = rows.map(|row| arena.substitute_all(row, &rest)).collect();
    let offset = arena.substitute_all(&mechanics.lagrangian.dv, &rest);
    let mut momenta = Vec::with_capacity(model.dof());
    for (&p, &a) in model.p.iter().zip(&offset) {
        let p = arena.symbol(p);
        momenta.push(arena.sub(p, a));
    }
    let velocities = inverse_mass::solve(&mass, &momenta, &model.q, arena)?;
    Ok(model.v.iter().copied().zip(velocities).collect())
}

impl Potential {
    /// Returns `½ Σ_a K_a` and the push as a noise, with its derivatives.
    pub(crate) fn noise(&self, model: &Model, arena: &mut Arena) -> (NoiseTerm, NoiseJet) {
        let noise = NoiseTerm {
            name: "K".to_owned(),
            kind: NoiseKind::H1,
            hamiltonian: arena.scale(0.5, self.value),
            force: self.push.clone(),
        };
        let jet = match &self.gradient {
            Some(gradient) => {
                let dq = gradient.iter().map(|&slope| arena.scale(0.5, slope));
                let dq = dq.collect();
                let dp = vec![arena.constant(0.0); model.dof()];
                mechanics::noise_jet_of([dq, dp], self.push.as_deref(), model, arena)
            }
            None => mechanics::noise_jet(&noise, model, arena),
        };
        (noise, jet)
    }
}

/// Returns the terms of `∂K/∂q_k = 2 ⟨∂G_q/∂q_k, w⟩ − ⟨w, ∂M/∂q_k w⟩` for a γ, with `K = ⟨G_q, w⟩`
/// and `w = M⁻¹ G_q`. The formula contains no derivative of w.
fn slope(
    at: usize,
    k: usize,
    w: &[Expr],
    mechanics: &Mechanics,
    model: &Model,
    arena: &mut Arena,
) -> Vec<(f64, Expr)> {
    let mut terms = Vec::new();
    for (i, &w_i) in w.iter().enumerate() {
        terms.push((2.0, arena.mul(mechanics.noises[at].dqq[i][k], w_i)));
        for (j, &w_j) in w.iter().enumerate() {
            let change = arena.diff(mechanics.lagrangian.dvv[i][j], model.q[k]);
            terms.push((-1.0, arena.product(&[(change, 1), (w_i, 1), (w_j, 1)])));
        }
    }
    terms
}

/// Returns `K = {G, X}` with `X = {G, H} + ∂G/∂t`, in q, p and the velocity v of p. For
/// `H(q, p) = ⟨p, v⟩ − L` the derivatives are `H_p = v`, `H_q = −L_q`, `∂v/∂p = M⁻¹` and
/// `∂v/∂q = −M⁻¹ L_vq`, so that
///
/// ```text
/// X = ⟨G_q, v⟩ + ⟨G_p, L_q⟩ + G_t        K = ⟨G_q, X_p⟩ − ⟨G_p, X_q⟩ + ⟨X_v, M⁻¹ (G_q + L_vq G_p)⟩
/// ```
fn double_bracket(
    at: usize,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Result<(Expr, Vec<Expr>), NoFormula> {
    let n = model.dof();
    let (lagrangian, noise) = (&mechanics.lagrangian, &mechanics.noises[at]);
    let mut terms = vec![(1.0, arena.diff(model.noises[at].hamiltonian, model.time))];
    for i in 0..n {
        let v = arena.symbol(model.v[i]);
        terms.push((1.0, arena.mul(noise.dq[i], v)));
        terms.push((1.0, arena.mul(noise.dp[i], lagrangian.dq[i])));
    }
    let rate = arena.sum(0.0, &terms);
    let mut b = Vec::with_capacity(n);
    for i in 0..n {
        let mut terms = vec![(1.0, noise.dq[i])];
        for j in 0..n {
            terms.push((1.0, arena.mul(lagrangian.dqv[j][i], noise.dp[j])));
        }
        b.push(arena.sum(0.0, &terms));
    }
    let w = inverse_mass::solve(&lagrangian.dvv, &b, &model.q, arena)?;
    let mut terms = Vec::with_capacity(3 * n);
    for i in 0..n {
        let [by_q, by_v, by_p] = [model.q[i], model.v[i], model.p[i]].map(|s| arena.diff(rate, s));
        for (sign, a, b) in [
            (1.0, noise.dq[i], by_p),
            (-1.0, noise.dp[i], by_q),
            (1.0, by_v, w[i]),
        ] {
            terms.push((sign, arena.mul(a, b)));
        }
    }
    Ok((arena.sum(0.0, &terms), w))
}

/// Returns the weak order of a rule: its order without noise; with noise at most 1, or 2 with the
/// option or if K is constant and so needs no term.
pub(crate) fn weak_order(rule: Rule, system: &Classified, arena: &mut Arena) -> u32 {
    let order = rule.order;
    if system.model.noises.is_empty() {
        return order;
    }
    if rule.options.contain(RuleOption::Weak2)
        || system.mechanics.is_additive
            && system.degeneracy.is_none()
            && obstacle(system, false, arena).is_none()
    {
        order.min(2)
    } else {
        1
    }
}

impl Obstacle {
    /// Returns the message at the option in the attribute.
    pub(crate) fn message(&self, rule: Rule) -> String {
        let without = rule.without(RuleOption::Weak2).name();
        match self {
            Self::NonCommuting(a, b) => format!(
                "`weak2` is for noises that commute, and `{a}` and `{b}` do not: write `{without}`"
            ),
            Self::MovesPositionWithForce(name) => format!(
                "the noise `{name}` moves the position, and with such noise and a force `{}` has weak order 1 as without the option: write `{without}`",
                rule.name()
            ),
            Self::MovesPosition {
                noise: name,
                is_forced,
            } => {
                let others = Rule::all().into_iter();
                let mut others = others.map(|rule| rule.with(RuleOption::Weak2));
                let other = others.find(|rule| rule.weak2().is_some_and(|w| w.takes_h1));
                let other = other.filter(|_| !is_forced);
                let other =
                    other.map_or_else(String::new, |rule| format!(", or `{}`", rule.name()));
                format!(
                    "the noise `{name}` moves the position, and with such noise `{}` has weak order 1 as without the option: write `{without}`{other}",
                    rule.name()
                )
            }
            Self::NoiseForce {
                name,
                reads_velocity,
            } => {
                let why = if *reads_velocity {
                    "depends on velocities"
                } else {
                    "acts on masses that are not constant"
                };
                format!(
                    "`weak2` is for noise forces of positions with constant masses, and `{name}` {why}: write `{without}`"
                )
            }
            Self::MomentumNotAffine => format!(
                "`weak2` is for momenta ∂L/∂v that are affine in the velocities, and here ∂²L/∂v² depends on them: write `{without}`"
            ),
            Self::ForceNotAffine => format!(
                "`weak2` is for forces that are affine in the velocities, and with others `{}` has weak order 1 as without the option: write `{without}`",
                rule.name()
            ),
            Self::NoInverseMass(NoFormula::TooManyCoupled(coupled)) => format!(
                "`weak2` needs the inverse of the mass matrix as a formula, and ∂²L/∂v² couples {coupled} coordinates by entries that depend on the configuration; the limit is 3 coordinates: write `{without}`"
            ),
            Self::NoInverseMass(NoFormula::NoPivot(coupled)) => format!(
                "`weak2` needs the inverse of the mass matrix as a formula, and ∂²L/∂v² of {coupled} coupled coordinates has only zeros on its diagonal: write `{without}`"
            ),
        }
    }
}

#[cfg(test)]
mod tests;

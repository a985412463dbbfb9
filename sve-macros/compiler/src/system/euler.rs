//! The increment of Euler's method: `h f(z) + Σ g_a(z) ΔW_a` for `z = (q, p)`, with the drift f and
//! the noise fields g of the first-order form, and the Itô correction `½ h Σ (Dg_a) g_a`. The
//! explicit baselines consist of such increments.
//!
//! Input: the derivatives of L, the noises and the force. Output: expressions in t, q, p, h and ΔW.
//! If the mass matrix is diagonal, the velocity is the formula `v = (p − ∂L/∂v(q, 0))/M`; otherwise
//! it is a symbol, and the code solves a linear system for it. The expressions are created last, so
//! they change the order of terms in no step.

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Symbol};
use crate::model::{Meaning, Model, Symbols};
use crate::system::mechanics::{ForceJet, Mechanics, NoiseJet};

/// Largest number of coordinates that a mass matrix may couple.
const MAX_COUPLED: usize = 6;

/// Largest number of coordinates.
const MAX_COORDINATES: usize = 32;

/// The increment of Euler's method.
pub(crate) struct Euler {
    /// The symbols of the model, with the step size and the increments of the noises.
    pub(crate) symbols: Symbols,
    /// The linear system for the velocity, unless the velocity is a formula.
    pub(crate) solved: Option<Solved>,
    /// The increment of q.
    pub(crate) dq: Vec<Expr>,
    /// The increment of p.
    pub(crate) dp: Vec<Expr>,
    /// The Itô correction of q and p over the step, unless it vanishes.
    pub(crate) correction: Option<[Vec<Expr>; 2]>,
}

/// A linear system for the velocity.
pub(crate) struct Solved {
    /// ∂²L/∂v².
    pub(crate) mass: Vec<Vec<Expr>>,
    /// True if the matrix depends on parameters alone.
    pub(crate) is_constant: bool,
    /// p − ∂L/∂v(q, 0).
    pub(crate) rhs: Vec<Expr>,
}

/// Returns the increment of a system whose L determines every velocity. `None` if the velocity must
/// be found by iteration, if the first-order form is not in a vector space, if the system is too
/// large, or if the Itô correction has to solve with a mass matrix.
pub(crate) fn euler(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Option<Euler> {
    let jet = &mechanics.lagrangian;
    let n = model.dof();
    let is_zero = |e: Expr| arena.constant_value(e) == Some(0.0);
    let is_diagonal = (0..n).all(|i| (0..n).all(|j| i == j || is_zero(jet.dvv[i][j])));
    if !has_increment(model, mechanics, is_diagonal) {
        return None;
    }
    let zero = arena.constant(0.0);
    let rest: HashMap<Symbol, Expr> = model.v.iter().map(|&v| (v, zero)).collect();
    let rows = jet.dvv.iter();
    let mass: Vec<Vec<Expr>> = rows.map(|row| arena.substitute_all(row, &rest)).collect();
    let at_rest = arena.substitute_all(&jet.dv, &rest);
    let p = model.p.iter().map(|&p| arena.symbol(p));
    let p: Vec<Expr> = p.collect();
    let rhs = p.iter().zip(&at_rest).map(|(&p, &r)| arena.sub(p, r));
    let rhs: Vec<Expr> = rhs.collect();
    let mut kick = jet.dq.clone();
    if let Some(force) = &mechanics.force {
        let sum = kick.iter().zip(&force.value);
        kick = sum.map(|(&a, &b)| arena.add(a, b)).collect();
    }
    let noises = &mechanics.noises;
    let mut kicks: Vec<Vec<Expr>> = noises.iter().map(|noise| noise.against(arena)).collect();
    let mut v: Vec<Expr> = model.v.iter().map(|&v| arena.symbol(v)).collect();
    let mut by_force = vec![arena.constant(0.0); n];
    for force in noises.iter().filter_map(|noise| noise.force.as_ref()) {
        add_correction(&mut by_force, force, &mass, arena);
    }
    let solved = if is_diagonal {
        v = divided(&rhs, &mass, model, arena);
        let formulas = model.v.iter().copied().zip(v.iter().copied()).collect();
        kick = arena.substitute_all(&kick, &formulas);
        by_force = arena.substitute_all(&by_force, &formulas);
        for row in &mut kicks {
            *row = arena.substitute_all(row, &formulas);
        }
        None
    } else {
        let is_constant = !mass.iter().flatten().any(|&e| moves(e, model, arena));
        Some(Solved {
            mass,
            is_constant,
            rhs,
        })
    };
    let mut symbols = model.symbols.clone();
    let h = symbols.declare(Meaning::StepSize);
    let h = arena.symbol(h);
    let dw = symbols.declare_all(mechanics.noises.len(), Meaning::Wiener);
    let dw: Vec<Expr> = dw.into_iter().map(|s| arena.symbol(s)).collect();
    let mut row = |drift: &[Expr], sign: f64, slopes: &[&[Expr]]| {
        let entries = (0..n).map(|i| {
            let mut terms = vec![(1.0, arena.mul(h, drift[i]))];
            for (slopes, &dw) in slopes.iter().zip(&dw) {
                terms.push((sign, arena.mul(dw, slopes[i])));
            }
            arena.sum(0.0, &terms)
        });
        entries.collect::<Vec<Expr>>()
    };
    let shifts: Vec<&[Expr]> = noises.iter().map(|noise| noise.dp.as_slice()).collect();
    let dq = row(&v, 1.0, &shifts);
    let kicks: Vec<&[Expr]> = kicks.iter().map(Vec::as_slice).collect();
    let dp = row(&kick, -1.0, &kicks);
    let correction = correction(noises, &by_force, h, arena);
    Some(Euler {
        symbols,
        solved,
        dq,
        dp,
        correction,
    })
}

/// Returns whether the increment of a system is a formula, or a formula of the solution of a small
/// linear system.
fn has_increment(model: &Model, mechanics: &Mechanics, is_diagonal: bool) -> bool {
    let is_plain = mechanics.affine_momentum
        && model.constraints.is_empty()
        && !model.configuration().has_rotations();
    let most = if is_diagonal {
        MAX_COORDINATES
    } else {
        MAX_COUPLED
    };
    let mut noises = mechanics.noises.iter();
    let has_solved_correction = !is_diagonal && noises.any(|noise| noise.reads_velocity);
    is_plain && model.dof() <= most && !has_solved_correction
}

/// Returns whether an expression depends on position or time.
fn moves(e: Expr, model: &Model, arena: &Arena) -> bool {
    let mut moving = model.q.iter().chain([&model.time]);
    moving.any(|&s| arena.contains(e, s))
}

/// Returns the velocity of a system whose mass matrix is diagonal.
fn divided(rhs: &[Expr], mass: &[Vec<Expr>], model: &Model, arena: &mut Arena) -> Vec<Expr> {
    let mut v = Vec::new();
    for (i, &rhs) in rhs.iter().enumerate() {
        let quotient = arena.div(rhs, mass[i][i]);
        // the force takes the velocity, and not a formula that divides once more
        let is_shared = moves(mass[i][i], model, arena);
        v.push(if is_shared {
            arena.opaque(quotient)
        } else {
            quotient
        });
    }
    v
}

/// The terms of an entry of the Itô correction: for two coordinates, signed products of two
/// derivatives of a noise.
type Terms<'a> = &'a dyn Fn(&NoiseJet, usize, usize) -> [(f64, Expr, Expr); 2];

/// Adds `½ ∂f/∂v M⁻¹ f` of a force, with a diagonal mass matrix unless f does not depend on v.
fn add_correction(sum: &mut [Expr], force: &ForceJet, mass: &[Vec<Expr>], arena: &mut Arena) {
    for (sum, row) in sum.iter_mut().zip(&force.dv) {
        for (j, &slope) in row.iter().enumerate() {
            if arena.constant_value(slope) != Some(0.0) {
                let factors = [(slope, 1), (force.value[j], 1), (mass[j][j], -1)];
                let term = arena.product(&factors);
                *sum = arena.sum(0.0, &[(1.0, *sum), (0.5, term)]);
            }
        }
    }
}

/// Returns `½ h Σ (Dg_a) g_a`, unless it vanishes. `by_force` has the part of the forces in dp.
fn correction(
    noises: &[NoiseJet],
    by_force: &[Expr],
    h: Expr,
    arena: &mut Arena,
) -> Option<[Vec<Expr>; 2]> {
    let n = by_force.len();
    let mut row = |entry: Terms<'_>| {
        let entries = (0..n).map(|i| {
            let mut terms = Vec::new();
            for noise in noises {
                for j in 0..n {
                    for (sign, a, b) in entry(noise, i, j) {
                        // most noises depend on few coordinates, so most products vanish
                        if [a, b].iter().all(|&e| arena.constant_value(e) != Some(0.0)) {
                            terms.push((0.5 * sign, arena.mul(a, b)));
                        }
                    }
                }
            }
            let sum = arena.sum(0.0, &terms);
            arena.mul(h, sum)
        });
        entries.collect::<Vec<Expr>>()
    };
    let q = row(&|g, i, j| [(1.0, g.dqp[j][i], g.dp[j]), (-1.0, g.dpp[i][j], g.dq[j])]);
    let mut p = row(&|g, i, j| [(-1.0, g.dqq[i][j], g.dp[j]), (1.0, g.dqp[i][j], g.dq[j])]);
    for (p, &more) in p.iter_mut().zip(by_force) {
        if arena.constant_value(more) != Some(0.0) {
            let more = arena.mul(h, more);
            *p = arena.add(*p, more);
        }
    }
    let is_zero = |e: &Expr| arena.constant_value(*e) == Some(0.0);
    let vanishes = q.iter().chain(&p).all(is_zero);
    (!vanishes).then_some([q, p])
}

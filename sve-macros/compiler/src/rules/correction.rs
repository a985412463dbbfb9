//! The Stratonovich correction of a rule with one node at `q₀ + c d`, for c ≠ ½.
//!
//! With the fields `X_a = (∂G_a/∂p, f_a − ∂G_a/∂q)` of the noises, the increments at the node lack
//!
//! ```text
//! −(c − ½) Σ_ab E_ab ΔW_a ΔW_b        E_ab = ∂_q X_a · X_b^q − ∂_p X_a · X_b^p
//! ```
//!
//! The part without forces is the variation of a term of the action,
//! `(c − ½) Σ_ab ⟨∂G_a/∂p, ∂G_b/∂q⟩ ΔW_a ΔW_b`. The part of the forces is no variation. It is work
//! at the node: on its position in dp, on its momentum in dq (`docs/mathematics.md`, section 16).

use std::collections::HashMap;

use super::action::{Place, Variables, Work};
use crate::algebra::{Arena, Expr, Symbol};
use crate::model::Model;
use crate::system::classify::Classified;
use crate::system::inverse_mass::NoFormula;
use crate::system::mechanics::Mechanics;

/// The part of `E_ab` that contains forces, for a pair of noises.
#[derive(Clone)]
pub(crate) struct Correction {
    pair: [usize; 2],
    q: Vec<Expr>,
    p: Vec<Expr>,
}

/// Returns the corrections that do not vanish identically.
pub(crate) fn corrections(
    system: &Classified,
    arena: &mut Arena,
) -> Result<Vec<Correction>, NoFormula> {
    let (model, mechanics) = (&system.model, &system.mechanics);
    let mut all = Vec::new();
    for a in 0..model.noises.len() {
        for b in 0..model.noises.len() {
            let [q, p] = of_pair(a, b, model, mechanics, arena)?;
            let is_zero = |&e: &Expr| arena.constant_value(e) == Some(0.0);
            if !q.iter().chain(&p).all(is_zero) {
                all.push(Correction { pair: [a, b], q, p });
            }
        }
    }
    Ok(all)
}

/// Returns the part of `E_ab` that contains forces, in dq and dp. A noise has either a Hamiltonian
/// or a force. A force f(q, v) changes by `f_q X^q + f_v w` with the change w of the velocity.
fn of_pair(
    a: usize,
    b: usize,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Result<[Vec<Expr>; 2], NoFormula> {
    let (n, zero) = (model.dof(), arena.constant(0.0));
    let [mut in_q, mut in_p] = [vec![zero; n], vec![zero; n]];
    let [first, second] = [a, b].map(|at| &mechanics.noises[at]);
    let sum = |products: &[(f64, Expr, Expr)], arena: &mut Arena| {
        let terms = products.iter().map(|&(c, x, y)| (c, arena.mul(x, y)));
        let terms: Vec<(f64, Expr)> = terms.collect();
        arena.sum(0.0, &terms)
    };
    match (&first.force, &second.force) {
        (None, None) => {}
        (None, Some(push)) => {
            for i in 0..n {
                let products = |row: &dyn Fn(usize) -> Expr, sign: f64| -> Vec<_> {
                    (0..n).map(|j| (sign, row(j), push.value[j])).collect()
                };
                in_q[i] = sum(&products(&|j| first.dpp[i][j], -1.0), arena);
                in_p[i] = sum(&products(&|j| first.dqp[i][j], 1.0), arena);
            }
        }
        (Some(force), _) => {
            let reads_velocity = first.reads_velocity;
            let against = second.against(arena);
            let change = if reads_velocity {
                mechanics.velocity_along([&second.dp, &against], &model.q_and_v(), arena)?
            } else {
                vec![zero; n]
            };
            for i in 0..n {
                let along_q = (0..n).map(|j| (1.0, force.dq[i][j], second.dp[j]));
                let along_v = (0..n).map(|j| (1.0, force.dv[i][j], change[j]));
                in_p[i] = sum(&along_q.chain(along_v).collect::<Vec<_>>(), arena);
            }
        }
    }
    Ok([in_q, in_p])
}

impl Variables<'_> {
    /// Returns the Stratonovich correction `Σ_a Σ_b ⟨shift by G_a, slope of G_b⟩ ΔW_a ΔW_b` at a
    /// node. For each noise, `fields` has the shift and the slope along each coordinate.
    pub(super) fn stratonovich(
        &mut self,
        fields: &[Vec<[Expr; 2]>],
        node: &HashMap<Symbol, Expr>,
    ) -> Expr {
        let mut terms = Vec::new();
        for (a, &dw_a) in fields.iter().zip(&self.dw) {
            for (b, &dw_b) in fields.iter().zip(&self.dw) {
                if self.arena.is_exhausted() {
                    return self.arena.constant(0.0);
                }
                let [dw_a, dw_b] = [dw_a, dw_b].map(|s| self.arena.symbol(s));
                for ([shift, _], [_, slope]) in a.iter().zip(b) {
                    let product = self.arena.product(&[(*shift, 1), (*slope, 1)]);
                    let at_node = self.arena.substitute(product, node);
                    let factors = [(at_node, 1), (dw_a, 1), (dw_b, 1)];
                    terms.push((1.0, self.arena.product(&factors)));
                }
            }
        }
        self.arena.sum(0.0, &terms)
    }

    /// Returns the shift and the slope of a noise along each of the coordinates.
    pub(super) fn field(
        &mut self,
        noise: usize,
        coordinates: impl IntoIterator<Item = usize>,
    ) -> Vec<[Expr; 2]> {
        let g = self.model.noises[noise].hamiltonian;
        let coordinates = coordinates.into_iter();
        let pairs = coordinates.map(|i| [self.model.p[i], self.model.q[i]]);
        pairs
            .map(|pair| pair.map(|s| self.arena.diff(g, s)))
            .collect()
    }

    /// Returns the correction of the noises with forces as work on the position and the momentum of
    /// a node.
    pub(super) fn correction_work(&mut self, c: f64, node: &HashMap<Symbol, Expr>) -> Vec<Work> {
        let (model, corrections) = (self.model, self.correction);
        let mut work = Vec::new();
        for Correction { pair, q, p } in corrections {
            let [dw_a, dw_b] = pair.map(|at| self.arena.symbol(self.dw[at]));
            // work on the momentum is subtracted from the displacement
            for (sign, rates, moved) in [(1.0, p, &model.q), (-1.0, q, &model.p)] {
                for (&rate, symbol) in rates.iter().zip(moved) {
                    if self.arena.constant_value(rate) == Some(0.0) {
                        continue;
                    }
                    let rate = self.arena.substitute(rate, node);
                    let impulse = self.arena.product(&[(rate, 1), (dw_a, 1), (dw_b, 1)]);
                    work.push(Work {
                        impulse: self.arena.scale(sign * (0.5 - c), impulse),
                        place: Place::Coordinate(node[symbol]),
                    });
                }
            }
        }
        work
    }
}

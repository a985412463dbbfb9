//! The test whether the noises of a system commute, which decides the strong order of the rules.

use super::degeneracy::{Degeneracy, Role, brackets as of_two_form};
use super::mechanics::{Mechanics, NoiseJet};
use crate::algebra::{Arena, Expr, Vanishing};
use crate::model::Model;

/// The result of the test whether the noises of a model commute.
#[derive(Clone)]
pub(crate) enum Commutation {
    /// All pairs of noises commute: proved, or found at random points.
    All(Vanishing),
    /// The source names of the first pair of noises that does not commute.
    NonCommuting(String, String),
}

impl Commutation {
    /// Returns the result for a system in which all brackets vanish where the constraints hold.
    pub(crate) fn on_constraints(self) -> Self {
        match self {
            Self::NonCommuting(..) => Self::All(Vanishing::Evaluated),
            Self::All(evidence) => Self::All(evidence),
        }
    }
}

/// Tests whether the noises commute. If L leaves velocities undetermined, the bracket of the
/// two-form decides, otherwise the Poisson bracket.
pub(crate) fn commutation(
    model: &Model,
    mechanics: &Mechanics,
    degeneracy: Option<&Degeneracy>,
    arena: &mut Arena,
) -> Commutation {
    match degeneracy {
        // γ's of the remaining coordinates always commute
        Some(degeneracy) if !degeneracy.of(Role::Massless).is_empty() => {
            of_two_form::commutation(degeneracy, model, mechanics, arena)
        }
        _ => brackets(model, &mechanics.noises, arena),
    }
}

/// Tests whether the Poisson bracket `{G_a, G_b} = ⟨∂G_a/∂q, ∂G_b/∂p⟩ − ⟨∂G_a/∂p, ∂G_b/∂q⟩`
/// vanishes for all pairs. Each rotation adds `− Π·(∂G_a/∂Π × ∂G_b/∂Π)`, with left-trivialised
/// derivatives in R.
fn brackets(model: &Model, noises: &[NoiseJet], arena: &mut Arena) -> Commutation {
    let jets: Vec<[Vec<Expr>; 2]> = noises.iter().map(|jet| scaled(jet, arena)).collect();
    let mut evidence = Vanishing::Proved;
    for (i, [a_q, a_p]) in jets.iter().enumerate() {
        for (j, [b_q, b_p]) in jets.iter().enumerate().skip(i + 1) {
            if arena.is_exhausted() {
                return Commutation::All(evidence);
            }
            let mut terms = Vec::new();
            for k in 0..model.dof() {
                for (sign, x, y) in [(1.0, a_q[k], b_p[k]), (-1.0, a_p[k], b_q[k])] {
                    // most noises depend on few coordinates, so most products vanish
                    if [x, y].iter().all(|&e| arena.constant_value(e) != Some(0.0)) {
                        terms.push((sign, arena.mul(x, y)));
                    }
                }
            }
            if model.configuration().has_rotations() {
                let p: Vec<Expr> = model.p.iter().map(|&s| arena.symbol(s)).collect();
                let transport = model.configuration().transport(&p, a_p, b_p, arena);
                terms.push((-1.0, transport));
            }
            let bracket = arena.sum(0.0, &terms);
            let bracket = model.on_rotations(bracket, arena);
            match arena.vanishing(bracket) {
                Some(vanishing) => evidence = evidence.max(vanishing),
                None => {
                    let [a, b] = [i, j].map(|at| model.noises[at].name.clone());
                    return Commutation::NonCommuting(a, b);
                }
            }
        }
    }
    Commutation::All(evidence)
}

/// Returns the gradients of a noise in q and p. If a product of two components might underflow or
/// overflow, a power of two scales the gradients to the order of 1.
fn scaled(jet: &NoiseJet, arena: &mut Arena) -> [Vec<Expr>; 2] {
    let factor = arena.scale_of(&[jet.dq.as_slice(), &jet.dp].concat());
    [&jet.dq, &jet.dp].map(|gradient| {
        if factor == 1.0 {
            gradient.clone()
        } else {
            gradient.iter().map(|&x| arena.scale(factor, x)).collect()
        }
    })
}

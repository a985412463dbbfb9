//! The test whether the noises of a system commute, which decides the strong order of the rules.

use super::degeneracy::{Degeneracy, Role, brackets as of_two_form};
use super::mechanics::{Mechanics, NoiseJet, less};
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
/// two-form decides, otherwise the Poisson bracket, or the bracket of fields with a force. A pair
/// whose bracket is not known counts as one that does not commute.
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
        _ => brackets(model, mechanics, arena),
    }
}

/// Tests whether the brackets of all pairs vanish: the Poisson bracket of two Hamiltonians,
/// otherwise the bracket of the fields.
fn brackets(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Commutation {
    let noises = &mechanics.noises;
    let jets: Vec<[Vec<Expr>; 2]> = noises.iter().map(|jet| scaled(jet, arena)).collect();
    let of_positions: Vec<bool> = noises.iter().map(|g| g.is_of_positions(arena)).collect();
    let mut fields = None;
    let mut evidence = Vanishing::Proved;
    for i in 0..noises.len() {
        for j in i + 1..noises.len() {
            if arena.is_exhausted() {
                return Commutation::All(evidence);
            }
            if of_positions[i] && of_positions[j] {
                continue;
            }
            let has_force = noises[i].force.is_some() || noises[j].force.is_some();
            let bracket = if has_force {
                let fields = fields.get_or_insert_with(|| Fields::new(model, mechanics, arena));
                let fields = fields.as_ref();
                fields.map(|fields| fields.bracket(i, j, model, arena))
            } else {
                Some(vec![poisson_bracket(&jets[i], &jets[j], model, arena)])
            };
            let vanishes = |bracket: Vec<Expr>| {
                let mut all = Vanishing::Proved;
                for component in bracket {
                    let component = model.on_rotations(component, arena);
                    all = all.max(arena.vanishing(component)?);
                }
                Some(all)
            };
            match bracket.and_then(vanishes) {
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

/// Returns `{G_a, G_b} = ⟨∂G_a/∂q, ∂G_b/∂p⟩ − ⟨∂G_a/∂p, ∂G_b/∂q⟩`. Each rotation adds
/// `− Π·(∂G_a/∂Π × ∂G_b/∂Π)`, with left-trivialised derivatives in R.
fn poisson_bracket(
    [a_q, a_p]: &[Vec<Expr>; 2],
    [b_q, b_p]: &[Vec<Expr>; 2],
    model: &Model,
    arena: &mut Arena,
) -> Expr {
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
    arena.sum(0.0, &terms)
}

/// The fields of the noises as functions of t, q and v.
struct Fields(Vec<Field>);

/// The rates of change of the configuration, the momentum and the velocity by a noise. They are
/// left-trivialised in rotations.
struct Field {
    q: Vec<Expr>,
    p: Vec<Expr>,
    v: Vec<Expr>,
}

impl Fields {
    /// Returns the fields; `None` if M⁻¹ has no formula.
    fn new(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Option<Self> {
        let momenta = model.p.iter().copied();
        let momenta = momenta
            .zip(mechanics.lagrangian.dv.iter().copied())
            .collect();
        let field = |noise: &NoiseJet| {
            let q = arena.substitute_all(&noise.dp, &momenta);
            let against = noise.against(arena);
            let against = arena.substitute_all(&against, &momenta);
            // in the body frame the momentum is rotated against the rotation of the body
            let p = &mechanics.lagrangian.dv;
            let turned = model.configuration().commutator(p, &q, arena);
            let p = less(&turned, &against, arena);
            let factor = arena.scale_of(&[&q[..], &p].concat());
            let [q, p] = [q, p]
                .map(|row| -> Vec<Expr> { row.iter().map(|&e| arena.scale(factor, e)).collect() });
            let v = mechanics.velocity_along([&q, &p], &[], arena).ok()?;
            Some(Field { q, p, v })
        };
        mechanics
            .noises
            .iter()
            .map(field)
            .collect::<Option<_>>()
            .map(Self)
    }

    /// Returns the bracket of two fields in q and p.
    fn bracket(&self, i: usize, j: usize, model: &Model, arena: &mut Arena) -> Vec<Expr> {
        let [a, b] = [i, j].map(|at| &self.0[at]);
        let turned = model.configuration().commutator(&a.q, &b.q, arena);
        let mut bracket = Vec::new();
        for (of_a, of_b) in a.q.iter().zip(&b.q).chain(a.p.iter().zip(&b.p)) {
            let along_a = a.along(*of_b, model, arena);
            let along_b = b.along(*of_a, model, arena);
            bracket.push(arena.sub(along_a, along_b));
        }
        for (component, turned) in bracket.iter_mut().zip(turned) {
            *component = arena.add(*component, turned);
        }
        bracket
    }
}

impl Field {
    /// Returns the derivative of an expression of t, q and v along the field.
    fn along(&self, of: Expr, model: &Model, arena: &mut Arena) -> Expr {
        let mut terms = Vec::new();
        for (slope, &q) in model.gradient(of, arena).into_iter().zip(&self.q) {
            terms.push((1.0, arena.mul(slope, q)));
        }
        for (&symbol, &v) in model.v.iter().zip(&self.v) {
            let slope = arena.diff(of, symbol);
            terms.push((1.0, arena.mul(slope, v)));
        }
        arena.sum(0.0, &terms)
    }
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

//! The equations of a system at a node, for the Gauss rules: its force at a node as functions of
//! the node's position and momentum, and the derivatives in the parameters.
//!
//! Input: the derivatives of the model. Output: expressions in the model's own time, positions,
//! velocities and momenta. These do not depend on the number of stages; the runtime solves the
//! equations of the stages.

use std::collections::HashMap;

use super::node_bounds::{self, Uniqueness};
use crate::algebra::{Arena, Expr, Purpose, Symbol};
use crate::catalogue::{Options, Rule};
use crate::model::domain::{self, Condition};
use crate::model::{Meaning, Model, Symbols};
use crate::system::mechanics::Mechanics;

/// The equations at a node.
pub(crate) struct Stages {
    /// The model's symbols and the symbols of a node: its weight in time and its parts of the
    /// increments.
    pub(crate) symbols: Symbols,
    pub(crate) weight: Symbol,
    pub(crate) dw: Vec<Symbol>,
    /// The form that decides how stages can be solved by fixed-point iteration.
    pub(crate) form: Form,
    /// True if a noise moves positions. Displacements are then additional unknowns.
    pub(crate) moves_position: bool,
    /// The derivatives in each parameter.
    pub(crate) parameters: Vec<ParameterJet>,
    /// The number of solutions of a step, as far as it is known.
    pub(crate) uniqueness: Uniqueness,
}

/// Smallest number of stages for which a step is first solved by fixed-point iteration. With fewer
/// stages Newton's systems are small.
const STAGES_OF_FIXED_POINT: usize = 4;

impl Stages {
    /// Derives the bounds by which a step tests its solution. They are derived last, so that the
    /// order of terms in other expressions does not depend on them.
    pub(crate) fn bound(&mut self, model: &Model, mechanics: &Mechanics, arena: &mut Arena) {
        self.uniqueness = node_bounds::uniqueness(model, mechanics, &mut self.symbols, arena);
    }

    /// Returns the number of unknowns of `stages` stages: velocities, and displacements if they are
    /// additional unknowns.
    pub(crate) fn unknowns(&self, stages: usize, coordinates: usize) -> usize {
        stages * coordinates * if self.moves_position { 2 } else { 1 }
    }

    /// Returns whether a step of this many stages is first solved by fixed-point iteration. The
    /// generated code tells the runtime.
    pub(crate) fn has_fixed_point(&self, stages: usize) -> bool {
        stages >= STAGES_OF_FIXED_POINT && !matches!(self.form, Form::General)
    }

    /// Returns whether the size of a rule's steps can be adapted to a tolerance.
    pub(crate) fn has_adapted_steps(&self, rule: Rule, stages: usize) -> bool {
        rule.options == Options::NONE && self.has_fixed_point(stages)
    }
}

/// The form of a system for the fixed-point iteration of its stages.
pub(crate) enum Form {
    /// L = ½⟨v, Mv⟩ − V(t, q) with constant M; force and noises depend on time and position alone.
    SecondOrder {
        has_diagonal_mass: bool,
        impulse: Impulse,
    },
    /// ∂L/∂v = M(t, q) v + a(t, q).
    Partitioned {
        mass: Vec<Vec<Expr>>,
        is_diagonal: bool,
        /// a.
        offset: Vec<Expr>,
        impulse: Impulse,
        /// `Σ ∂G/∂p ω`, the contribution of noises to the displacement.
        shift: Vec<Expr>,
    },
    /// ∂L/∂v is not affine in v. Only Newton's method applies.
    General,
}

/// `w (∂L/∂q + F) − Σ (∂G/∂q − f) ω`, and the conditions under which it is defined.
pub(crate) struct Impulse {
    pub(crate) value: Vec<Expr>,
    pub(crate) domain: Vec<Condition<Expr>>,
}

/// Derivatives in a parameter, in the order of the runtime's `ParameterJet`.
pub(crate) struct ParameterJet {
    pub(crate) dq: Vec<Expr>,
    pub(crate) dv: Vec<Expr>,
    pub(crate) force: Vec<Expr>,
    /// Of `∂G/∂q − f` of each noise.
    pub(crate) noise_against: Vec<Vec<Expr>>,
    pub(crate) noise_dp: Vec<Vec<Expr>>,
}

/// Derives the equations at a node.
pub(crate) fn stages(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Stages {
    let mut symbols = model.symbols.clone();
    let weight = symbols.declare(Meaning::StepSize);
    let dw = symbols.declare_all(model.noises.len(), Meaning::Wiener);
    let parameters: Vec<Symbol> = symbols.parameters().collect();
    let jet = |&parameter| parameter_jet(parameter, model, mechanics, arena);
    let parameters = parameters.iter().map(jet).collect();
    let is_given = |e: &Expr| arena.constant_value(*e) != Some(0.0);
    let moves_position = mechanics.noises.iter().any(|g| g.dp.iter().any(is_given));
    Stages {
        form: form(model, mechanics, weight, &dw, arena),
        symbols,
        weight,
        dw,
        moves_position,
        parameters,
        uniqueness: Uniqueness::Unknown,
    }
}

fn parameter_jet(
    parameter: Symbol,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> ParameterJet {
    let noises = mechanics.noises.iter();
    let against: Vec<Vec<Expr>> = noises.map(|g| g.against(arena)).collect();
    let mut by = |list: &[Expr]| -> Vec<Expr> {
        let derivatives = list.iter().map(|&e| arena.diff(e, parameter));
        let mut derivatives: Vec<Expr> = derivatives.collect();
        arena.stabilise(Purpose::Values, derivatives.iter_mut().collect());
        derivatives
    };
    ParameterJet {
        dq: by(&mechanics.lagrangian.dq),
        dv: by(&mechanics.lagrangian.dv),
        force: by(model.force.as_deref().unwrap_or_default()),
        noise_against: against.iter().map(|row| by(row)).collect(),
        noise_dp: mechanics.noises.iter().map(|g| by(&g.dp)).collect(),
    }
}

fn form(
    model: &Model,
    mechanics: &Mechanics,
    weight: Symbol,
    dw: &[Symbol],
    arena: &mut Arena,
) -> Form {
    if !mechanics.affine_momentum {
        return Form::General;
    }
    let rest: HashMap<Symbol, Expr> = {
        let zero = arena.constant(0.0);
        model.v.iter().map(|&v| (v, zero)).collect()
    };
    let at_rest = |list: &[Expr], arena: &mut Arena| -> Vec<Expr> {
        list.iter().map(|&e| arena.substitute(e, &rest)).collect()
    };
    let lagrangian = &mechanics.lagrangian;
    let rows = lagrangian.dvv.iter();
    let mut mass: Vec<Vec<Expr>> = rows.map(|row| at_rest(row, arena)).collect();
    let mut offset = at_rest(&lagrangian.dv, arena);
    let mut impulse = impulse(model, mechanics, weight, dw, arena);
    let mut shift = shift(model, mechanics, dw, arena);
    let is_diagonal = mass
        .iter()
        .enumerate()
        .all(|(i, row)| (0..row.len()).all(|j| i == j || is_zero(row[j], arena)));
    let contains_any = |list: &[Expr], of: &[Symbol]| {
        list.iter()
            .any(|&e| of.iter().any(|&s| arena.contains(e, s)))
    };
    let moving = [&[model.time], model.q.as_slice()].concat();
    let has_constant_mass =
        !contains_any(&mass.concat(), &moving) && offset.iter().all(|&e| is_zero(e, arena));
    let conditions: Vec<Expr> = impulse.domain.iter().map(|c| c.value).collect();
    let depends_on_motion = [&impulse.value[..], &conditions]
        .iter()
        .any(|list| contains_any(list, &model.v) || contains_any(list, &model.p));
    let has_shift = shift.iter().any(|&e| !is_zero(e, arena));
    let exprs = impulse.value.iter_mut();
    let exprs = exprs.chain(impulse.domain.iter_mut().map(|c| &mut c.value));
    if has_constant_mass && !depends_on_motion && !has_shift {
        arena.stabilise(Purpose::Step, exprs.collect());
        return Form::SecondOrder {
            has_diagonal_mass: is_diagonal,
            impulse,
        };
    }
    let exprs = exprs.chain(mass.iter_mut().flatten()).chain(&mut offset);
    arena.stabilise(Purpose::Step, exprs.chain(&mut shift).collect());
    Form::Partitioned {
        mass,
        is_diagonal,
        offset,
        impulse,
        shift,
    }
}

fn is_zero(e: Expr, arena: &Arena) -> bool {
    arena.constant_value(e) == Some(0.0)
}

/// Returns `Σ ∂G/∂p ω`, the contribution of noises to the displacement.
fn shift(model: &Model, mechanics: &Mechanics, dw: &[Symbol], arena: &mut Arena) -> Vec<Expr> {
    let shift = (0..model.dof()).map(|k| {
        let terms = mechanics.noises.iter().zip(dw).map(|(noise, &dw)| {
            let dw = arena.symbol(dw);
            (1.0, arena.mul(noise.dp[k], dw))
        });
        let terms: Vec<(f64, Expr)> = terms.collect();
        arena.sum(0.0, &terms)
    });
    shift.collect()
}

fn impulse(
    model: &Model,
    mechanics: &Mechanics,
    weight: Symbol,
    dw: &[Symbol],
    arena: &mut Arena,
) -> Impulse {
    let noises = mechanics.noises.iter();
    let against: Vec<Vec<Expr>> = noises.map(|g| g.against(arena)).collect();
    let value = (0..model.dof()).map(|k| {
        let force = model.force.as_ref().map(|force| force[k]);
        let forces: Vec<(f64, Expr)> = [Some(mechanics.lagrangian.dq[k]), force]
            .into_iter()
            .flatten()
            .map(|e| (1.0, e))
            .collect();
        let (force, weight) = (arena.sum(0.0, &forces), arena.symbol(weight));
        let mut terms = vec![(1.0, arena.mul(weight, force))];
        for (against, &dw) in against.iter().zip(dw) {
            let dw = arena.symbol(dw);
            terms.push((-1.0, arena.mul(against[k], dw)));
        }
        arena.sum(0.0, &terms)
    });
    let value = value.collect();
    let noises = model.noises.iter().map(|noise| noise.hamiltonian);
    let mut roots: Vec<Expr> = noises.chain([model.lagrangian]).collect();
    roots.extend(model.forces().flatten());
    Impulse {
        value,
        domain: domain::conditions(&roots, arena),
    }
}

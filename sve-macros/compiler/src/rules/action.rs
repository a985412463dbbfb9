//! Rule → discrete action: the parts that all rules share.
//!
//! Input: the model. Output: `S_d` as an expression in the start `q₀`, the displacement
//! `d = q₁ − q₀`, the internal variables of the rule, the step size and the Wiener increments
//! (`docs/mathematics.md`, section 2). The displacement is the variable instead of q₁, so that a
//! small step does not cancel: `∂S_d/∂q₁ = ∂S/∂d` and `∂S_d/∂q₀ = ∂S/∂q₀ − ∂S/∂d`.

use std::collections::{BTreeSet, HashMap};

use super::constraints::{self, Enforced};
use super::correction::Correction;
use super::degenerate;
use super::discretisation;
use super::rotations::{NodePlace, RotationAtNode, values_at_nodes};
use super::weak2::Potential;
use crate::algebra::{Arena, Expr, Symbol};
use crate::catalogue::{Rule, RuleOption};
use crate::model::configuration::{Configuration, Factor};
use crate::model::domain::Condition;
use crate::model::{AtNode, Family, Meaning, Model, NodeQuantity, Quantity, Symbols, Unknown};
use crate::system::degeneracy::Degeneracy;

/// A discrete action with its variables.
pub(crate) struct Action {
    pub(crate) value: Expr,
    /// The action in the form that is differentiated. It also depends on the entries of rotations
    /// at the nodes, for which `value` has their values.
    pub(crate) varied: Expr,
    /// The rotations at the nodes.
    pub(crate) rotations: Vec<RotationAtNode>,
    pub(crate) h: Symbol,
    pub(crate) start_q: Vec<Symbol>,
    pub(crate) start_p: Vec<Symbol>,
    pub(crate) displacement: Vec<Symbol>,
    /// Variables in which the action is stationary.
    pub(crate) internal: Vec<Symbol>,
    pub(crate) work: Vec<Work>,
    /// The increments of noise forces that depend on velocities.
    pub(crate) dividing: Vec<Symbol>,
    /// The kinds of the entries of the start and of the components of the displacement.
    pub(crate) configuration: Configuration,
    pub(crate) ends: Ends,
    /// `½ κ` of the option `weak2`, if the action has its term.
    pub(crate) half_factor: Option<f64>,
    /// The contributions of constraints, if there are any.
    pub(crate) enforced: Option<Enforced>,
}

impl Action {
    /// Returns the rotations at nodes at the end of the step.
    pub(crate) fn turned(&self) -> impl Iterator<Item = &RotationAtNode> {
        let rotations = self.rotations.iter();
        rotations.filter(|rotation| rotation.place == NodePlace::End)
    }
}

/// Virtual work of a component of a force (Lagrange–d'Alembert): `impulse · δ place` is added to
/// δS.
pub(crate) struct Work {
    /// A component of F or of the force of a noise at a node, times its weight in time or its
    /// increment.
    pub(crate) impulse: Expr,
    pub(crate) place: Place,
}

/// The quantity that a component of the force moves.
#[derive(Clone, Copy)]
pub(crate) enum Place {
    /// A coordinate of the node, or a momentum.
    Coordinate(Expr),
    /// The rotation at the node of this number among those of the rule, which turns in a direction
    /// of the configuration, about an axis of the body.
    Turn { node: usize, direction: usize },
}

/// Conditions and equations at the two ends of a step beside the momentum balance of each
/// coordinate, `p₀ = −∂S_d/∂q₀`. Empty for regular Lagrangians.
#[derive(Default)]
pub(crate) struct Ends {
    /// For each coordinate, true if its momentum balance is left out since the action does not
    /// contain its displacement.
    pub(crate) unbalanced: Vec<bool>,
    /// For each coordinate, the p₀ in its momentum balance if this is a function of q₀ instead of
    /// the momentum of the state.
    pub(crate) start: Vec<Option<Expr>>,
    /// For each coordinate, p₁ if it is a function of q₁.
    pub(crate) end: Vec<Option<Expr>>,
    /// The symbols in `closures` that stand for `∂S_d/∂q₁`.
    pub(crate) momentum: Vec<Symbol>,
    /// Additional equations.
    pub(crate) closures: Vec<Closure>,
    /// Expressions that must not be negative at the start of the step.
    pub(crate) conditions: Vec<Expr>,
}

impl Ends {
    /// Returns the conditions on the start of the step.
    pub(crate) fn at_start(&self) -> impl Iterator<Item = Condition<Expr>> {
        self.conditions.iter().map(|&value| Condition {
            value,
            is_closed: true,
            text: value,
        })
    }
}

/// An equation at the end of the step, and the additional unknown that it determines.
pub(crate) struct Closure {
    pub(crate) unknown: Symbol,
    pub(crate) residual: Expr,
}

/// The discrete action of a rule, with its internal variables and the work of the force.
pub(crate) struct Discrete {
    pub(super) value: Expr,
    /// Variables in which the action is stationary.
    pub(super) internal: Vec<Symbol>,
    pub(super) work: Vec<Work>,
    pub(super) rotations: Vec<RotationAtNode>,
}

/// The variables that all rules share.
pub(crate) struct Variables<'a> {
    pub(super) arena: &'a mut Arena,
    pub(super) model: &'a Model,
    pub(super) symbols: &'a mut Symbols,
    pub(super) h: Symbol,
    pub(super) start_q: Vec<Symbol>,
    pub(super) start_p: Vec<Symbol>,
    pub(super) displacement: Vec<Symbol>,
    pub(super) dw: Vec<Symbol>,
    /// `½ κ` and `Σ_a K_a` of the option `weak2`.
    potential: Option<(f64, &'a Potential)>,
    /// The corrections of the noises with forces.
    pub(super) correction: &'a [Correction],
}

/// The terms of an action that are derived before it, from the system alone.
#[derive(Clone, Copy)]
pub(crate) struct Terms<'a> {
    /// The potential of the option `weak2` (`weak2::potential`).
    pub(crate) potential: Option<&'a Potential>,
    /// The corrections of the noises with forces (`correction::corrections`).
    pub(crate) correction: &'a [Correction],
}

impl Terms<'_> {
    pub(crate) const NONE: Self = Self {
        potential: None,
        correction: &[],
    };
}

/// Returns the discrete action of `rule`. If L does not determine every velocity, the action is the
/// one of `degeneracy`.
pub(crate) fn discretise(
    rule: Rule,
    model: &Model,
    degeneracy: Option<&Degeneracy>,
    Terms {
        potential,
        correction,
    }: Terms<'_>,
    symbols: &mut Symbols,
    arena: &mut Arena,
) -> Action {
    let n = model.dof();
    let h = symbols.declare(Meaning::StepSize);
    let entries = model.configuration().entries();
    let start_q = symbols.declare_all(entries, |i| Meaning::Start(Quantity::Position, i));
    let start_p = symbols.declare_all(n, |i| Meaning::Start(Quantity::Momentum, i));
    let displacement = symbols.declare_all(n, Unknown::of(Family::Displacement));
    let dw = symbols.declare_all(model.noises.len(), Meaning::Wiener);
    let term = rule
        .weak2()
        .filter(|_| rule.options.contain(RuleOption::Weak2));
    let potential = term.map(|term| 0.5 * term.factor).zip(potential);
    let mut variables = Variables {
        arena,
        model,
        symbols,
        h,
        start_q,
        start_p,
        displacement,
        dw,
        potential,
        correction,
    };
    let (discrete, ends) = match (degeneracy, rule.node()) {
        (Some(degeneracy), Some(node)) => degenerate::action(node, degeneracy, &mut variables),
        _ => (discretisation(rule).action(&mut variables), Ends::default()),
    };
    let action = variables.action(discrete, ends);
    constraints::enforce(action, model, symbols, arena)
}

impl Variables<'_> {
    /// Returns the action without constraints.
    fn action(self, discrete: Discrete, ends: Ends) -> Action {
        let varied = discrete.value;
        let value = if discrete.rotations.is_empty() {
            varied
        } else {
            let values = values_at_nodes(&discrete.rotations);
            self.arena.substitute(varied, &values)
        };
        let dividing = self.dividing();
        Action {
            value,
            varied,
            rotations: discrete.rotations,
            h: self.h,
            start_q: self.start_q,
            start_p: self.start_p,
            displacement: self.displacement,
            internal: discrete.internal,
            work: discrete.work,
            dividing,
            configuration: self.model.configuration().clone(),
            ends,
            half_factor: self.potential.map(|(half_factor, _)| half_factor),
            enforced: None,
        }
    }

    /// Returns the increments of noise forces that depend on velocities.
    fn dividing(&self) -> Vec<Symbol> {
        let mut dividing = Vec::new();
        for (noise, &dw) in self.model.noises.iter().zip(&self.dw) {
            let mut force = noise.force.iter();
            dividing.extend(
                force
                    .any(|f| self.model.reads_velocity(f, self.arena))
                    .then_some(dw),
            );
        }
        dividing
    }

    /// Returns an intermediate result for a quantity at a node.
    pub(super) fn at_node(&mut self, node: usize, quantity: NodeQuantity, value: Expr) -> Expr {
        let identity = AtNode { node, quantity }.identity();
        self.arena.intermediate(value, Some(identity))
    }

    /// Returns `h L` at a node, minus `½ κ h |h| Σ_a K_a` with the option `weak2`. Every rule sums
    /// this term over its nodes.
    pub(super) fn lagrangian(&mut self, node: &HashMap<Symbol, Expr>) -> Expr {
        let h = self.arena.symbol(self.h);
        let lagrangian = self.arena.substitute(self.model.lagrangian, node);
        let action = self.arena.mul(h, lagrangian);
        match self.weak2(node) {
            Some(term) => self.arena.sum(0.0, &[(1.0, action), term]),
            None => action,
        }
    }

    /// Returns the term `− ½ κ h |h| Σ_a K_a` at a node with the option `weak2`, as a factor and an
    /// expression.
    pub(super) fn weak2(&mut self, node: &HashMap<Symbol, Expr>) -> Option<(f64, Expr)> {
        let (half_factor, potential) = self.potential?;
        if self.arena.constant_value(potential.value).is_some() {
            return None;
        }
        let potential = self.potential_at(potential, node);
        let h = self.arena.symbol(self.h);
        let size = self.arena.abs(h);
        let term = self.arena.product(&[(h, 1), (size, 1), (potential, 1)]);
        Some((-half_factor, term))
    }

    /// Returns `Σ_a K_a` at a node, with its derivatives by the chain rule.
    fn potential_at(&mut self, potential: &Potential, node: &HashMap<Symbol, Expr>) -> Expr {
        let value = self.arena.substitute(potential.value, node);
        let value = self.arena.opaque(value);
        let Some(gradient) = &potential.gradient else {
            return value;
        };
        let gradient = self.arena.substitute_all(gradient, node);
        let time = node.get(&self.model.time).copied();
        let positions: Vec<Expr> = self.model.q.iter().map(|q| node[q]).collect();
        let symbols = positions.iter().flat_map(|&q| self.arena.symbols_of(q));
        let moves_only_positions = |&symbol: &Symbol| {
            let others = time.into_iter().chain([potential.value]);
            others.into_iter().all(|e| !self.arena.contains(e, symbol))
        };
        let symbols: BTreeSet<Symbol> = symbols.filter(moves_only_positions).collect();
        for symbol in symbols {
            let mut terms = Vec::new();
            for (&slope, &q) in gradient.iter().zip(&positions) {
                let rate = self.arena.diff(q, symbol);
                terms.push((1.0, self.arena.mul(slope, rate)));
            }
            let derivative = self.arena.sum(0.0, &terms);
            self.arena.record_derivative(value, symbol, derivative);
        }
        value
    }

    /// Returns the term `p (d − h v)` of a coordinate, by which its displacement is h times its
    /// velocity.
    pub(super) fn displaced(&mut self, i: usize, v: Symbol, p: Symbol) -> (f64, Expr) {
        let [h, d, v, p] = [self.h, self.displacement[i], v, p].map(|s| self.arena.symbol(s));
        let hv = self.arena.mul(h, v);
        let constraint = self.arena.sub(d, hv);
        (1.0, self.arena.mul(p, constraint))
    }

    /// Returns the terms `− part G_a ΔW_a` at a node.
    pub(super) fn noises(&mut self, part: f64, node: &HashMap<Symbol, Expr>) -> Vec<(f64, Expr)> {
        let mut terms = Vec::new();
        for (noise, &dw) in self.model.noises.iter().zip(&self.dw) {
            let g = self.arena.substitute(noise.hamiltonian, node);
            let dw = self.arena.symbol(dw);
            terms.push((-part, self.arena.mul(g, dw)));
        }
        terms
    }

    /// Returns the work of all forces at a node, for a part of the step: `h F`, the forces of
    /// noises times their increments, and that of the option `weak2`. `number` is that of the node.
    pub(super) fn work(
        &mut self,
        part: f64,
        number: usize,
        node: &HashMap<Symbol, Expr>,
    ) -> Vec<Work> {
        let model = self.model;
        let mut work = Vec::new();
        if let Some(force) = &model.force {
            let h = self.arena.symbol(self.h);
            work.extend(self.work_of(force, part, h, number, node));
        }
        for (at, noise) in model.noises.iter().enumerate() {
            if let Some(force) = &noise.force {
                let dw = self.arena.symbol(self.dw[at]);
                work.extend(self.work_of(force, part, dw, number, node));
            }
        }
        if let Some((half_factor, potential)) = self.potential
            && let Some(push) = &potential.push
        {
            let h = self.arena.symbol(self.h);
            let size = self.arena.abs(h);
            let duration = self.arena.mul(h, size);
            let part = 2.0 * half_factor * part;
            work.extend(self.work_of(push, part, duration, number, node));
        }
        work
    }

    /// Returns the work of a force with the impulse `part · duration · force` at a node.
    fn work_of(
        &mut self,
        force: &[Expr],
        part: f64,
        duration: Expr,
        number: usize,
        node: &HashMap<Symbol, Expr>,
    ) -> Vec<Work> {
        let mut work = Vec::new();
        for block in self.model.configuration().blocks() {
            let entries = &self.model.q[block.entries];
            for (k, direction) in block.directions.enumerate() {
                let f = self.arena.substitute(force[direction], node);
                let impulse = self.arena.mul(duration, f);
                let impulse = self.arena.scale(part, impulse);
                let place = match block.factor {
                    Factor::Vector(_) => Place::Coordinate(node[&entries[k]]),
                    Factor::Rotation => Place::Turn {
                        node: number,
                        direction,
                    },
                };
                work.push(Work { impulse, place });
            }
        }
        work
    }
}

//! Model → the derivatives of L, the noises and the force, which the runtime needs beside the
//! steps.

use super::drag::Drag;
use super::inverse_mass::{self, NoFormula};
use crate::algebra::{Arena, Expr, Purpose, Symbol};
use crate::model::{Constraint, Model, NoiseTerm};

/// Derivatives of the Lagrangian, in the order of the runtime's `LagrangianJet`.
#[derive(Clone)]
pub(crate) struct LagrangianJet {
    pub(crate) value: Expr,
    pub(crate) dq: Vec<Expr>,
    pub(crate) dv: Vec<Expr>,
    pub(crate) dqq: Vec<Vec<Expr>>,
    pub(crate) dqv: Vec<Vec<Expr>>,
    pub(crate) dvv: Vec<Vec<Expr>>,
    pub(crate) dqt: Vec<Expr>,
    pub(crate) dvt: Vec<Expr>,
}

/// Derivatives of a noise, those of its Hamiltonian in the order of the runtime's `NoiseJet`.
#[derive(Clone)]
pub(crate) struct NoiseJet {
    pub(crate) dq: Vec<Expr>,
    pub(crate) dp: Vec<Expr>,
    pub(crate) dqq: Vec<Vec<Expr>>,
    pub(crate) dqp: Vec<Vec<Expr>>,
    pub(crate) dpp: Vec<Vec<Expr>>,
    /// f, if the noise has a force.
    pub(crate) force: Option<ForceJet>,
    /// True if f depends on velocities.
    pub(crate) reads_velocity: bool,
}

/// A force with its derivatives, in the order of the runtime's `ForceJet`.
#[derive(Clone)]
pub(crate) struct ForceJet {
    pub(crate) value: Vec<Expr>,
    pub(crate) dq: Vec<Vec<Expr>>,
    pub(crate) dv: Vec<Vec<Expr>>,
    pub(crate) dt: Vec<Expr>,
}

/// A constraint with its derivatives, in the order of the runtime's `ConstraintJet`.
#[derive(Clone)]
pub(crate) struct ConstraintJet {
    pub(crate) value: Expr,
    /// The magnitude to which rounding errors of φ are relative.
    pub(crate) magnitude: Expr,
    pub(crate) dt: Expr,
    pub(crate) dq: Vec<Expr>,
}

impl LagrangianJet {
    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self {
            value,
            dq,
            dv,
            dqq,
            dqv,
            dvv,
            dqt,
            dvt,
        } = self;
        let vectors = [dq, dv, dqt, dvt].into_iter().flatten();
        let matrices = [dqq, dqv, dvv].into_iter().flatten().flatten();
        std::iter::once(value)
            .chain(vectors)
            .chain(matrices)
            .collect()
    }
}

impl NoiseJet {
    /// Returns `∂G/∂q − f`, the negative of the rate of the momentum.
    pub(crate) fn against(&self, arena: &mut Arena) -> Vec<Expr> {
        match &self.force {
            Some(force) => less(&self.dq, &force.value, arena),
            None => self.dq.clone(),
        }
    }

    /// Returns whether the noise moves momenta alone, by an amount that depends on t and q.
    pub(crate) fn is_of_positions(&self, arena: &Arena) -> bool {
        let is_zero = |&e: &Expr| arena.constant_value(e) == Some(0.0);
        self.dp.iter().all(is_zero) && !self.reads_velocity
    }

    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self {
            dq,
            dp,
            dqq,
            dqp,
            dpp,
            force,
            reads_velocity: _,
        } = self;
        let matrices = [dqq, dqp, dpp].into_iter().flatten().flatten();
        let force = force.iter_mut().flat_map(ForceJet::exprs);
        let vectors = [dq, dp].into_iter().flatten();
        vectors.chain(matrices).chain(force).collect()
    }
}

impl ConstraintJet {
    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self {
            value,
            magnitude,
            dt,
            dq,
        } = self;
        [value, magnitude, dt].into_iter().chain(dq).collect()
    }
}

impl ForceJet {
    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self { value, dq, dv, dt } = self;
        let matrices = [dq, dv].into_iter().flatten().flatten();
        [value, dt].into_iter().flatten().chain(matrices).collect()
    }
}

/// The derivatives and properties of a model.
#[derive(Clone)]
pub(crate) struct Mechanics {
    pub(crate) lagrangian: LagrangianJet,
    pub(crate) noises: Vec<NoiseJet>,
    pub(crate) force: Option<ForceJet>,
    pub(crate) constraints: Vec<ConstraintJet>,
    /// True if `∂L/∂v` is affine in v.
    pub(crate) affine_momentum: bool,
    /// True if L = T(v) − V(t, q).
    pub(crate) is_separable: bool,
    /// True if the noises are additive: γ's that are linear in q and constant forces, with constant
    /// masses. They may depend on time.
    pub(crate) is_additive: bool,
    /// The forces of velocities, for additive noises.
    pub(crate) drag: Drag,
}

/// Differentiates the model.
pub(crate) fn mechanics(model: &Model, arena: &mut Arena) -> Mechanics {
    let l = model.lagrangian;
    let dq = model.gradient(l, arena);
    let dv = gradient(arena, l, &model.v);
    let dvv = hessian(arena, &dv, &model.v);
    let lagrangian = LagrangianJet {
        value: l,
        dqq: gradients(arena, &dq, model),
        dqv: hessian(arena, &dq, &model.v),
        dqt: gradient_in(arena, &dq, model.time),
        dvt: gradient_in(arena, &dv, model.time),
        dq,
        dv,
        dvv,
    };
    let affine_momentum = lagrangian.dvv.iter().flatten().all(|&entry| {
        let constant = arena.constant_value(entry).is_some();
        constant
            || arena.is_exhausted()
            || model.v.iter().all(|&v| {
                if !arena.contains(entry, v) {
                    return true;
                }
                let change = arena.diff(entry, v);
                arena.is_zero(change)
            })
    });
    let mixed = lagrangian.dqv.iter().flatten().chain(&lagrangian.dvt);
    let is_separable =
        mixed.copied().all(|entry| arena.is_zero(entry)) && !model.configuration().has_rotations();
    let noises = model
        .noises
        .iter()
        .map(|noise| noise_jet(noise, model, arena))
        .collect::<Vec<_>>();
    let is_free = |entry: Expr| {
        let mut state = model.q.iter().chain(&model.v).chain(&model.p);
        !state.any(|&s| arena.contains(entry, s))
    };
    let masses = lagrangian.dvv.iter().flatten().copied();
    let kicks = noises.iter().flat_map(|noise| {
        let force = noise.force.iter().flat_map(|force| &force.value);
        noise.dq.iter().chain(force).copied()
    });
    let mut shifts = noises.iter().flat_map(|noise| noise.dp.iter().copied());
    let is_additive = masses.chain(kicks).all(is_free)
        && shifts.all(|shift| arena.constant_value(shift) == Some(0.0))
        // the momentum of a body turns with its velocity
        && !model.configuration().has_rotations()
        // the constraint force of an additive noise depends on the configuration
        && model.constraints.is_empty();
    let force = model.force.as_ref();
    let force = force.map(|force| force_jet(force, model, arena));
    let drag = if is_additive {
        Drag::of(model, &lagrangian, force.as_ref(), arena)
    } else {
        Drag::Nonlinear
    };
    let constraints = model
        .constraints
        .iter()
        .map(|constraint| constraint_jet(constraint, model, arena))
        .collect();
    Mechanics {
        lagrangian,
        noises,
        force,
        constraints,
        affine_momentum,
        is_separable,
        is_additive,
        drag,
    }
}

impl Mechanics {
    /// Returns the derivatives with one more noise.
    pub(crate) fn with_noise(&self, noise: NoiseJet) -> Self {
        let mut mechanics = self.clone();
        mechanics.noises.push(noise);
        mechanics
    }

    /// Returns the change of the velocity, `M⁻¹ (δp − L_vq δq)`, for a change of (q, p). Entries of
    /// large blocks of M must not depend on the symbols `moving`.
    pub(crate) fn velocity_along(
        &self,
        [dq, dp]: [&[Expr]; 2],
        moving: &[Symbol],
        arena: &mut Arena,
    ) -> Result<Vec<Expr>, NoFormula> {
        let lagrangian = &self.lagrangian;
        let mut rhs = Vec::with_capacity(dp.len());
        for (i, &dp) in dp.iter().enumerate() {
            let mut terms = vec![(1.0, dp)];
            for (row, &dq) in lagrangian.dqv.iter().zip(dq) {
                terms.push((-1.0, arena.mul(row[i], dq)));
            }
            rhs.push(arena.sum(0.0, &terms));
        }
        inverse_mass::solve(&lagrangian.dvv, &rhs, moving, arena)
    }

    /// Returns the derivatives in forms that are stable in floating-point arithmetic.
    pub(crate) fn stabilised(&self, arena: &mut Arena) -> Self {
        let mut mechanics = self.clone();
        mechanics.stabilise(arena);
        mechanics
    }

    fn stabilise(&mut self, arena: &mut Arena) {
        let jets = self.noises.iter_mut().flat_map(NoiseJet::exprs);
        let force = self.force.iter_mut().flat_map(ForceJet::exprs);
        let constraints = self.constraints.iter_mut().flat_map(ConstraintJet::exprs);
        let exprs = self.lagrangian.exprs().into_iter().chain(jets).chain(force);
        let exprs = exprs.chain(constraints);
        arena.stabilise(Purpose::Values, exprs.collect());
    }
}

/// Differentiates a noise.
pub(crate) fn noise_jet(noise: &NoiseTerm, model: &Model, arena: &mut Arena) -> NoiseJet {
    let dq = model.gradient(noise.hamiltonian, arena);
    let dp = gradient(arena, noise.hamiltonian, &model.p);
    noise_jet_of([dq, dp], noise.force.as_deref(), model, arena)
}

/// Returns the derivatives of a noise from the gradient of its Hamiltonian.
pub(crate) fn noise_jet_of(
    [dq, dp]: [Vec<Expr>; 2],
    force: Option<&[Expr]>,
    model: &Model,
    arena: &mut Arena,
) -> NoiseJet {
    NoiseJet {
        dqq: gradients(arena, &dq, model),
        dqp: hessian(arena, &dq, &model.p),
        dpp: hessian(arena, &dp, &model.p),
        reads_velocity: force.is_some_and(|force| model.reads_velocity(force, arena)),
        force: force.map(|force| force_jet(force, model, arena)),
        dq,
        dp,
    }
}

fn force_jet(force: &[Expr], model: &Model, arena: &mut Arena) -> ForceJet {
    ForceJet {
        dq: gradients(arena, force, model),
        dv: hessian(arena, force, &model.v),
        dt: gradient_in(arena, force, model.time),
        value: force.to_vec(),
    }
}

/// Returns `a − b`, entry by entry.
pub(crate) fn less(a: &[Expr], b: &[Expr], arena: &mut Arena) -> Vec<Expr> {
    a.iter().zip(b).map(|(&a, &b)| arena.sub(a, b)).collect()
}

fn constraint_jet(constraint: &Constraint, model: &Model, arena: &mut Arena) -> ConstraintJet {
    ConstraintJet {
        value: constraint.value,
        magnitude: model.magnitude(constraint.value, arena),
        dt: arena.diff(constraint.value, model.time),
        dq: gradient(arena, constraint.value, &model.q),
    }
}

fn gradient(arena: &mut Arena, expr: Expr, symbols: &[Symbol]) -> Vec<Expr> {
    symbols.iter().map(|&s| arena.diff(expr, s)).collect()
}

fn gradient_in(arena: &mut Arena, exprs: &[Expr], symbol: Symbol) -> Vec<Expr> {
    exprs.iter().map(|&e| arena.diff(e, symbol)).collect()
}

/// Returns the derivatives of each expression in the directions of the configuration.
fn gradients(arena: &mut Arena, exprs: &[Expr], model: &Model) -> Vec<Vec<Expr>> {
    exprs.iter().map(|&e| model.gradient(e, arena)).collect()
}

fn hessian(arena: &mut Arena, gradient: &[Expr], symbols: &[Symbol]) -> Vec<Vec<Expr>> {
    gradient
        .iter()
        .map(|&g| self::gradient(arena, g, symbols))
        .collect()
}

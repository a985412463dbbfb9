//! Model → the derivatives of L, the noises and the force, which the runtime needs beside the
//! steps.

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

/// Derivatives of a noise Hamiltonian, in the order of the runtime's `NoiseJet`.
#[derive(Clone)]
pub(crate) struct NoiseJet {
    pub(crate) dq: Vec<Expr>,
    pub(crate) dp: Vec<Expr>,
    pub(crate) dqq: Vec<Vec<Expr>>,
    pub(crate) dqp: Vec<Vec<Expr>>,
    pub(crate) dpp: Vec<Vec<Expr>>,
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
    fn exprs(&mut self) -> Vec<&mut Expr> {
        let Self {
            dq,
            dp,
            dqq,
            dqp,
            dpp,
        } = self;
        let matrices = [dqq, dqp, dpp].into_iter().flatten().flatten();
        [dq, dp].into_iter().flatten().chain(matrices).collect()
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
    /// True if the noises are additive: γ's that are linear in q, with constant masses. The γ's may
    /// depend on time.
    pub(crate) is_additive: bool,
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
    let kicks = noises.iter().flat_map(|noise| noise.dq.iter().copied());
    let mut shifts = noises.iter().flat_map(|noise| noise.dp.iter().copied());
    let is_additive = masses.chain(kicks).all(is_free)
        && shifts.all(|shift| arena.constant_value(shift) == Some(0.0))
        // the constraint force of an additive noise depends on the configuration
        && model.constraints.is_empty();
    let force = model.force.as_ref().map(|force| ForceJet {
        dq: gradients(arena, force, model),
        dv: hessian(arena, force, &model.v),
        dt: gradient_in(arena, force, model.time),
        value: force.clone(),
    });
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
    }
}

impl Mechanics {
    /// Returns the derivatives with one more noise Hamiltonian.
    pub(crate) fn with_noise(&self, noise: NoiseJet) -> Self {
        let mut mechanics = self.clone();
        mechanics.noises.push(noise);
        mechanics
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

/// Differentiates a noise Hamiltonian.
pub(crate) fn noise_jet(noise: &NoiseTerm, model: &Model, arena: &mut Arena) -> NoiseJet {
    let dq = model.gradient(noise.hamiltonian, arena);
    let dp = gradient(arena, noise.hamiltonian, &model.p);
    noise_jet_of(dq, dp, model, arena)
}

/// Returns the derivatives of a noise Hamiltonian from its gradient.
pub(crate) fn noise_jet_of(
    dq: Vec<Expr>,
    dp: Vec<Expr>,
    model: &Model,
    arena: &mut Arena,
) -> NoiseJet {
    NoiseJet {
        dqq: gradients(arena, &dq, model),
        dqp: hessian(arena, &dq, &model.p),
        dpp: hessian(arena, &dp, &model.p),
        dq,
        dp,
    }
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

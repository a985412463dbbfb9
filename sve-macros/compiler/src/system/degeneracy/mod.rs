//! Classification of Lagrangians whose momenta ∂L/∂v do not determine every velocity.
//!
//! Input: the model with its derivatives. Output: `None` for a regular L; for a degenerate one the
//! role of each coordinate, and the one-form α of the coordinates whose velocities are linear in L;
//! or an error that says why L does not determine the motion.
//!
//! ```text
//! L = L₀(t, q, v_massive) + ⟨α(q), v_massless⟩        ω = Dαᵀ − Dα,  ω_ij = ∂_iα_j − ∂_jα_i
//! ```
//!
//! A massless coordinate is part of a pair on which ω is regular; its momentum is a function of the
//! configuration, p = α(q). A coordinate is algebraic if its velocity is absent and α does not
//! depend on it; it follows from 0 = ∂L/∂q. As elsewhere, the algebra and evaluations at random
//! points decide whether derivatives vanish and matrices are regular.

pub(crate) mod brackets;
mod internal;
mod refused;

use std::collections::HashMap;

use crate::algebra::{Arena, Expr, Sharp, Symbol, Vanishing};
use crate::model::Model;
use crate::syntax::parse::Annotated;
use crate::system::mechanics::Mechanics;
use crate::system::regular;
pub(crate) use internal::Internal;
use refused::Refused;

/// The way in which the velocity of a coordinate occurs in L.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    /// Quadratically or in another way in which the momentum determines the velocity.
    Massive,
    /// Linearly. The momentum is a function of the configuration, and ω is regular on the massless
    /// coordinates.
    Massless,
    /// Not at all. The coordinate follows from the others by 0 = ∂L/∂q.
    Algebraic,
}

/// The parts of a degenerate Lagrangian.
#[derive(Clone)]
pub(crate) struct Degeneracy {
    /// The role of each coordinate.
    pub(crate) roles: Vec<Role>,
    /// L₀: the Lagrangian in which the velocities of massless and algebraic coordinates are zero.
    pub(crate) rest: Expr,
    /// The one-form α: the momentum of each massless coordinate as a function of q, and 0 for the
    /// other coordinates.
    pub(crate) alpha: Vec<Expr>,
    /// `∂_iα_j`; i counts the rows.
    pub(crate) slopes: Vec<Vec<Expr>>,
    /// ω, `ω_ij = ∂_iα_j − ∂_jα_i`, on all coordinates.
    pub(crate) two_form: Vec<Vec<Expr>>,
    /// ∂L₀/∂q.
    pub(crate) rest_slopes: Vec<Expr>,
    /// True if α is affine in q.
    pub(crate) is_affine: bool,
    /// The form in which half of the velocities do not occur, if α has it and no coordinate is
    /// massive.
    pub(crate) internal: Option<Internal>,
}

/// The form of a step of a degenerate system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Form {
    /// All degenerate coordinates are algebraic. The step is a step of the Lagrangian from which
    /// they are eliminated.
    Eliminated,
    /// α is affine: the discrete Euler–Lagrange equations keep p = α(q).
    Plain,
    /// Half of the coordinates are variables of the node.
    Internal,
    /// Both ends are shifted by the same multiplier along the field of p − α(q).
    Projected,
}

impl Degeneracy {
    /// Returns whether a coordinate has this role.
    pub(crate) fn is(&self, i: usize, role: Role) -> bool {
        self.roles[i] == role
    }

    /// Returns the coordinates of a role, ascending.
    pub(crate) fn of(&self, role: Role) -> Vec<usize> {
        (0..self.roles.len())
            .filter(|&i| self.is(i, role))
            .collect()
    }

    /// Returns the form of the step of a one-node rule. Rules whose node is not in the middle need
    /// the internal form.
    pub(crate) fn form(&self, is_midpoint: bool) -> Form {
        if self.of(Role::Massless).is_empty() {
            Form::Eliminated
        } else if self.is_affine && is_midpoint {
            Form::Plain
        } else if self.internal.is_some() {
            Form::Internal
        } else {
            Form::Projected
        }
    }

    /// Returns whether the step conserves the momentum of an affine symmetry to rounding. The
    /// action of the step must have the symmetry.
    pub(crate) fn keeps_momentum(
        &self,
        generator: &[Expr],
        is_midpoint: bool,
        model: &Model,
        arena: &Arena,
    ) -> bool {
        // the node of an inner coordinate moves independently of the nodes of the other coordinates
        let is_free = |i: usize, inner: &[usize]| {
            let mut inner = inner.iter();
            inner.all(|&j| !arena.contains(generator[i], model.q[j]))
        };
        match (self.form(is_midpoint), &self.internal) {
            (Form::Plain, _) => true,
            (Form::Internal, Some(form)) => {
                let has_gauge = form
                    .inner
                    .iter()
                    .any(|&j| arena.constant_value(self.alpha[j]) != Some(0.0));
                !has_gauge && form.outer.iter().all(|&i| is_free(i, &form.inner))
            }
            (Form::Eliminated, _) => {
                let (massive, inner) = (self.of(Role::Massive), self.of(Role::Algebraic));
                massive.into_iter().all(|i| is_free(i, &inner))
            }
            // a translation moves the node and both ends by the same amount, whatever the
            // multiplier
            _ => {
                let all: Vec<usize> = (0..generator.len()).collect();
                all.iter().all(|&i| is_free(i, &all))
            }
        }
    }
}

/// Classifies the Lagrangian. Returns `None` if it is regular.
pub(crate) fn classify(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> syn::Result<Option<Degeneracy>> {
    let Err(undetermined) = regular::check(model, mechanics, arena) else {
        return Ok(None);
    };
    // all velocities of a rotation have kinetic energy
    if !undetermined.is_certain || model.configuration().has_rotations() {
        return Err(undetermined.error(block, model.dof(), ""));
    }
    let taken = taken_apart(model, mechanics, arena);
    taken
        .map(Some)
        .map_err(|refused| refused.error(block, model.dof(), &undetermined))
}

/// Takes the Lagrangian apart into its massive, massless and algebraic coordinates.
fn taken_apart(
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Result<Degeneracy, Refused> {
    let n = model.dof();
    let (light, massive) = by_mass(mechanics, n, arena)?;
    let alpha = momenta_at_rest(&light, model, mechanics, arena);
    // ∂_iα_j
    let slopes: Vec<Vec<Expr>> = model
        .q
        .iter()
        .map(|&q| alpha.iter().map(|&a| arena.diff(a, q)).collect())
        .collect();
    let zero = arena.constant(0.0);
    let is_free = |i: &usize, arena: &Arena| {
        alpha[*i] == zero && light.iter().all(|&j| arena.is_zero(slopes[*i][j]))
    };
    let (algebraic, paired): (Vec<usize>, Vec<usize>) =
        light.iter().partition(|&i| is_free(i, arena));
    let still = light.iter().map(|&i| (model.v[i], zero)).collect();
    let rest = arena.substitute(model.lagrangian, &still);
    check_algebraic(&algebraic, &massive, rest, model, arena)?;
    if massive.is_empty() && paired.is_empty() {
        return Err(Refused::Undetermined(light));
    }
    let two_form = two_form(&slopes, arena);
    check_paired(&paired, &alpha, &two_form, model, arena)?;
    let rest_slopes = model.q.iter().map(|&q| arena.diff(rest, q)).collect();
    let mut entries = slopes.iter().flatten();
    let is_affine = entries.all(|&e| is_constant(e, model, arena));
    let internal = massive
        .is_empty()
        .then(|| internal::find(&alpha, &paired, model, arena))
        .flatten();
    let mut roles = vec![Role::Massive; n];
    for &i in &paired {
        roles[i] = Role::Massless;
    }
    for &i in &algebraic {
        roles[i] = Role::Algebraic;
    }
    Ok(Degeneracy {
        roles,
        rest,
        alpha,
        slopes,
        two_form,
        rest_slopes,
        is_affine,
        internal,
    })
}

/// Returns the coordinates whose row of ∂²L/∂v² vanishes, and the others, whose block is regular.
fn by_mass(
    mechanics: &Mechanics,
    n: usize,
    arena: &Arena,
) -> Result<(Vec<usize>, Vec<usize>), Refused> {
    let mass = &mechanics.lagrangian.dvv;
    let vanishes = |&e: &Expr| {
        let vanishing = arena.vanishing(e);
        matches!(vanishing, Some(Vanishing::Proved | Vanishing::Evaluated))
    };
    let (light, massive): (Vec<usize>, Vec<usize>) =
        (0..n).partition(|&i| mass[i].iter().all(vanishes));
    if light.is_empty() || !is_regular(mass, &massive, arena) {
        return Err(Refused::NoSplit);
    }
    Ok((light, massive))
}

/// Returns α(q): ∂L/∂v at rest for coordinates without mass, zero for the others.
fn momenta_at_rest(
    light: &[usize],
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> Vec<Expr> {
    let zero = arena.constant(0.0);
    let at_rest: HashMap<Symbol, Expr> = model.v.iter().map(|&v| (v, zero)).collect();
    let mut alpha = vec![zero; model.dof()];
    for &i in light {
        let momentum = arena.substitute(mechanics.lagrangian.dv[i], &at_rest);
        if !arena.is_zero(momentum) {
            alpha[i] = momentum;
        }
    }
    alpha
}

/// Checks that the momenta of paired coordinates do not depend on time, and that their two-form is
/// regular.
fn check_paired(
    paired: &[usize],
    alpha: &[Expr],
    two_form: &[Vec<Expr>],
    model: &Model,
    arena: &mut Arena,
) -> Result<(), Refused> {
    let depends_on_time = |&i: &usize| arena.contains(alpha[i], model.time);
    if let Some(i) = paired.iter().copied().find(depends_on_time) {
        return Err(Refused::TimeDependent(i));
    }
    match null_columns(&part(two_form, paired), arena) {
        Some(columns) => Err(Refused::SingularForm(
            columns.into_iter().map(|k| paired[k]).collect(),
        )),
        None => Ok(()),
    }
}

/// Checks that the equations 0 = ∂L/∂q determine the algebraic coordinates and contain no
/// velocities.
fn check_algebraic(
    algebraic: &[usize],
    massive: &[usize],
    rest: Expr,
    model: &Model,
    arena: &mut Arena,
) -> Result<(), Refused> {
    let mut hessian = Vec::new();
    for &i in algebraic {
        let slope = arena.diff(rest, model.q[i]);
        for &j in massive {
            let mixed = arena.diff(slope, model.v[j]);
            if !arena.is_zero(mixed) {
                return Err(Refused::WithVelocity(i));
            }
        }
        let row = algebraic.iter().map(|&j| arena.diff(slope, model.q[j]));
        hessian.push(row.collect::<Vec<_>>());
        for noise in &model.noises {
            let slopes = [model.q[i], model.p[i]].map(|s| arena.diff(noise.hamiltonian, s));
            if !slopes.iter().all(|&slope| arena.is_zero(slope)) {
                return Err(Refused::NoisyAlgebraic(i, noise.name.clone()));
            }
        }
    }
    let all: Vec<usize> = (0..algebraic.len()).collect();
    if is_regular(&hessian, &all, arena) {
        return Ok(());
    }
    let multipliers = multipliers(algebraic, massive, &hessian, rest, model, arena);
    Err(if multipliers.is_empty() {
        Refused::Undetermined(algebraic.to_vec())
    } else {
        Refused::Multipliers(multipliers)
    })
}

/// Returns the algebraic coordinates in which L is linear, with a factor that depends on massive
/// coordinates. `hessian` is the Hessian of L in the algebraic coordinates.
fn multipliers(
    algebraic: &[usize],
    massive: &[usize],
    hessian: &[Vec<Expr>],
    rest: Expr,
    model: &Model,
    arena: &mut Arena,
) -> Vec<usize> {
    let mut found = Vec::new();
    for (&i, row) in algebraic.iter().zip(hessian) {
        let factor = arena.diff(rest, model.q[i]);
        let slopes: Vec<Expr> = massive
            .iter()
            .map(|&j| arena.diff(factor, model.q[j]))
            .collect();
        if row.iter().all(|&e| arena.is_zero(e)) && !slopes.iter().all(|&e| arena.is_zero(e)) {
            found.push(i);
        }
    }
    found
}

/// Returns ω, `ω_ij = ∂_iα_j − ∂_jα_i`, from the slopes `∂_iα_j`.
fn two_form(slopes: &[Vec<Expr>], arena: &mut Arena) -> Vec<Vec<Expr>> {
    let n = slopes.len();
    let mut form = Vec::new();
    for i in 0..n {
        let entry = |j: usize| arena.sub(slopes[i][j], slopes[j][i]);
        form.push((0..n).map(entry).collect());
    }
    form
}

/// Returns some rows and columns of a matrix.
fn part(matrix: &[Vec<Expr>], of: &[usize]) -> Vec<Vec<Expr>> {
    let row = |&i: &usize| of.iter().map(|&j| matrix[i][j]).collect();
    of.iter().map(row).collect()
}

/// Returns whether an expression is independent of the configuration.
fn is_constant(e: Expr, model: &Model, arena: &mut Arena) -> bool {
    model.q.iter().all(|&q| {
        !arena.contains(e, q) || {
            let change = arena.diff(e, q);
            arena.is_zero(change)
        }
    })
}

/// Returns whether the matrix of some rows and columns is regular at some random point, or defined
/// nowhere.
fn is_regular(matrix: &[Vec<Expr>], of: &[usize], arena: &Arena) -> bool {
    null_columns(&part(matrix, of), arena).is_none()
}

/// Returns the columns that occur in null vectors of a matrix, if it is singular at all random
/// points.
fn null_columns(matrix: &[Vec<Expr>], arena: &Arena) -> Option<Vec<usize>> {
    let n = matrix.len();
    if n == 0 {
        return None;
    }
    let entries = matrix.concat();
    let rows = |point: Vec<f64>| point.chunks(n).map(<[f64]>::to_vec).collect();
    if arena
        .samples(&entries)
        .any(|point| regular::is_regular(rows(point)))
    {
        return None;
    }
    let mut columns = Vec::new();
    for point in arena.sharp_samples(&entries) {
        let found = regular::null_columns(point.chunks(n).map(<[Sharp]>::to_vec).collect());
        if found.columns.is_empty() {
            return None;
        }
        columns.extend(found.columns);
    }
    columns.sort_unstable();
    columns.dedup();
    (!columns.is_empty()).then_some(columns)
}

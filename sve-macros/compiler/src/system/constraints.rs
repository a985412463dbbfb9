//! Checks of constraints, and of the noises of a system with constraints, at points where the
//! constraints hold.
//!
//! Input: the model with its derivatives. Output: errors, if any. Invariant: an identity that must
//! hold only where φ = 0 is tested there, at random points that Gauss–Newton steps move onto φ = 0,
//! with velocities along the constraints. The checks are:
//!
//! - The gradients of the constraints are linearly independent.
//! - A noise moves the position along the constraints, `⟨∂φ/∂q, ∂G/∂p⟩ = 0`. Otherwise the
//!   equations of motion have no solution.
//! - For rules with one node at an end, either the Stratonovich correction also moves along the
//!   constraints, or the noise is tangent everywhere. Otherwise the multiplier is divided by
//!   `h + c ΔW`.

mod points;
mod tangent;

pub(crate) use tangent::tangent_noises;

use points::{Point, points};

use crate::algebra::{Arena, Expr};
use crate::catalogue::Rule;
use crate::errors::Errors;
use crate::model::Model;
use crate::syntax::parse::{Annotated, RoleFunction};
use crate::system::mechanics::Mechanics;

/// Smallest sum, relative to the magnitudes of its terms, that counts as nonzero. The points lie on
/// φ = 0 to rounding, which is amplified if gradients are nearly dependent.
const NOT_ZERO: f64 = 1e-7;

/// Smallest pivot of independent gradients, relative to the diagonal entry. Rounding errors of a
/// repeated constraint are some 1e-15.
const SMALLEST_PIVOT: f64 = 1e-10;

/// Largest gradient of φ at a point where φ = 0, relative to the gradient at a random point, that
/// counts as zero. The gradient of a squared constraint has the size of the square root of
/// rounding.
const NO_GRADIENT: f64 = 1e-5;

/// Checks the constraints of a block. Returns true if there are constraints and the noises commute
/// where they hold.
pub(crate) fn check(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &mut Arena,
) -> syn::Result<bool> {
    if model.constraints.is_empty() {
        return Ok(false);
    }
    let quantities = Quantities::new(model, mechanics, arena);
    let points = points(model, mechanics, arena);
    let mut errors = Errors::new();
    if points.is_empty() {
        // noises and gradients that cannot be tested are not accepted
        let message = "no configuration that satisfies the constraints was found for any of the random parameters that were tried, so that noises and gradients cannot be tested there: write them such that small positive parameters have a configuration";
        errors.push(block.constraints[0].name.span(), message);
        return errors.finish(false);
    }
    let values: Vec<Values> = points.iter().map(|at| quantities.at(at, arena)).collect();
    check_noise_forces(block, model, mechanics, arena, &mut errors);
    let is_regular = check_gradients(block, model, &points, &mut errors);
    if is_regular {
        check_tangency(block, model, &values, &mut errors);
    }
    errors.finish(())?;
    check_correction(block, model, &quantities, &values, arena)?;
    let mut brackets = values.iter().flat_map(|at| &at.brackets);
    Ok(brackets.all(Sum::vanishes))
}

/// Checks that the momentum of a system with constraints is affine in the velocity. Then the
/// projection of the momentum is a linear equation.
pub(crate) fn check_momentum(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
) -> syn::Result<()> {
    if model.constraints.is_empty() || mechanics.affine_momentum {
        return Ok(());
    }
    let message = "constraints are for Lagrangians that are quadratic in the velocities, and ∂²L/∂v² of this one depends on v: use coordinates along the constraints";
    Err(syn::Error::new(block.lagrangian.name.span(), message))
}

/// Sums that must vanish, as lists of terms.
struct Quantities {
    /// `⟨∂φ/∂q, ∂G/∂p⟩` of each noise and constraint.
    drift: Vec<Vec<Vec<Expr>>>,
    /// `⟨∂φ/∂q, ∂/∂p (⟨∂G_a/∂p, ∂G_b/∂q⟩ + ⟨∂G_b/∂p, ∂G_a/∂q⟩)⟩` of each pair of noises and each
    /// constraint.
    correction: Vec<(usize, usize, Vec<Vec<Expr>>)>,
    /// `{G_a, G_b}` of each pair of noises.
    brackets: Vec<Vec<Expr>>,
}

/// The value of a sum, and the sum of the magnitudes of its terms.
struct Sum {
    value: f64,
    magnitude: f64,
}

impl Sum {
    fn vanishes(&self) -> bool {
        // an undefined value is no evidence against the identity
        let is_undefined = self.value.is_nan() || self.magnitude.is_nan();
        is_undefined || self.value.abs() <= NOT_ZERO * self.magnitude
    }
}

/// The sums of [`Quantities`] at a point, in the same order.
struct Values {
    drift: Vec<Vec<Sum>>,
    correction: Vec<Vec<Sum>>,
    brackets: Vec<Sum>,
}

impl Quantities {
    fn new(model: &Model, mechanics: &Mechanics, arena: &mut Arena) -> Self {
        let along = |row: &[Expr], field: &[Expr], arena: &mut Arena| -> Vec<Expr> {
            let pairs = row.iter().zip(field);
            pairs.map(|(&a, &b)| arena.mul(a, b)).collect()
        };
        let slopes: Vec<&Vec<Expr>> = mechanics.constraints.iter().map(|c| &c.dq).collect();
        let noises = &mechanics.noises;
        let drift = noises.iter().map(|g| {
            slopes
                .iter()
                .map(|slope| along(slope, &g.dp, arena))
                .collect()
        });
        let drift = drift.collect();
        let (mut correction, mut brackets) = (Vec::new(), Vec::new());
        for (b, g) in noises.iter().enumerate() {
            for (a, f) in noises.iter().enumerate().take(b + 1) {
                let [first, second] = [along(&f.dp, &g.dq, arena), along(&g.dp, &f.dq, arena)];
                let all: Vec<(f64, Expr)> = [&first[..], &second]
                    .concat()
                    .into_iter()
                    .map(|e| (1.0, e))
                    .collect();
                let sum = arena.sum(0.0, &all);
                let by_p: Vec<Expr> = model.p.iter().map(|&p| arena.diff(sum, p)).collect();
                let each = slopes.iter().map(|slope| along(slope, &by_p, arena));
                correction.push((a, b, each.collect()));
                if a != b {
                    let negative = first.into_iter().map(|e| arena.neg(e));
                    let bracket: Vec<Expr> = negative.collect();
                    brackets.push([bracket, second].concat());
                }
            }
        }
        Self {
            drift,
            correction,
            brackets,
        }
    }

    fn at(&self, point: &Point, arena: &Arena) -> Values {
        let sums = |lists: &[Vec<Expr>]| -> Vec<Sum> {
            let sum = |terms: &Vec<Expr>| {
                let values = arena.values(terms, |s| point.value(s));
                Sum {
                    value: values.iter().sum(),
                    magnitude: values.iter().map(|x| x.abs()).sum(),
                }
            };
            lists.iter().map(sum).collect()
        };
        Values {
            drift: self.drift.iter().map(|list| sums(list)).collect(),
            correction: self.correction.iter().map(|c| sums(&c.2)).collect(),
            brackets: sums(&self.brackets),
        }
    }
}

/// Reports constraints that depend on earlier ones at every point. Returns whether there are none.
fn check_gradients(
    block: &Annotated,
    model: &Model,
    points: &[Point],
    errors: &mut Errors,
) -> bool {
    for (k, constraint) in model.constraints.iter().enumerate() {
        let place = function(&block.constraints, &constraint.name).name.span();
        let name = &constraint.name;
        if points.iter().all(|at| at.gradient_size(k) < NO_GRADIENT) {
            let message = format!(
                "the gradient of the constraint `{name}` vanishes wherever it holds, so that it has no force: write it without the power, as in `f` for `f * f`"
            );
            errors.push(place, message);
            return false;
        }
        if points.iter().all(|at| at.pivot(k).abs() < SMALLEST_PIVOT) {
            let message = format!(
                "the constraint `{name}` depends on those before it at every point where they hold, so that its force is not determined: remove it"
            );
            errors.push(place, message);
            return false;
        }
    }
    true
}

/// Reports a noise force that depends on velocities, and any noise force beside a noise that moves
/// the position. The fields of the motion are projected on the constraints. For such fields,
/// neither the bracket with another noise nor the correction of a rule with one node at an end is
/// derived.
fn check_noise_forces(
    block: &Annotated,
    model: &Model,
    mechanics: &Mechanics,
    arena: &Arena,
    errors: &mut Errors,
) {
    let noises = &mechanics.noises;
    let Some(first) = noises.iter().position(|noise| noise.force.is_some()) else {
        return;
    };
    let is_given = |e: &Expr| arena.constant_value(*e) != Some(0.0);
    let name = |at: usize| &model.noises[at].name;
    let reads_velocity = noises.iter().position(|noise| noise.reads_velocity);
    let moves_position = noises
        .iter()
        .position(|noise| noise.dp.iter().any(is_given));
    let (name, cause) = match (reads_velocity, moves_position) {
        (Some(at), _) => (name(at), format!("`{}` depends on velocities", name(at))),
        (None, Some(at)) => (name(first), format!("`{}` moves the position", name(at))),
        (None, None) => return,
    };
    if noises.len() > 1 {
        let message = format!(
            "with constraints, whether the noise force `{name}` commutes with the other noises is not derived, since {cause}: write all noises as functions of q, or leave one noise"
        );
        errors.push(function(&block.noises, name).name.span(), message);
    }
    let listed = block.arguments.rules.iter();
    for listed in listed.filter(|listed| listed.rule.has_correction()) {
        let message = format!(
            "with constraints, the Stratonovich correction of `{}` with the noise force `{name}` is not derived, since {cause}: use `midpoint` or `stormer_verlet`",
            listed.rule.name()
        );
        errors.push(listed.place, message);
    }
}

/// Reports noises that move the position off the constraints.
fn check_tangency(block: &Annotated, model: &Model, values: &[Values], errors: &mut Errors) {
    for (a, noise) in model.noises.iter().enumerate() {
        let leaves = |k: &usize| values.iter().any(|at| !at.drift[a][*k].vanishes());
        let Some(k) = (0..model.constraints.len()).find(leaves) else {
            continue;
        };
        let (noise, constraint) = (&noise.name, &model.constraints[k].name);
        let message = format!(
            "the noise `{noise}` moves q off the constraint `{constraint}`: ∂{noise}/∂p is not tangent to it, so that the constraint force would have to be infinite; write `#[h1(tangent)]`, which puts the momentum along the constraints in the place of p"
        );
        errors.push(function(&block.noises, noise).name.span(), message);
    }
}

/// Reports the rules with one node at an end whose correction moves the position off the
/// constraints.
fn check_correction(
    block: &Annotated,
    model: &Model,
    quantities: &Quantities,
    values: &[Values],
    arena: &mut Arena,
) -> syn::Result<()> {
    let is_one_sided = |rule: &Rule| rule.has_correction();
    let mut errors = Errors::new();
    for (at, &(a, b, _)) in quantities.correction.iter().enumerate() {
        let leaves = values
            .iter()
            .any(|v| v.correction[at].iter().any(|s| !s.vanishes()));
        if !leaves {
            continue;
        }
        // with a noise that is tangent everywhere, the multiplier keeps the factor h
        let mut terms = [a, b].into_iter().flat_map(|g| &quantities.drift[g]);
        let is_tangent_everywhere = terms.all(|terms| {
            let terms: Vec<(f64, Expr)> = terms.iter().map(|&e| (1.0, e)).collect();
            let sum = arena.sum(0.0, &terms);
            arena.is_zero(sum)
        });
        if is_tangent_everywhere {
            continue;
        }
        let noise = &model.noises[b].name;
        for listed in block
            .arguments
            .rules
            .iter()
            .filter(|l| is_one_sided(&l.rule))
        {
            let message = format!(
                "`{}` has no solution with the noise `{noise}`: its Stratonovich correction moves q off the constraints; write `#[h1(tangent)]` on the noise, or use `midpoint` or `stormer_verlet`",
                listed.rule.name()
            );
            errors.push(listed.place, message);
        }
        break;
    }
    errors.finish(())
}

/// Finds the function of a term by the name of the term, `f` or `f[2]`.
fn function<'a>(functions: &'a [RoleFunction], term: &str) -> &'a RoleFunction {
    let name = term.split('[').next().unwrap_or(term);
    let found = functions.iter().find(|f| f.name == name);
    found.unwrap_or(&functions[0])
}

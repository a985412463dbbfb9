//! Checks that each `#[symmetry]` is a symmetry, and derives the momentum that it conserves.
//!
//! Input: the model with its generators ξ. Output: the momentum maps ⟨p, ξ⟩, or an error that names
//! the function which is not invariant. If the algebra does not decide whether an expression
//! vanishes, it is evaluated at random points (`algebra/zero.rs`).
//!
//! The following expressions must vanish identically (`docs/mathematics.md`, section 7), with `ξ_t`
//! if the generator depends on time:
//!
//! ```text
//! L:   ⟨L_q, ξ⟩ + ⟨L_v, Dξ v + ξ_t⟩        γ:   ⟨γ_q, ξ⟩
//! H₁:  ⟨∂H₁/∂q, ξ⟩ − ⟨p, Dξ ∂H₁/∂p⟩        F:   ⟨F, ξ⟩, the work of a force
//! ```
//!
//! A rotation moves by δR = R ξ̂ and its body velocity by Dξ v + v × ξ, which replaces Dξ v. The
//! same holds for ∂H₁/∂p.

use proc_macro2::Ident;
use quote::format_ident;

use crate::algebra::{Arena, Expr, Symbol, Vanishing};
use crate::errors::Errors;
use crate::model::configuration::{Block, Factor, cross};
use crate::model::{Generator, Model, NoiseKind, NoiseTerm};
use crate::scene::moves_nothing;
use crate::syntax::parse::{Annotated, RoleFunction};
use crate::system::degeneracy::Degeneracy;

/// Returns the name of the function that returns the momentum of a symmetry.
pub(crate) fn momentum_name(symmetry: &Ident) -> Ident {
    format_ident!("{symmetry}_momentum", span = symmetry.span())
}

/// A conserved momentum.
pub(crate) struct MomentumMap {
    /// Source name of the symmetry.
    pub(crate) name: String,
    /// ⟨p, ξ⟩.
    pub(crate) value: Expr,
    /// True if ξ is affine in q and independent of time. The steps then conserve the momentum too.
    pub(crate) is_affine: bool,
    /// The evidence of the invariance along ξ: a proof, or values at random points.
    pub(crate) evidence: Vanishing,
}

/// Largest number of characters of a rate of change that a message shows.
const READABLE: usize = 160;

/// Checks the symmetries of a block.
pub(crate) fn check(
    block: &Annotated,
    model: &Model,
    degeneracy: Option<&Degeneracy>,
    arena: &mut Arena,
) -> syn::Result<Vec<MomentumMap>> {
    let mut errors = Errors::new();
    let mut maps = Vec::new();
    for (symmetry, generator) in block.symmetries.iter().zip(&model.symmetries) {
        if generator.field.iter().all(|&x| arena.is_zero(x)) {
            let message = moves_nothing(&symmetry.name.to_string());
            errors.push(symmetry.name.span(), message);
            continue;
        }
        check_name(symmetry, block, &mut errors);
        let mut evidence = Vanishing::Proved;
        for Change { of, rate, scale } in changes(block, generator, model, arena) {
            let on_rotations = model.on_rotations(rate, arena);
            match arena.vanishing(on_rotations) {
                Some(vanishing) => evidence = evidence.max(vanishing),
                None => {
                    let rate = arena.scale(1.0 / scale, rate);
                    let message = broken(symmetry, &of, rate, model, arena);
                    errors.push(symmetry.name.span(), message);
                }
            }
        }
        let mut map = momentum(generator, evidence, model, arena);
        map.is_affine &= is_kept(generator, block, degeneracy, model, arena);
        maps.push(map);
    }
    errors.finish(maps)
}

/// Checks that the function of the momentum has a name of its own.
pub(crate) fn check_name(symmetry: &RoleFunction, block: &Annotated, errors: &mut Errors) {
    let name = momentum_name(&symmetry.name);
    if block.functions.iter().any(|f| f.sig.ident == name) {
        let message = format!(
            "`{}` gives the function `{name}`, which the block has already: rename one of them",
            symmetry.name
        );
        errors.push(symmetry.name.span(), message);
    }
}

/// Returns whether the nodes of all rules conserve the momentum of an affine generator. If the
/// Lagrangian is regular, every node conserves it.
fn is_kept(
    generator: &Generator,
    block: &Annotated,
    degeneracy: Option<&Degeneracy>,
    model: &Model,
    arena: &Arena,
) -> bool {
    degeneracy.is_none_or(|degeneracy| {
        let rules = block.arguments.rules.iter();
        let mut nodes = rules.filter_map(|listed| listed.rule.node());
        nodes.all(|c| degeneracy.keeps_momentum(&generator.field, c == 0.5, model, arena))
    })
}

fn broken(
    symmetry: &RoleFunction,
    what: &Changed,
    change: Expr,
    model: &Model,
    arena: &Arena,
) -> String {
    let name = &symmetry.name;
    let rate = model
        .symbols
        .formula(change, READABLE, arena)
        .map(|formula| format!(" at the rate {formula}"))
        .unwrap_or_default();
    match what {
        Changed::Function(whose) => format!(
            "`{name}` is not a symmetry of {whose}, which changes along it{rate}; correct the generator, or remove `#[symmetry]`"
        ),
        Changed::Work(force) => format!(
            "the force {force} does work along the symmetry `{name}`{rate}, so that its momentum is not conserved; remove `#[symmetry]`, or the force along it"
        ),
    }
}

/// A quantity that must be invariant along a generator.
enum Changed {
    /// A function of the block, under its name in messages.
    Function(String),
    /// The work of the forces with these names.
    Work(String),
}

/// The change of a quantity along a generator.
struct Change {
    of: Changed,
    /// The rate of change times `scale`.
    rate: Expr,
    /// A power of two, which prevents overflow and underflow.
    scale: f64,
}

/// Returns an expression times a power of two, and this power. The power is 1 unless products with
/// the expression might underflow or overflow; otherwise it brings the expression to the order
/// of 1.
fn scaled(expr: Expr, arena: &mut Arena) -> (Expr, f64) {
    let scale = arena.scale_of(&[expr]);
    if scale == 1.0 {
        (expr, scale)
    } else {
        (arena.scale(scale, expr), scale)
    }
}

/// Returns the change of each function of the block along a generator.
fn changes(
    block: &Annotated,
    generator: &Generator,
    model: &Model,
    arena: &mut Arena,
) -> Vec<Change> {
    let unit = arena.scale_of(&generator.field);
    let xi: Vec<Expr> = match unit {
        1.0 => generator.field.clone(),
        _ => {
            let scaled = generator.field.iter().map(|&x| arena.scale(unit, x));
            scaled.collect()
        }
    };
    let mut changes = vec![change_of_lagrangian(&xi, model, arena)];
    for noise in &model.noises {
        changes.push(match &noise.force {
            Some(force) => work(force, format!("`{}`", noise.name), &xi, arena),
            None => change_of_noise(noise, &xi, model, arena),
        });
    }
    for constraint in &model.constraints {
        let (value, scale) = scaled(constraint.value, arena);
        changes.push(Change {
            of: Changed::Function(format!("the constraint `{}`", constraint.name)),
            rate: pairing(value, &model.q, &xi, arena),
            scale,
        });
    }
    if let Some(force) = &model.force {
        let names = block.forces.iter();
        let names: Vec<String> = names.map(|f| format!("`{}`", f.name)).collect();
        changes.push(work(force, names.join(" + "), &xi, arena));
    }
    for change in &mut changes {
        change.scale *= unit;
    }
    changes
}

/// Returns the work of the forces with these names along a generator.
fn work(force: &[Expr], names: String, xi: &[Expr], arena: &mut Arena) -> Change {
    let scale = arena.scale_of(force);
    let force: Vec<Expr> = force.iter().map(|&f| arena.scale(scale, f)).collect();
    Change {
        of: Changed::Work(names),
        rate: dot(&force, xi, arena),
        scale,
    }
}

fn change_of_lagrangian(xi: &[Expr], model: &Model, arena: &mut Arena) -> Change {
    let v: Vec<Expr> = model.v.iter().map(|&s| arena.symbol(s)).collect();
    let mut flow = carried(xi, &v, model, arena);
    for (at, &x) in xi.iter().enumerate() {
        let drift = arena.diff(x, model.time);
        flow[at] = arena.add(flow[at], drift);
    }
    let (lagrangian, scale) = scaled(model.lagrangian, arena);
    let along_q = along(lagrangian, xi, model, arena);
    let along_v = pairing(lagrangian, &model.v, &flow, arena);
    Change {
        of: Changed::Function(match model.time_scale {
            Some(_) => "the Lagrangian with its time scale".to_owned(),
            None => "the Lagrangian".to_owned(),
        }),
        rate: arena.add(along_q, along_v),
        scale,
    }
}

fn change_of_noise(noise: &NoiseTerm, xi: &[Expr], model: &Model, arena: &mut Arena) -> Change {
    let p: Vec<Expr> = model.p.iter().map(|&s| arena.symbol(s)).collect();
    let (hamiltonian, scale) = scaled(noise.hamiltonian, arena);
    let along_q = along(hamiltonian, xi, model, arena);
    let by_p = model.p.iter().map(|&s| arena.diff(hamiltonian, s));
    let by_p: Vec<Expr> = by_p.collect();
    let along_p = carried(xi, &by_p, model, arena);
    let along_p = dot(&p, &along_p, arena);
    let mut rate = arena.sub(along_q, along_p);
    if noise.kind == NoiseKind::Gamma {
        // the noise Hamiltonian is −γ
        rate = arena.neg(rate);
    }
    Change {
        of: Changed::Function(format!("the noise `{}`", noise.name)),
        rate,
        scale,
    }
}

/// Returns the derivative of `f` along a direction of the configuration.
fn along(f: Expr, direction: &[Expr], model: &Model, arena: &mut Arena) -> Expr {
    let gradient = model.gradient(f, arena);
    dot(&gradient, direction, arena)
}

/// Returns the derivative of `f` along a direction, `⟨∂f/∂x, direction⟩`.
fn pairing(f: Expr, x: &[Symbol], direction: &[Expr], arena: &mut Arena) -> Expr {
    let gradient: Vec<Expr> = x.iter().map(|&s| arena.diff(f, s)).collect();
    dot(&gradient, direction, arena)
}

fn dot(a: &[Expr], b: &[Expr], arena: &mut Arena) -> Expr {
    let terms: Vec<(f64, Expr)> = a
        .iter()
        .zip(b)
        .map(|(&a, &b)| (1.0, arena.mul(a, b)))
        .collect();
    arena.sum(0.0, &terms)
}

/// Returns the change of a velocity `direction` along a generator, `Dξ · direction`. For a rotation
/// the commutator `direction × ξ` is added.
fn carried(xi: &[Expr], direction: &[Expr], model: &Model, arena: &mut Arena) -> Vec<Expr> {
    let mut change: Vec<Expr> = xi
        .iter()
        .map(|&x| along(x, direction, model, arena))
        .collect();
    if model.configuration().has_rotations() {
        let commutator = model.configuration().commutator(direction, xi, arena);
        for (change, commutator) in change.iter_mut().zip(commutator) {
            *change = arena.add(*change, commutator);
        }
    }
    change
}

/// Returns whether the components of a generator are affine in the entries of the configuration.
fn is_affine_in_coordinates(field: &[Expr], model: &Model, arena: &mut Arena) -> bool {
    let mut is_affine = true;
    for &x in field {
        for &q in &model.q {
            let slope = arena.diff(x, q);
            for &other in &model.q {
                let second = arena.diff(slope, other);
                is_affine &= arena.is_zero(second);
            }
        }
    }
    is_affine
}

/// Returns whether a generator turns a rotation by `ξ = Rᵀa + c` with constant vectors, that is, by
/// a rotation of space and one of the body. Steps are symmetric under both.
///
/// The derivative of Rᵀa in the direction e is − e × Rᵀa. The code computes η, which equals Rᵀa for
/// such a generator, from the derivatives of ξ, and requires that both ξ and η have this
/// derivative.
fn turns_uniformly(field: &[Expr], block: &Block, model: &Model, arena: &mut Arena) -> bool {
    let zero = arena.constant(0.0);
    let derivatives = |field: &[Expr], arena: &mut Arena| -> Vec<Vec<Expr>> {
        field.iter().map(|&x| model.gradient(x, arena)).collect()
    };
    let first = derivatives(field, arena);
    let at = block.directions.start;
    // − e₁ × η = (0, η₃, −η₂), − e₂ × η = (−η₃, 0, η₁)
    let eta = [first[2][at + 1], arena.neg(first[2][at]), first[1][at]];
    let second = derivatives(&eta, arena);
    for direction in 0..model.dof() {
        let mut unit = [zero; 3];
        if block.directions.contains(&direction) {
            unit[direction - at] = arena.constant(1.0);
        }
        let turned = cross(&unit, &eta, arena);
        for k in 0..3 {
            for derivative in [first[k][direction], second[k][direction]] {
                let rest = arena.add(derivative, turned[k]);
                let rest = model.on_rotations(rest, arena);
                if !arena.is_zero(rest) {
                    return false;
                }
            }
        }
    }
    true
}

fn momentum(
    generator: &Generator,
    evidence: Vanishing,
    model: &Model,
    arena: &mut Arena,
) -> MomentumMap {
    let p: Vec<Expr> = model.p.iter().map(|&s| arena.symbol(s)).collect();
    let value = dot(&p, &generator.field, arena);
    let mut is_affine = true;
    for &x in &generator.field {
        is_affine &= !arena.contains(x, model.time);
    }
    for block in model.configuration().blocks() {
        let field = &generator.field[block.directions.clone()];
        is_affine &= match block.factor {
            Factor::Vector(_) => is_affine_in_coordinates(field, model, arena),
            Factor::Rotation => turns_uniformly(field, &block, model, arena),
        };
    }
    MomentumMap {
        name: generator.name.clone(),
        value,
        is_affine,
        evidence,
    }
}
